#include "fem/io/npz.hpp"

#include "fem/io/safe_file.hpp"
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {
namespace {

void emit(const NpzWriter& arrays, const NpzWriter::Sink& sink) {
  if (const std::string refusal = arrays.emit(sink); !refusal.empty())
    throw InputError(refusal);
}

} // namespace

void write_npz(const std::string& path, const NpzWriter& arrays) {
  SafeFile file(path);
  emit(arrays, [&](const void* bytes, std::size_t size) { file.write(bytes, size); });
  file.commit();
}

std::string npz_bytes(const NpzWriter& arrays) {
  std::string out;
  emit(arrays, [&](const void* bytes, std::size_t size) {
    out.append(static_cast<const char*>(bytes), size);
  });
  return out;
}

} // namespace tactus::fem
