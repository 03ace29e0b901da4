#include "max/shell/output.hpp"

#include <cstring>
#include <limits>
#include <string_view>

namespace tactus::max {
namespace {

constexpr std::size_t kWord = 8; // alignment of all records, bytes

struct Header {
  std::uint32_t kind, outlet;
  std::uint64_t count; // number of atoms
};
struct StoredAtom {
  std::uint64_t length; // length of the word that follows, or kNumber
  double number;
};
constexpr std::uint64_t kNumber = std::numeric_limits<std::uint64_t>::max();
/// Replaces a kind if the record does not fit before the end of the ring and therefore begins at
/// its front.
constexpr std::uint32_t kGoOnAtFront = std::numeric_limits<std::uint32_t>::max();

constexpr std::size_t padded(std::size_t size) { return (size + kWord - 1) / kWord * kWord; }

} // namespace

std::size_t stored_size(std::span<const Atom> atoms) noexcept {
  std::size_t size = sizeof(Header);
  for (const Atom& atom : atoms)
    size += sizeof(StoredAtom) + (atom.is_word ? padded(atom.word.size()) : 0);
  return size;
}

void store(std::byte* bytes, Output::Kind kind, std::size_t outlet,
           std::span<const Atom> atoms) noexcept {
  const Header header{static_cast<std::uint32_t>(kind), static_cast<std::uint32_t>(outlet),
                      atoms.size()};
  std::memcpy(bytes, &header, sizeof header);
  bytes += sizeof header;
  for (const Atom& atom : atoms) {
    const StoredAtom stored{atom.is_word ? atom.word.size() : kNumber, atom.number};
    std::memcpy(bytes, &stored, sizeof stored);
    bytes += sizeof stored;
    if (atom.is_word && !atom.word.empty()) {
      std::memcpy(bytes, atom.word.data(), atom.word.size());
      bytes += padded(atom.word.size());
    }
  }
}

std::size_t load(const std::byte* bytes, Output& output) {
  const std::byte* at = bytes;
  Header header{};
  std::memcpy(&header, at, sizeof header);
  at += sizeof header;
  output.kind = static_cast<Output::Kind>(header.kind);
  output.outlet = header.outlet;
  output.atoms.clear();
  for (std::uint64_t i = 0; i < header.count; ++i) {
    StoredAtom stored{};
    std::memcpy(&stored, at, sizeof stored);
    at += sizeof stored;
    if (stored.length == kNumber) {
      output.atoms.emplace_back(stored.number);
    } else {
      output.atoms.emplace_back(std::string_view(reinterpret_cast<const char*>(at), stored.length));
      at += padded(stored.length);
    }
  }
  return static_cast<std::size_t>(at - bytes);
}

void Outbox::add(Output::Kind kind, std::size_t outlet, std::span<const Atom> atoms) {
  const std::size_t begin = bytes_.size();
  bytes_.resize(begin + stored_size(atoms));
  store(bytes_.data() + begin, kind, outlet, atoms);
}

bool OutputRing::add(Output::Kind kind, std::size_t outlet, std::span<const Atom> atoms) noexcept {
  const std::size_t size = stored_size(atoms);
  std::size_t written = written_.load(std::memory_order_relaxed);
  const std::size_t room = kCapacity - (written - read_.load(std::memory_order_acquire));
  const std::size_t before_end = kCapacity - written % kCapacity;
  const std::size_t skipped = size > before_end ? before_end : 0;
  if (size + skipped > room)
    return false;
  if (skipped > 0) {
    std::memcpy(bytes_.data() + written % kCapacity, &kGoOnAtFront, sizeof kGoOnAtFront);
    written += skipped;
  }
  store(bytes_.data() + written % kCapacity, kind, outlet, atoms);
  written_.store(written + size, std::memory_order_release);
  return true;
}

std::size_t OutputRing::skip_to_record() noexcept {
  std::size_t read = read_.load(std::memory_order_relaxed);
  if (read == written_.load(std::memory_order_acquire))
    return read;
  std::uint32_t kind = 0;
  std::memcpy(&kind, bytes_.data() + read % kCapacity, sizeof kind);
  if (kind == kGoOnAtFront)
    read += kCapacity - read % kCapacity;
  return read;
}

} // namespace tactus::max
