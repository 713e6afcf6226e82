#include "peer/recordings.h"

#include <chrono>
#include <filesystem>
#include <stdexcept>

#include "common/model/user_error.h"
#include "shell/revision.h"

namespace padr::peer {

std::string trace_file(const std::string& first, int incarnation) {
  if (incarnation == 0) return first;
  const std::filesystem::path path(first);
  const std::string name = path.stem().string() + "." + std::to_string(incarnation + 1) + path.extension().string();
  return (path.parent_path() / name).string();
}

namespace {

std::unique_ptr<shell::OutputFile> open_trace(const std::string& path) {
  return std::make_unique<shell::OutputFile>("--trace", path, shell::Readers::kAsUsual, shell::Content::kBinary);
}

}  // namespace

Recordings::Recordings(const Options& options, Log& log) : options_(options), log_(log) {
  if (!options.trace.empty()) files_.push_back(open_trace(options.trace));
}

trace::Provenance Recordings::provenance() const {
  const Options& o = options_;
  trace::Provenance p;
  p.program = "padr-peer";
  p.revision = std::string(shell::revision());
  p.command = o.command;
  p.scenario = o.scenario.label;
  p.scenario_text = o.scenario.text;
  p.scenario_seed = o.scenario.seed;
  p.netem = o.netem_text;
  p.netem_seed = o.netem_seed;
  p.input = o.input;
  p.start_unix_us =
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
          .count();
  return p;
}

std::optional<node::RecordedReplica::Recording> Recordings::of(int incarnation) {
  if (files_.empty()) return std::nullopt;
  const auto n = static_cast<std::size_t>(incarnation);
  if (incarnation > 0 || begun_) {
    files_.resize(std::max(files_.size(), n + 1));
    files_[n].reset();  // what it has buffered is written now, and not into the file that begins anew
    try {
      files_[n] = open_trace(trace_file(options_.trace, incarnation));
    } catch (const UserError& e) {
      unopened_ = std::string(e.what()) + ": the peer has joined again, and this is not recorded";
      log_.play->error("{}", unopened_);
      return std::nullopt;
    }
  }
  begun_ = true;
  shell::OutputFile* file = files_[n].get();
  return node::RecordedReplica::Recording{provenance(),
                                          [this, file](std::span<const std::byte> b) { write(*file, b); }};
}

void Recordings::write(shell::OutputFile& file, std::span<const std::byte> bytes) {
  if (trouble_) return;
  try {
    file.write(bytes);
  } catch (const std::exception& e) {
    trouble_ = std::current_exception();
    log_.play->error("--trace: {}: nothing more is recorded", e.what());
  }
}

void Recordings::close() {
  if (trouble_) std::rethrow_exception(trouble_);
  for (const auto& file : files_)
    if (file) file->close();
  if (!unopened_.empty()) throw std::runtime_error(unopened_);
}

}  // namespace padr::peer
