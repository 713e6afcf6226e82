#pragma once

#include <string>
#include <vector>

#include "tools/lab/alternatives/spec.h"

namespace padr::lab::alternatives {

/// A contestant that a file of this folder brings: entrants/NAME.cpp defines
///
///   namespace padr::lab::alternatives::entrants {
///   std::vector<Entrant> NAME() { return {{"name", "what it does", {.kind = Kind::kEntrant, .make = ...}}}; }
///   }
///
/// and is in every comparison and benchmark once it has been built: the list of all files is made when they are.
struct Entrant {
  std::string id;    ///< as --techniques takes it
  std::string what;  ///< one line for people
  Spec spec;
};

/// Of all files, in the order of their names.
std::vector<Entrant> all_entrants();

}  // namespace padr::lab::alternatives
