#include "common/capture/frame_reader.h"

#include <algorithm>
#include <string_view>

#include "common/capture/formats.h"
#include "common/model/user_error.h"

namespace padr::capture {

FrameReader::FrameReader(ByteSource source, std::string label) : label_(std::move(label)), queue_(std::move(source)) {}

FrameReader::~FrameReader() = default;

bool FrameReader::recognise() {
  const ByteView head = queue_.peek(4);
  if (head.size() < 4) {
    if (head.empty() || is_begin_of_magic(head)) return false;
  } else if (is_pcapng(head)) {
    format_ = make_pcapng_reader(queue_);
    return true;
  } else if (const auto kind = pcap_kind(head)) {
    format_ = make_pcap_reader(queue_, *kind);
    return true;
  }
  // The traces of padr-peer --trace lie beside its captures.
  const auto begins_with = [head](std::string_view text) {
    return head.size() >= text.size() &&
           std::equal(text.begin(), text.end(), head.begin(), [](char c, std::byte b) { return std::byte(c) == b; });
  };
  if (begins_with("PADR")) throw UserError(label_ + ": not a capture but a trace; padr-report reads it");
  if (begins_with("\x1F\x8B"))
    throw UserError(label_ + ": not a capture but gzip: zcat " + label_ + " | padr-capture ... -");
  if (begins_with("padr")) throw UserError(label_ + ": not a capture; it looks like a key log: --keylog " + label_);
  throw UserError(label_ + ": not a capture: neither pcap nor pcapng begins with these bytes");
}

std::optional<Frame> FrameReader::next() {
  if (!format_ && !recognise()) return std::nullopt;
  auto frame = format_->next();
  if (frame) packets_ = frame->number;
  return frame;
}

Stop FrameReader::stop() const {
  return format_ ? format_->stop() : Stop::kCut;
}

std::string FrameReader::trouble() const {
  if (stop() == Stop::kEnd) return "";
  const std::string where =
      label_ + ": packet " + std::to_string(packets_ + 1) + " at byte " + std::to_string(queue_.offset()) + ": ";
  if (stop() == Stop::kDamaged) return where + format_->damage();
  if (offset() == 0 && !format_) return label_ + ": the file is empty or ends after a few bytes";
  if (offset() == 0) return label_ + ": the file ends in its own header";
  return where + "the file ends in its midst";
}

}  // namespace padr::capture
