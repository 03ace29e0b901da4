#include "fem/io/mesh_bytes.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace tactus::fem {
namespace {

static_assert(sizeof(Vec3) == 24 && std::is_trivially_copyable_v<Vec3>);

template <class T> void put(std::string& out, const T* values, std::size_t count) {
  out.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}
void put_size(std::string& out, std::size_t size) {
  const std::uint64_t value = size;
  put(out, &value, 1);
}
void put_text(std::string& out, const std::string& text) {
  put_size(out, text.size());
  out += text;
}

/// A material's constants, one after the other.
template <class Material> auto constants_of(Material& m) {
  return std::array{&m.density,    &m.young_pa[0], &m.young_pa[1], &m.young_pa[2], &m.poisson[0],
                    &m.poisson[1], &m.poisson[2],  &m.shear_pa[0], &m.shear_pa[1], &m.shear_pa[2],
                    &m.axis_1.x,   &m.axis_1.y,    &m.axis_1.z,    &m.axis_2.x,    &m.axis_2.y,
                    &m.axis_2.z,   &m.loss_factor, &m.rayleigh_a,  &m.rayleigh_b};
}
void put_material(std::string& out, const std::optional<Material>& material) {
  put_size(out, material ? 1 : 0);
  if (!material)
    return;
  put_text(out, material->name);
  put_text(out, material->source);
  for (const double* value : constants_of(*material))
    put(out, value, 1);
}

class Cursor {
public:
  explicit Cursor(std::string_view bytes) : bytes_(bytes) {}

  /// Reads a count of items of `size` bytes each; the items follow it.
  std::size_t count(std::size_t size) {
    std::uint64_t value = 0;
    take(&value, 1);
    if (value > bytes_.size() / size)
      fail();
    return static_cast<std::size_t>(value);
  }
  template <class T> void take(T* values, std::size_t count) {
    if (count > bytes_.size() / sizeof(T))
      fail();
    if (count > 0)
      std::memcpy(values, bytes_.data(), count * sizeof(T));
    bytes_.remove_prefix(count * sizeof(T));
  }
  std::string text() {
    const std::size_t size = count(1);
    std::string result(bytes_.substr(0, size));
    bytes_.remove_prefix(size);
    return result;
  }
  std::vector<int> indices(std::size_t limit) {
    std::vector<int> result(count(sizeof(int)));
    take(result.data(), result.size());
    for (const int i : result)
      require(i >= 0 && static_cast<std::size_t>(i) < limit);
    return result;
  }
  void require(bool good) const {
    if (!good)
      fail();
  }
  [[nodiscard]] bool at_end() const noexcept { return bytes_.empty(); }

private:
  [[noreturn]] static void fail() {
    throw InputError("the mesh from the mesher process is damaged");
  }
  std::string_view bytes_;
};

std::optional<Material> material_from(Cursor& cursor) {
  std::uint64_t present = 0;
  cursor.take(&present, 1);
  cursor.require(present <= 1);
  if (present == 0)
    return std::nullopt;
  Material m;
  m.name = cursor.text();
  m.source = cursor.text();
  for (double* value : constants_of(m)) {
    cursor.take(value, 1);
    cursor.require(std::isfinite(*value));
  }
  return m;
}

} // namespace

std::string to_bytes(const Mesh& mesh) {
  std::string out;
  out.reserve(24 * mesh.nodes.size() + 4 * mesh.connectivity.size() + 8 * mesh.elements.size() +
              4096);
  put_size(out, mesh.nodes.size());
  put(out, mesh.nodes.data(), mesh.nodes.size());
  put_size(out, mesh.connectivity.size());
  put(out, mesh.connectivity.data(), mesh.connectivity.size());
  put_size(out, mesh.regions.size());
  for (const std::string& name : mesh.regions)
    put_text(out, name);
  put_size(out, mesh.elements.size());
  for (const Element& e : mesh.elements) {
    const std::array<int, 5> words{static_cast<int>(e.shape), e.region, e.interval[0],
                                   e.interval[1], e.interval[2]};
    put(out, words.data(), words.size());
  }
  put_size(out, mesh.node_sets.size());
  for (const auto& [name, set] : mesh.node_sets) {
    put_text(out, name);
    put_size(out, set.size());
    put(out, set.data(), set.size());
  }
  if (!mesh.materials.empty()) // older tables have no materials
    for (const auto& material : mesh.materials)
      put_material(out, material);
  return out;
}

Mesh mesh_from_bytes(std::string_view bytes) {
  Cursor cursor(bytes);
  Mesh mesh;
  mesh.nodes.resize(cursor.count(sizeof(Vec3)));
  cursor.take(mesh.nodes.data(), mesh.nodes.size());
  cursor.require(mesh.nodes.size() <= static_cast<std::size_t>(std::numeric_limits<int>::max()));
  for (const Vec3& p : mesh.nodes)
    cursor.require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  mesh.connectivity = cursor.indices(mesh.nodes.size());
  mesh.regions.resize(cursor.count(8));
  for (std::string& name : mesh.regions)
    name = cursor.text();
  mesh.elements.resize(cursor.count(20));
  std::size_t first = 0;
  for (Element& e : mesh.elements) {
    std::array<int, 5> words{};
    cursor.take(words.data(), words.size());
    cursor.require(words[0] >= 0 && words[0] < static_cast<int>(kShapes) && words[1] >= 0 &&
                   static_cast<std::size_t>(words[1]) < mesh.regions.size());
    // Intervals later serve as indices of elements, at most three per element.
    for (std::size_t axis = 2; axis < words.size(); ++axis)
      cursor.require(
          words[axis] == -1 ||
          (words[axis] >= 0 && static_cast<std::size_t>(words[axis]) < 3 * mesh.elements.size()));
    e = {static_cast<Shape>(words[0]), words[1], first, {words[2], words[3], words[4]}};
    first += static_cast<std::size_t>(node_count(e.shape));
    cursor.require(first <= mesh.connectivity.size());
  }
  cursor.require(first == mesh.connectivity.size());
  const std::size_t sets = cursor.count(16);
  for (std::size_t s = 0; s < sets; ++s) {
    const std::string name = cursor.text();
    mesh.node_sets[name] = cursor.indices(mesh.nodes.size());
  }
  while (!cursor.at_end())
    mesh.materials.push_back(material_from(cursor));
  cursor.require(mesh.materials.empty() || mesh.materials.size() == mesh.regions.size());
  return mesh;
}

} // namespace tactus::fem
