#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "common/model/hash.h"
#include "common/trace/events.h"

namespace padr::trace {

/// Walks through the bytes of a trace. A last record that is cut off is no error: the writer crashed or is still
/// running. Anything else that is wrong throws UserError, one line "LABEL: record N at byte B: what".
class TraceReader {
 public:
  /// `bytes` must outlive the reader. Reads as far as the header.
  TraceReader(std::span<const std::byte> bytes, std::string label);

  const std::string& label() const { return label_; }
  const Header& header() const { return header_; }

  /// The next record, nothing at the end. Its spans hold until the next call.
  std::optional<Event> next();

  /// The live world as of the last Step.
  const LiveView& live() const { return live_; }
  /// The confirmed world as of the last Confirmed.
  const Truth& truth() const { return truth_; }

  /// At the end: the last record was cut off.
  bool truncated() const { return truncated_; }
  /// At the end: there was a footer.
  bool clean() const { return clean_; }

 private:
  struct Parser;
  std::optional<std::span<const std::byte>> next_record();
  [[noreturn]] void refuse(const std::string& what) const;
  /// Refuses the trace if this is not the checksum of the records since the last one.
  void verify(std::uint32_t checksum);
  /// As verify() does, for a record whose checksum is of itself, too.
  void verify_itself(std::uint32_t checksum);

  std::span<const std::byte> bytes_;
  std::string label_;
  std::size_t at_ = 0;            ///< of the next record
  std::size_t record_start_ = 0;  ///< of the current one
  std::size_t record_ = 0;        ///< its number; the header is 1
  std::size_t verified_ = 0;      ///< what follows has not been verified by a checksum
  Hasher since_checksum_;         ///< of the records from there to the current one
  Header header_;
  LiveView live_;
  Truth truth_;
  std::vector<std::byte> datagram_;  ///< or other bytes of the current record
  Tick last_step_ = -1;
  Tick last_confirmed_ = -1;
  bool begun_ = false;
  bool truncated_ = false;
  bool clean_ = false;
};

}  // namespace padr::trace
