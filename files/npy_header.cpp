#include "files/npy_header.hpp"

#include "core/text.hpp"

#include <cstring>

namespace tactus::files {
namespace {

/// The text after 'key': in the header, which is a Python dictionary of three entries.
std::string_view entry(std::string_view header, std::string_view key) {
  const std::size_t at = header.find("'" + std::string(key) + "'");
  if (at == std::string_view::npos)
    return {};
  const std::size_t colon = header.find(':', at);
  if (colon == std::string_view::npos)
    return {};
  const std::size_t value = header.find_first_not_of(' ', colon + 1);
  return value == std::string_view::npos ? std::string_view{} : header.substr(value);
}

std::string read_type(std::string_view text, NpzArray& array) {
  constexpr const char* unknown = "has a type that is not a number";
  if (text.size() < 4 || text[0] != '\'')
    return unknown;
  const std::size_t close = text.find('\'', 1);
  if (close == std::string_view::npos || close < 4 || close > 5)
    return unknown;
  const char order = text[1];
  array.kind = text[2];
  array.big_endian = order == '>';
  const std::size_t n = to_number<std::size_t>(text.substr(3, close - 3)).value_or(0);
  array.item_bytes = n;
  const bool whole = array.kind == 'i' || array.kind == 'u';
  const bool known = (whole && (n == 1 || n == 2 || n == 4 || n == 8)) ||
                     (array.kind == 'f' && (n == 4 || n == 8)) ||
                     (array.kind == 'c' && (n == 8 || n == 16)) || (array.kind == 'b' && n == 1);
  if (!known || (order != '<' && order != '>' && order != '|'))
    return "has type " + std::string(text.substr(0, close + 1)) +
           ": expected integer, real or complex numbers of a standard size";
  return {};
}

std::string read_shape(std::string_view text, NpzArray& array) {
  constexpr const char* damaged = "has a damaged shape";
  const std::size_t close = text.find(')');
  if (!text.starts_with('(') || close == std::string_view::npos)
    return damaged;
  for (const std::string_view word : split_words(text.substr(1, close - 1), ",L")) {
    const auto extent = to_number<std::size_t>(word);
    if (!extent || array.shape.size() == 4)
      return damaged;
    array.shape.push_back(*extent);
  }
  return {};
}

} // namespace

std::string read_npy_header(std::span<const std::byte> bytes, NpzArray& array, std::size_t& size) {
  static constexpr unsigned char kMagic[] = {0x93, 'N', 'U', 'M', 'P', 'Y'};
  if (bytes.size() < 12 || std::memcmp(bytes.data(), kMagic, sizeof kMagic) != 0)
    return "is not in NumPy's format";
  const auto byte = [&](std::size_t i) { return std::to_integer<std::size_t>(bytes[i]); };
  const std::size_t version = byte(6);
  if (version < 1 || version > 3)
    return "is in a newer version of NumPy's format";
  const std::size_t prefix = version == 1 ? 10 : 12;
  std::size_t length = byte(8) | byte(9) << 8;
  if (version > 1)
    length |= byte(10) << 16 | byte(11) << 24;
  if (length > bytes.size() - prefix || length > 65536)
    return "has a damaged header";
  size = prefix + length;
  const std::string_view header(reinterpret_cast<const char*>(bytes.data()) + prefix, length);
  if (std::string refusal = read_type(entry(header, "descr"), array); !refusal.empty())
    return refusal;
  const std::string_view order = entry(header, "fortran_order");
  if (!order.starts_with("True") && !order.starts_with("False"))
    return "has a damaged header";
  array.fortran_order = order.starts_with("True");
  return read_shape(entry(header, "shape"), array);
}

} // namespace tactus::files
