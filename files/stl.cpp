#include "files/mesh_formats.hpp"
#include "files/product.hpp"

#include <algorithm>
#include <bit>

namespace tactus::files {
namespace {

constexpr std::size_t kHeader = 84, kRecord = 50; // bytes
constexpr std::size_t kNormal = 12;               // bytes of a record before its corners

std::uint32_t read_uint32(std::string_view bytes, std::size_t at) noexcept {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i-- > 0;)
    word = word << 8 | static_cast<unsigned char>(bytes[at + i]);
  return word;
}

std::size_t binary_count(std::string_view bytes) noexcept {
  return bytes.size() >= kHeader ? read_uint32(bytes, 80) : 0;
}

/// Ends a facet; its corners are the points since `first`.
bool close_facet(std::size_t first, std::size_t line, const MeshLimits& limits, PolygonMesh& mesh) {
  const std::size_t corners = mesh.points.size() - first;
  if (corners != 3) {
    mesh.error =
        line_text(line) + "a facet with " + std::to_string(corners) + " corners, expected 3";
    return false;
  }
  for (std::size_t p = first; p < mesh.points.size(); ++p)
    mesh.corner.push_back(static_cast<std::uint32_t>(p));
  mesh.group.push_back(
      static_cast<std::uint32_t>(std::max<std::size_t>(mesh.groups.size(), 1) - 1));
  return accepts(mesh.polygons(), limits, mesh);
}

} // namespace

bool is_binary_stl_by_size(std::string_view bytes) noexcept {
  return bytes.size() >= kHeader && product(kRecord, binary_count(bytes)) == bytes.size() - kHeader;
}

bool is_stl_text(std::string_view bytes) {
  const auto start = bytes.find_first_not_of(" \t\r\n");
  if (start == std::string_view::npos || !is_word(bytes.substr(start, 5), "solid"))
    return false;
  const std::string beginning = lower(bytes.substr(0, 1 << 16));
  return beginning.find('\0') == std::string::npos &&
         (beginning.find("facet") != std::string::npos ||
          beginning.find("endsolid") != std::string::npos);
}

void read_binary_stl(std::string_view bytes, const MeshLimits& limits, PolygonMesh& mesh) {
  if (bytes.size() < kHeader) {
    mesh.error = "is not an STL file: it has " + std::to_string(bytes.size()) +
                 " bytes and does not start with \"solid\"";
    return;
  }
  const std::size_t available = (bytes.size() - kHeader) / kRecord;
  std::size_t count = binary_count(bytes);
  if (count == 0) // some programs do not write the count
    count = (bytes.size() - kHeader) % kRecord == 0 ? available : 0;
  if (count > available) {
    mesh.error = "is damaged: its header counts " + std::to_string(count) +
                 " triangles, it ends after " + std::to_string(available);
    return;
  }
  if (!accepts(count, limits, mesh))
    return;
  mesh.groups = {"solid"};
  mesh.points.reserve(3 * count);
  mesh.corner.reserve(3 * count);
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t at = kHeader + kRecord * t + kNormal + 12 * c;
      Vec3 p;
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = static_cast<double>(
            std::bit_cast<float>(read_uint32(bytes, at + 4 * static_cast<std::size_t>(axis))));
      if (!is_finite(p)) {
        mesh.error =
            "triangle " + std::to_string(t + 1) + " has a corner that is not a finite number";
        return;
      }
      mesh.corner.push_back(static_cast<std::uint32_t>(mesh.points.size()));
      mesh.points.push_back(p);
    }
  }
}

namespace {

/// Reads the keywords of a text, one per line. Text before the first keyword is a comment.
class StlTextReader {
public:
  StlTextReader(const MeshLimits& limits, PolygonMesh& mesh) : limits_(limits), mesh_(mesh) {}

  /// Reads one line; false on an error.
  bool line(std::size_t number, Words words) {
    std::string word = lower(words.next());
    if (word == "end") // some programs write "end facet"
      word += lower(words.next());
    if (word == "solid")
      begin_solid(words.rest());
    else if (word == "facet" && first_ == mesh_.points.size())
      return only_normal(number, words);
    else if (word == "vertex")
      return add_point(words, number, mesh_) && ends(number, words);
    else if (word == "endfacet")
      return end_facet(number);
    else if (begun_ && !word.empty() && word != "outer" && word != "endloop" && word != "endsolid")
      return refuse(number, word);
    return true;
  }

  void end() {
    if (mesh_.error.empty() && first_ != mesh_.points.size())
      mesh_.error = "is damaged: it ends within a facet";
  }

private:
  void begin_solid(std::string_view name) {
    begun_ = true;
    mesh_.groups.push_back(name.empty() ? "solid" + std::to_string(mesh_.groups.size() + 1)
                                        : std::string(name));
  }
  bool only_normal(std::size_t number, Words& words) {
    begun_ = true;
    for (int word = 0; word < 4; ++word) // skips "normal" and its numbers: the corners determine
                                         // the normal
      words.next();
    return ends(number, words);
  }
  bool end_facet(std::size_t number) {
    const bool good = close_facet(first_, number, limits_, mesh_);
    first_ = mesh_.points.size();
    return good;
  }
  bool ends(std::size_t number, Words& words) {
    const std::string_view more = words.next();
    return more.empty() || refuse(number, more);
  }
  bool refuse(std::size_t number, std::string_view word) {
    mesh_.error = line_text(number) + "\"" + std::string(word) +
                  "\", expected facet, outer loop, vertex, endloop, endfacet or endsolid, each on "
                  "its own line";
    return false;
  }

  const MeshLimits& limits_;
  PolygonMesh& mesh_;
  std::size_t first_ = 0; ///< corner of the facet being read
  bool begun_ = false;
};

} // namespace

void read_stl_text(std::string_view text, const MeshLimits& limits, PolygonMesh& mesh) {
  StlTextReader reader(limits, mesh);
  for_each_line(text, [&](std::size_t number, std::string_view line) {
    return reader.line(number, Words(line));
  });
  reader.end();
}

} // namespace tactus::files
