#include "tools/monitor/capture_film.h"

#include <limits>

#include "common/model/user_error.h"
#include "common/monitor/sampler.h"
#include "shell/text.h"
#include "tools/capture/rebuild.h"

namespace padr::monitor {
namespace {

/// Tells of what changes from tick to tick in the agreed world.
class Reporter {
 public:
  std::vector<Event> take(const sync::FoldState& s) {
    std::vector<Event> out;
    if (known_) {
      for (std::size_t b = 0; b < s.authority.size(); ++b) {
        const PeerId owner = s.authority[b].holder();
        const PeerId before = last_.authority[b].holder();
        if (owner == before) continue;
        out.push_back(event(s.tick, owner == kNoPeer ? EventKind::kRelease : EventKind::kAuthority,
                            static_cast<EntityId>(b), owner == kNoPeer ? before : owner));
      }
      for (std::size_t p = 0; p < s.members.size(); ++p) {
        if (s.members[p] == last_.members[p]) continue;
        out.push_back(event(s.tick, s.members[p].present ? EventKind::kJoined : EventKind::kLeft, kNoEntity,
                            static_cast<PeerId>(p)));
      }
    }
    last_ = s;
    known_ = true;
    return out;
  }

 private:
  Event event(Tick tick, EventKind kind, EntityId entity, PeerId peer) {
    return {++number_, tick, kind, entity, peer, 0, ""};
  }
  sync::FoldState last_;
  bool known_ = false;
  std::uint32_t number_ = 0;
};

}  // namespace

Film film_captures(const std::vector<std::string>& files, const std::vector<std::string>& keylogs,
                   const capture::SettingFlags& flags, const Note& note) {
  capture::Captures captures(files, keylogs);
  capture::Bookkeeper books;
  while (const capture::Datagram* d = captures.next()) books.take(*d);
  for (const std::string& trouble : captures.troubles()) note(trouble);
  const capture::SessionLog& session_log = books.choose(flags.session());
  if (const std::string why = capture::nothing_to_begin_with(session_log, captures.contents()); !why.empty())
    throw UserError("--capture: " + why);
  const capture::Setting setting = flags.setting(session_log);
  const std::size_t entities = setting.scene.bodies.size() + static_cast<std::size_t>(setting.slots);
  const Tick sample = sample_for(session_log.newest, 1, entities);
  FilmMaker maker(
      std::make_unique<ObservedSession>(SessionKey{session_log.session, scene_hash(setting.scene)}, setting.scene,
                                        shell::valid_utf8(setting.label), 0, setting.slots, 0),
      sample, session_log.newest);
  Reporter reporter;
  const Origin nobody{1, session_log.session, kNoPeer, 0};
  const capture::Rebuilt r =
      capture::rebuild(session_log, setting, 0, [&](const sync::FoldState& s, std::uint64_t hash) {
        const Micros now = FilmMaker::time_of(s.tick);
        auto events = reporter.take(s);
        if (!events.empty()) maker.session().take({nobody, Events{std::move(events)}}, {}, now);
        if (s.tick % sample != 0) return;
        Agreed a;
        Sampler::agreed(s, hash, setting.authority, a);
        maker.session().show_agreed(a);
        maker.take(s.tick);
      });
  if (r.stretches.empty()) throw UserError("--capture: nothing of the session's world follows from the packets");
  for (const capture::Stretch& s : r.stretches)
    note("rebuilt from tick " + std::to_string(s.from) + " to " + std::to_string(s.to) +
         (s.why.empty() ? "" : ": " + s.why));
  note(std::to_string(r.agreeing()) + " of " + std::to_string(r.hashes.size()) + " hashes that peers told agree");
  return maker.finish();
}

}  // namespace padr::monitor
