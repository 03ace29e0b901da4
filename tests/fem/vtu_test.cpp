// The file for ParaView, read back by a small reader that shares nothing with the writer.
#include "fem/io/vtu.hpp"
#include "static_bodies.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <sstream>

using namespace tactus::fem;

namespace {

/// The numbers of each array by its Name; the coordinates have none.
std::map<std::string, std::vector<double>> read_vtu(const std::string& path) {
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::regex name("Name=\"([^\"]*)\"");
  std::map<std::string, std::vector<double>> out;
  // Not by one expression: std::regex takes a frame of the stack for each character.
  for (auto at = text.find("<DataArray "); at != text.npos; at = text.find("<DataArray ", at + 1)) {
    const auto end = text.find('>', at);
    const std::string tag = text.substr(at, end - at);
    std::smatch found;
    std::istringstream numbers(text.substr(end + 1, text.find("</DataArray>", end) - end - 1));
    auto& values = out[std::regex_search(tag, found, name) ? found[1].str() : ""];
    values.assign(std::istream_iterator<double>(numbers), {});
  }
  return out;
}

const std::string kPath = std::filesystem::temp_directory_path() / "tactus_vtu_test.vtu";

} // namespace

TEST_CASE("every node, element and field of a mesh is read back") {
  const Mesh mesh = // hexahedra and wedges
      make_shape("disk", {{"diameter", .1}, {"thickness", .012}}, {}, {.h = .04});
  std::vector<double> displacement, stress, xyz, ends, types;
  for (std::size_t i = 0; i < mesh.dofs(); ++i) {
    displacement.push_back(std::sin(.1 * static_cast<double>(i)) * 1e-5);
    xyz.push_back(mesh.nodes[i / 3][static_cast<int>(i % 3)]);
  }
  for (const Element& e : mesh.elements) {
    stress.push_back(1e6 * (1 + static_cast<double>(stress.size())));
    ends.push_back((ends.empty() ? 0 : ends.back()) + node_count(e.shape));
    types.push_back(vtk_type(e.shape));
  }
  const std::vector<VtuField> nodal{{"displacement", 3, displacement}},
      elemental{{"von Mises <\"Pa\"> & more", 1, stress}};
  write_vtu(kPath, mesh, nodal, elemental);
  auto back = read_vtu(kPath);
  const auto agrees = [&](const std::string& name, const std::vector<double>& expected) {
    CAPTURE(name);
    REQUIRE(back[name].size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      CHECK(std::abs(back[name][i] - expected[i]) <= 1e-6 * std::abs(expected[i]) + 1e-12);
  };
  agrees("", xyz);
  agrees("connectivity", {mesh.connectivity.begin(), mesh.connectivity.end()});
  agrees("offsets", ends);
  agrees("types", types);
  agrees("displacement", displacement);
  agrees("von Mises &lt;&quot;Pa&quot;&gt; &amp; more", stress);
  CHECK(back["region"].size() == mesh.elements.size());
  std::filesystem::remove(kPath);
}

TEST_CASE("fields of another size or without finite numbers are refused and leave no file") {
  const std::vector<double> line{0, .5, 1};
  const Mesh mesh = block(line, line, line);
  std::vector<double> values(mesh.nodes.size(), 1.);
  const auto refuses = [&](std::size_t components, const char* words) {
    const std::vector<VtuField> nodal{{"stress", components, values}};
    check_refused([&] { write_vtu(kPath, mesh, nodal, {}); }, words);
    CHECK(!std::filesystem::exists(kPath));
  };
  refuses(3, "expected 3 for each of");
  refuses(0, "field stress");
  values[5] = NAN;
  refuses(1, "not a finite number");
}
