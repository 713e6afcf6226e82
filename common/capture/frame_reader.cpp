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
  constexpr std::string_view kTrace = "PADR";
  if (std::equal(head.begin(), head.end(), kTrace.begin(), kTrace.end(),
                 [](std::byte b, char c) { return std::to_integer<char>(b) == c; }))
    throw UserError(label_ + ": not a capture but a trace; padr-report reads it");
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
  return where + "the file ends in its midst";
}

}  // namespace padr::capture
