#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "common/wire/seal.h"
#include "tools/capture/input.h"

namespace padr::capture {

/// One datagram as fields by name, those of the Wireshark dissector: see `padr-capture export --help`.
class Record {
 public:
  struct Value {
    std::string text;
    bool is_text = false;  ///< in quotes in JSON; otherwise a number or true, false
  };

  void number(std::string_view name, std::uint64_t v) { add(name, {std::to_string(v), false}); }
  void signed_number(std::string_view name, std::int64_t v) { add(name, {std::to_string(v), false}); }
  void flag(std::string_view name, bool v) { add(name, {v ? "true" : "false", false}); }
  void text(std::string_view name, std::string_view v) { add(name, {std::string(v), true}); }
  void hex32(std::string_view name, std::uint32_t v);
  void bytes(std::string_view name, std::span<const std::byte> v);
  void hex64(std::string_view name, std::uint64_t v);
  /// The shortest text that reads back as the same float; text if it is not finite.
  void real(std::string_view name, float v);
  /// Addresses as inet_ntop writes the 16 bytes.
  void address(std::string_view name, const Endpoint& v);

  const std::vector<Value>* find(std::string_view name) const;
  /// In one line, without a newline. Fields that can come several times are lists, others are not.
  std::string json() const;
  /// One value, or several with semicolons between them; RFC 4180 quotes where they are needed.
  std::string csv(const std::vector<std::string_view>& columns) const;

 private:
  void add(std::string_view name, Value v);

  std::vector<std::pair<std::string_view, std::vector<Value>>> fields_;  ///< names are literals
};

/// Whether a field of this name may come several times in one datagram.
bool can_repeat(std::string_view name);
/// Every name there is, in a sensible order.
const std::vector<std::string_view>& all_fields();

/// Turns datagrams into records, one after another: who is at which address is learnt on the way.
class Recorder {
 public:
  Record record(const Datagram& d);

 private:
  std::map<Endpoint, PeerId> who_;
};

// The parts of a record; for Recorder.

/// False if everybody drops it; `why` says for what.
bool put_state(Record& r, const wire::Opened& o, std::string_view& why);
bool put_session(Record& r, const wire::Opened& o);
bool put_membership(Record& r, const wire::Opened& o);

}  // namespace padr::capture
