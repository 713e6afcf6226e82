// Behaviours of a liar: what it says about who is there, and to those who join.
#include <algorithm>

#include "tools/lab/chaos/lies.h"

namespace padr::lab {
namespace {

/// The members as the liar knows them, or in their place peers whom nobody has ever seen.
std::vector<wire::Seat> seats(Deceiver& d, bool invented) {
  const node::Replica& n = d.replica();
  std::vector<wire::Seat> all;
  for (PeerId p = 0; p < n.config().slots; ++p) {
    if (p == n.self())
      all.push_back({p, n.config().incarnation, 0});
    else if (invented)
      all.push_back({p, 5000U + p, 0});
    else if (n.seat(p).there())
      all.push_back({p, n.seat(p).incarnation, 0});
  }
  return all;
}

void change_answer(Deceiver& d, wire::Answer& answer) {
  for (wire::Seat& s : answer.lost) switch (d.variant % 4) {
      case 0:
        s.heard = 1;
        break;
      case 1:
        s.heard = 0;
        break;
      case 2:
        s.have = 1'000'000;
        break;
      default:
        s.have = 0;
        answer.frozen = !answer.frozen;
    }
}

void corrupt(wire::Piece& piece, std::uint32_t variant) {
  switch (variant % 3) {
    case 0:  // a world that is another, or none
      for (std::size_t i = 7; i < piece.bytes.size(); i += 101) piece.bytes[i] ^= std::byte{1};
      break;
    case 1:  // for ever
      piece.count = wire::kMaxPieces;
      break;
    default:
      piece.index = 0;
  }
}

}  // namespace

void lie_with_probes(const Plot& plot) {
  plot->liar.send_too([plot](const wire::Header&, PeerId) {
    std::vector<wire::Bytes> out;
    if (!plot->active || !plot->rng.chance(0.1)) return out;
    const bool invented = plot->variant % 2 == 0 || plot->rng.chance(0.5);
    const wire::Probe probe{plot->replica().config().incarnation, seats(*plot, invented), false,
                            plot->replica().roster().newest_incarnation() + plot->rng.below(1000)};
    out.push_back(plot->said(probe));
    return out;
  });
}

void lie_with_answers(const Plot& plot) {
  plot->liar.speak_of_others([plot](wire::MembershipMessage& m) {
    if (auto* answer = std::get_if<wire::Answer>(&m); answer != nullptr && plot->active) change_answer(*plot, *answer);
  });
}

// Numbers grow now and then, which takes back what was asked before.
void lie_with_polls(const Plot& plot) {
  plot->liar.send_too([plot, number = std::uint32_t{0}](const wire::Header&, PeerId to) mutable {
    std::vector<wire::Bytes> out;
    const PeerId about = plot->victim();
    if (!plot->active || about == kNoPeer || about == to || !plot->rng.chance(0.1)) return out;
    if (plot->rng.chance(0.05)) number = std::min(number + 1, wire::kMostPollNumber);
    out.push_back(plot->said(wire::Poll{{{about, plot->replica().seat(about).incarnation}}, true, number}));
    return out;
  });
}

void lie_to_joiners(const Plot& plot) {
  const std::uint32_t sort = plot->variant % 5;
  plot->liar.speak_to_joiners([plot, sort](wire::SessionMessage& m) {
    const auto* welcome = std::get_if<wire::Welcome>(&m);
    if (welcome == nullptr || !plot->active) return;
    const std::uint64_t nonce = welcome->nonce;
    if (sort == 0) m = wire::Refuse{nonce, "no"};
    if (sort == 1) m = wire::Redirect{nonce, ipv4({192, 0, 2, 1}, 9)};
  });
  plot->liar.speak_of_others([plot, sort](wire::MembershipMessage& m) {
    if (auto* piece = std::get_if<wire::Piece>(&m); piece != nullptr && plot->active && sort >= 2)
      corrupt(*piece, sort - 2);
  });
}

}  // namespace padr::lab
