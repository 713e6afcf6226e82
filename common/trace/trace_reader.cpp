#include "common/trace/trace_reader.h"

#include <google/protobuf/io/coded_stream.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "common/model/user_error.h"
#include "common/trace/trace_format.h"

namespace padr::trace {
namespace {

using google::protobuf::io::CodedInputStream;

constexpr std::size_t kPreamble = kMagic.size() + 1;

/// Entity ids out of gaps; an id past the last entity is reported by `ok`.
class Ids {
 public:
  explicit Ids(std::size_t entities) : entities_(entities) {}
  std::optional<std::size_t> next(std::uint32_t gap) {
    if (gap >= entities_ - next_) return std::nullopt;
    next_ += gap + std::size_t{1};
    return next_ - 1;
  }

 private:
  std::size_t entities_;
  std::size_t next_ = 0;
};

/// No world has such places or speeds; what is computed from them would not be finite.
constexpr float kBeyond = 1e9F;

bool possible(const BodyState& s) {
  const auto values = fields_of(s);
  return std::all_of(values.begin(), values.end(), [](float v) { return std::abs(v) < kBeyond; });
}

bool possible(Vec2 place) {
  return std::abs(place.x) < kBeyond && std::abs(place.y) < kBeyond;
}

bool follows(std::uint32_t tick, Tick last) {
  return tick < static_cast<std::uint32_t>(std::numeric_limits<Tick>::max()) && static_cast<Tick>(tick) == last + 1;
}

}  // namespace

/// What records say, once their bytes have been told apart. Each function returns what is wrong, if anything.
struct TraceReader::Parser {
  TraceReader& r;

  std::string changes(const file::Step& in) const {
    if (in.changed_size() != in.changed_fields_size()) return "columns of changed entities differ in length";
    Ids ids(r.live_.states.size());
    int next_value = 0;
    for (int i = 0; i < in.changed_size(); ++i) {
      const auto e = ids.next(in.changed(i));
      if (!e) return "no such entity";
      BodyState& s = r.live_.states[*e];
      auto values = fields_of(s);
      for (unsigned f = 0; f < values.size(); ++f) {
        if ((in.changed_fields(i) & (1U << f)) == 0) continue;
        if (next_value >= in.values_size()) return "fewer values than changed fields";
        values[f] = in.values(next_value++);
      }
      set_fields(s, values);
      s.awake = (in.changed_fields(i) & kAwakeBit) != 0;
      if (!possible(s)) return "the state of an entity is out of range";
    }
    return next_value == in.values_size() ? "" : "more values than changed fields";
  }

  std::string shown(const file::Step& in) const {
    for (std::size_t e = 0; e < r.live_.shown.size(); ++e) r.live_.shown[e] = r.live_.states[e].position;
    if (in.shown_at_size() != 2 * in.shown_size()) return "columns of shown entities differ in length";
    Ids ids(r.live_.shown.size());
    for (int i = 0; i < in.shown_size(); ++i) {
      const auto e = ids.next(in.shown(i));
      if (!e) return "no such entity";
      r.live_.shown[*e] = {in.shown_at(2 * i), in.shown_at(2 * i + 1)};
      if (!possible(r.live_.shown[*e])) return "a shown position is out of range";
    }
    return "";
  }

  std::string step(const file::Step& in, Step& s) const {
    if (!follows(in.tick(), r.last_step_)) return "step to tick " + std::to_string(in.tick()) + " is out of turn";
    s.tick = r.last_step_ = static_cast<Tick>(in.tick());
    s.target = {in.target_x(), in.target_y()};
    if (!is_finite(s.target) || !std::isfinite(in.threshold()) || !std::isfinite(in.own_error()) ||
        !std::isfinite(in.snap_m()))
      return "a number is not finite";
    s.leaving = in.leaving();
    s.outside = in.outside();
    s.live_hash = in.live_hash();
    s.threshold = in.threshold();
    s.own_error = in.own_error();
    s.lateness = in.lateness_us();
    s.replayed_steps = in.replayed_steps();
    s.snaps = in.snaps();
    s.snap_m = in.snap_m();
    s.signature.reset();
    if (!in.signature().empty()) {
      if (in.signature().size() != sizeof(sync::Signature)) return "a signature has another length";
      const auto bytes = std::as_bytes(std::span(in.signature()));
      std::copy(bytes.begin(), bytes.end(), s.signature.emplace().begin());
    }
    const std::string wrong = changes(in);
    return wrong.empty() ? shown(in) : wrong;
  }

  std::string confirmed(const file::Confirmed& in, Confirmed& c) const {
    if (!follows(in.tick(), r.last_confirmed_))
      return "confirmed tick " + std::to_string(in.tick()) + " is out of turn";
    c.tick = r.last_confirmed_ = static_cast<Tick>(in.tick());
    c.hash = in.hash();
    if (in.owner_size() != in.changed_size() || in.position_size() != 2 * in.changed_size())
      return "columns of confirmed entities differ in length";
    Ids ids(r.truth_.owner.size());
    for (int i = 0; i < in.changed_size(); ++i) {
      const auto e = ids.next(in.changed(i));
      if (!e) return "no such entity";
      const std::uint32_t owner = in.owner(i) / 2;
      if (owner > static_cast<std::uint32_t>(r.header_.slots)) return "no such owner";
      // Traces from before name the first peer as the owner of every body where there is no authority.
      const bool body = *e < static_cast<std::size_t>(r.header_.bodies);
      const bool nobody = owner == 0 || (body && !r.header_.technique.authority);
      r.truth_.owner[*e] = nobody ? kNoPeer : static_cast<PeerId>(owner - 1);
      r.truth_.present[*e] = in.owner(i) % 2 != 0;
      r.truth_.agreed[*e] = {in.position(2 * i), in.position(2 * i + 1)};
      if (!possible(r.truth_.agreed[*e])) return "a confirmed position is out of range";
    }
    return "";
  }

  std::string begin(const file::Begin& in, Begin& b) const {
    constexpr auto kMost = static_cast<std::uint32_t>(std::numeric_limits<Tick>::max());
    if (r.begun_) return "begins where something has begun";
    if (in.tick() >= kMost || in.confirmed() > in.tick()) return "begins at a tick that makes no sense";
    b.tick = static_cast<Tick>(in.tick());
    b.confirmed = static_cast<Tick>(in.confirmed());
    r.last_step_ = b.tick - 1;
    r.last_confirmed_ = b.confirmed - 1;
    return "";
  }

  std::string sent(const file::Sent& in) const {
    if (in.to() >= static_cast<std::uint32_t>(r.header_.slots)) return "sent to peer " + std::to_string(in.to());
    if (r.last_step_ < 0 || in.tick() != static_cast<std::uint32_t>(r.last_step_))
      return "sent at tick " + std::to_string(in.tick()) + ", which is not the present one";
    return "";
  }

  void check(const std::string& wrong) const {
    if (!wrong.empty()) r.refuse(wrong);
  }

  std::span<const std::byte> keep(const std::string& datagram) const {
    r.datagram_.resize(datagram.size());
    std::transform(datagram.begin(), datagram.end(), r.datagram_.begin(),
                   [](char c) { return static_cast<std::byte>(c); });
    return r.datagram_;
  }

  PeerId slot(std::uint32_t peer, const char* wrong) const {
    if (peer >= static_cast<std::uint32_t>(r.header_.slots)) r.refuse(wrong);
    return static_cast<PeerId>(peer);
  }

  /// Of one that came later, or of who comes and goes.
  Event membership(const file::Record& in) const {
    if (in.has_begin()) {
      Begin b;
      check(begin(in.begin(), b));
      r.begun_ = true;
      b.transfer = keep(in.begin().transfer());
      return b;
    }
    if (in.has_order()) return Order{keep(in.order().fetched())};
    if (in.has_relayed()) return Relayed{keep(in.relayed().fetched())};
    if (in.has_freeze()) return Freeze{slot(in.freeze().peer(), "freezes no slot"), in.freeze().frozen()};
    if (in.has_give_up()) return GiveUp{slot(in.give_up().peer(), "gives up no slot")};
    return Excuse{};
  }

  /// What is done to the peer from outside.
  Event interference(const file::Record& in) const {
    if (in.has_retune()) {
      Retune t;
      if (!take_technique(in.retune(), t.technique)) r.refuse("a knob of the technique is out of range");
      if (t.technique.authority != r.header_.technique.authority) r.refuse("changes the rule of authority");
      return t;
    }
    if (in.has_push()) {
      const file::Push& p = in.push();
      if (p.body() >= static_cast<std::uint32_t>(r.header_.bodies)) r.refuse("pushes no body");
      if (!(std::abs(p.x()) <= Push::kMost && std::abs(p.y()) <= Push::kMost)) r.refuse("pushes too hard");
      return Push{static_cast<EntityId>(p.body()), {p.x(), p.y()}};
    }
    const std::uint32_t peer = in.remark().peer();
    return Remark{in.remark().kind(), peer == 0 ? kNoPeer : slot(peer - 1, "is about no slot"), in.remark().text()};
  }

  Footer footer(const file::Footer& in) const {
    Footer f;
    f.bundles = in.bundles();
    f.updates_by_cause.assign(in.updates_by_cause().begin(), in.updates_by_cause().end());
    f.repeats = in.repeats();
    f.datagrams_sent = in.datagrams_sent();
    f.wire_bytes_sent = in.wire_bytes_sent();
    f.datagrams_received = in.datagrams_received();
    f.dropped.assign(in.dropped().begin(), in.dropped().end());
    f.hash_checks = in.hash_checks();
    f.hash_mismatches = in.hash_mismatches();
    f.first_mismatch = in.first_mismatch();
    f.superseded = in.superseded();
    for (const file::Dropped& d : in.dropped_of())
      f.dropped_of.push_back(
          {slot(d.peer(), "dropped something of no slot"), {d.by_reason().begin(), d.by_reason().end()}});
    return f;
  }
};

void TraceReader::refuse(const std::string& what) const {
  throw UserError(label_ + ": record " + std::to_string(record_) + " at byte " + std::to_string(record_start_) + ": " +
                  what);
}

namespace {

// As pcap or pcapng files begin, of whatever byte order and resolution.
bool is_capture(std::span<const std::byte> bytes) {
  constexpr std::array<std::uint32_t, 5> kMagics{0xa1b2c3d4, 0xd4c3b2a1, 0xa1b23c4d, 0x4d3cb2a1, 0x0a0d0d0a};
  std::uint32_t magic = 0;
  if (bytes.size() < sizeof magic) return false;
  std::memcpy(&magic, bytes.data(), sizeof magic);
  return std::find(kMagics.begin(), kMagics.end(), magic) != kMagics.end();
}

}  // namespace

TraceReader::TraceReader(std::span<const std::byte> bytes, std::string label)
    : bytes_(bytes), label_(std::move(label)) {
  if (bytes.empty()) throw UserError(label_ + ": is empty, not a trace");
  for (std::size_t i = 0; i < std::min(kMagic.size(), bytes.size()); ++i)
    if (bytes[i] != static_cast<std::byte>(kMagic[i]))
      throw UserError(label_ + ": not a trace of padr (it does not begin with " + std::string(kMagic) + ")" +
                      (is_capture(bytes) ? "; it is a capture of packets, which padr-capture reads" : ""));
  if (bytes.size() < kPreamble)
    throw UserError(label_ + ": ends within the first " + std::to_string(kPreamble) + " bytes");
  const auto version = std::to_integer<unsigned>(bytes[kMagic.size()]);
  if (version != kFormatVersion)
    throw UserError(label_ + ": trace format " + std::to_string(version) + "; this program reads format " +
                    std::to_string(kFormatVersion));
  at_ = verified_ = kPreamble;
  const auto first = next_record();
  if (!first) throw UserError(label_ + ": ends before its header is complete");
  file::Record record;
  if (!record.ParseFromArray(first->data(), static_cast<int>(first->size())) || !record.has_header())
    refuse("is not a header");
  // Without one it is of a trace from before, or the next checksum does not fit.
  if (record.header().checksum() != 0) {
    verify_itself(record.header().checksum());
    verified_ = at_;
  }
  const std::string wrong = take_header(record.header(), header_);
  if (!wrong.empty()) refuse("header: " + wrong);
  begun_ = header_.incarnation == 0;
  const auto entities = static_cast<std::size_t>(header_.entities());
  live_.states.assign(entities, kUntold);
  live_.shown.resize(entities);
  truth_ = nothing_agreed(entities);
}

std::optional<std::span<const std::byte>> TraceReader::next_record() {
  if (at_ >= bytes_.size()) return std::nullopt;
  if (record_start_ >= verified_) add_record(since_checksum_, bytes_.subspan(record_start_, at_ - record_start_));
  record_start_ = at_;
  ++record_;
  constexpr std::size_t kLongestLength = 5;  // bytes of a varint of 32 bits
  const auto rest = bytes_.subspan(at_, std::min(bytes_.size() - at_, kLongestLength));
  CodedInputStream in(reinterpret_cast<const std::uint8_t*>(rest.data()), static_cast<int>(rest.size()));
  std::uint32_t size = 0;
  const bool whole = in.ReadVarint32(&size);
  if (!whole && rest.size() == kLongestLength) refuse("its length makes no sense");
  if (whole && size > kMaxRecordBytes) refuse("its length of " + std::to_string(size) + " bytes makes no sense");
  at_ += static_cast<std::size_t>(in.CurrentPosition());
  if (!whole || bytes_.size() - at_ < size) {
    at_ = bytes_.size();
    truncated_ = true;
    return std::nullopt;
  }
  const auto record = bytes_.subspan(at_, size);
  at_ += size;
  return record;
}

void TraceReader::verify(std::uint32_t checksum) {
  if (checksum == 0 && verified_ == kPreamble) return;  // a trace from before
  if (checksum_of(since_checksum_) != checksum)
    refuse("its checksum does not fit: the trace is damaged between byte " + std::to_string(verified_) + " and here");
  since_checksum_ = {};
  verified_ = record_start_;
}

void TraceReader::verify_itself(std::uint32_t checksum) {
  if (checksum != 0) add_up_to_checksum(since_checksum_, bytes_.subspan(record_start_, at_ - record_start_));
  verify(checksum);
}

std::optional<Event> TraceReader::next() {
  const auto bytes = next_record();
  if (!bytes) return std::nullopt;
  if (clean_) refuse("comes after the footer");
  file::Record record;
  if (!record.ParseFromArray(bytes->data(), static_cast<int>(bytes->size()))) refuse("does not decode");
  const Parser parser{*this};
  if (!begun_ && !record.has_begin()) refuse("is not what one who came later begins with");
  switch (record.kind_case()) {
    case file::Record::kBegin:
    case file::Record::kOrder:
    case file::Record::kFreeze:
    case file::Record::kGiveUp:
    case file::Record::kRelayed:
    case file::Record::kExcuse:
      return parser.membership(record);
    case file::Record::kRetune:
    case file::Record::kPush:
    case file::Record::kRemark:
      return parser.interference(record);
    case file::Record::kStep: {
      Step s;
      verify(record.step().checksum());
      parser.check(parser.step(record.step(), s));
      return s;
    }
    case file::Record::kReceived:
      return Received{record.received().at_us(), parser.keep(record.received().datagram())};
    case file::Record::kSent:
      parser.check(parser.sent(record.sent()));
      return Sent{static_cast<PeerId>(record.sent().to()), static_cast<Tick>(record.sent().tick()),
                  parser.keep(record.sent().datagram())};
    case file::Record::kConfirmed: {
      Confirmed c;
      parser.check(parser.confirmed(record.confirmed(), c));
      return c;
    }
    case file::Record::kFooter:
      clean_ = true;
      verify_itself(record.footer().checksum());
      return parser.footer(record.footer());
    case file::Record::kHeader:
      refuse("is a second header");
    case file::Record::KIND_NOT_SET:
      break;
  }
  refuse("is of a kind that this program does not know");
}

}  // namespace padr::trace
