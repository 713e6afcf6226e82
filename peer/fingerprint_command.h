#pragma once

namespace padr::peer {

/// `padr-peer fingerprint [OTHER]`: prints this machine's physics fingerprint and, with another machine's, what
/// differs. Returns the exit code.
int fingerprint_command(int argc, const char* const* argv);

}  // namespace padr::peer
