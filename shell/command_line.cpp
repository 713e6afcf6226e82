#include "shell/command_line.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <regex>
#include <sstream>
#include <utility>

#include "common/model/user_error.h"
#include "shell/input_text.h"
#include "shell/revision.h"

namespace padr::shell {

void add_version_flag(CLI::App& app, const std::string& program) {
  app.set_version_flag("--version",
                       program + " " + std::string(version()) + " (revision " + std::string(revision()) + ")");
}

namespace {

/// A first word that is no command of a program that has commands, or no word at all where there must be one.
void check_command(const CLI::App& app, int argc, const char* const* argv) {
  const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
  const char* const word = argc < 2 ? nullptr : argv[1];
  const bool may_be_none = word == nullptr ? app.get_require_subcommand_min() == 0 : *word == '-';
  if (commands.empty() || may_be_none) return;
  std::string names;
  for (const CLI::App* c : commands) {
    if (word != nullptr && c->get_name() == word) return;
    names += (names.empty() ? "" : ", ") + c->get_name();
  }
  if (word == nullptr) throw UserError("give a command: " + names + " (see --help)");
  throw UserError("'" + std::string(word) + "' is no command; allowed: " + names + " (see --help)");
}

std::string plain(double v) {
  std::array<char, 400> text{};  // the longest double without an exponent
  return std::string(text.data(),
                     std::to_chars(text.data(), text.data() + text.size(), v, std::chars_format::fixed).ptr);
}

/// CLI11's "Could not convert: --seed = x" in the words of the other messages.
std::string in_our_words(const std::string& line) {
  static const std::regex converts("Could not convert: (-[^ ]+) = (.*)");
  static const std::regex twice("(-[^ ]+): At Most 1 required but received ([0-9]+)");
  static const std::regex no_value("(-[^ ]+): 1 required ([^: ]+).* missing");
  std::smatch found;
  if (std::regex_match(line, found, twice))
    return found[1].str() + ": given " + found[2].str() + " times; give it once";
  if (std::regex_match(line, found, no_value)) return found[1].str() + ": no value; give " + found[2].str();
  if (!std::regex_match(line, found, converts)) return line;
  const std::string text = found[2];
  double v = 0;
  const bool number = std::from_chars(text.data(), text.data() + text.size(), v).ec == std::errc();
  return found[1].str() + ": '" + text + "' is not allowed; give a " + (number ? "whole number" : "number");
}

/// How many letters have to be put in, left out or changed to make one word of the other (Levenshtein).
std::size_t letters_apart(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, changed}));
    }
  }
  return row.back();
}

/// "; did you mean --listen?", or nothing if no option is like that. Few mistake the first letter.
std::string guess_for(const CLI::App& app, const std::string& word) {
  constexpr std::size_t kLike = 2;
  std::string best;
  std::size_t least = kLike + 1;
  for (const CLI::Option* o : app.get_options())
    for (const std::string& name : o->get_lnames()) {
      const std::size_t apart = letters_apart("--" + name, word);
      if (apart >= least || !word.starts_with("--" + name.substr(0, 1))) continue;
      least = apart;
      best = "--" + name;
    }
  return best.empty() ? "" : "; did you mean " + best + "?";
}

/// Names of the options that take files: "--trace or --capture"; empty if there are none.
std::string options_for_files(const CLI::App& app) {
  std::string all;
  for (const CLI::Option* o : app.get_options())
    if (!o->get_lnames().empty() && o->get_type_name().find("FILE") != std::string::npos)
      all += (all.empty() ? "--" : " or --") + o->get_lnames().front();
  return all;
}

/// What to say of the first word of the command line that nobody wants.
std::string not_expected(const CLI::App& app) {
  const auto given = app.get_subcommands();
  const CLI::App& in = given.empty() ? app : *given.front();
  const std::vector<std::string> left = app.remaining(true);
  if (left.empty()) return "unexpected arguments";
  const std::string& whole = left.front();
  const std::string word = whole.starts_with("--") ? whole.substr(0, whole.find('=')) : whole;
  if (word.starts_with('-')) return "'" + word + "' is no option here" + guess_for(in, word);
  for (const CLI::Option* o : in.get_options())
    if (o->get_lnames().empty() && o->get_snames().empty() && o->count() > 0)
      return "'" + word + "' is one word too many; give one " + o->get_name();
  const std::string for_files = options_for_files(in);
  std::error_code unreadable;
  if (!for_files.empty() && std::filesystem::exists(word, unreadable))
    return "'" + word + "' stands without an option; give a file by " + for_files;
  return "'" + word + "' is one word too many; put a value that has spaces in quotes";
}

/// How messages name an option, or what is given without one.
std::string name_of(const CLI::Option& o) {
  return o.get_lnames().empty() ? o.get_name() : "--" + o.get_lnames().front();
}

/// An empty value is most likely a variable that is not set, and must not count as an option that is not given. Only
/// impairments may be empty: there are none then.
void refuse_empty_values(const CLI::App& app) {
  for (const CLI::Option* o : app.get_options()) {
    if (o->get_expected_min() == 0) continue;  // its value may be left out
    const std::string type = o->get_type_name();
    const std::vector<std::string>& values = o->results();
    if (type.find("SPEC") != std::string::npos || std::find(values.begin(), values.end(), "") == values.end()) continue;
    const std::string name = name_of(*o);
    throw UserError(name + ": is empty; " + (o->get_lnames().empty() ? "" : "give " + type + ", or ") + "leave " +
                    name + " out");
  }
}

/// CLI11 would take 010 for eight.
bool seems_octal(const std::string& text) {
  return text.size() > 1 && text[0] == '0' && text[1] >= '0' && text[1] <= '9';
}

void refuse_octal_numbers(const CLI::App& app) {
  for (const CLI::Option* o : app.get_options()) {
    const std::string type = o->get_type_name();
    const std::string word = type.substr(0, type.find_first_of(":, "));
    if (word != "N" && word != "INT" && word != "UINT") continue;
    for (const std::string& value : o->results())
      if (seems_octal(value)) throw UserError(name_of(*o) + ": '" + value + "' begins with 0; leave that out");
  }
}

/// Whether the two name one file that can be lost, also by hard links, or that will be made.
bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  const auto place = [&](const std::string& file) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(file, error), error);
  };
  const std::filesystem::path one = place(a);
  if (one.empty() || (one != place(b) && !std::filesystem::equivalent(a, b, error))) return false;
  return !std::filesystem::exists(one, error) || std::filesystem::is_regular_file(one, error);
}

/// A file that an option names.
struct NamedFile {
  const CLI::Option* option;
  std::string file;
  bool is_read;
  bool prints;
};

/// The files that a value of an option names: itself, or those in a specification of an input or of impairments.
std::vector<NamedFile> files_in(const CLI::Option& o, const std::string& value) {
  const std::string type = o.get_type_name();
  if (const auto path = path_text(value)) return {{&o, path->file, true, false}};
  std::vector<NamedFile> files;
  if (type.find("SPEC") != std::string::npos) {
    std::istringstream words(value);
    for (std::string before, word; words >> word; before = word)
      if (before == "trace" || before.ends_with("=trace")) files.push_back({&o, word, true, false});
  } else if (type.find("FILES") != std::string::npos) {
    std::istringstream list(value);
    for (std::string file; std::getline(list, file, ',');) files.push_back({&o, file, true, false});
  } else if (type.find("FILE") != std::string::npos) {
    files.push_back({&o, value, false, value == "-" && type.find("|-") != std::string::npos});
  }
  return files;
}

/// One of the two would overwrite what the other one reads or writes, or both would be printed into one another.
void refuse_shared_files(const CLI::App& app) {
  std::vector<NamedFile> all;
  for (const CLI::Option* o : app.get_options()) {
    if (o->count() == 0) continue;
    for (const std::string& value : o->results())
      for (NamedFile& named : files_in(*o, value)) all.push_back(std::move(named));
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const NamedFile& a = all[j];
      const NamedFile& b = all[i];
      if (a.option == b.option || (a.is_read && b.is_read)) continue;
      const std::string both = name_of(*a.option) + " and " + name_of(*b.option);
      if (a.prints && b.prints) throw UserError(both + ": only one of them can be printed; give a file in place of -");
      if (a.file != "-" && b.file != "-" && is_same_file(a.file, b.file))
        throw UserError(both + ": both name the file '" + b.file + "'; give each its own");
    }
  }
}

}  // namespace

bool parse(CLI::App& app, int argc, const char* const* argv) {
  check_command(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {  // --help, --version
    app.exit(request);
    return false;
  } catch (const CLI::ExtrasError&) {
    throw UserError(not_expected(app) + " (see --help)");
  } catch (const CLI::ParseError& e) {
    std::string line = e.what();
    constexpr std::size_t kMostSaid = 500;  // and far more would be too much for std::regex
    if (line.size() > kMostSaid) line = line.substr(0, kMostSaid) + "...";
    for (char& c : line)
      if (c == '\n') c = ' ';
    throw UserError(in_our_words(line) + " (see --help)");
  }
  std::vector<const CLI::App*> all{&app};
  for (const CLI::App* command : app.get_subcommands()) all.push_back(command);
  for (const CLI::App* each : all) {
    refuse_empty_values(*each);
    refuse_octal_numbers(*each);
    refuse_shared_files(*each);
  }
  return true;
}

CLI::Validator whole_number() {
  const auto check = [](std::string& text) -> std::string {
    std::uint64_t v = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
    if (error == std::errc() && end == text.data() + text.size() && !seems_octal(text)) return "";
    return "'" + text + "' is not allowed; give a whole number from 0 to 18446744073709551615";
  };
  return CLI::Validator(check, "");
}

CLI::Validator between(double low, double high, const std::string& unit) {
  const std::string allowed = plain(low) + " to " + plain(high) + (unit.empty() ? "" : " ") + unit;
  const auto check = [low, high, allowed](std::string& text) -> std::string {
    double v = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
    if (error == std::errc() && end == text.data() + text.size() && v >= low && v <= high && !seems_octal(text))
      return "";
    return "'" + text + "' is not allowed; give " + allowed;
  };
  return CLI::Validator(check, "in [" + plain(low) + " - " + plain(high) + "]");
}

CLI::Validator range(double low, double high) {
  return between(low, high, "");
}

std::vector<std::string> command_of(int argc, const char* const* argv) {
  return {argv, argv + argc};
}

std::string shell_line(const std::vector<std::string>& command) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
  std::string line;
  for (const std::string& word : command) {
    if (!line.empty()) line += ' ';
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) {
      line += word;
      continue;
    }
    line += '\'';
    for (const char c : word) {
      if (c == '\'') {
        line += "'\\''";
      } else {
        line += c;
      }
    }
    line += '\'';
  }
  return line;
}

}  // namespace padr::shell
