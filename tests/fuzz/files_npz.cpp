// NumPy's archives and the tables in them. The input is an archive; where its directory can be
// found, its checksums are made right first, so that damage gets behind them.
#include "files/npz.hpp"
#include "files/tables.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

using namespace tactus::files;
using tactus::fuzz::check;

namespace {

/// A number of so many bytes there; 0 outside.
std::size_t number_at(const std::vector<std::byte>& file, std::size_t at, std::size_t size) {
  std::size_t value = 0;
  for (std::size_t i = size; i-- > 0;)
    value = value << 8 | (at + i < file.size() ? std::to_integer<std::size_t>(file[at + i]) : 0);
  return value;
}

/// Puts the right checksum into each entry of the directory whose member is within the file.
void correct_checksums(std::vector<std::byte>& file) {
  for (std::size_t at = 0; at + 46 <= file.size(); ++at) {
    if (number_at(file, at, 4) != 0x02014b50)
      continue;
    const std::size_t size = number_at(file, at + 24, 4), local = number_at(file, at + 42, 4);
    const std::size_t begin =
        local + 30 + number_at(file, local + 26, 2) + number_at(file, local + 28, 2);
    if (begin > file.size() || size > file.size() - begin)
      continue;
    const std::uint32_t sum = crc32(std::span(file).subspan(begin, size));
    for (std::size_t i = 0; i < 4; ++i)
      file[at + 16 + i] = static_cast<std::byte>(sum >> 8 * i & 0xff);
  }
}

bool below(std::int32_t index, std::size_t count) {
  return index >= 0 && static_cast<std::size_t>(index) < count;
}

void check_table(const tactus::modal::ModalTable& table) {
  for (const double f : table.frequency_hz)
    check(f > 0 && std::isfinite(f), "a frequency");
  for (const float x : table.shape)
    check(std::isfinite(x), "a mode's shape");
  for (const auto& triangle : table.triangle)
    for (const std::int32_t v : triangle)
      check(below(v, table.vertices()), "a corner of a body's triangle");
}

void check_table(const tactus::stress::StressTable& table) {
  check(tactus::stress::check_base(table, table.base).empty(), "the base of a table of stress");
  check(table.trust_m > 0, "its trust");
  for (const auto& p : table.parameters)
    check(p.control_point < table.control_point_m.size() && p.low_m <= 0 && p.high_m >= 0,
          "a parameter");
  for (const auto& triangle : table.surface_triangle)
    for (const std::int32_t v : triangle)
      check(below(v, table.surface_node_m.size()), "a corner of a part's triangle");
  for (const std::int32_t e : table.surface_node_element)
    check(below(e, table.elements()), "a node's element");
}

} // namespace

void tactus::fuzz::decode(std::span<const std::uint8_t> input) {
  const auto raw = std::as_bytes(input);
  std::vector<std::byte> file(raw.begin(), raw.end());
  correct_checksums(file);
  file.shrink_to_fit(); // so that a sanitizer sees what reads beyond the end
  NpzFile npz;
  if (!npz.open(file).empty())
    check(npz.arrays().empty(), "arrays of an archive that was refused");
  std::size_t total = 0;
  for (const NpzArray& array : npz.arrays()) {
    check(array.bytes.data() >= file.data() &&
              array.bytes.data() + array.bytes.size() <= file.data() + file.size(),
          "an array is not in the file");
    check(array.count() * array.item_bytes == array.bytes.size(), "an array has another size");
    check(array.values().size() == array.count() * (array.kind == 'c' ? 2 : 1),
          "values are missing");
    total += array.bytes.size();
  }
  check(total <= file.size(), "the arrays are longer than the file");
  tactus::modal::ModalTable modal;
  if (read_modal_table(file, modal).empty())
    check_table(modal);
  tactus::stress::StressTable stress;
  if (read_stress_table(file, stress).empty())
    check_table(stress);
}
