#include "tools/capture/input.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "common/model/hash.h"
#include "common/model/user_error.h"
#include "common/wire/handshake.h"

namespace padr::capture {
namespace {

/// So far apart, by the clocks of those who captured, may sightings of one datagram be.
constexpr std::int64_t kApart = 10'000'000'000;
constexpr std::size_t kMostSightings = 1U << 20U;
constexpr std::size_t kMostPlaces = 1U << 16U;  ///< more than any session has, so that forgers cannot fill the memory

/// A file descriptor of one's own.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ > STDERR_FILENO) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

std::uint64_t size_of(const std::vector<std::string>& files) {
  std::uint64_t all = 0;
  for (const std::string& f : files) {
    std::error_code error;
    const auto size = std::filesystem::file_size(f, error);
    if (error) return 0;
    all += size;
  }
  return all;
}

/// By the magic and either a header as this version's are, or a checksum that fits. Others' datagrams hardly ever are
/// so.
bool is_ours(std::span<const std::byte> payload) {
  if (payload.size() < wire::kHeaderBytes || payload[0] != std::byte{'P'} || payload[1] != std::byte{'d'}) return false;
  const auto kind = std::to_integer<std::uint32_t>(payload[2]);
  const auto sender = std::to_integer<std::uint32_t>(payload[3]);
  const bool usual =
      kind >> 4U == wire::kProtocolVersion && (kind & 15U) <= static_cast<std::uint32_t>(wire::Kind::kMembership);
  if (usual && (sender < kMaxPeers || sender == kNoPeer)) return true;
  wire::SealError error = wire::SealError::kNone;
  return wire::open(payload, error) || error == wire::SealError::kVersion || error == wire::SealError::kKind;
}

/// Whether so little of a payload is there that it could be ours or others'.
bool may_become_ours(std::span<const std::byte> payload) {
  constexpr std::array kMagic{std::byte{'P'}, std::byte{'d'}};
  const auto head = payload.first(std::min(payload.size(), kMagic.size()));
  return payload.size() < wire::kHeaderBytes && std::equal(head.begin(), head.end(), kMagic.begin());
}

std::uint64_t hash_of(std::span<const std::byte> b) {
  return std::hash<std::string_view>()({reinterpret_cast<const char*>(b.data()), b.size()});
}

/// In which file a datagram has been seen, and from which address: a NAT or a relay changes that one.
std::uint64_t sighted_at(const Datagram& d) {
  Hasher h;
  for (const std::uint8_t b : d.outer_from.address) h.add(std::uint64_t{b});
  h.add(std::uint64_t{d.outer_from.port});
  h.add(std::uint64_t{d.file});
  return h.value();
}

/// Of a peer of which no address is known.
Endpoint nowhere(std::uint32_t id) {
  Endpoint e;
  for (std::size_t i = 0; i < 4; ++i) e.key[i] = static_cast<std::uint8_t>(id >> 8U * i & 0xFFU);
  return e;
}

}  // namespace

ByteSource open_source(const std::string& file) {
  std::error_code error;
  if (file != "-" && std::filesystem::is_directory(file, error))
    throw UserError("CAPTURE: cannot read '" + file + "': it is a directory");
  const int fd = file == "-" ? STDIN_FILENO : ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) throw UserError("CAPTURE: cannot read '" + file + "': " + std::generic_category().message(errno));
  return [own = std::make_shared<Descriptor>(fd), file](std::span<std::byte> into) -> std::size_t {
    while (true) {
      const ssize_t n = ::read(own->get(), into.data(), into.size());
      if (n >= 0) return static_cast<std::size_t>(n);
      if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "cannot read '" + file + "'");
    }
  };
}

struct Captures::File {
  File(const std::string& name, std::size_t number)
      : reader(open_source(name), name == "-" ? "standard input" : name), index(number) {}
  FrameReader reader;
  std::size_t index;
  Datagram datagram;
  std::span<const std::byte> whole;        ///< the UDP payload in the frame
  wire::Bytes unsealed;                    ///< that the datagram is in, if it came sealed
  std::optional<std::uint32_t> sealed_by;  ///< short id of who sealed the whole, likewise
  std::uint32_t id = 0;                    ///< of whose it is: of another one if it is carried on its second hop
  std::uint64_t inner = 0;                 ///< content of what was carried
  bool begun = false;
  bool done = false;
};

Captures::Captures(std::vector<std::string> files, const std::vector<std::string>& keylogs)
    : names_(std::move(files)), keys_(keylogs), progress_(size_of(names_)) {
  if (std::count(names_.begin(), names_.end(), "-") > 1) throw UserError("CAPTURE: standard input (-) is given twice");
  for (const std::string& f : names_) files_.push_back(std::make_unique<File>(f, files_.size()));
}

Captures::~Captures() = default;

bool Captures::advance(File& file) {
  while (const auto frame = file.reader.next()) {
    ++contents_.packets;
    Datagram& d = file.datagram;
    const Content content = udp_of(*frame, d);
    ++contents_.of[static_cast<std::size_t>(content)];
    if (content != Content::kUdp && content != Content::kCutUdp) continue;
    d.outer_from = d.from;
    d.outer_to = d.to;
    d.seal_bytes = 0;
    d.carried_to.reset();
    file.sealed_by.reset();
    file.whole = d.payload;
    if (content == Content::kCutUdp && may_become_ours(d.payload)) {
      --contents_.of[static_cast<std::size_t>(content)];
      ++contents_.of[static_cast<std::size_t>(Content::kCutHeaders)];
      continue;
    }
    if (content == Content::kUdp && wire::is_handshake(d.payload)) {
      ++contents_.handshakes;
      continue;
    }
    if (content == Content::kUdp && wire::read_sealed(d.payload)) {
      if (!unseal(file)) continue;
    } else if (!is_ours(d.payload)) {
      ++contents_.others;
      continue;
    }
    if (file.begun && frame->time_ns < d.time_ns) ++contents_.back;
    file.begun = true;
    d.time_ns = frame->time_ns;
    d.packet = frame->number;
    d.file = file.index;
    d.cut = content == Content::kCutUdp;
    return true;
  }
  file.done = true;
  return false;
}

bool Captures::unseal(File& file) {
  Datagram& d = file.datagram;
  auto sealed = *wire::read_sealed(d.payload);
  Keyring::Result result = keys_.read(sealed, d.payload);
  file.sealed_by = sealed.id;
  if (sealed.kind == wire::Kind::kCarried && result.unsealed) {
    const auto inner = carried_in(*result.unsealed, file);
    if (!inner) return false;
    ++contents_.carried;
    sealed = *wire::read_sealed(*inner);
    result = keys_.read(sealed, *inner);
    if (!result.unsealed) {  // the carrier's capture, say: it has no key for it
      ++contents_.carried_unread;
      return false;
    }
  }
  ++contents_.sealed[static_cast<std::size_t>(result.reading)];
  if (!result.unsealed) return false;
  file.id = sealed.id;
  file.unsealed = std::move(*result.unsealed);
  d.seal_bytes = file.whole.size() - file.unsealed.size();
  d.payload = file.unsealed;
  return true;
}

std::optional<wire::Bytes> Captures::carried_in(const wire::Bytes& unsealed, File& file) {
  const auto carried = wire::decode_carried(unsealed);
  const auto inner = carried ? wire::read_sealed(carried->sealed) : std::nullopt;
  if (!inner || inner->kind == wire::Kind::kCarried) {
    ++(carried && wire::is_handshake(carried->sealed) ? contents_.handshakes : contents_.others);
    return std::nullopt;
  }
  file.datagram.carried_to = carried->to;
  file.inner = hash_of(carried->sealed);
  return wire::Bytes(carried->sealed.begin(), carried->sealed.end());
}

Endpoint Captures::same(const Endpoint& address) const {
  const auto found = same_.find(address);
  return found == same_.end() ? address : found->second;
}

Endpoint Captures::place_of(std::uint32_t id, const Endpoint* at) {
  const Endpoint here = at == nullptr ? nowhere(id) : same(*at);
  if (places_.size() >= kMostPlaces && !places_.contains(id)) return here;
  const Endpoint first = places_.try_emplace(id, here).first->second;
  if (at != nullptr && here != first && same_.size() < kMostPlaces) same_[*at] = first;
  return first;
}

void Captures::place(File& file) {
  Datagram& d = file.datagram;
  const bool first_hop = file.sealed_by == file.id;
  if (!file.sealed_by) {
    d.from = same(d.outer_from);
  } else {
    d.from = place_of(file.id, first_hop ? &d.outer_from : nullptr);
  }
  d.to = d.carried_to ? place_of(*d.carried_to, first_hop ? nullptr : &d.outer_to) : same(d.outer_to);
}

const Datagram* Captures::next() {
  if (!begun_) {
    for (const auto& f : files_) advance(*f);
    begun_ = true;
  } else if (given_ != nullptr) {
    advance(*given_);
  }
  while (true) {
    given_ = nullptr;
    for (const auto& f : files_)
      if (!f->done && (given_ == nullptr || f->datagram.time_ns < given_->datagram.time_ns)) given_ = f.get();
    if (given_ == nullptr) return nullptr;
    std::uint64_t done = 0;
    for (const auto& f : files_) done += f->reader.offset();
    progress_.at(done);
    const Datagram& d = given_->datagram;
    place(*given_);
    if (!seen_elsewhere(hash_of(given_->whole), sighted_at(d), d)) break;
    ++contents_.seen_again;
    advance(*given_);
  }
  Datagram& d = given_->datagram;
  d.second_hop = d.carried_to && seen_elsewhere(given_->inner, given_->sealed_by.value_or(0), d);
  ++contents_.ours;
  return &d;
}

// By content alone, as a NAT changes addresses. What differs in nothing else is one datagram of one peer: then its
// other address is known.
bool Captures::seen_elsewhere(std::uint64_t content, std::uint64_t place, const Datagram& d) {
  forget(d.time_ns);
  Sighting& s = sightings_[content];
  if (s.seen.empty()) {
    by_time_.emplace_back(d.time_ns, content);
    s.from = d.from;
  }
  auto mine = std::find_if(s.seen.begin(), s.seen.end(), [place](const auto& e) { return e.first == place; });
  if (mine == s.seen.end()) mine = s.seen.insert(s.seen.end(), {place, 0});
  if (++mine->second <= s.told) {
    if (d.from != s.from && !d.carried_to && same_.size() < kMostPlaces) same_[d.from] = s.from;
    return true;
  }
  s.told = mine->second;
  return false;
}

void Captures::forget(std::int64_t now_ns) {
  while (!by_time_.empty() && (now_ns - by_time_.front().first > kApart || by_time_.size() > kMostSightings)) {
    sightings_.erase(by_time_.front().second);
    by_time_.pop_front();
  }
}

std::vector<std::string> Captures::troubles() const {
  std::vector<std::string> all;
  for (const auto& f : files_)
    if (const std::string t = f->reader.trouble(); !t.empty()) all.push_back(t);
  return all;
}

bool Captures::damaged() const {
  return std::any_of(files_.begin(), files_.end(), [](const auto& f) { return f->reader.stop() == Stop::kDamaged; });
}

void Captures::look_again() {
  begun_ = false;
  for (const auto& f : files_) f->done = false;
}

std::vector<std::string> Captures::comments() const {
  std::vector<std::string> all;
  for (const auto& f : files_) all.push_back(f->reader.comment());
  return all;
}

}  // namespace padr::capture
