#pragma once

#include <map>
#include <optional>
#include <utility>

#include "tests/hostile/liar.h"
#include "tests/lab_audit/recorder.h"

namespace padr::test {

/// A session of four with a key, recorded, one of whom lies from some moment on.
class LiarTrial {
 public:
  static constexpr PeerId kLiar = 2;
  static constexpr std::uint32_t kBodies = 20;

  LiarTrial(std::uint64_t seed, const std::string& netem, wire::SealMode seal = wire::SealMode::kAuth)
      : recorder_("arena", seed, kBodies), trial_(4, kLiar, seal, seed, [this, netem](lab::VirtualNetworkConfig& c) {
          c.recording = recorder_.hook();
          c.netem = shell::parse_netem(netem);
        }) {
    run(3);
    from_ = trial_.replica(kLiar).now() + 1;
  }

  /// Tells `lie` of every update from now on, the same each time and to everybody.
  void tell(std::function<void(sync::Bundle&)> lie) {
    trial_.liar().begin([this, lie = std::move(lie)](sync::StatePacket& p, PeerId) {
      for (sync::Bundle& b : p.updates)
        if (b.tick >= from_) lie(b);
    });
  }
  void run(double s) { trial_.party().run(s); }
  Tick from() const { return from_; }
  Trial& trial() { return trial_; }
  const node::Replica& liar() const { return trial_.replica(kLiar); }
  const Recorder& recorder() const { return recorder_; }
  const PublicKey& key() { return trial_.liar().public_key(); }

  /// What the traces of the others say, and nothing of them.
  lab::audit::Report report() {
    trial_.party().net().finish();
    const int liar = trial_.person(kLiar);
    lab::audit::Report all = lab::audit::audit(recorder_.traces({liar}), {});
    for (const lab::audit::TraceText& t : recorder_.traces({liar})) blame(lab::audit::audit({t}, {}), t.label);
    blame(all, "all");
    return all;
  }
  /// How many findings of a kind there are.
  static int count(const lab::audit::Report& r, lab::audit::Kind kind) {
    return static_cast<int>(std::count_if(r.findings.begin(), r.findings.end(),
                                          [kind](const lab::audit::Finding& f) { return f.kind == kind; }));
  }

 private:
  /// Nobody but the liar is named; by its key, as it may have come back in another slot.
  void blame(const lab::audit::Report& r, const std::string& where) {
    for (const lab::audit::Finding& f : r.findings) {
      const lab::audit::Member& who = r.evidence.members[f.who];
      const bool is_liar = key() != PublicKey{} ? who.key == key() : who.slot == kLiar;
      EXPECT_TRUE(is_liar) << where << " blames slot " << int{who.slot} << "\n" << lines(r);
    }
  }

  Recorder recorder_;
  Trial trial_;
  Tick from_ = 0;
};

}  // namespace padr::test
