#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/link/netem_spec.h"
#include "shell/link_trace.h"

namespace padr::shell {

/// Reads the options of `tc qdisc add ... netem OPTIONS`, as iproute2 does: keywords by prefix, TIME with s, ms, us or
/// ns (a bare number is microseconds), percentages with or without `%`, rates where `bit` is bits and `bps` is bytes
/// per second. An empty text is a perfect link.
///
/// Stricter than tc where tc takes nonsense: transitions of `loss state` that add up to more than 100 %, infinite
/// times. Laxer: `distribution uniform` works, `.5` is a number, `duplicate`'s correlation is never ignored, `seed N`
/// is always known. `ecn` is refused: the datagrams that pass here have no ECN bits. What tc does not have is
/// `trace NAME|FILE [START|random]`: a link trace, see link_trace.h. `read` reads a FILE; without it only the built-in
/// ones have a name.
///
/// Things that are legal but rarely meant are added to `warnings`, one line each, unless it is null.
/// Throws UserError: one line with the word, its number and column, and what is allowed.
link::NetemSpec parse_netem(std::string_view text, std::vector<std::string>* warnings = nullptr,
                            const ReadFile& read = {});

/// Canonical form: only what differs from a perfect link, every unit written. parse_netem(to_string(s)) == s, with the
/// same `read`.
std::string to_string(const link::NetemSpec& spec);

/// The name that the grammar uses: uniform, normal, pareto, paretonormal.
std::string_view to_string(link::Distribution distribution);

}  // namespace padr::shell
