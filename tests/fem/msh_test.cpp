// The .msh reader against gmsh itself: meshes that gmsh writes in every format, read by both.
#include "fem/io/msh.hpp"

#include "fem/io/gmsh_elements.hpp"

#include <algorithm>
#include <bit>
#include <doctest/doctest.h>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gmsh.h>
#include <set>
#include <unistd.h>

using namespace tactus::fem;

namespace {

struct Gmsh {
  Gmsh() {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("Mesh.MeshSizeMax", 12);
  }
  ~Gmsh() { gmsh::finalize(); }
};

struct Folder {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("tactus_msh_" + std::to_string(getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
};

std::string write(const Folder& folder, const std::string& bytes) {
  const std::string path = folder.path / "mesh.msh";
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

std::string refusal(const std::string& bytes) {
  const Folder folder;
  try {
    (void)read_msh(write(folder, bytes), 1);
  } catch (const InputError& refused) {
    return refused.what();
  }
  return "read";
}

using Point = std::array<double, 3>;
/// A mesh without its numbering: elements by region and corners, sets by points.
struct Content {
  std::multiset<std::pair<std::string, std::vector<Point>>> elements;
  std::map<std::string, std::set<Point>> sets;
  bool operator==(const Content&) const = default;
};

Content content(const Mesh& mesh) {
  Content c;
  const auto point = [&](int n) {
    const Vector3& p = mesh.nodes[static_cast<std::size_t>(n)];
    return Point{p.x, p.y, p.z};
  };
  for (const Element& e : mesh.elements) {
    std::vector<Point> corners;
    for (const int n : mesh.nodes_of(e))
      corners.push_back(point(n));
    c.elements.emplace(mesh.regions[static_cast<std::size_t>(e.region)], corners);
  }
  for (const auto& [name, set] : mesh.node_sets)
    for (const int n : set)
      c.sets[name].insert(point(n));
  return c;
}

/// The same from gmsh's model, groups by its own functions.
Content content_by_gmsh(const std::string& path) {
  gmsh::open(path);
  Content c;
  std::map<std::size_t, Point> points;
  std::vector<std::size_t> tags;
  std::vector<double> xyz, parameters;
  gmsh::model::mesh::getNodes(tags, xyz, parameters);
  for (std::size_t i = 0; i < tags.size(); ++i)
    points[tags[i]] = {xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]};
  std::map<int, std::string> name_of;
  gmsh::vectorpair groups, volumes;
  gmsh::model::getPhysicalGroups(groups);
  gmsh::model::getEntities(volumes, 3);
  std::map<std::string, std::vector<std::size_t>> sets;
  for (const auto& [dimension, tag] : groups) {
    std::string name;
    gmsh::model::getPhysicalName(dimension, tag, name);
    if (name.empty())
      name = (dimension == 3 ? "region" : "set") + std::to_string(tag);
    std::vector<int> entities;
    gmsh::model::getEntitiesForPhysicalGroup(dimension, tag, entities);
    if (dimension == 3) {
      for (const int e : entities)
        name_of[e] = name;
      continue;
    }
    gmsh::model::mesh::getNodesForPhysicalGroup(dimension, tag, tags, xyz);
    sets[name].insert(sets[name].end(), tags.begin(), tags.end());
  }
  std::set<std::size_t> used;
  std::set<std::pair<std::string, std::vector<Point>>> once;
  for (const auto& [dimension, volume] : volumes) {
    std::vector<int> types;
    std::vector<std::vector<std::size_t>> elements, nodes;
    gmsh::model::mesh::getElements(types, elements, nodes, dimension, volume);
    const std::string name = name_of.contains(volume) ? name_of[volume]
                             : volumes.size() == 1    ? "body"
                                                      : "volume" + std::to_string(volume);
    for (std::size_t t = 0; t < types.size(); ++t) {
      const GmshElement* const type = gmsh_element(types[t]);
      REQUIRE(type->shape.has_value());
      const auto count = static_cast<std::size_t>(type->nodes);
      for (std::size_t e = 0; e < elements[t].size(); ++e) {
        std::vector<Point> corners;
        for (std::size_t i = 0; i < count; ++i) {
          const std::size_t n = nodes[t][e * count + static_cast<std::size_t>(type->from[i])];
          used.insert(n);
          corners.push_back(points.at(n));
        }
        once.emplace(name, corners); // gmsh keeps what MSH 2 writes twice
      }
    }
  }
  c.elements.insert(once.begin(), once.end());
  for (const auto& [name, nodes] : sets)
    for (const std::size_t n : nodes)
      if (used.contains(n))
        c.sets[name].insert(points.at(n));
  return c;
}

/// Two boxes that share a face, groups of every dimension.
void two_boxes(int order) {
  gmsh::model::add("boxes");
  gmsh::model::occ::addBox(0, 0, 0, 20, 20, 10, 1);
  gmsh::model::occ::addBox(20, 0, 0, 15, 20, 10, 2);
  gmsh::vectorpair all;
  std::vector<gmsh::vectorpair> map;
  gmsh::model::occ::fragment({{3, 1}}, {{3, 2}}, all, map);
  gmsh::model::occ::synchronize();
  gmsh::model::addPhysicalGroup(3, {1}, 7);
  gmsh::model::setPhysicalName(3, 7, "the left one");
  gmsh::model::addPhysicalGroup(3, {2}, 40);
  gmsh::model::addPhysicalGroup(2, {1, 3}, 5);
  gmsh::model::setPhysicalName(2, 5, "foot");
  gmsh::model::addPhysicalGroup(2, {2}, 6);
  gmsh::model::addPhysicalGroup(1, {4}, 9);
  gmsh::model::setPhysicalName(1, 9, "edge");
  gmsh::model::addPhysicalGroup(0, {2}, 3);
  gmsh::model::setPhysicalName(0, 3, "foot"); // one name for groups of two dimensions
  gmsh::model::mesh::generate(3);
  gmsh::model::mesh::setOrder(order);
}

void turned_or_lifted(bool bricks, int order, bool incomplete) {
  gmsh::model::add("swept");
  gmsh::option::setNumber("Mesh.SecondOrderIncomplete", incomplete);
  const int face = gmsh::model::occ::addRectangle(0, 0, 0, 30, 20);
  gmsh::vectorpair out;
  gmsh::model::occ::extrude({{2, face}}, 0, 0, 10, out, {2}, {}, true);
  gmsh::model::occ::synchronize();
  if (bricks) {
    gmsh::vectorpair curves;
    gmsh::model::getEntities(curves, 1);
    for (const auto& [dimension, tag] : curves)
      gmsh::model::mesh::setTransfiniteCurve(tag, 3);
    gmsh::model::mesh::setTransfiniteSurface(face);
    gmsh::model::mesh::setRecombine(2, face);
  }
  gmsh::model::addPhysicalGroup(2, {face}, 11);
  gmsh::model::addPhysicalGroup(3, {1}, 2);
  gmsh::model::mesh::generate(3);
  gmsh::model::mesh::setOrder(order);
}

/// One tetrahedron with tags far apart, a set and a region.
void sparse() {
  gmsh::model::add("sparse");
  gmsh::model::addDiscreteEntity(2, 900);
  gmsh::model::addDiscreteEntity(3, 70);
  gmsh::model::mesh::addNodes(3, 70, {4000000, 12, 999999937, 5},
                              {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  gmsh::model::mesh::addElementsByType(900, 2, {88}, {4000000, 12, 5});
  gmsh::model::mesh::addElementsByType(70, 4, {1000000007}, {4000000, 12, 999999937, 5});
  gmsh::model::addPhysicalGroup(2, {900}, 123456);
  gmsh::model::addPhysicalGroup(3, {70}, 2000000);
}

void compare_all(const std::string& what, const std::function<void()>& build) {
  const Folder folder;
  for (const double version : {2.2, 4.1})
    for (const int binary : {0, 1})
      for (const int all : {0, 1})
        for (const int parametric : {0, 1}) {
          const Gmsh session;
          build();
          gmsh::option::setNumber("Mesh.MshFileVersion", version);
          gmsh::option::setNumber("Mesh.Binary", binary);
          gmsh::option::setNumber("Mesh.SaveAll", all);
          gmsh::option::setNumber("Mesh.SaveParametric", parametric);
          const std::string path = folder.path / "mesh.msh";
          gmsh::write(path);
          gmsh::clear();
          CAPTURE(what);
          CAPTURE(version);
          CAPTURE(binary);
          CAPTURE(all);
          CAPTURE(parametric);
          const Content expected = content_by_gmsh(path), found = content(read_msh(path, 1));
          CHECK(found.elements.size() > 0);
          CHECK(found.elements == expected.elements);
          CHECK(found.sets == expected.sets);
        }
}

} // namespace

TEST_CASE("every format that gmsh writes is read as gmsh reads it") {
  compare_all("tet4", [] { two_boxes(1); });
  compare_all("tet10", [] { two_boxes(2); });
  compare_all("hex8", [] { turned_or_lifted(true, 1, true); });
  compare_all("hex20", [] { turned_or_lifted(true, 2, true); });
  compare_all("wedge15", [] { turned_or_lifted(false, 2, true); });
  compare_all("sparse tags", sparse);
  compare_all("no group, one volume", [] {
    gmsh::model::occ::addSphere(0, 0, 0, 20);
    gmsh::model::occ::synchronize();
    gmsh::model::mesh::generate(3);
  });
  compare_all("no group, two volumes", [] {
    gmsh::model::occ::addSphere(0, 0, 0, 20);
    gmsh::model::occ::addSphere(50, 0, 0, 10);
    gmsh::model::occ::synchronize();
    gmsh::model::mesh::generate(3);
  });
  compare_all("a volume in two groups", [] {
    gmsh::model::occ::addBox(0, 0, 0, 20, 20, 20);
    gmsh::model::occ::synchronize();
    gmsh::model::addPhysicalGroup(3, {1}, 4);
    gmsh::model::addPhysicalGroup(3, {1}, 9);
    gmsh::model::addPhysicalGroup(2, {1, 2}, 1);
    gmsh::model::addPhysicalGroup(2, {2, 3}, 2);
    gmsh::model::setPhysicalName(3, 9, "last");
    gmsh::model::mesh::generate(3);
  });
}

namespace {

/// Bytes of a binary file in either order.
struct Binary {
  bool big;
  std::string text{};
  template <class T> Binary& put(T value) {
    auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (big)
      std::reverse(bytes.begin(), bytes.end());
    text.append(bytes.data(), bytes.size());
    return *this;
  }
  template <class... T> Binary& all(T... values) {
    (put(values), ...);
    return *this;
  }
  Binary& notify(const std::string& words) {
    text += words;
    return *this;
  }
};

/// A tetrahedron of MSH 4.1 whose counts and tags are of type Word.
template <class Word> std::string binary_4(bool big) {
  const auto n = [](int v) { return static_cast<Word>(v); };
  Binary b{big};
  b.notify("$MeshFormat\n4.1 1 " + std::to_string(sizeof(Word)) + "\n")
      .put(1)
      .notify("\n$EndMeshFormat\n");
  b.notify("$PhysicalNames\n1\n3 5 \"horn\"\n$EndPhysicalNames\n");
  b.notify("$Entities\n").all(n(0), n(0), n(0), n(1));
  b.put(2).all(0., 0., 0., 1., 1., 1.).put(n(1)).put(5).put(n(0)).notify("\n$EndEntities\n");
  b.notify("$Nodes\n").all(n(1), n(4), n(10), n(40)).all(3, 2, 0).put(n(4));
  b.all(n(10), n(20), n(30), n(40)).all(0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.);
  b.notify("\n$EndNodes\n$Elements\n").all(n(1), n(1), n(1), n(1)).all(3, 2, 4).put(n(1));
  return b.all(n(1), n(10), n(20), n(30), n(40)).notify("\n$EndElements\n").text;
}

std::string binary_2(bool big) {
  Binary b{big};
  b.notify("$MeshFormat\n2.2 1 8\n").put(1).notify("\n$EndMeshFormat\n");
  b.notify("$PhysicalNames\n1\n3 5 \"horn\"\n$EndPhysicalNames\n$Nodes\n4\n");
  b.put(10).all(0., 0., 0.).put(20).all(1., 0., 0.).put(30).all(0., 1., 0.).put(40).all(0., 0., 1.);
  b.notify("\n$EndNodes\n$Elements\n1\n").all(4, 1, 2, 1, 5, 2, 10, 20, 30, 40);
  return b.notify("\n$EndElements\n").text;
}

const std::string kText2 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
    "4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n";
const std::string kText4 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 0 0\n$EndEntities\n"
    "$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n"
    "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n";

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

} // namespace

TEST_CASE("binary files of both orders of bytes and both sizes of counts are the same mesh") {
  const Folder folder;
  for (const std::string& bytes : {binary_4<std::uint64_t>(false), binary_4<std::uint64_t>(true),
                                   binary_4<std::uint32_t>(false), binary_4<std::uint32_t>(true),
                                   binary_2(false), binary_2(true)}) {
    const Mesh mesh = read_msh(write(folder, bytes), 2);
    CHECK(mesh.regions == std::vector<std::string>{"horn"});
    REQUIRE(mesh.elements.size() == 1);
    CHECK(volume(mesh) == doctest::Approx(8. / 6));
  }
}

TEST_CASE("comments, unknown sections, blank lines and Windows line ends change nothing") {
  const Folder folder;
  std::string windows;
  for (const char c : kText4)
    windows += c == '\n' ? "\r\n" : std::string(1, c);
  for (const std::string& text :
       {kText2, kText4, windows, "\n\n" + kText2 + "\n \n",
        "$Comments\nSystemCall \"touch canary\";\n$EndComments\n" + kText2,
        changed(kText4, "$Entities", "$Wonder\n$Nodes\n7\n$EndWonder\n$Entities"),
        kText2 + "$NodeData\n1\n\"view\"\n$EndNodeData\n"})
    CHECK(volume(read_msh(write(folder, text), 1)) == doctest::Approx(1. / 6));
}

TEST_CASE("what is damaged is refused by place, value and expectation") {
  const auto mentions = [](const std::string& bytes, const std::vector<std::string>& words) {
    const std::string error_text = refusal(bytes);
    CAPTURE(error_text);
    CHECK(error_text.find('\n') == std::string::npos);
    for (const std::string& word : words)
      CHECK(error_text.find(word) != std::string::npos);
  };
  mentions("SystemCall \"touch canary\";", {"line 1", "SystemCall", "$MeshFormat"});
  mentions("// a script\nSystemCall \"touch canary\";", {"line 1", "$MeshFormat"});
  mentions(kText2 + "SystemCall \"touch canary\";", {"line 15", "SystemCall"});
  mentions("", {"$MeshFormat"});
  mentions(changed(kText2, "2.2 0 8", "1 0 8"), {"line 2", "version 1", "4.1"});
  mentions(changed(kText2, "2.2 0 8", "4 0 8"), {"version 4", "4.1"});
  mentions(changed(kText2, "2.2 0 8", "2.2 0 4"), {"4", "8 bytes"});
  mentions(changed(kText2, "$Nodes\n4", "$Nodes\n4000000000"),
           {"line 5 in $Nodes", "4000000000", "bytes left"});
  mentions(changed(kText2, "$Nodes\n4", "$Nodes\n-4"), {"line 5", "-4"});
  mentions(changed(kText2, "$Nodes\n4\n1 0 0 0", "$Nodes\n5\n1 0 0 0"),
           {"$EndNodes", "a node's number"});
  mentions(changed(kText2, "$Nodes\n4", "$Nodes\n3"), {"line 9", "4", "$EndNodes"});
  mentions(changed(kText2, "2 1 0 0", "2 nan 0 0"), {"line 7", "nan", "finite"});
  mentions(changed(kText2, "2 1 0 0", "2 1e999 0 0"), {"line 7", "1e999"});
  mentions(changed(kText2, "2 1 0 0", "1 1 0 0"), {"node 1", "twice"});
  mentions(changed(kText2, "1 2 3 4\n$", "1 2 3 9\n$"), {"element 1", "node 9"});
  mentions(changed(kText2, "1 4 2", "1 5 2"), {"$EndElements", "node's number"});
  mentions(changed(kText2, "1 4 2", "1 7 2"), {"5-node pyramid", "type 7"});
  mentions(changed(kText2, "1 4 2", "1 777 2"), {"777"});
  mentions(changed(kText2, "1 4 2 0 1", "1 4 -2 0 1"), {"-2", "number of tags"});
  mentions(changed(kText2, "1 4 2 0 1 1 2 3 4", "1 2 2 0 1 1 2 3"), {"no volume element"});
  mentions(changed(kText2, "$EndNodes", "$Endnodes"), {"$EndNodes"});
  mentions(kText2.substr(0, 60), {"bytes left"});
  mentions(kText2.substr(0, kText2.size() - 14), {"the file ends", "$EndElements"});
  mentions(changed(kText4, "4.1 0 8", "4.1 0 6"), {"6", "4 or 8"});
  mentions(changed(kText4, "0 0 0 1\n", "0 0 0 18446744073709551615\n"),
           {"18446744073709551615", "entities"});
  mentions(changed(kText4, "3 1 0 4", "3 1 0 400000"), {"400000", "nodes"});
  mentions(changed(kText4, "3 1 0 4", "3 1 0 5"), {"5 nodes", "4 in all"});
  mentions(changed(kText4, "1 4 1 4", "1 5 1 4"), {"4 nodes", "5 as"});
  mentions(changed(kText4, "3 1 4 1", "2 1 4 1"), {"4-node tetrahedron", "dimension 2"});
  mentions(changed(kText4, "$Nodes", "$PartitionedEntities"), {"partitioned"});
  mentions(changed(kText4, "$Elements", "$Nodes"), {"$Nodes"});
  mentions(
      changed(kText4, "$Entities\n", "$PhysicalNames\n1\n3 1 horn\n$EndPhysicalNames\n$Entities\n"),
      {"horn", "quotation marks"});
  mentions(changed(kText4, "$Entities\n",
                   "$PhysicalNames\n1\n3 1 \"a\x1b[2J\"\n$EndPhysicalNames\n$Entities\n"),
           {"control"});
  mentions(changed(kText4, "$Entities", "$Wonder"), {"never ends", "$EndWonder"});
  for (const bool big : {false, true}) {
    const std::string whole = binary_4<std::uint64_t>(big), old = binary_2(big);
    for (std::size_t size = 0; size + 2 < whole.size(); ++size)
      CHECK(refusal(whole.substr(0, size)) != "read");
    for (std::size_t size = 0; size + 2 < old.size(); ++size)
      CHECK(refusal(old.substr(0, size)) != "read");
    mentions(changed(whole, "4.1 1 8", "4.1 1 4"), {"byte"});
  }
}

TEST_CASE("an element that is not solved is refused by its name") {
  const Folder folder;
  const Gmsh session;
  turned_or_lifted(true, 2, false);
  const std::string path = folder.path / "mesh.msh";
  gmsh::write(path);
  CHECK_THROWS_WITH(
      (void)read_msh(path, 1),
      doctest::Contains("a 27-node hexahedron (gmsh's type 12), expected tetrahedra"));
}
