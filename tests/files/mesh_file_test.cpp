// STL and OBJ: one reader of their polygons for what is felt and for what is solved.
#include "files/mesh_file.hpp"

#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cctype>
#include <cstdint>
#include <string>
#include <vector>

using namespace tactus::files;
using tactus::Vec3;

namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

const std::string kNoTriangles = "holds no triangles: expected an STL or OBJ file";
const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0 # corner\nv 0 1 0\n";
const std::string kFacet = "facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n"
                           " vertex 0 1e0 0\n endloop\nendfacet\n";

void put(std::string& bytes, float value) {
  const auto word = std::bit_cast<std::uint32_t>(value);
  for (int i = 0; i < 4; ++i)
    bytes += static_cast<char>(word >> 8 * i & 0xff);
}

/// A binary STL of so many triangles, which claims another number.
std::string parse_binary_stl(std::uint32_t count, std::uint32_t claimed, std::string head = "x") {
  head.resize(80, ' ');
  for (int i = 0; i < 4; ++i)
    head += static_cast<char>(claimed >> 8 * i & 0xff);
  for (std::uint32_t t = 0; t < count; ++t) {
    for (const float value : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 2.f, 0.f, 0.f, 0.f, 3.f, 0.1f})
      put(head, value);
    head += std::string(2, '\0');
  }
  return head;
}

std::string error_of(const std::string& bytes, MeshFormat format = MeshFormat::kByContent,
                     const MeshLimits& limits = {}) {
  return read_mesh(bytes, format, limits).error;
}

std::string utf16(const std::string& text, bool big_endian) {
  std::string bytes = big_endian ? "\xFE\xFF" : "\xFF\xFE";
  for (const char c : text) {
    bytes += big_endian ? '\0' : c;
    bytes += big_endian ? c : '\0';
  }
  return bytes;
}

} // namespace

TEST_CASE("meshes are read from text and binary, told apart by what they hold") {
  const PolygonMesh obj = read_mesh("# tetra\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\n"
                                    "f 1/1/1 2//1 3\nf -4 -1 -3\r\nf 1 2 3 4\n");
  CHECK(obj.error == "");
  CHECK(obj.points.size() == 4);
  CHECK(obj.polygons() == 3);
  CHECK(obj.polygon(2).size() == 4);
  CHECK(fan_triangles(obj) == Triangles{{0, 1, 2}, {0, 3, 1}, {0, 1, 2}, {0, 2, 3}});
  for (const std::string& text :
       {"solid a\n" + kFacet + "endsolid\n", kFacet, "comment\n" + kFacet,
        "solid a\nfacet\nOuter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nend loop\nEnd "
        "Facet\nend solid a\n" +
            std::string()}) {
    const PolygonMesh stl = read_mesh(text);
    CHECK(stl.error == "");
    CHECK(fan_triangles(stl) == Triangles{{0, 1, 2}});
    CHECK(stl.points == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  }
  const PolygonMesh binary = read_mesh(parse_binary_stl(2, 2));
  CHECK(binary.error == "");
  CHECK(fan_triangles(binary) == Triangles{{0, 1, 2}, {3, 4, 5}});
  CHECK(binary.points[5] == Vec3{0, 3, static_cast<double>(0.1f)});
  // The first bytes of a binary file may be those of a text.
  for (const char* head : {"solid facet", "\xFE\xFF", "\xEF\xBB\xBF", "v 0 0 0\n"})
    for (const MeshFormat format : {MeshFormat::kByContent, MeshFormat::kStl})
      CHECK(read_mesh(parse_binary_stl(2, 2, head), format).polygons() == 2);
}

TEST_CASE("STL text in any case, with marks and several solids, is read") {
  std::string loud = "  SOLID left wheel\r\n";
  for (const char c : kFacet)
    loud += c == '\n' ? std::string("\r\n") : std::string(1, static_cast<char>(std::toupper(c)));
  const std::string text =
      loud + "ENDSOLID left wheel\r\nsolid hub\n" + kFacet + "endsolid hub\nsolid\n" + kFacet;
  for (const std::string& bytes :
       {text, "\xEF\xBB\xBF" + text, utf16(text, false), utf16(text, true)})
    for (const MeshFormat format : {MeshFormat::kByContent, MeshFormat::kStl}) {
      const PolygonMesh mesh = read_mesh(bytes, format);
      CHECK(mesh.error == "");
      CHECK(mesh.polygons() == 3);
      CHECK(mesh.groups == std::vector<std::string>{"left wheel", "hub", "solid3"});
      CHECK(mesh.group == std::vector<std::uint32_t>{0, 1, 2});
    }
}

TEST_CASE("a binary STL file may have bytes after its triangles, or count none") {
  const std::string one = parse_binary_stl(1, 1, "solid facet");
  CHECK(read_mesh(one + "extra", MeshFormat::kStl).polygons() == 1);
  CHECK(read_mesh(parse_binary_stl(3, 0), MeshFormat::kStl).polygons() == 3);
  CHECK(error_of(parse_binary_stl(3, 0) + "x", MeshFormat::kStl) == kNoTriangles);
  CHECK(error_of(parse_binary_stl(3, 4), MeshFormat::kStl) ==
        "is damaged: its header counts 4 triangles, it ends after 3");
  CHECK(error_of("cube", MeshFormat::kStl) ==
        "is not an STL file: it has 4 bytes and does not start with \"solid\"");
  std::string nan = parse_binary_stl(2, 2);
  nan.replace(84 + 50 + 12, 4, "\xff\xff\xff\xff");
  CHECK(error_of(nan) == "triangle 2 has a corner that is not a finite number");
}

TEST_CASE("OBJ indices, groups, joined lines and free form") {
  const PolygonMesh mesh = read_mesh(
      kSquare + "o lid\nf -4/1/1 -3//2 \\ \t\n -2 \\\n-1 # all\nl 1 2\ng not\no \nf 1 2 3");
  CHECK(mesh.error == "");
  CHECK(mesh.free_form == "");
  CHECK(fan_triangles(mesh) == Triangles{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}});
  CHECK(mesh.groups == std::vector<std::string>{"lid", "part2"});
  CHECK(mesh.group == std::vector<std::uint32_t>{0, 1});
  // Groups count where there are no objects; those before the first object that hold nothing go.
  CHECK(read_mesh(kSquare + "g a\nf 1 2 3\ng b\nf 1 2 4\n").groups ==
        std::vector<std::string>{"a", "b"});
  CHECK(read_mesh(kSquare + "g a\no b\nf 1 2 4\n").groups == std::vector<std::string>{"b"});
  CHECK(read_mesh(kSquare + "f 1 2 4\n").groups == std::vector<std::string>{"part1"});
  const PolygonMesh free = read_mesh(kSquare + "cstype bezier\nsurf 0 1 0 1 1 2\nf 1 2 3\n");
  CHECK(free.polygons() == 1);
  CHECK(free.free_form ==
        "line 5: \"cstype\" is a free-form curve or surface, expected polygons (f)");
  // Numbers of lines count those that were joined.
  CHECK(error_of(kSquare + "f 1 \\\n2 \\\n3\nf 1 2 9\n") == "line 8: vertex 9 does not exist");
}

TEST_CASE("a file named OBJ is text; numbers may have a plus, lines end with a carriage return") {
  CHECK(error_of(parse_binary_stl(2, 2), MeshFormat::kObj) == kNoTriangles);
  const PolygonMesh mesh = read_mesh("v +1 -2 +3e0\rv 1 0 0\rv 1 1 0\rf 1 2 3\r");
  REQUIRE(mesh.points.size() == 3);
  CHECK(mesh.points[0] == Vec3{1, -2, 3});
  CHECK(mesh.polygons() == 1);
}

TEST_CASE("what is wrong is one sentence with its line") {
  struct Wrong {
    std::string text, error;
  };
  const std::string stl_words =
      "facet, outer loop, vertex, endloop, endfacet or endsolid, each on its own line";
  const std::string begin = "solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\n";
  for (const Wrong& one :
       {Wrong{"v 1 2\n", "line 1: expected three coordinates"},
        {"v 0 0 nan\n", "line 1: expected three coordinates"},
        {"v 0 0 1e999\n", "line 1: expected three coordinates"},
        {"v 0 0 1mm\n", "line 1: expected three coordinates"},
        {"v 0 0 0\r\nv 1 0 0\r\rv 0 1\r\n", "line 4: expected three coordinates"},
        {"v 0 0 0\nf 1 2 3\n", "line 2: vertex 2 does not exist"},
        {kSquare + "f 1 2\n", "line 5: a face with 2 corners, expected 3 or more"},
        {kSquare + "l 1 2\np 1\np 2\n", "holds 1 lines and 2 points and no face: expected the "
                                        "polygons (f) of a closed surface"},
        {"", kNoTriangles},
        {"no mesh at all", kNoTriangles},
        {begin + "endfacet\n", "line 5: a facet with 2 corners, expected 3"},
        {begin + "vertex 1 1 0\nvertex 0 1 0\nendfacet",
         "line 7: a facet with 4 corners, expected 3"},
        {begin, "is damaged: it ends within a facet"},
        {begin + "facet\n", "line 5: \"facet\", expected " + stl_words},
        {begin + "edge 1 1 0\n", "line 5: \"edge\", expected " + stl_words},
        {begin + "vertex 1 1 0 vertex 1 1 1\n", "line 5: \"vertex\", expected " + stl_words},
        {"solid\nfacet normal 0 0 1 outer loop\n", "line 2: \"outer\", expected " + stl_words},
        {begin + "vertex 0,5 1 0\n", "line 5: 0,5 has a comma: expected a decimal point"},
        {"v 0 1,5e-3 0\n", "line 1: 1,5e-3 has a comma: expected a decimal point"},
        {kSquare + "fo 1 2 3\nf 1 2 3\n", "line 5: \"fo\", expected a keyword of OBJ"}}) {
    CAPTURE(one.text);
    CHECK(error_of(one.text) == one.error);
  }
  for (const char* word : {"0", "-5", "5", "x", "1x", "1x/2", "99999999999999999999", "/1"}) {
    CAPTURE(word);
    CHECK(error_of(kSquare + "f 1 2 " + word + "\n") ==
          "line 5: vertex " + std::string(word) + " does not exist");
  }
  CHECK(error_of(std::string(84, '\xff')) != "");
}

TEST_CASE("more triangles or corners than are accepted are refused in every format") {
  const MeshLimits two{.max_triangles = 2}, quads{.max_face_corners = 4};
  struct Limited {
    std::string bytes;
    MeshLimits limits;
    const char* error;
  };
  const char* const many = "has more than 2 triangles";
  for (const Limited& one :
       {Limited{parse_binary_stl(2, 2), two, ""},
        {parse_binary_stl(3, 3), two, many},
        {"solid\n" + kFacet + kFacet, two, ""},
        {"solid\n" + kFacet + kFacet + kFacet, two, many},
        {kSquare + "f 1 2 3 4\n", two, ""},
        {kSquare + "f 1 2 3 4\nf 1 2 3\n", two, many},
        {kSquare + "f 1 2 3 4 1\n", two, many},
        {kSquare + "f 1 2 3 4\n", quads, ""},
        {kSquare + "f 1 2 3 4 1\n", quads, "line 5: a face with 5 corners, expected 3 to 4"}}) {
    CAPTURE(one.bytes);
    CHECK(error_of(one.bytes, MeshFormat::kByContent, one.limits) == one.error);
  }
}
