#include "files/npz_writer.hpp"

#include "files/npz.hpp"

#include <bit>
#include <utility>

namespace tactus::files {

static_assert(std::endian::native == std::endian::little);

void NpzWriter::add_bytes(const std::string& name, const char* kind,
                          std::span<const std::byte> bytes, const std::vector<std::size_t>& shape) {
  std::string header = std::string("{'descr': '") + kind + "', 'fortran_order': False, 'shape': (";
  for (const std::size_t extent : shape)
    header += std::to_string(extent) + ",";
  header += "), }";
  while ((10 + header.size() + 1) % 64 != 0)
    header += ' ';
  header += '\n';
  std::string start("\x93NUMPY\x01\x00", 8);
  start += static_cast<char>(header.size() & 255);
  start += static_cast<char>(header.size() >> 8);
  start += header;
  Member member{name + ".npy", {}};
  const auto text = std::as_bytes(std::span(start));
  member.bytes.assign(text.begin(), text.end());
  member.bytes.insert(member.bytes.end(), bytes.begin(), bytes.end());
  members_.push_back(std::move(member));
}

void NpzWriter::add(const std::string& name, std::span<const double> v,
                    const std::vector<std::size_t>& shape) {
  add_bytes(name, "<f8", std::as_bytes(v), shape);
}
void NpzWriter::add(const std::string& name, std::span<const float> v,
                    const std::vector<std::size_t>& shape) {
  add_bytes(name, "<f4", std::as_bytes(v), shape);
}
void NpzWriter::add(const std::string& name, std::span<const std::int32_t> v,
                    const std::vector<std::size_t>& shape) {
  add_bytes(name, "<i4", std::as_bytes(v), shape);
}
void NpzWriter::add(const std::string& name, std::span<const std::int64_t> v,
                    const std::vector<std::size_t>& shape) {
  add_bytes(name, "<i8", std::as_bytes(v), shape);
}
void NpzWriter::add(const std::string& name, std::span<const std::complex<float>> v,
                    const std::vector<std::size_t>& shape) {
  add_bytes(name, "<c8", std::as_bytes(v), shape);
}
void NpzWriter::add(const std::string& name, std::span<const std::uint8_t> v,
                    const std::vector<std::size_t>& shape) {
  add_bytes(name, "|u1", std::as_bytes(v), shape);
}

namespace {

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i)
    out += static_cast<char>(value >> (8 * i) & 255);
}

} // namespace

std::string NpzWriter::emit(const Sink& sink) const {
  std::string directory;
  std::uint64_t at = 0;
  for (const Member& m : members_) {
    if (at + m.bytes.size() > 0xFFFFFF00ULL)
      return "the table is larger than 4 GB: use fewer modes or a coarser mesh";
    std::string common; // the fields common to local and central headers
    put(common, 20, 2); // version needed
    put(common, 0, 2);
    put(common, 0, 2);    // stored
    put(common, 0, 2);    // time
    put(common, 0x21, 2); // 1 January 1980, so that equal tables give equal files
    put(common, crc32(m.bytes), 4);
    put(common, m.bytes.size(), 4);
    put(common, m.bytes.size(), 4);
    put(common, m.name.size(), 2);
    put(common, 0, 2);
    std::string local("PK\x03\x04", 4);
    local += common + m.name;
    directory += std::string("PK\x01\x02", 4);
    put(directory, 20, 2);
    directory += common;
    put(directory, 0, 6); // comment, disk, internal attributes
    put(directory, 0, 4); // external attributes
    put(directory, at, 4);
    directory += m.name;
    sink(local.data(), local.size());
    sink(m.bytes.data(), m.bytes.size());
    at += local.size() + m.bytes.size();
  }
  std::string end("PK\x05\x06", 4);
  put(end, 0, 4);
  put(end, members_.size(), 2);
  put(end, members_.size(), 2);
  put(end, directory.size(), 4);
  put(end, at, 4);
  put(end, 0, 2);
  sink(directory.data(), directory.size());
  sink(end.data(), end.size());
  return {};
}

} // namespace tactus::files
