#pragma once

#include "common/model/hash.h"
#include "common/trace/events.h"

namespace padr::trace {

namespace file {
class Record;
}

/// Turns what happens into the bytes of a trace, record by record; proto/trace.proto has the format. It writes no file:
/// whoever owns one gives a sink.
class TraceWriter {
 public:
  /// Hands magic, version and header to the sink at once.
  TraceWriter(const Header& header, ByteSink sink);

  /// First of all, if the header's incarnation is above 0.
  void begin(const Begin& b);
  void order(const Order& o);
  void freeze(const Freeze& f);
  void give_up(const GiveUp& g);
  void relayed(const Relayed& r);
  void excuse();
  void retune(const Retune& r);
  void push(const Push& p);
  void remark(const Remark& r);
  /// `live`: every entity of the header's scene.
  void step(const Step& s, const LiveView& live);
  void received(Micros at, std::span<const std::byte> datagram);
  void sent(PeerId to, Tick tick, std::span<const std::byte> datagram);
  void confirmed(Tick tick, std::uint64_t hash, const Truth& truth);
  /// The last record: the run ended well.
  void footer(const Footer& f);

 private:
  void hand_over(const file::Record& record);

  ByteSink sink_;
  Hasher since_checksum_;          ///< of what was handed over since the last one
  std::vector<BodyState> states_;  ///< as last told
  Truth truth_;                    ///< as last told
};

}  // namespace padr::trace
