#include "tools/capture/record.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "shell/text.h"
#include "tools/capture/field_names.h"
#include "tools/capture/names.h"

namespace padr::capture {
namespace {

std::string hex_of(std::uint64_t v, int digits) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string s(static_cast<std::size_t>(digits), '0');
  for (auto c = s.rbegin(); c != s.rend(); ++c, v >>= 4U) *c = kDigits[v & 15U];
  return s;
}

/// Without the port.
std::string address_of(const Endpoint& e) {
  const std::string s = to_string(e);
  return e.is_v4() ? s.substr(0, s.find(':')) : s.substr(1, s.find(']') - 1);
}

}  // namespace

void Record::bytes(std::string_view name, std::span<const std::byte> v) {
  std::string hex;
  for (const std::byte b : v)
    for (const unsigned shift : {4U, 0U}) hex += "0123456789abcdef"[std::to_integer<unsigned>(b) >> shift & 15U];
  text(name, hex);
}

void Record::hex32(std::string_view name, std::uint32_t v) {
  add(name, {hex_of(v, 8), true});
}

void Record::hex64(std::string_view name, std::uint64_t v) {
  add(name, {hex_of(v, 16), true});
}

void Record::real(std::string_view name, float v) {
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), v).ptr;
  add(name, {std::string(text.data(), end), !std::isfinite(v)});
}

void Record::address(std::string_view name, const Endpoint& v) {
  add(name, {(v.is_v4() ? "::ffff:" : "") + address_of(v), true});
}

void Record::add(std::string_view name, Value v) {
  const auto found = std::find_if(fields_.begin(), fields_.end(), [name](const auto& f) { return f.first == name; });
  if (found != fields_.end()) {
    found->second.push_back(std::move(v));
  } else {
    fields_.push_back({name, {std::move(v)}});
  }
}

const std::vector<Record::Value>* Record::find(std::string_view name) const {
  const auto found = std::find_if(fields_.begin(), fields_.end(), [name](const auto& f) { return f.first == name; });
  return found == fields_.end() ? nullptr : &found->second;
}

std::string Record::json() const {
  std::string out = "{";
  for (const auto& [name, values] : fields_) {
    if (out.size() > 1) out += ',';
    out += '"';
    out += name;
    out += "\":";
    const bool list = can_repeat(name);
    if (list) out += '[';
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i > 0) out += ',';
      out += values[i].is_text ? nlohmann::json(values[i].text).dump() : values[i].text;
    }
    if (list) out += ']';
  }
  return out + '}';
}

std::string Record::csv(const std::vector<std::string_view>& columns) const {
  std::string out;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i > 0) out += ',';
    const auto* values = find(columns[i]);
    if (values == nullptr) continue;
    std::string cell;
    for (const Value& v : *values) cell += (cell.empty() ? "" : ";") + v.text;
    out += shell::csv_field(cell);
  }
  return out;
}

Record Recorder::record(const Datagram& d) {
  Record r;
  const std::span<const std::byte> b = d.payload;
  const auto byte = [b](std::size_t i) { return std::to_integer<std::uint32_t>(b[i]); };
  r.number("frame.number", d.packet);
  const std::string fraction = std::to_string(1'000'000'000 + d.time_ns % 1'000'000'000).substr(1);
  r.text("frame.time_epoch", std::to_string(d.time_ns / 1'000'000'000) + "." + fraction);
  const Endpoint& from = d.outer_from;
  const Endpoint& to = d.outer_to;
  r.text(from.is_v4() ? "ip.src" : "ipv6.src", address_of(from));
  r.text(to.is_v4() ? "ip.dst" : "ipv6.dst", address_of(to));
  r.number("udp.srcport", from.port);
  r.number("udp.dstport", to.port);
  if (b.size() > 2) {
    r.number("padr.version", byte(2) >> 4U);
    const std::uint32_t kind = byte(2) & 15U;
    r.text("padr.kind", kind <= 2 ? name_of(static_cast<wire::Kind>(kind)) : std::to_string(kind));
  }
  if (b.size() > 3) r.number("padr.peer", byte(3));
  if (b.size() > 5) r.number("padr.session", byte(4) | byte(5) << 8U);
  if (d.carried_to) r.hex32("padr.carried.to", *d.carried_to);
  if (d.cut) return r;
  wire::SealError error = wire::SealError::kNone;
  const auto opened = wire::open(b, error);
  if (b.size() >= wire::kHeaderBytes + wire::kTagBytes) {
    const std::size_t n = b.size();
    r.hex32("padr.tag", byte(n - 4) | byte(n - 3) << 8U | byte(n - 2) << 16U | byte(n - 1) << 24U);
    if (error != wire::SealError::kTooLong) r.flag("padr.tag_good", error != wire::SealError::kTag);
  }
  std::string_view why = name_of(error);
  if (opened) {
    if (opened->header.sender != kNoPeer) who_[d.from] = opened->header.sender;
    if (const auto at = who_.find(d.to); at != who_.end()) r.number("padr.to", at->second);
    Record whole = r;
    bool good = false;
    if (opened->header.kind == wire::Kind::kState) good = put_state(whole, *opened, why);
    if (opened->header.kind == wire::Kind::kSession) good = put_session(whole, *opened);
    if (opened->header.kind == wire::Kind::kMembership) good = put_membership(whole, *opened);
    if (good) return whole;
    if (why.empty()) why = "malformed";
  }
  r.text("padr.drop", why);
  return r;
}

}  // namespace padr::capture
