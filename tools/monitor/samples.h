#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "tools/monitor/trace_film.h"

namespace padr::monitor {

/// A session that comes along, to be looked at where nobody plays. It is not kept but played, on a virtual clock, when
/// somebody wants to see it: the same flags play the same to the bit.
struct Sample {
  std::string_view name;  ///< in addresses: lower case, digits and '-'
  std::string_view title;
  std::string_view about;  ///< a sentence or two for who has not read anything
  std::string_view live;   ///< the command that plays the like with real peers
  std::string_view scenario;
  std::string_view technique;              ///< as shell::technique_of takes it
  std::array<std::string_view, 2> inputs;  ///< dealt round to the peers; the second may be empty. Paths are built in
  std::string_view netem;
  int peers;
  int seconds;
};

std::span<const Sample> samples();
/// Null if there is none of that name.
const Sample* find_sample(std::string_view name);

/// The command that plays it in the lab, from the top of the source tree.
std::string lab_command(const Sample& sample);

/// Plays it and films it; takes a second or so, and more on a busy machine.
Film film_sample(const Sample& sample);

}  // namespace padr::monitor
