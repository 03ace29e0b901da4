#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Reads NumPy's archives of arrays: a ZIP of stored .npy members, as numpy.savez writes it.
/// Format: PKWARE APPNOTE 6.3 sections 4.3.7, 4.3.12, 4.3.16; NumPy enhancement proposal 1.
namespace tactus::files {

/// One array. Its bytes stay in the file's memory; values() copies them.
struct NpzArray {
  std::string name;
  char kind = 'f';            ///< i, u, f, c or b, as NumPy's type codes
  std::size_t item_bytes = 0; ///< bytes of one element
  bool big_endian = false;
  bool fortran_order = false;
  std::vector<std::size_t> shape;
  std::span<const std::byte> bytes;

  [[nodiscard]] std::size_t count() const noexcept;
  /// All elements in C order, converted; a complex array gives real and imaginary part in turn.
  /// Whole numbers beyond 2^53 lose digits.
  [[nodiscard]] std::vector<double> values() const;
  /// As values(), but in single precision, for large arrays.
  [[nodiscard]] std::vector<float> single_values() const;
  /// As values(), but as complex numbers; the imaginary parts of a real array are 0.
  [[nodiscard]] std::vector<std::complex<float>> single_complex_values() const;
};

class NpzFile {
public:
  /// Opens a whole file in memory, which must outlive this object. Returns an empty text, or a
  /// sentence if it is not a valid archive. Everything is checked before memory is allocated for
  /// it: sizes against the file, checksums, names, types and shapes. Members that are not .npy are
  /// ignored.
  [[nodiscard]] std::string open(std::span<const std::byte> file);
  [[nodiscard]] const NpzArray* find(std::string_view name) const noexcept;
  [[nodiscard]] const std::vector<NpzArray>& arrays() const noexcept { return arrays_; }

private:
  std::vector<NpzArray> arrays_;
};

/// CRC-32 of ZIP (ISO 3309).
[[nodiscard]] std::uint32_t crc32(std::span<const std::byte> bytes) noexcept;

} // namespace tactus::files
