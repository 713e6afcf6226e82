#pragma once

#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/channel/secure_channels.h"
#include "peer/log.h"
#include "peer/options.h"
#include "shell/files.h"

namespace padr::peer {

/// `padr-peer keygen [FILE]`: prints a new session key, or writes it to a file that only its owner may read. The exit
/// code. Throws UserError.
int keygen(int argc, const char* const* argv);

/// The session's key by --key-file or else PADR_KEY; nothing if neither is given. Before it is read, the memory of the
/// process is protected, and it is wiped where it came from. Throws UserError.
std::optional<wire::Key> session_key(const std::string& file, std::vector<std::string>& warnings);

/// The keys of a session as they are made, for those who analyse captures.
class Keylog {
 public:
  /// A file that only its owner may read. Throws UserError.
  Keylog(const std::string& file, Log& log);
  void add(const PublicKey& from, const PublicKey& to, const wire::Key& key);
  /// Throws std::system_error if something could not be written: then nothing more was since, and play went on.
  void close();

 private:
  shell::OutputFile file_;
  Log& log_;
  std::exception_ptr trouble_;
};

/// For a peer in a session with a key; nothing if there is none. `keylog` may be null, and must outlive the channels.
std::optional<node::ChannelConfig> gate_config(const Options& options, Keylog* keylog);

}  // namespace padr::peer
