// The .msh reader on meshes that gmsh writes in every format, and on damaged ones.
#include "fem/io/msh.hpp"

#include "static_bodies.hpp"

#include <algorithm>
#include <bit>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gmsh.h>
#include <set>
#include <unistd.h>

using namespace tactus::fem;
using tactus::Vec3;

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

/// A body that gmsh meshes, and what must be read of it.
struct Body {
  std::function<void()> build;
  std::map<std::string, double> volume;                        ///< of each region, mm^3
  std::map<std::string, std::function<bool(const Vec3&)>> set; ///< which nodes are in it
};

void add_box(double x, double length) { gmsh::model::occ::addBox(x, 0, 0, length, 20, 10); }

void generate(int order) {
  gmsh::model::mesh::generate(3);
  gmsh::model::mesh::setOrder(order);
}

void add_group(int dimension, const std::vector<int>& tags, int number, const char* name = "") {
  gmsh::model::addPhysicalGroup(dimension, tags, number);
  if (*name)
    gmsh::model::setPhysicalName(dimension, number, name);
}

/// Entities of a dimension between two corners.
std::vector<int> within(int dimension, const Vec3& low, const Vec3& high) {
  gmsh::vectorpair found;
  gmsh::model::getEntitiesInBoundingBox(low.x - .1, low.y - .1, low.z - .1, high.x + .1,
                                        high.y + .1, high.z + .1, found, dimension);
  std::vector<int> tags;
  for (const auto& [_, tag] : found)
    tags.push_back(tag);
  return tags;
}

/// Two boxes that share a face, groups of every dimension.
Body two_boxes(int order) {
  return {[order] {
            add_box(0, 20);
            add_box(20, 15);
            gmsh::vectorpair all;
            std::vector<gmsh::vectorpair> map;
            gmsh::model::occ::fragment({{3, 1}}, {{3, 2}}, all, map);
            gmsh::model::occ::synchronize();
            add_group(3, within(3, {0, 0, 0}, {20, 20, 10}), 7, "the left one");
            add_group(3, within(3, {20, 0, 0}, {35, 20, 10}), 40);
            add_group(2, within(2, {0, 0, 0}, {0, 20, 10}), 5, "foot");
            add_group(2, within(2, {20, 0, 0}, {20, 20, 10}), 6);
            add_group(1, within(1, {0, 0, 0}, {20, 0, 0}), 9, "edge");
            add_group(0, within(0, {35, 20, 10}, {35, 20, 10}), 3, "foot"); // of two dimensions
            generate(order);
          },
          {{"the left one", 4000}, {"region40", 3000}},
          {{"foot",
            [](const Vec3& p) {
              return p.x == 0 || p == Vec3{35, 20, 10};
            }},
           {"set6", [](const Vec3& p) { return p.x == 20; }},
           {"edge", [](const Vec3& p) { return p.x <= 20 && p.y == 0 && p.z == 0; }}}};
}

/// A rectangle swept upwards: wedges, or bricks, with nodes in their faces or without.
Body lifted(bool bricks, int order, bool incomplete) {
  return {[=] {
            gmsh::option::setNumber("Mesh.SecondOrderIncomplete", incomplete);
            const int face = gmsh::model::occ::addRectangle(0, 0, 0, 30, 20);
            gmsh::vectorpair out, curves;
            gmsh::model::occ::extrude({{2, face}}, 0, 0, 10, out, {2}, {}, true);
            gmsh::model::occ::synchronize();
            if (bricks) {
              gmsh::model::getEntities(curves, 1);
              for (const auto& [_, tag] : curves)
                gmsh::model::mesh::setTransfiniteCurve(tag, 3);
              gmsh::model::mesh::setTransfiniteSurface(face);
              gmsh::model::mesh::setRecombine(2, face);
            }
            add_group(2, {face}, 11);
            add_group(3, {1}, 2);
            generate(order);
          },
          {{"region2", 6000}},
          {{"set11", [](const Vec3& p) { return p.z == 0; }}}};
}

/// Boxes apart, in no group.
Body boxes_apart(int count) {
  Body body{[count] {
              for (int i = 0; i < count; ++i)
                add_box(50 * i, 10);
              gmsh::model::occ::synchronize();
              generate(1);
            },
            {{"body", 2000}},
            {}};
  if (count == 2)
    body.volume = {{"volume1", 2000}, {"volume2", 2000}};
  return body;
}

const Body kInTwoGroups{[] {
                          add_box(0, 20);
                          gmsh::model::occ::synchronize();
                          add_group(3, {1}, 4);
                          add_group(3, {1}, 9, "last");
                          add_group(2, {1, 2}, 1); // the ends in x
                          add_group(2, {2, 3}, 2);
                          generate(1);
                        },
                        {{"last", 4000}},
                        {{"set1", [](const Vec3& p) { return p.x == 0 || p.x == 20; }},
                         {"set2", [](const Vec3& p) { return p.x == 20 || p.y == 0; }}}};

/// One tetrahedron with tags far apart, a set and a region.
const Body kSparse{
    [] {
      gmsh::model::addDiscreteEntity(2, 900);
      gmsh::model::addDiscreteEntity(3, 70);
      gmsh::model::mesh::addNodes(3, 70, {4000000, 12, 999999937, 5},
                                  {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
      gmsh::model::mesh::addElementsByType(900, 2, {88}, {4000000, 12, 5});
      gmsh::model::mesh::addElementsByType(70, 4, {1000000007}, {4000000, 12, 999999937, 5});
      add_group(2, {900}, 123456);
      add_group(3, {70}, 2000000);
    },
    {{"region2000000", 1. / 6}},
    {{"set123456", [](const Vec3& p) { return p.y == 0; }}}};

void check_read(const Body& body, std::initializer_list<int> choices) {
  const Folder folder;
  for (const double version : {2.2, 4.1})
    for (const int binary : {0, 1})
      for (const int all : choices)
        for (const int parametric : choices) {
          CAPTURE(version);
          CAPTURE(binary);
          CAPTURE(all);
          CAPTURE(parametric);
          const Gmsh session;
          gmsh::model::add("body");
          body.build();
          gmsh::option::setNumber("Mesh.MshFileVersion", version);
          gmsh::option::setNumber("Mesh.Binary", binary);
          gmsh::option::setNumber("Mesh.SaveAll", all);
          gmsh::option::setNumber("Mesh.SaveParametric", parametric);
          const std::string path = folder.path / "mesh.msh";
          gmsh::write(path);
          gmsh::clear();
          const Mesh mesh = read_msh(path, 1);
          CHECK_NOTHROW(check(mesh)); // nodes in their order: no element is inside out
          double whole = 0;
          for (const auto& [_, volume] : body.volume)
            whole += volume;
          CHECK(volume(mesh) == doctest::Approx(whole).epsilon(1e-9));
          if (all && version < 3)
            continue; // gmsh then writes no groups
          std::map<std::string, double> volumes;
          const auto each = element_volumes(mesh);
          for (std::size_t e = 0; e < each.size(); ++e)
            volumes[mesh.regions[static_cast<std::size_t>(mesh.elements[e].region)]] += each[e];
          REQUIRE(volumes.size() == body.volume.size());
          for (const auto& [name, expected] : body.volume)
            CHECK(volumes[name] == doctest::Approx(expected).epsilon(1e-9));
          REQUIRE(mesh.node_sets.size() == body.set.size());
          for (const auto& set : body.set) {
            CAPTURE(set.first);
            const auto& nodes = mesh.node_sets.at(set.first);
            const std::set<int> in(nodes.begin(), nodes.end());
            for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
              CHECK(in.contains(static_cast<int>(n)) == set.second(mesh.nodes[n]));
          }
        }
}

} // namespace

TEST_CASE("regions and sets of every dimension are read as gmsh writes them") {
  check_read(two_boxes(2), {0}); // tet10
  check_read(kInTwoGroups, {0});
  check_read(kSparse, {0});
}

TEST_CASE("every shape in every format is read as gmsh writes it" * doctest::test_suite("slow")) {
  for (const Body& body :
       {two_boxes(1), two_boxes(2), lifted(true, 1, true), lifted(true, 2, true),
        lifted(false, 2, true), kSparse, boxes_apart(1), boxes_apart(2), kInTwoGroups})
    check_read(body, {0, 1});
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

std::string binary_2(bool big, int in_block = 1) {
  Binary b{big};
  b.notify("$MeshFormat\n2.2 1 8\n").put(1).notify("\n$EndMeshFormat\n");
  b.notify("$PhysicalNames\n1\n3 5 \"horn\"\n$EndPhysicalNames\n$Nodes\n4\n");
  b.put(10).all(0., 0., 0.).put(20).all(1., 0., 0.).put(30).all(0., 1., 0.).put(40).all(0., 0., 1.);
  b.notify("\n$EndNodes\n$Elements\n1\n").all(4, in_block, 2);
  for (int i = 0; i < in_block; ++i)
    b.all(1 + i, 5, 2, 10, 20, 30, 40);
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
  std::string said;
  const auto notify = [&](const std::string& sentence) { said += sentence + ";"; };
  std::string windows;
  for (const char c : kText4)
    windows += c == '\n' ? "\r\n" : std::string(1, c);
  for (const std::string& text :
       {kText2, kText4, windows, "\n\n" + kText2 + "\n \n",
        "$Comments\nSystemCall \"touch canary\";\n$EndComments\n" + kText2,
        changed(kText4, "$Entities", "$Wonder\n$Nodes\n7\n$EndWonder\n$Entities"),
        kText2 + "$NodeData\n1\n\"view\"\n$EndNodeData\n"})
    CHECK(volume(read_msh(write(folder, text), 1, notify)) == doctest::Approx(1. / 6));
  CHECK(said == "ignored in the file: $Wonder;ignored in the file: $NodeData;");
}

TEST_CASE("what is damaged is refused by place, value and expectation") {
  const auto mentions = [](const std::string& bytes, const std::vector<std::string>& words) {
    const Folder folder;
    for (const std::string& word : words)
      check_refused([&] { return read_msh(write(folder, bytes), 1); }, word);
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
  mentions(changed(kText2, "1 4 2", "1 19 2"), {"13-node pyramid", "type 19"});
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
  mentions(changed(binary_4<std::uint64_t>(true), "4.1 1 8", "4.1 1 4"), {"byte"});
  mentions(binary_2(false, 2), {"2 elements in a block", "1 in all"});
}

namespace {

void check_truncations(std::size_t stride) {
  const Folder folder;
  for (const bool big : {false, true})
    for (const std::string& whole : {binary_4<std::uint64_t>(big), binary_2(big)})
      for (std::size_t size = 0; size + 2 < whole.size(); size += stride)
        CHECK_THROWS_AS((void)read_msh(write(folder, whole.substr(0, size)), 1), InputError);
}

} // namespace

TEST_CASE("what is cut off is refused") { check_truncations(29); }

TEST_CASE("what is cut off anywhere is refused" * doctest::test_suite("slow")) {
  check_truncations(1);
}

TEST_CASE("an element that is not solved is refused by its name") {
  const Folder folder;
  const Gmsh session;
  gmsh::model::add("body");
  lifted(true, 2, false).build();
  const std::string path = folder.path / "mesh.msh";
  gmsh::write(path);
  check_refused([&] { return read_msh(path, 1); },
                "a 27-node hexahedron (gmsh's type 12), expected tetrahedra");
}
