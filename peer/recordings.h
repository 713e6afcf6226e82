#pragma once

#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "common/replica/recorded_replica.h"
#include "peer/log.h"
#include "peer/options.h"
#include "shell/files.h"

namespace padr::peer {

/// Where the n-th incarnation is recorded to: NAME.trace, NAME.2.trace, NAME.3.trace, ...
std::string trace_file(const std::string& first, int incarnation);

/// The traces of a peer, one file for each of its incarnations.
class Recordings {
 public:
  /// Opens the first file, if --trace is given: throws UserError if that cannot be. Both must outlive it.
  Recordings(const Options& options, Log& log);

  /// Where to record incarnation 0, 1, ...; nothing without --trace, and if a later incarnation's file cannot be
  /// opened, which is said in the log. An incarnation that is begun anew because it got nowhere writes its file anew.
  std::optional<node::RecordedReplica::Recording> of(int incarnation);
  /// Throws std::system_error if something could not be written: then nothing more was since, and play went on.
  void close();

 private:
  void write(shell::OutputFile& file, std::span<const std::byte> bytes);
  trace::Provenance provenance() const;

  const Options& options_;
  Log& log_;
  std::vector<std::unique_ptr<shell::OutputFile>> files_;  ///< by incarnation; null where there is none
  std::exception_ptr trouble_;                             ///< the first failure
  std::string unopened_;                                   ///< the last file that could not be opened; empty: none
  bool begun_ = false;                                     ///< the first file has been written to, or may have been
};

}  // namespace padr::peer
