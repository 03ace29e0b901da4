// CalculiX' and Abaqus' files as their users write them: read whole, or refused by line and word.
#include "fem/io/exchange.hpp"
#include "fem/io/inp.hpp"
#include "fem/io/text.hpp"
#include "solve.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <unistd.h>

using namespace tactus::fem;
using tactus::Vec3;

namespace {

struct Deck {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("tactus_" + std::to_string(getpid()) + ".inp");
  std::string said; ///< a line for each sentence
  ~Deck() { std::filesystem::remove(path); }
  Mesh read(const std::string& text, double unit = 1) {
    std::ofstream(path, std::ios::binary) << text;
    return read_inp(path, unit, [this](const std::string& sentence) { said += sentence + "\n"; });
  }
};

/// Two tetrahedra that share a face.
const std::string kNodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n";
const std::string kBody = kNodes + "*ELEMENT,TYPE=C3D4,ELSET=E\n7,1,2,3,4\n8,2,3,4,5\n";
const std::string kSteel = "*MATERIAL,NAME=S\n*ELASTIC\n2e11,.3\n*DENSITY\n7850\n";

} // namespace

TEST_CASE("a CalculiX file is read in each way that it may be written") {
  Deck deck;
  const auto whole = deck.read(kBody);
  CHECK(whole.elements.size() == 2);
  for (const std::string& same :
       {std::string(
            "** of cgx\n\n *Node , nset = Nall\n1, 0,0,0,\n2,1.D0,0,0\n3,0,1d+0,0\n4,0,0,1.0E0"
            "\n5,1,1,1\n*Element , type = C3D4H ,\n Elset = \"E\"\n7,1,2,\n3,4\n8,2,3,4,5\n"),
        kNodes + "*ELEMENT,TYPE=C3D4,ELSET=e\n7,1,2,3,4\n*Element,Type=c3d4,Elset=E\n8,2,3,4,5\n",
        kBody + "*ELEMENT,TYPE=S3,ELSET=SKIN\n9,1,2,3\n*STEP\n*FREQUENCY\n7\n*END STEP\n",
        "\xEF\xBB\xBF*HEADING\r\na plate\r\n" + kBody + "*BOUNDARY\r\n1,1,3\r\n"}) {
    CAPTURE(same);
    const Mesh mesh = deck.read(same);
    CHECK(mesh.nodes == whole.nodes);
    CHECK(mesh.connectivity == whole.connectivity);
    CHECK(tactus::lower(mesh.regions.at(0)) == "e");
    CHECK(mesh.regions.size() == 1);
  }
  CHECK(deck.said.find("1 elements of S3 (line 10) have no volume") != std::string::npos);
  CHECK(deck.said.find("*STEP (line 12)") != std::string::npos);
  CHECK(deck.said.find("*BOUNDARY (line 12)") != std::string::npos);
}

TEST_CASE("sets hold nodes, ranges, other sets and the nodes of elements") {
  Deck deck;
  const auto sets =
      deck.read(kBody +
                "*NSET,NSET=A\n3,1\n*NSET,NSET=B,GENERATE\n2,5,3\n*Nset, nset=\"all, both\"\na,"
                " B\n*NSET,NSET=MIXED\nA,4\n*ELSET,ELSET=LAST\n8\n*ELSET,ELSET=TWICE\nlast\n*"
                "NSET,NSET=F,ELSET=TWICE\n*NSET,NSET=A\n2,\n")
          .node_sets;
  const auto sorted = [&](const char* name) {
    auto set = sets.at(name);
    std::sort(set.begin(), set.end());
    return set;
  };
  CHECK(sorted("A") == std::vector{0, 1, 2});
  CHECK(sorted("B") == std::vector{1, 4});
  CHECK(sorted("all, both") == std::vector{0, 1, 2, 4});
  CHECK(sorted("MIXED") == std::vector{0, 2, 3});
  CHECK(sorted("F") == std::vector{1, 2, 3, 4});
}

TEST_CASE("wedges and pyramids keep their volume beside bricks") {
  Deck deck;
  const std::string nodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n"
                            "8,0,1,1\n9,2,0,0\n10,2,0,1\n11,.5,.5,2\n";
  const Mesh mesh = deck.read(nodes + "*ELEMENT,TYPE=C3D8R\n1,1,2,3,4,5,6,7,8\n*ELEMENT,TYPE=C3D6\n"
                                      "2,2,9,3,6,10,7\n*ELEMENT,TYPE=C3D5\n3,5,6,7,8,11\n");
  CHECK_NOTHROW(check(mesh));
  CHECK(mesh.element_names() == "hex8 + wedge6 + pyramid5");
  CHECK(volume(mesh) == doctest::Approx(1 + .5 + 1. / 3));
  CHECK(surface_of(mesh).triangles.size() == 8 + 6 + 4);
  // CalculiX' own way: bricks with repeated nodes
  const Mesh collapsed =
      deck.read(nodes + "*ELEMENT,TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n2,2,9,3,3,6,10,7,7\n"
                        "3,5,6,7,8,11,11,11,11\n");
  CHECK(collapsed.connectivity == mesh.connectivity);
}

TEST_CASE("materials and their axes come back from our own file, and in a file's own units") {
  Deck deck;
  Mesh mesh = deck.read(kBody);
  Material wood = find_material("rosewood");
  wood.axis_1 = {0, 1, 0};
  wood.axis_2 = {0, 0, 1};
  write_inp(deck.path, mesh, std::vector{wood}, {}, 7);
  const Material back = read_inp(deck.path, 1).materials.at(0).value();
  const ElasticMatrix ours = elastic_matrix(wood), theirs = elastic_matrix(back);
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      CHECK(theirs[i][j] == doctest::Approx(ours[i][j]));
  CHECK(back.density == doctest::Approx(830));
  CHECK(back.loss_factor == doctest::Approx(wood.loss_factor));
  const auto stiffness = [&](std::size_t i, std::size_t j) {
    const std::array<std::size_t, 3> axis{1, 2, 0}; // of 1, 2 and 3 in the body
    return format("%.12g,", ours[axis[i]][axis[j]]);
  };
  const Material same = deck.read(kBody + "*MATERIAL,NAME=W\n*ELASTIC,TYPE=ORTHO\n" +
                                  stiffness(0, 0) + stiffness(0, 1) + stiffness(1, 1) +
                                  stiffness(0, 2) + stiffness(1, 2) + stiffness(2, 2) +
                                  format("%.12g,%.12g\n%.12g\n", wood.shear_pa[2], wood.shear_pa[1],
                                         wood.shear_pa[0]) +
                                  "*SOLID SECTION,ELSET=E,MATERIAL=W\n")
                            .materials.at(0)
                            .value();
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(same.young_pa[i] == doctest::Approx(wood.young_pa[i]));
    CHECK(same.poisson[i] == doctest::Approx(wood.poisson[i]));
    CHECK(same.shear_pa[i] == doctest::Approx(wood.shear_pa[i]));
  }
  // mm, N, s: MPa and t/mm^3; a section for each of two sets, before its material
  mesh = deck.read(kBody +
                       "*ELSET,ELSET=A\n7\n*ELSET,ELSET=B\n8\n*SOLID SECTION,ELSET=A,MATERIAL=s\n"
                       "1.,\n*Solid Section, elset=b, material=\"Alu\"\n*MATERIAL,NAME=S\n*ELASTIC,"
                       "TYPE=ISO\n210000,.3,20\n*DENSITY\n7.85e-9\n*MATERIAL,NAME=ALU\n*DENSITY\n"
                       "2.7D-9\n*ELASTIC\n70000,.33\n*DAMPING,ALPHA=3,BETA=1e-7\n",
                   1e-3);
  CHECK(mesh.regions == std::vector<std::string>{"A", "b"});
  CHECK(mesh.materials.at(0)->young_pa[0] == doctest::Approx(2.1e11));
  CHECK(mesh.materials.at(1)->density == doctest::Approx(2700));
  CHECK(mesh.materials.at(1)->loss_factor == 0);
  CHECK(mesh.materials.at(1)->rayleigh_a == 3);
}

TEST_CASE("each instance of a part has its place, its names and its grain") {
  Deck deck;
  const std::string part = "*PART,NAME=P\n" + kBody +
                           "*NSET,NSET=TIP\n5\n*ORIENTATION,NAME=O\n0,1,0,0,0,1\n"
                           "*SOLID SECTION,ELSET=E,MATERIAL=S,ORIENTATION=O\n*End Part\n";
  const std::string instances =
      "*ASSEMBLY,NAME=A\n*Instance, name=P-1, part=P\n0,50,0\n*End Instance\n"
      "*INSTANCE,NAME=P-2,PART=p\n1,0,0\n1,0,0,1,0,7,90\n*END INSTANCE\n"
      "*NSET,NSET=BOTH,INSTANCE=P-1\nTIP,2\n*NSET,NSET=BOTH,INSTANCE=P-2\n1\n"
      "*NSET,NSET=ALL\nBOTH,P-2.TIP\n*END ASSEMBLY\n";
  const Mesh mesh = deck.read("*PART,NAME=Q\n*END PART\n" + part + instances + kSteel);
  CHECK(mesh.elements.size() == 4);
  CHECK(mesh.nodes.size() == 10);
  const auto at = [&](std::size_t node, Vec3 expected) {
    CHECK(length(mesh.nodes.at(node) - expected) < 1e-12);
  };
  at(1, {1, 50, 0}); // moved
  at(4, {1, 51, 1});
  at(5, {1, 0, 0}); // moved to (1, 0, 0), on the axis
  at(6, {1, 1, 0}); // moved to (2, 0, 0), turned from x to y
  at(7, {0, 0, 0}); // moved to (1, 1, 0), turned from y to -x
  at(8, {1, 0, 1});
  CHECK(mesh.regions == std::vector<std::string>{"P-1.E", "P-2.E"});
  CHECK(mesh.node_sets.at("P-1.TIP") == std::vector<int>{4});
  CHECK(mesh.node_sets.at("BOTH") == std::vector<int>{4, 1, 5});
  CHECK(mesh.node_sets.at("ALL") == std::vector<int>{4, 1, 5, 9});
  CHECK(length(mesh.materials.at(0)->axis_1 - Vec3{0, 1, 0}) < 1e-12);
  CHECK(length(mesh.materials.at(1)->axis_1 - Vec3{-1, 0, 0}) < 1e-12);
  CHECK(deck.said.find("part q has no *INSTANCE and is ignored") != std::string::npos);
  const std::pair<std::string, std::string> refused[]{
      {part + part, "line 17: part p is defined twice"},
      {"*PART,NAME=P\n" + kBody, "line 1: *PART without its end"},
      {part + "*INSTANCE,NAME=I,PART=Q\n", "line 17: *INSTANCE: expected NAME= and PART="},
      {part + "*INSTANCE,NAME=I,PART=P\n1,0\n",
       "line 18: 1,0, expected a line with the shift x,y,z"},
      {part + "*INSTANCE,NAME=I,PART=P\n", "the file ends in *INSTANCE"},
      {part + "*INSTANCE,NAME=I,PART=P\n0,0,0\n1,0,0,1,0,0,90\n", "two points of the axis"},
      {part + "*INSTANCE,NAME=I,PART=P\n*NODE\n", "line 18: *NODE in *INSTANCE"},
      {part + "*NSET,NSET=A,INSTANCE=I\n1\n", "line 17: unknown instance I"},
      {part + "*END INSTANCE\n", "line 17: *END INSTANCE without *INSTANCE"}};
  for (const auto& [text, words] : refused)
    check_refused([&, &bytes = text] { return deck.read(bytes); }, words);
}

TEST_CASE("what is not read of a CalculiX file is refused by its line and word") {
  Deck deck;
  const std::pair<std::string, std::string> kRefused[]{
      {"*INCLUDE, INPUT=a.inp\n", "line 1: *INCLUDE is not supported"},
      {kBody + "*STEP\n*INCLUDE,INPUT=a\n*END STEP\n", "line 11: *INCLUDE is not supported"},
      {kBody + "*TIE,NAME=T\nA,B\n", "line 10: *TIE is not supported"},
      {kBody + "*NGEN\n1,2,1\n", "line 10: *NGEN is not supported"},
      {"*SYSTEM\n1,0,0\n" + kBody, "line 1: *SYSTEM is not supported"},
      {"*NODE,SYSTEM=C\n1,1,90,0\n", "line 1: *NODE: system is not supported"},
      {"1,2,3,4\n" + kBody, "line 1: 1,2,3,4, expected a keyword such as *NODE"},
      {"*NODE\n1,0,0\n", "line 2: 1,0,0, expected number,x,y,z"},
      {kNodes + "*ELEMENT,TYPE=C3D27\n1,2,3\n", "line 7: *ELEMENT TYPE=C3D27: expected C3D4"},
      {kNodes + "*ELEMENT,TYPE=DC3D4\n7,1,2,3,4\n", "TYPE=DC3D4"},
      {kNodes + "*ELEMENT,TYPE=C3D4\n7,1,2,3,4\n7,2,3,4,5\n", "line 9: element 7 is defined twice"},
      {kNodes + "*ELEMENT,TYPE=C3D4\n7,1,2,3,\n", "line 8: element 7 ends early"},
      {kBody + "*NSET,NSET=A\nLEFT,2\n", "line 11: unknown set LEFT"},
      {kBody + "*NSET,NSET=A\n1,9\n", "line 11: node 9 is not defined"},
      {kBody + "*NSET,NSET=A,GENERATE\n1,5,0\n", "line 11: 1,5,0, expected first,last,step"},
      {kBody + "*NSET\n1\n", "line 10: *NSET: expected a name, nset="},
      {kBody + "*ELSET,ELSET=A\n9\n", "line 11: element 9 is not defined"},
      {kBody + "*SHELL SECTION,ELSET=E\n1\n", "line 10: *SHELL SECTION is not supported"},
      {kBody + "*SOLID SECTION,ELSET=F,MATERIAL=S\n" + kSteel, "line 10: unknown element set F"},
      {kBody + "*SOLID SECTION,ELSET=E,MATERIAL=T\n" + kSteel, "line 10: unknown material T"},
      {kBody + "*SOLID SECTION,ELSET=E,MATERIAL=S,ORIENTATION=O\n" + kSteel,
       "line 10: unknown orientation O"},
      {kBody + "*MATERIAL,NAME=S\n*ELASTIC,TYPE=ANISO\n1,2\n",
       "line 11: *ELASTIC TYPE=ANISO: expected ISO, ORTHO or ENGINEERING CONSTANTS"},
      {kBody + "*MATERIAL,NAME=S\n*ELASTIC\n2e11,.3,20\n1e11,.3,500\n",
       "line 13: expected 2 elastic constants, of one temperature"},
      {kBody + "*MATERIAL,NAME=S\n*ELASTIC\n2.1e5,.3\n",
       "line 12: 2.1e5 is 2.1e+05 Pa with lengths of 1 m"},
      {kBody + "*MATERIAL,NAME=S\n*HYPERELASTIC\n1\n", "line 11: *HYPERELASTIC is not supported"},
      {kBody + "*ORIENTATION,NAME=O,SYSTEM=CYLINDRICAL\n",
       "SYSTEM=cylindrical: expected RECTANGULAR"},
      {kBody + "*ELEMENT,TYPE=T3D2,ELSET=R\n9,1,2\n*SOLID SECTION,ELSET=R,MATERIAL=S\n" + kSteel,
       "line 12: a section of elements without volume"},
      {std::string("*\0N\0O\0", 6), "line 1: a byte of 0"}};
  for (const auto& [text, words] : kRefused)
    check_refused([&, &bytes = text] { return deck.read(bytes); }, words);
}
