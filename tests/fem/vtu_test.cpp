// The file for ParaView, read back by a small reader that shares nothing with the writer.
#include "fem/io/vtu.hpp"
#include "fem/shapes/block.hpp"
#include "fem/shapes/shapes.hpp"

#include <doctest/doctest.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>

using namespace tactus::fem;

namespace {

struct ReadBack {
  std::map<std::string, std::vector<double>> array; ///< by Name; the coordinates have none
  std::map<std::string, int> components;
  std::size_t points = 0, cells = 0;
};

ReadBack read_vtu(const std::filesystem::path& path) {
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  ReadBack out;
  std::smatch sizes;
  REQUIRE(std::regex_search(text, sizes,
                            std::regex("NumberOfPoints=\"([0-9]+)\" NumberOfCells=\"([0-9]+)\"")));
  out.points = std::stoul(sizes[1]);
  out.cells = std::stoul(sizes[2]);
  for (std::size_t at = text.find("<DataArray "); at != std::string::npos;
       at = text.find("<DataArray ", at + 1)) {
    const auto close = text.find('>', at), end = text.find("</DataArray>", at);
    const std::string tag = text.substr(at, close - at);
    std::smatch found;
    const std::string name =
        std::regex_search(tag, found, std::regex("Name=\"([^\"]*)\"")) ? found[1].str() : "";
    out.components[name] =
        std::regex_search(tag, found, std::regex("NumberOfComponents=\"([0-9]+)\""))
            ? std::stoi(found[1])
            : 1;
    std::istringstream numbers(text.substr(close + 1, end - close - 1));
    for (double value = 0; numbers >> value;)
      out.array[name].push_back(value);
  }
  // Every tag that opens is closed, in order.
  std::vector<std::string> open;
  const std::regex tags("<(/?)([A-Za-z]+)[^>?]*>");
  for (std::sregex_iterator t(text.begin(), text.end(), tags), none; t != none; ++t) {
    if ((*t)[1].length() == 0) {
      open.push_back((*t)[2]);
    } else {
      REQUIRE(!open.empty());
      CHECK(open.back() == (*t)[2].str());
      open.pop_back();
    }
  }
  CHECK(open.empty());
  return out;
}

struct File {
  std::filesystem::path path = std::filesystem::temp_directory_path() / "tactus_vtu_test.vtu";
  ~File() { std::filesystem::remove(path); }
};

} // namespace

TEST_CASE("every node, element and field of a mesh is read back") {
  const File file;
  MeshChoice choice;
  choice.h = .02; // hexahedra and wedges
  const Mesh mesh = make_shape("disk", {{"diameter", .1}, {"thickness", .012}}, {}, choice);
  std::vector<double> displacement(mesh.dofs()), stress(mesh.elements.size());
  for (std::size_t i = 0; i < displacement.size(); ++i)
    displacement[i] = std::sin(.1 * static_cast<double>(i)) * 1e-5;
  for (std::size_t e = 0; e < stress.size(); ++e)
    stress[e] = 1e6 * (1 + static_cast<double>(e));
  const std::vector<VtuField> nodal{{"displacement", 3, displacement}},
      elemental{{"von Mises <\"Pa\"> & more", 1, stress}};
  write_vtu(file.path.string(), mesh, nodal, elemental);
  const ReadBack back = read_vtu(file.path);
  REQUIRE(back.points == mesh.nodes.size());
  REQUIRE(back.cells == mesh.elements.size());
  const auto& xyz = back.array.at("");
  REQUIRE(xyz.size() == mesh.dofs());
  for (std::size_t i = 0; i < xyz.size(); ++i)
    CHECK(std::abs(xyz[i] - mesh.nodes[i / 3][static_cast<int>(i % 3)]) < 1e-9);
  std::vector<double> connectivity(mesh.connectivity.begin(), mesh.connectivity.end());
  CHECK(back.array.at("connectivity") == connectivity);
  double end = 0;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    end += node_count(mesh.elements[e].shape);
    CHECK(back.array.at("offsets")[e] == end);
    CHECK(back.array.at("types")[e] == vtk_type(mesh.elements[e].shape));
  }
  CHECK(back.array.at("region").size() == mesh.elements.size());
  REQUIRE(back.array.at("displacement").size() == displacement.size());
  CHECK(back.components.at("displacement") == 3);
  for (std::size_t i = 0; i < displacement.size(); ++i)
    CHECK(back.array.at("displacement")[i] == doctest::Approx(displacement[i]).epsilon(1e-6));
  const auto& read = back.array.at("von Mises &lt;&quot;Pa&quot;&gt; &amp; more");
  REQUIRE(read.size() == stress.size());
  for (std::size_t e = 0; e < stress.size(); ++e)
    CHECK(read[e] == doctest::Approx(stress[e]).epsilon(1e-6));
}

TEST_CASE("fields of another size or without finite numbers are refused and leave no file") {
  const File file;
  const std::vector<double> line{0, .5, 1};
  const Mesh mesh = block(line, line, line);
  std::vector<double> values(mesh.nodes.size(), 1.);
  const auto refuses = [&](std::size_t components, const char* words) {
    const std::vector<VtuField> nodal{{"stress", components, values}};
    try {
      write_vtu(file.path.string(), mesh, nodal, {});
      FAIL("nothing was refused");
    } catch (const InputError& refusal) {
      CHECK(std::string(refusal.what()).find(words) != std::string::npos);
    }
    CHECK(!std::filesystem::exists(file.path));
  };
  refuses(3, "expected 3 for each of");
  refuses(0, "field stress");
  values[5] = NAN;
  refuses(1, "no finite number");
}
