#include "peer/session_key.h"

#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string_view>
#include <system_error>

#include "common/model/user_error.h"
#include "shell/key_text.h"
#include "shell/run_main.h"
#include "shell/secrets.h"

namespace padr::peer {
namespace {

constexpr const char* kEnvironment = "PADR_KEY";

/// 256 bytes at most.
void unpredictable_bytes(std::span<std::byte> out) {
  if (::getentropy(out.data(), out.size()) != 0)
    throw std::system_error(errno, std::generic_category(), "no random numbers from the system");
}

wire::Key unpredictable_key() {
  wire::Key key{};
  unpredictable_bytes(std::as_writable_bytes(std::span<std::uint8_t>(key)));
  return key;
}

std::optional<wire::Key> parsed(const shell::SecretText& text) {
  wire::Key key{};
  if (!shell::parse_key(text.text(), key)) return std::nullopt;
  return key;
}

/// A file that did not exist; nothing of it is left if it cannot be written.
void write_new(const std::string& file, const std::string& text) {
  shell::OutputFile out("keygen", file, shell::Readers::kOwnerNew);
  try {
    out.write(text);
    out.close();
  } catch (const std::system_error&) {
    std::remove(file.c_str());
    throw;
  }
}

void wipe(std::string& text) {
  wire::wipe(std::as_writable_bytes(std::span(text)));
}

}  // namespace

int keygen(int argc, const char* const* argv) {
  const std::string file = argc > 2 ? argv[2] : "-";
  if (file.empty()) throw UserError("keygen: the name of the file is empty; give one, or leave it out");
  if (argc > 3 || (file.size() > 1 && file[0] == '-')) {
    if (argc == 3 && (file == "--help" || file == "-h")) {
      std::puts(
          "usage: padr-peer keygen [FILE]\n\n"
          "Prints a new session key, or writes it to FILE. FILE must not exist yet; only you may read it then.\n"
          "All peers of a session need the same key: --key-file FILE, or the key itself in PADR_KEY.");
      return shell::kExitFine;
    }
    throw UserError("keygen: '" + std::string(argv[argc - 1]) + "' is not expected; give one file, or nothing");
  }
  shell::protect_memory();
  std::string text = shell::key_text(unpredictable_key()) + "\n";
  if (file == "-") {
    shell::write_text("keygen", file, text);
  } else {
    write_new(file, text);
  }
  wipe(text);
  return shell::kExitFine;
}

std::optional<wire::Key> session_key(const std::string& file, std::vector<std::string>& warnings) {
  constexpr std::string_view kWanted = "64 hexadecimal digits, such as padr-peer keygen makes";
  if (!file.empty()) {
    shell::protect_memory();
    auto key = parsed(shell::SecretText("--key-file", file));
    if (!key) throw UserError("--key-file: '" + file + "' has no key in it; a key is " + std::string(kWanted));
    struct stat s {};
    if (::stat(file.c_str(), &s) == 0 && S_ISREG(s.st_mode) && (s.st_mode & (S_IRWXG | S_IRWXO)) != 0)
      warnings.push_back("--key-file: other users than its owner may read '" + file + "'");
    return key;
  }
  // NOLINTNEXTLINE(concurrency-mt-unsafe): before any thread is there, and nobody else sets variables
  const char* value = std::getenv(kEnvironment);
  if (value == nullptr || *value == '\0') return std::nullopt;
  shell::protect_memory();
  auto key = parsed(shell::SecretText(kEnvironment));
  // What it is instead may be somebody's secret all the same.
  if (!key) throw UserError(std::string(kEnvironment) + ": is no key; a key is " + std::string(kWanted));
  return key;
}

Keylog::Keylog(const std::string& file, Log& log) : file_("--keylog", file, shell::Readers::kOwner), log_(log) {}

void Keylog::add(const PublicKey& from, const PublicKey& to, const wire::Key& key) {
  if (trouble_) return;
  std::string line = shell::keylog_line({from, to, key});
  try {
    file_.write(line);
    file_.flush();
  } catch (const std::exception& e) {
    trouble_ = std::current_exception();
    log_.session->error("--keylog: {}: no more keys are written", e.what());
  }
  wipe(line);
}

void Keylog::close() {
  if (trouble_) std::rethrow_exception(trouble_);
  file_.close();
}

std::optional<node::ChannelConfig> gate_config(const Options& options, Keylog* keylog) {
  if (!options.key) return std::nullopt;
  node::ChannelConfig c;
  c.session = *options.key;
  c.seed = unpredictable_key();
  c.random = unpredictable_bytes;
  c.mode = options.seal;
  if (keylog != nullptr)
    c.on_key = [keylog](const PublicKey& from, const PublicKey& to, const wire::Key& key) {
      keylog->add(from, to, key);
    };
  return c;
}

}  // namespace padr::peer
