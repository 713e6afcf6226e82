#include "shell/session_words.h"

#include <functional>
#include <map>

#include "common/membership/last_heard.h"
#include "common/membership/misbehaviour_policy.h"
#include "shell/text.h"

namespace padr::shell {

using Kind = node::SessionEvent::Kind;

namespace {

/// Why a datagram was dropped, by the name that files have for it.
std::string why_dropped(const std::string& name) {
  static const std::map<std::string, std::string, std::less<>> words{
      {"malformed", "malformed"},
      {"tick", "it is of a tick that cannot be now"},
      {"order", "its updates contradict earlier ones"},
      {"entity", "it tells of a body that does not exist, or of one twice"},
      {"value", "its values are impossible"},
      {"signature", "an update in it has no valid signature"},
      {"right", "an order in it is not its sender's to give, or not yet"},
      {"cut_off", "its sender is ignored"},
      {"promise", "its sender had promised that there are no more updates of that time"}};
  const auto found = words.find(name);
  return found == words.end() ? name : found->second;
}

}  // namespace

std::string words_of(const node::SessionEvent& e) {
  const std::string who = "peer " + std::to_string(e.peer);
  const std::string count = std::to_string(e.count);
  switch (e.kind) {
    case Kind::kWelcomed:
      return "welcomed by " + to_string(e.at) + " as " + who;
    case Kind::kPassedOn:
      return to_string(e.at) + " passes us on to " + to_string(e.to);
    case Kind::kAdmitted:
      return "admitted at tick " + std::to_string(e.tick) + " as " + who;
    case Kind::kJoined:
      return who + " at " + to_string(e.at) + " joins at tick " + std::to_string(e.tick);
    case Kind::kLeft:
      return who + " has left";
    case Kind::kLost:
      return who + " is lost: out from tick " + std::to_string(e.tick);
    case Kind::kRefused:
      return "refused " + to_string(e.at) + ": " + e.text;
    case Kind::kUnreachable:
      return "nobody listens at " + who + "'s address";
    case Kind::kSuspected:
      return who + " is silent: asking the others for its updates";
    case Kind::kHeard:
      return who + " does not answer, but others hear it: it stays";
    case Kind::kHeardAgain:
      return who + " is heard again: it stays";
    case Kind::kCarried:
      return who + " is reached through peer " + std::to_string(e.by) + ": the link to it is silent";
    case Kind::kRelayed:
      return who + " is not reached: the link to it does not work, and others relay its updates, which is slow";
    case Kind::kDirect:
      return who + " is reached directly again";
    case Kind::kDropped:
      return "dropped " + counted(e.count, "datagram") + " of " + who + ": " + why_dropped(e.text);
    case Kind::kMuted:
      return who + " " + e.text + ": ignored for " + std::to_string(e.tick / kTicksPerSecond) + " s";
    case Kind::kWithholds:
      return who + " does not say which updates it has of a lost peer, or does not send them: going on without";
    case Kind::kCutOff:
      return who + " " + e.text + ": cut off";
    case Kind::kOutvoted:
      return "met " + count + (e.count == 1 ? " peer that goes" : " peers that go") + " on without us; we are " +
             std::to_string(e.own) + ": joining them by " + to_string(e.at);
    case Kind::kReturning:
      return e.text + ": joining anew";
    case Kind::kStillOut:
      return "not in yet: " + e.text;
    case Kind::kWrongKey:
      return counted(e.count, "datagram") + (e.count == 1 ? " was" : " were") +
             " not made with this session's key, the last by " + to_string(e.at);
    case Kind::kLastKeyLogged:
      return "the keys of " + count + " peers have been logged, and no more will be";
    case Kind::kReadable:
      return to_string(e.at) + " sends readable datagrams (--seal auth), though this peer encrypts";
    case Kind::kOtherSession:
      return to_string(e.at) + " is in another session; to come into that one, start this peer with --join " +
             to_string(e.at);
    case Kind::kDiffered:
      return "here and there " + e.text;
  }
  return {};
}

bool is_problem(const node::SessionEvent& e) {
  return e.kind >= Kind::kLost;
}

}  // namespace padr::shell
