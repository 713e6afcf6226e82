#pragma once

// What FrameReader chooses from; nobody else includes it.

#include <memory>
#include <optional>

#include "common/capture/frame_reader.h"

namespace padr::capture {

struct PcapKind {
  ByteOrder order;
  bool nanoseconds = false;
};

/// `head`: at least four bytes.
std::optional<PcapKind> pcap_kind(ByteView head);
bool is_pcapng(ByteView head);
/// Fewer than four bytes that may become the beginning of a capture yet.
bool is_begin_of_magic(ByteView head);

/// The queue, which must outlive the reader, stands at the file's beginning.
std::unique_ptr<FrameFormat> make_pcap_reader(ByteQueue& queue, PcapKind kind);
std::unique_ptr<FrameFormat> make_pcapng_reader(ByteQueue& queue);

}  // namespace padr::capture
