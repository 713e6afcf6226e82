#include "common/scenarios/rules.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cmath>

#include "common/scenarios/numbers.h"

namespace padr::scenarios {
namespace {

namespace pb = google::protobuf;
using padr::scenario::Rule;
using Tree = pb::TextFormat::ParseInfoTree;

std::string with_unit(std::string text, const Rule& rule) {
  if (rule.has_unit()) text += " " + rule.unit();
  return text;
}

std::string allowed(const Rule& rule) {
  return with_unit(number_text(rule.min()) + " .. " + number_text(rule.max()), rule);
}

class Walker {
 public:
  Walker(const std::function<void(const Origin&)>& seen,
         const std::function<void(const Origin&, const std::string&)>& fail)
      : seen_(seen), fail_(fail) {}

  /// `inherited` is the rule of the field that holds this message: the range of a Vec2's or Range's two numbers.
  void message(const pb::Message& m, const Tree* tree, const Origin& where, const Rule& inherited) const {
    const pb::Descriptor& type = *m.GetDescriptor();
    for (int i = 0; i < type.real_oneof_decl_count(); ++i) choice(m, *type.oneof_decl(i), where);
    for (int i = 0; i < type.field_count(); ++i) {
      Rule rule = type.field(i)->options().GetExtension(padr::scenario::rule);
      if (!rule.has_min() && inherited.has_min()) {
        rule.set_min(inherited.min());
        rule.set_max(inherited.max());
        rule.set_unit(inherited.unit());
      }
      field(m, *type.field(i), tree, where, rule);
    }
    if (const auto* range = dynamic_cast<const padr::scenario::Range*>(&m); range && range->min() > range->max()) {
      fail_(where, "has min " + number_text(range->min()) + " above max " + number_text(range->max()) +
                       ", allowed: min at most max");
    }
  }

 private:
  static std::string joined(const std::string& path, const std::string& name) {
    return path.empty() ? name : path + "." + name;
  }

  void choice(const pb::Message& m, const pb::OneofDescriptor& oneof, const Origin& where) const {
    if (m.GetReflection()->HasOneof(m, &oneof)) return;
    std::string names;
    for (int i = 0; i < oneof.field_count(); ++i) names += (i > 0 ? " or " : "") + oneof.field(i)->name();
    fail_(where, "has no " + oneof.name() + ", needed: " + names);
  }

  void field(const pb::Message& m, const pb::FieldDescriptor& f, const Tree* tree, const Origin& parent,
             const Rule& rule) const {
    const pb::Reflection& reflection = *m.GetReflection();
    const int count = f.is_repeated() ? reflection.FieldSize(m, &f) : static_cast<int>(reflection.HasField(m, &f));
    const Origin named{joined(parent.field, f.name()), parent.line, parent.column};
    if (rule.required() && count == 0) {
      fail_(named, std::string("is missing") + (rule.has_min() ? ", needed: " + allowed(rule) : std::string()));
    }
    if (f.is_repeated()) number_of_items(count, named, rule);
    for (int i = 0; i < count; ++i) {
      const int index = f.is_repeated() ? i : -1;
      Origin where = named;
      if (f.is_repeated()) where.field.append("[").append(std::to_string(i)).append("]");
      if (tree != nullptr) {
        const auto at = tree->GetLocation(&f, index);
        if (at.line >= 0) {
          where.line = at.line + 1;
          where.column = at.column + 1;
        }
      }
      seen_(where);
      value(m, f, index, tree, where, rule);
    }
  }

  void number_of_items(int count, const Origin& where, const Rule& rule) const {
    const auto n = static_cast<std::uint32_t>(count);
    if (n >= rule.min_items() && (!rule.has_max_items() || n <= rule.max_items())) return;
    fail_(where, "is given " + std::to_string(n) + " times, allowed: " + std::to_string(rule.min_items()) + " .. " +
                     std::to_string(rule.max_items()) + " times");
  }

  void value(const pb::Message& m, const pb::FieldDescriptor& f, int index, const Tree* tree, const Origin& where,
             const Rule& rule) const {
    const pb::Reflection& reflection = *m.GetReflection();
    switch (f.cpp_type()) {
      case pb::FieldDescriptor::CPPTYPE_MESSAGE: {
        const pb::Message& nested =
            f.is_repeated() ? reflection.GetRepeatedMessage(m, &f, index) : reflection.GetMessage(m, &f);
        message(nested, tree != nullptr ? tree->GetTreeForNested(&f, index) : nullptr, where, rule);
        break;
      }
      case pb::FieldDescriptor::CPPTYPE_DOUBLE:
        number(reflection.GetDouble(m, &f), where, rule);
        break;
      case pb::FieldDescriptor::CPPTYPE_UINT32:
        number(reflection.GetUInt32(m, &f), where, rule);
        break;
      case pb::FieldDescriptor::CPPTYPE_STRING:
        text(reflection.GetString(m, &f), where, rule);
        break;
      default:
        break;  // a bool has nothing to get wrong
    }
  }

  void number(double v, const Origin& where, const Rule& rule) const {
    if (std::isfinite(v) && v >= rule.min() && v <= rule.max()) return;
    fail_(where, "is " + with_unit(number_text(v), rule) + ", allowed: " + allowed(rule));
  }

  void text(const std::string& v, const Origin& where, const Rule& rule) const {
    bool printable = !v.empty();
    for (const char c : v) printable = printable && static_cast<unsigned char>(c) >= 0x20;
    if (printable && v.size() <= rule.max_items()) return;
    fail_(where, "has " + std::to_string(v.size()) + " bytes, allowed: one line of 1 .. " +
                     std::to_string(rule.max_items()) + " bytes");
  }

  const std::function<void(const Origin&)>& seen_;
  const std::function<void(const Origin&, const std::string&)>& fail_;
};

}  // namespace

void check_rules(const padr::scenario::Scenario& scenario, const Tree& tree,
                 const std::function<void(const Origin&)>& seen,
                 const std::function<void(const Origin&, const std::string&)>& fail) {
  Walker(seen, fail).message(scenario, &tree, Origin{}, Rule{});
}

}  // namespace padr::scenarios
