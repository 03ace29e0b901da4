#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace tactus::files {

/// Arrays for numpy.load: a ZIP of .npy files, stored without compression, little-endian, C order.
class NpzWriter {
public:
  void add(const std::string& name, std::span<const double>, const std::vector<std::size_t>& shape);
  void add(const std::string& name, std::span<const float>, const std::vector<std::size_t>& shape);
  void add(const std::string& name, std::span<const std::int32_t>,
           const std::vector<std::size_t>& shape);
  void add(const std::string& name, std::span<const std::int64_t>,
           const std::vector<std::size_t>& shape);
  void add(const std::string& name, std::span<const std::complex<float>>,
           const std::vector<std::size_t>& shape);
  void add(const std::string& name, std::span<const std::uint8_t>,
           const std::vector<std::size_t>& shape);
  /// Little-endian elements in C order, `kind` as NumPy's descr: "<f8".
  void add_bytes(const std::string& name, const char* kind, std::span<const std::byte> bytes,
                 const std::vector<std::size_t>& shape);
  /// Receives the next bytes of the file.
  using Sink = std::function<void(const void*, std::size_t)>;
  /// Writes all arrays to `sink`; the same arrays give the same bytes. Returns an empty text, or a
  /// sentence if the arrays exceed the limit of an archive (4 GB).
  [[nodiscard]] std::string emit(const Sink& sink) const;

private:
  struct Member {
    std::string name;
    std::vector<std::byte> bytes;
  };
  std::vector<Member> members_;
};

} // namespace tactus::files
