#include "files/npz.hpp"

#include "files/npy_header.hpp"
#include "files/product.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

namespace tactus::files {
namespace {

constexpr std::size_t kEndRecord = 22, kCentralEntry = 46, kLocalEntry = 30;
constexpr std::size_t kMaxMembers = 1000, kMaxNameLength = 200;

std::uint32_t number_at(std::span<const std::byte> bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = size; i-- > 0;)
    value = value << 8 | std::to_integer<std::uint32_t>(bytes[at + i]);
  return value;
}

/// The position of the archive's end record; the file's size if there is none.
std::size_t find_end_record(std::span<const std::byte> file) {
  if (file.size() < kEndRecord)
    return file.size();
  const std::size_t first = file.size() - std::min<std::size_t>(file.size(), kEndRecord + 0xffff);
  for (std::size_t at = file.size() - kEndRecord + 1; at-- > first;)
    if (number_at(file, at, 4) == 0x06054b50)
      return at;
  return file.size();
}

/// A member's position in the file, from the archive's directory.
struct Member {
  std::string name;
  std::uint32_t method, checksum, stored, size, local;
  std::span<const std::byte> bytes{};
};

/// Finds a member's bytes. Returns the error, or an empty string.
std::string locate(std::span<const std::byte> file, Member& member) {
  const std::string named = "member '" + member.name + "' ";
  if (member.method == 8)
    return named + "is compressed: save with numpy.savez, not savez_compressed";
  if (member.method != 0)
    return named + "has an unknown compression method: save with numpy.savez";
  if (member.size == 0xffffffff || member.stored == 0xffffffff || member.local == 0xffffffff)
    return named + "is a ZIP64 member: files above 4 GB are not read";
  if (member.stored != member.size)
    return named + "is damaged: its two sizes differ";
  if (member.local > file.size() || file.size() - member.local < kLocalEntry ||
      number_at(file, member.local, 4) != 0x04034b50)
    return named + "is damaged: it is not at the position given in the directory";
  const std::size_t begin = member.local + kLocalEntry + number_at(file, member.local + 26, 2) +
                            number_at(file, member.local + 28, 2);
  if (begin > file.size() || file.size() - begin < member.size)
    return named + "is damaged: it ends early";
  member.bytes = file.subspan(begin, member.size);
  return {};
}

/// Refuses members that share bytes: otherwise a small file could be read a thousand times and fill
/// a thousand times its size in memory. Returns the error, or an empty string.
std::string overlap(std::span<const std::byte> file, std::vector<Member>& members) {
  std::sort(members.begin(), members.end(),
            [](const Member& a, const Member& b) { return a.local < b.local; });
  for (std::size_t m = 1; m < members.size(); ++m)
    if (const Member& before = members[m - 1];
        file.data() + members[m].local < before.bytes.data() + before.bytes.size())
      return "members '" + before.name + "' and '" + members[m].name + "' overlap";
  return {};
}

/// Reads the directory's entry at `at` and advances `at`. Returns the error, or an empty string.
std::string read_entry(std::span<const std::byte> file, std::size_t end, std::size_t& at,
                       Member& member) {
  if (at > end || end - at < kCentralEntry || number_at(file, at, 4) != 0x02014b50)
    return "the archive's directory is damaged";
  const std::size_t name_size = number_at(file, at + 28, 2);
  const std::size_t skip = name_size + number_at(file, at + 30, 2) + number_at(file, at + 32, 2);
  if (end - at - kCentralEntry < skip || name_size > kMaxNameLength)
    return "the archive's directory is damaged";
  member = {{},
            number_at(file, at + 10, 2),
            number_at(file, at + 16, 4),
            number_at(file, at + 20, 4),
            number_at(file, at + 24, 4),
            number_at(file, at + 42, 4)};
  for (std::size_t i = 0; i < name_size; ++i)
    member.name += static_cast<char>(file[at + kCentralEntry + i]);
  at += kCentralEntry + skip;
  const bool plain = std::all_of(member.name.begin(), member.name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '.' || c == '-';
  });
  if (!plain || member.name.find("..") != std::string::npos || member.name.empty())
    return "a member's name is not a plain name: expected letters, digits, _, . and -";
  return {};
}

/// Reads a .npy member's header and finds its numbers. Returns the error, or an empty string.
std::string read_array(std::span<const std::byte> bytes, const std::string& name, NpzArray& array) {
  array.name = name.substr(0, name.size() - 4);
  std::size_t header = 0;
  if (std::string refusal = read_npy_header(bytes, array, header); !refusal.empty())
    return "array '" + array.name + "' " + refusal;
  std::size_t size = array.item_bytes;
  for (const std::size_t extent : array.shape) {
    const auto larger = product(size, extent);
    if (!larger)
      return "array '" + array.name + "' has a damaged shape: it is too large";
    size = *larger;
  }
  if (size != bytes.size() - header)
    return "array '" + array.name + "' is " + std::to_string(bytes.size() - header) +
           " bytes long: expected for its shape " + std::to_string(size);
  array.bytes = bytes.subspan(header);
  return {};
}

template <class T> T element(const std::byte* from, bool swap) {
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), from, sizeof(T));
  if (swap)
    std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

/// One real number of an array's element.
double read_number(const NpzArray& array, const std::byte* from, std::size_t bytes) {
  const bool swap = array.big_endian == (std::endian::native == std::endian::little);
  switch (array.kind) {
  case 'f':
  case 'c':
    return bytes == 4 ? static_cast<double>(element<float>(from, swap))
                      : element<double>(from, swap);
  case 'i':
    switch (bytes) {
    case 1:
      return element<std::int8_t>(from, swap);
    case 2:
      return element<std::int16_t>(from, swap);
    case 4:
      return element<std::int32_t>(from, swap);
    default:
      return static_cast<double>(element<std::int64_t>(from, swap));
    }
  default:
    switch (bytes) {
    case 1:
      return element<std::uint8_t>(from, swap);
    case 2:
      return element<std::uint16_t>(from, swap);
    case 4:
      return element<std::uint32_t>(from, swap);
    default:
      return static_cast<double>(element<std::uint64_t>(from, swap));
    }
  }
}

/// Walks through the elements in C order, whatever the order in the file.
template <class T> std::vector<T> copy_values(const NpzArray& array) {
  const std::size_t parts = array.kind == 'c' ? 2 : 1;
  const std::size_t part_bytes = array.item_bytes / parts;
  const std::size_t count = array.count();
  constexpr bool kComplex = std::is_same_v<T, std::complex<float>>;
  std::vector<T> out;
  out.reserve(kComplex ? count : count * parts);
  std::vector<std::size_t> index(array.shape.size(), 0), stride(array.shape.size(), 1);
  for (std::size_t d = 1; d < stride.size(); ++d)
    stride[d] = stride[d - 1] * array.shape[d - 1];
  std::size_t at = 0;
  for (std::size_t n = 0; n < count; ++n) {
    const std::byte* from = array.bytes.data() + (array.fortran_order ? at : n) * array.item_bytes;
    if constexpr (kComplex)
      out.emplace_back(static_cast<float>(read_number(array, from, part_bytes)),
                       parts == 2
                           ? static_cast<float>(read_number(array, from + part_bytes, part_bytes))
                           : 0.0f);
    else
      for (std::size_t part = 0; part < parts; ++part)
        out.push_back(static_cast<T>(read_number(array, from + part * part_bytes, part_bytes)));
    if (!array.fortran_order)
      continue;
    for (std::size_t d = index.size(); d-- > 0;) {
      at += stride[d];
      if (++index[d] < array.shape[d])
        break;
      at -= stride[d] * index[d];
      index[d] = 0;
    }
  }
  return out;
}

} // namespace

std::uint32_t crc32(std::span<const std::byte> bytes) noexcept {
  // Eight bytes at a time (Kounavis & Berry 2008): table k holds the remainder of a byte followed
  // by k zero bytes.
  constexpr std::size_t kAtOnce = 8;
  static constexpr auto kTables = [] {
    std::array<std::array<std::uint32_t, 256>, kAtOnce> tables{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit)
        value = value & 1 ? 0xedb88320 ^ value >> 1 : value >> 1;
      tables[0][i] = value;
    }
    for (std::size_t k = 1; k < kAtOnce; ++k)
      for (std::size_t i = 0; i < 256; ++i)
        tables[k][i] = tables[0][tables[k - 1][i] & 0xff] ^ tables[k - 1][i] >> 8;
    return tables;
  }();
  std::uint32_t sum = 0xffffffff;
  for (; bytes.size() >= kAtOnce; bytes = bytes.subspan(kAtOnce)) {
    std::uint32_t next = 0;
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      const std::uint32_t before = k < 4 ? sum >> 8 * k : 0;
      next ^= kTables[kAtOnce - 1 - k][(before ^ std::to_integer<std::uint32_t>(bytes[k])) & 0xff];
    }
    sum = next;
  }
  for (const std::byte byte : bytes)
    sum = kTables[0][(sum ^ std::to_integer<std::uint32_t>(byte)) & 0xff] ^ sum >> 8;
  return sum ^ 0xffffffff;
}

std::size_t NpzArray::count() const noexcept {
  std::size_t n = 1;
  for (const std::size_t extent : shape)
    n *= extent;
  return n;
}

std::vector<double> NpzArray::values() const { return copy_values<double>(*this); }
std::vector<float> NpzArray::single_values() const { return copy_values<float>(*this); }
std::vector<std::complex<float>> NpzArray::single_complex_values() const {
  return copy_values<std::complex<float>>(*this);
}

std::string NpzFile::open(std::span<const std::byte> file) {
  arrays_.clear();
  const std::size_t end = find_end_record(file);
  if (end == file.size())
    return "not an .npz file, or damaged: it has no ZIP end record";
  const std::size_t members = number_at(file, end + 10, 2);
  const std::size_t directory = number_at(file, end + 16, 4);
  if (members == 0xffff || directory == 0xffffffff)
    return "a ZIP64 archive: files above 4 GB are not read";
  if (members > kMaxMembers)
    return "it holds more than " + std::to_string(kMaxMembers) + " members";
  std::size_t at = directory;
  std::vector<Member> listed(members);
  for (Member& member : listed) {
    if (std::string refusal = read_entry(file, end, at, member); !refusal.empty())
      return refusal;
    if (std::string refusal = locate(file, member); !refusal.empty())
      return refusal;
  }
  if (std::string refusal = overlap(file, listed); !refusal.empty())
    return refusal;
  std::vector<NpzArray> found;
  for (const Member& member : listed) {
    if (crc32(member.bytes) != member.checksum)
      return "member '" + member.name + "' is damaged: its checksum differs";
    if (!member.name.ends_with(".npy"))
      continue;
    NpzArray array;
    if (std::string refusal = read_array(member.bytes, member.name, array); !refusal.empty())
      return refusal;
    if (std::any_of(found.begin(), found.end(),
                    [&](const NpzArray& other) { return other.name == array.name; }))
      return "array '" + array.name + "' occurs twice";
    found.push_back(std::move(array));
  }
  arrays_ = std::move(found);
  return {};
}

const NpzArray* NpzFile::find(std::string_view name) const noexcept {
  for (const NpzArray& array : arrays_)
    if (array.name == name)
      return &array;
  return nullptr;
}

} // namespace tactus::files
