#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/capture/byte_queue.h"
#include "common/capture/frame.h"

namespace padr::capture {

/// Why there is no further frame.
enum class Stop : std::uint8_t {
  kEnd,      ///< the file ends where a packet ends
  kCut,      ///< it ends in the midst of one: the writer crashed, or is not done yet
  kDamaged,  ///< what comes next cannot be told: nothing behind it can be read
};

/// One kind of capture file. What it has read so far stays right when it stops.
class FrameFormat {
 public:
  virtual ~FrameFormat() = default;
  /// The next packet; nothing if there is none yet, or none any more.
  virtual std::optional<Frame> next() = 0;
  Stop stop() const { return stop_; }
  const std::string& damage() const { return damage_; }
  const std::string& comment() const { return comment_; }

 protected:
  std::optional<Frame> halt(Stop why, std::string what = {}) {
    stop_ = why;
    damage_ = std::move(what);
    return std::nullopt;
  }
  std::string comment_;  ///< of the newest section, if its writer left one

 private:
  Stop stop_ = Stop::kEnd;
  std::string damage_;
};

/// Reads pcap and pcapng, of either byte order, microseconds, nanoseconds or any if_tsresol, as a stream in bounded
/// memory. A file that is still being written can be read on: after kEnd and kCut `next` tries again.
class FrameReader {
 public:
  /// Nothing is read yet. `label` names the file in messages.
  FrameReader(ByteSource source, std::string label);
  ~FrameReader();

  /// The next packet; nothing at the end, see stop(). Throws UserError if this is no capture file at all.
  std::optional<Frame> next();

  Stop stop() const;
  /// In one line: file, packet number, byte offset and what is wrong there. Empty at a proper end.
  std::string trouble() const;
  const std::string& label() const { return label_; }
  /// What the file says of itself.
  std::string comment() const { return format_ ? format_->comment() : ""; }
  /// Bytes used up.
  std::uint64_t offset() const { return queue_.offset(); }

 private:
  bool recognise();

  std::string label_;
  ByteQueue queue_;
  std::uint64_t packets_ = 0;
  std::unique_ptr<FrameFormat> format_;
};

}  // namespace padr::capture
