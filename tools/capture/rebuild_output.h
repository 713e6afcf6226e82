#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shell/files.h"
#include "tools/capture/rebuild.h"
#include "tools/plot/film_strip.h"

namespace padr::capture {

/// For people.
std::string rebuilt_text(const Setting& setting, const SessionLog& session_log, const Rebuilt& r,
                         std::uint64_t last_hash);
std::string rebuilt_json(const Setting& setting, const SessionLog& session_log, const Rebuilt& r,
                         std::uint64_t last_hash, const std::vector<std::string>& command);

/// One row per tick and entity that is there.
class StatesCsv {
 public:
  explicit StatesCsv(const std::string& file);
  void add(const sync::FoldState& s);
  void close() { out_.close(); }

 private:
  shell::OutputFile out_;
};

/// Four moments of the world, with the ways of the avatars; avatars and owned bodies in the colours of their peers.
class WorldPicture {
 public:
  void add(const sync::FoldState& s);
  /// The picture as SVG; empty if no world was added.
  std::string svg(const Setting& setting) const;

 private:
  struct Moment {
    Tick tick = 0;
    std::vector<bool> present;    ///< avatars by slot
    std::vector<Vec2> positions;  ///< by entity
    std::vector<float> angles;
    std::vector<PeerId> owners;  ///< by body; kNoPeer: nobody
  };
  std::vector<plot::KeyEntry> key() const;
  plot::Frame frame(const Setting& setting, std::size_t at) const;

  std::vector<Moment> moments_;
};

}  // namespace padr::capture
