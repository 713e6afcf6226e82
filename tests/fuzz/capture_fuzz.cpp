// Readers of captures, and what padr-capture makes of them: whatever the bytes are, it ends with a result or a message.
#include "common/capture/frame_reader.h"
#include "common/capture/ip_packet.h"
#include "common/capture/pcapng_writer.h"
#include "common/model/user_error.h"
#include "common/wire/codec.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/good.h"
#include "tests/wire/samples.h"
#include "tools/capture/record.h"
#include "tools/capture/sentence.h"
#include "tools/capture/session_log.h"
#include "tools/capture/summary.h"
#include "tools/capture/timeline.h"

namespace {

using namespace padr;

/// Three datagrams of a peer, one of them a membership message, in either format.
wire::Bytes capture_of(Rng& rng) {
  Endpoint a, b;
  a.address[15] = b.address[14] = 1;
  a.port = 1;
  b.port = 2;
  wire::Bytes out;
  capture::PcapngWriter writer({"good", "fuzz", "lo", ""}, [&out](std::span<const std::byte> block) {
    out.insert(out.end(), block.begin(), block.end());
  });
  for (std::uint64_t i = 0; i < 3; ++i) {
    const bool state = rng.chance(0.7);
    const wire::Bytes payload =
        state ? wire::encode(test::any_packet(rng, 3))
              : wire::encode_membership(test::any_membership(rng, rng.below(test::kMembershipKinds)));
    const auto datagram = wire::seal({state ? wire::Kind::kState : wire::Kind::kMembership, 3, 9}, payload);
    std::vector<std::byte> ip;
    capture::make_udp_packet(a, b, datagram, 0, ip);
    writer.packet(static_cast<std::int64_t>(i) * 1'000'000'000, capture::Direction::kOutbound, ip);
  }
  return out;
}

/// Empty if it is too short for an envelope.
wire::Bytes resealed(std::span<const std::byte> datagram) {
  constexpr std::size_t kEnvelope = wire::kHeaderBytes + wire::kTagBytes;
  if (datagram.size() < kEnvelope || datagram.size() > wire::kMaxDatagram) return {};
  const auto at = [datagram](std::size_t i) { return std::to_integer<unsigned>(datagram[i]); };
  const wire::Header header{static_cast<wire::Kind>((at(2) & 15U) % 3), static_cast<PeerId>(at(3)),
                            static_cast<std::uint16_t>(at(4) | at(5) << 8U)};
  return wire::seal(header, datagram.subspan(wire::kHeaderBytes, datagram.size() - kEnvelope));
}

}  // namespace

wire::Bytes padr::test::good_input(Rng& rng) {
  return capture_of(rng);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span<const std::byte> rest = test::bytes(data, size);
  capture::FrameReader reader(
      [&rest](std::span<std::byte> into) {
        const std::size_t n = std::min({into.size(), rest.size(), std::size_t{100}});
        std::copy_n(rest.begin(), n, into.begin());
        rest = rest.subspan(n);
        return n;
      },
      "fuzz");
  capture::Tally tally;
  capture::Bookkeeper books;
  capture::Timeline timeline;
  capture::Recorder recorder;
  std::size_t text = 0;
  const auto look = [&](const capture::Datagram& d) {
    tally.take(d);
    books.take(d);
    timeline.take(d);
    const capture::Record r = recorder.record(d);
    text += r.json().size() + r.csv(capture::all_fields()).size() + capture::sentence(r).size();
  };
  try {
    while (const auto frame = reader.next()) {
      capture::Datagram d;
      const auto content = capture::udp_of(*frame, d);
      if (content != capture::Content::kUdp && content != capture::Content::kCutUdp) continue;
      d.time_ns = frame->time_ns;
      d.cut = content == capture::Content::kCutUdp;
      look(d);
      // The same with a checksum that fits, so that what is damaged is looked into.
      const wire::Bytes sealed = resealed(d.payload);
      d.payload = sealed;
      if (!sealed.empty()) look(d);
    }
    const capture::Source source{{"fuzz"}, {}, {reader.trouble()}};
    text += capture::summary_text(source, tally).size() + capture::summary_json(source, tally, {}).size();
    for (const auto& [session, events] : timeline.events())
      text += capture::timeline_csv(events).size() + capture::timeline_svg(session, events).size();
  } catch (const UserError&) {
  }
  return text == 1 ? 1 : 0;  // never: but all of it has to be made
}
