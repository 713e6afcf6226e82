#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/capture/frame_reader.h"
#include "common/capture/udp_datagram.h"
#include "tools/capture/keyring.h"
#include "tools/capture/progress.h"

namespace padr::capture {

/// A UDP datagram of a capture that may be one of ours: by its first bytes or its checksum. `from` and `to` tell
/// between whom it counts, by addresses that stay the same: where a peer has several, beside a NAT for instance, by the
/// first that the captures show, and where they show none, because all is carried, by none with the peer's short id.
struct Datagram : UdpDatagram {
  Endpoint outer_from;  ///< as the frame has it: of what is carried, of whoever passes it on
  Endpoint outer_to;
  std::optional<std::uint32_t> carried_to;  ///< if it is carried: short id of whom it is for
  bool second_hop = false;                  ///< it is carried, and its other hop has been given out before
  std::int64_t time_ns = 0;                 ///< since 1970
  std::uint64_t packet = 0;                 ///< its number in the file
  std::size_t file = 0;                     ///< index of the file
  bool cut = false;                         ///< the capture has not all of it
  std::size_t seal_bytes = 0;               ///< that `payload` had and has not any more, as it has been unsealed
};

/// What the files held.
struct Contents {
  std::uint64_t packets = 0;
  std::array<std::uint64_t, kContents> of{};  ///< by Content
  std::uint64_t others = 0;                   ///< UDP datagrams that are not ours
  std::uint64_t ours = 0;                     ///< that are, each once
  std::uint64_t seen_again = 0;               ///< that another file has too, or the same one from another address
  std::uint64_t back = 0;                     ///< ours that are earlier than the one before in their file
  std::array<std::uint64_t, 4> sealed{};      ///< by Keyring::Reading; the last two are not among ours
  std::uint64_t carried = 0;         ///< sealed ones that a third peer passes on, each hop; what is in them counts
  std::uint64_t carried_unread = 0;  ///< those of `carried` in which there is what has no key: not in `sealed`
  std::uint64_t handshakes = 0;      ///< of sessions with a key; not among ours
};

/// The captures of one session, as one: by time, and what several of them have seen, or one on both sides of a NAT or
/// relay, counts once. Two equal datagrams from one address in one file are two datagrams; if another file has them
/// too, they still are two. Memory does not grow with the files.
class Captures {
 public:
  /// `files`: "-" is standard input. Shows progress on long files if standard error is a terminal. What is sealed comes
  /// out unsealed, checked and decrypted with the keys in `keylogs`. Throws UserError.
  explicit Captures(std::vector<std::string> files, const std::vector<std::string>& keylogs = {});
  ~Captures();

  /// The next datagram, valid until the next call; nothing at the end.
  const Datagram* next();

  const Contents& contents() const { return contents_; }
  const std::vector<std::string>& names() const { return names_; }
  /// A line for each file that cannot be read to its end.
  std::vector<std::string> troubles() const;
  /// Whether something cannot be read, now or ever.
  bool damaged() const;
  /// Files that have been read to their end may have grown.
  void look_again();
  /// What the files say of themselves, by file; may be empty.
  std::vector<std::string> comments() const;

 private:
  struct File;
  struct Sighting {
    Endpoint from;                                              ///< of the first
    std::uint32_t told = 0;                                     ///< how often it has been given out
    std::vector<std::pair<std::uint64_t, std::uint32_t>> seen;  ///< how often, by place
  };
  bool advance(File& file);
  bool unseal(File& file);
  std::optional<wire::Bytes> carried_in(const wire::Bytes& unsealed, File& file);
  /// Says between whom it counts, and whether it is the second hop of one.
  void place(File& file);
  Endpoint same(const Endpoint& address) const;
  Endpoint place_of(std::uint32_t id, const Endpoint* at);
  /// Whether what has this content has been given out as often as it has been seen at this place: see sighted_at; or
  /// on this hop.
  bool seen_elsewhere(std::uint64_t content, std::uint64_t place, const Datagram& d);
  void forget(std::int64_t now_ns);

  std::vector<std::string> names_;
  Keyring keys_;
  std::unordered_map<std::uint32_t, Endpoint> places_;  ///< of peers, by short id
  std::map<Endpoint, Endpoint> same_;                   ///< further addresses of peers, and the first of each
  std::vector<std::unique_ptr<File>> files_;
  File* given_ = nullptr;  ///< whose datagram was given out last
  bool begun_ = false;
  Contents contents_;
  std::unordered_map<std::uint64_t, Sighting> sightings_;
  std::deque<std::pair<std::int64_t, std::uint64_t>> by_time_;
  Progress progress_;
};

/// Bytes of an opened file, "-" being standard input. Throws UserError if it cannot be opened.
ByteSource open_source(const std::string& file);

}  // namespace padr::capture
