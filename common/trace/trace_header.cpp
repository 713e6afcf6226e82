#include <google/protobuf/io/coded_stream.h>

#include <algorithm>
#include <cassert>
#include <cstring>

#include "common/trace/trace_format.h"

namespace padr::trace {

using google::protobuf::io::CodedOutputStream;

std::vector<std::byte> delimited(const file::Record& record) {
  const std::size_t size = record.ByteSizeLong();
  assert(size <= kMaxRecordBytes);
  const auto prefix = static_cast<std::size_t>(CodedOutputStream::VarintSize32(static_cast<std::uint32_t>(size)));
  std::vector<std::byte> bytes(prefix + size);
  auto* const out = reinterpret_cast<std::uint8_t*>(bytes.data());
  CodedOutputStream::WriteVarint32ToArray(static_cast<std::uint32_t>(size), out);
  record.SerializeWithCachedSizesToArray(out + prefix);
  return bytes;
}

// By words: all that is recorded passes through here.
void add_record(Hasher& sum, std::span<const std::byte> bytes) {
  std::uint64_t word = 0;
  sum.add(static_cast<std::uint64_t>(bytes.size()));
  for (; bytes.size() >= sizeof word; bytes = bytes.subspan(sizeof word)) {
    std::memcpy(&word, bytes.data(), sizeof word);
    sum.add(word);
  }
  word = 0;
  std::memcpy(&word, bytes.data(), bytes.size());
  sum.add(word);
}

void add_up_to_checksum(Hasher& sum, std::span<const std::byte> bytes) {
  add_record(sum, bytes.first(bytes.size() - sizeof(std::uint32_t)));
}

std::uint32_t checksum_of(const Hasher& sum) {
  return std::max<std::uint32_t>(1, static_cast<std::uint32_t>(sum.value()));
}

void put_technique(const Technique& t, file::Technique& out) {
  // Names every field, so that a new one does not compile until it is told here and in take_technique.
  const auto& [name, authority, replay, model, predictor, law, lead, time_space, foresee, high, low, body_threshold,
               convergence, radius, steps, count, pcc_bound, update_every_contact, every_tick, end_update, proxy_update,
               rest_state, precision, unowned, time_stamps, budget] = t;
  out.set_name(name);
  out.set_authority(authority);
  out.set_replay(replay);
  out.set_model(static_cast<std::uint32_t>(model));
  out.set_predictor(static_cast<std::uint32_t>(predictor));
  out.set_law(static_cast<std::uint32_t>(law));
  out.set_convergence(static_cast<std::uint32_t>(convergence));
  out.set_threshold_high(high);
  out.set_threshold_low(low);
  out.set_body_threshold(body_threshold);
  out.set_lead(lead);
  out.set_time_space(time_space);
  out.set_foresee(foresee);
  out.set_radius(radius);
  out.set_steps(static_cast<std::uint32_t>(steps));
  out.set_count(static_cast<std::uint32_t>(count));
  out.set_pcc_bound(pcc_bound);
  out.set_update_every_contact(update_every_contact);
  out.set_every_tick(every_tick);
  out.set_no_end_update(!end_update);
  out.set_no_proxy_update(!proxy_update);
  out.set_no_rest_state(!rest_state);
  out.set_precision(static_cast<std::uint32_t>(precision));
  out.set_unowned(static_cast<std::uint32_t>(unowned));
  out.set_time_stamps(time_stamps);
  out.set_budget(budget);
}

bool take_technique(const file::Technique& in, Technique& t) {
  if (in.model() > static_cast<unsigned>(Model::kChosen) || in.predictor() > static_cast<unsigned>(Predictor::kPcc) ||
      in.law() > static_cast<unsigned>(ThresholdLaw::kContinuous) ||
      in.convergence() > static_cast<unsigned>(Convergence::kTrack) ||
      in.precision() > static_cast<unsigned>(Precision::kRounded) ||
      in.unowned() > static_cast<unsigned>(Unowned::kLive))
    return false;  // before it is cut to the size of an enumeration
  t.name = in.name();
  t.authority = in.authority();
  t.replay = in.replay();
  t.model = static_cast<Model>(in.model());
  t.predictor = static_cast<Predictor>(in.predictor());
  t.law = static_cast<ThresholdLaw>(in.law());
  t.convergence = static_cast<Convergence>(in.convergence());
  t.threshold_high = in.threshold_high();
  t.threshold_low = in.threshold_low();
  t.body_threshold = in.body_threshold();
  t.lead = in.lead();
  t.time_space = in.time_space();
  t.foresee = in.foresee();
  t.radius = in.radius();
  t.steps = static_cast<int>(in.steps());
  t.count = static_cast<int>(in.count());
  t.pcc_bound = in.pcc_bound();
  t.update_every_contact = in.update_every_contact();
  t.every_tick = in.every_tick();
  t.end_update = !in.no_end_update();
  t.proxy_update = !in.no_proxy_update();
  t.rest_state = !in.no_rest_state();
  t.precision = static_cast<Precision>(in.precision());
  t.unowned = static_cast<Unowned>(in.unowned());
  t.time_stamps = in.time_stamps();
  t.budget = in.budget();
  return wrong_field(t).empty();
}

void put_header(const Header& h, file::Header& out) {
  out.set_program(h.program);
  out.set_revision(h.revision);
  for (const std::string& word : h.command) out.add_command(word);
  out.set_peer(h.peer);
  out.set_peers(static_cast<std::uint32_t>(h.peers));
  out.set_slots(static_cast<std::uint32_t>(h.slots));
  out.set_session(h.session);
  out.set_scenario(h.scenario);
  out.set_scenario_text(h.scenario_text);
  out.set_scenario_seed(h.scenario_seed);
  out.set_scene_hash(h.scene_hash);
  out.set_fingerprint(h.fingerprint);
  out.set_bodies(static_cast<std::uint32_t>(h.bodies));
  put_technique(h.technique, *out.mutable_technique());
  out.set_netem(h.netem);
  out.set_netem_seed(h.netem_seed);
  out.set_input(h.input);
  out.set_start_unix_us(h.start_unix_us);
  out.set_incarnation(h.incarnation);
  out.set_is_signed(h.is_signed);
  out.set_spectates(h.spectates);
  out.set_wanted(static_cast<std::uint32_t>(h.wanted));
  if (h.session_id != SessionId{}) out.set_session_id(h.session_id.data(), h.session_id.size());
}

std::string take_header(const file::Header& in, Header& h) {
  if (in.slots() < 1 || in.slots() > kMaxPeers)
    return "slots " + std::to_string(in.slots()) + ", allowed: 1 to " + std::to_string(kMaxPeers);
  if (in.peers() < 1 || in.peers() > in.slots()) return "peers " + std::to_string(in.peers()) + ", allowed: 1 to slots";
  if (in.incarnation() == 0 && in.peer() >= in.peers())
    return "peer " + std::to_string(in.peer()) + ", allowed: below the number of peers";
  if (in.wanted() > in.slots()) return "wanted " + std::to_string(in.wanted()) + ", allowed: 0 to slots";
  if (in.peer() >= in.slots()) return "peer " + std::to_string(in.peer()) + ", allowed: below the number of slots";
  if (!in.session_id().empty() && in.session_id().size() != h.session_id.size())
    return "session_id of " + std::to_string(in.session_id().size()) + " bytes, allowed: 0 or 16";
  if (in.session() > 0xFFFF) return "session " + std::to_string(in.session()) + ", allowed: 0 to 65535";
  if (in.bodies() >= kNoEntity || in.bodies() + in.slots() >= kNoEntity)
    return "bodies " + std::to_string(in.bodies()) + ", too many";
  if (!take_technique(in.technique(), h.technique)) return "a knob of the technique is out of range";
  h.program = in.program();
  h.revision = in.revision();
  h.command.assign(in.command().begin(), in.command().end());
  h.peer = static_cast<PeerId>(in.peer());
  h.peers = static_cast<int>(in.peers());
  h.slots = static_cast<int>(in.slots());
  h.session = static_cast<std::uint16_t>(in.session());
  h.scenario = in.scenario();
  h.scenario_text = in.scenario_text();
  h.scenario_seed = in.scenario_seed();
  h.scene_hash = in.scene_hash();
  h.fingerprint = in.fingerprint();
  h.bodies = static_cast<int>(in.bodies());
  h.netem = in.netem();
  h.netem_seed = in.netem_seed();
  h.input = in.input();
  h.start_unix_us = in.start_unix_us();
  h.incarnation = in.incarnation();
  h.is_signed = in.is_signed();
  h.spectates = in.spectates();
  h.wanted = static_cast<int>(in.wanted());
  std::copy(in.session_id().begin(), in.session_id().end(), h.session_id.begin());
  return {};
}

}  // namespace padr::trace
