#include "shell/json.h"
#include "shell/text.h"
#include "tools/capture/names.h"
#include "tools/capture/summary.h"

namespace padr::capture {
namespace {

using shell::Json;

void put(Json& j, const Traffic& t) {
  j.field("datagrams", t.datagrams).field("wire_bytes", t.bytes).field("seconds", t.seconds());
  j.field("least_payload_bytes", t.least_size).field("most_payload_bytes", t.most_size);
  j.key("wire_bytes_by_part").begin_object();
  j.field("headers", t.header_bytes).field("envelopes", t.envelope_bytes).field("updates", t.update_bytes);
  j.field("updates_again", t.repeat_bytes).field("marks", t.mark_bytes).field("messages", t.other_bytes);
  j.field("cut_off", t.cut_bytes).end_object();
}

void put(Json& j, const LifeKey& key, const LifeTally& who) {
  j.begin_object();
  j.field("peer", static_cast<int>(key.slot)).field("incarnation", key.incarnation);
  j.field("address", to_string(who.at)).field("left", who.left);
  put(j, who.traffic);
  j.key("updates").begin_object();
  for (std::size_t c = 0; c < sync::kCauses; ++c) j.field(sync::kCauseNames[c], who.updates[c]);
  j.end_object().end_object();
}

void put(Json& j, const Tally& t, const LinkKey& key, const LinkTally& link, std::int64_t tick0) {
  j.begin_object();
  j.field("from", static_cast<int>(key.from.slot)).field("from_incarnation", key.from.incarnation);
  const PeerId to = t.receiver(key);
  j.key("to");
  if (to == kNoPeer) {
    j.null();
  } else {
    j.value(static_cast<int>(to));
  }
  j.field("to_incarnation", key.to_incarnation).field("to_address", to_string(link.at));
  put(j, link.traffic);
  const bool judged = t.judges(link);
  j.field("missing", judged ? std::optional(link.seqs.missing()) : std::nullopt);
  j.field("missing_of", judged ? std::optional(link.seqs.span()) : std::nullopt);
  j.field("loss_percent", judged ? std::optional(loss_percent(link)) : std::nullopt);
  j.field("duplicates", link.duplicates).field("reordered", link.reordered);
  j.field("marks", link.marks).field("updates_resent", link.repeats);
  j.field("gap_mean_ms", link.gaps.mean_us() / 1000).field("gap_p50_ms", link.gaps.percentile_us(0.5) / 1000);
  j.field("gap_p95_ms", link.gaps.percentile_us(0.95) / 1000);
  const DelayFigures d = delays_of(link, tick0);
  j.field("delay_mean_ms", d.mean_ms).field("delay_p50_ms", d.p50_ms).field("delay_p95_ms", d.p95_ms);
  j.field("delay_least_ms", d.least_ms).field("jitter_ms", d.jitter_ms);
  j.key("receivers_least_delay_ms");
  if (link.transit) {
    j.value(*link.transit / 10.0);
  } else {
    j.null();
  }
  j.key("receivers_loss_percent");
  if (link.told_loss.of() > 0) {
    j.value(link.told_loss.percent());
  } else {
    j.null();
  }
  j.field("receivers_loss_of", link.told_loss.of());
  j.field("acknowledged_updates", link.acks.count()).field("ack_mean_ms", link.acks.mean_us() / 1000);
  j.end_object();
}

void put(Json& j, const Tally& t, std::uint16_t number, const SessionTally& s) {
  j.begin_object().field("session", static_cast<int>(number));
  j.field("scenario", s.scenario).field("authority", s.authority);
  j.field("slots", s.slots).field("peers_at_start", s.wanted);
  j.field("first_tick", s.first_tick).field("last_tick", s.last_tick).field("hashes", s.hashes);
  const auto [tick0, by_clock] = t.tick0(number);
  j.field("delays_by", by_clock ? "session clock" : "fastest datagram");
  j.key("peers").begin_array();
  for (const auto& [key, who] : t.incarnations())
    if (key.session == number) put(j, key, who);
  j.end_array().key("links").begin_array();
  for (const auto& [key, link] : links_of(t, number)) put(j, t, key, *link, tick0);
  j.end_array().end_object();
}

void put(Json& j, const Source& s) {
  j.key("files").begin_array();
  for (const std::string& f : s.files) j.value(f);
  j.end_array().field("complete", s.troubles.empty()).key("troubles").begin_array();
  for (const std::string& t : s.troubles) j.value(t);
  j.end_array();
  const auto of = [&s](Content c) { return s.contents.of[static_cast<std::size_t>(c)]; };
  j.field("packets", s.contents.packets).field("datagrams", s.contents.ours);
  j.field("seen_in_another_file", s.contents.seen_again).field("other_udp", s.contents.others);
  j.field("out_of_order", s.contents.back);
  const auto sealed = [&s](Keyring::Reading r) { return s.contents.sealed[static_cast<std::size_t>(r)]; };
  j.key("sealed").begin_object().field("checked", sealed(Keyring::Reading::kChecked));
  j.field("unchecked", sealed(Keyring::Reading::kUnchecked)).field("encrypted", sealed(Keyring::Reading::kHidden));
  j.field("wrong", sealed(Keyring::Reading::kWrong)).field("carried", s.contents.carried);
  j.field("handshakes", s.contents.handshakes).end_object();
  j.field("not_udp", of(Content::kOther)).field("fragments", of(Content::kFragment));
  j.field("unknown_link_type", of(Content::kUnknownLink)).field("malformed_headers", of(Content::kMalformed));
  j.field("cut_headers", of(Content::kCutHeaders));
}

}  // namespace

std::string summary_json(const Source& source, const Tally& tally, const std::vector<std::string>& command) {
  Json j;
  j.begin_object().key("command").begin_array();
  for (const std::string& word : command) j.value(word);
  j.end_array();
  put(j, source);
  j.key("dropped").begin_object();
  for (const auto& [why, n] : tally.dropped()) j.field(why, n);
  j.end_object().field("not_told_apart", tally.beyond());
  j.key("all").begin_object();
  put(j, tally.all());
  j.end_object().key("messages").begin_object();
  for (const auto& [name, n] : tally.messages()) j.field(name, n);
  j.end_object().key("sessions").begin_array();
  for (const auto& [number, session] : tally.sessions())
    if (session.states > 0) put(j, tally, number, session);
  j.end_array().end_object();
  return j.text();
}

}  // namespace padr::capture
