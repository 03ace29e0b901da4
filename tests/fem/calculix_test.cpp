#include "fem/element/quadrature.hpp"
#include "fem/io/exchange.hpp"
#include "fem/mesh/gmsh_model.hpp"
#include "static_bodies.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <unistd.h>

using namespace tactus::fem;

namespace {

/// A lever in curved tet10, millimetres in gmsh: two bosses with holes, a web between them that
/// narrows, and a foot with a fillet.
Mesh lever() {
  Session session;
  return session.run("lever", [] {
    gmsh::model::add("lever");
    namespace occ = gmsh::model::occ;
    const int pivot = occ::addCylinder(0, 0, 0, 0, 0, 24, 20);
    const int eye = occ::addCylinder(120, 20, 4, 0, 0, 16, 13);
    const int web = occ::addBox(0, -9, 7, 122, 26, 10);
    gmsh::vectorpair body, holes;
    std::vector<gmsh::vectorpair> map;
    occ::fuse({{3, pivot}}, {{3, eye}, {3, web}}, body, map);
    const int bore = occ::addCylinder(0, 0, -1, 0, 0, 30, 10);
    const int pin = occ::addCylinder(120, 20, -1, 0, 0, 30, 6);
    const int light = occ::addCylinder(60, 4, -1, 0, 0, 30, 7);
    gmsh::vectorpair cut;
    occ::cut(body, {{3, bore}, {3, pin}, {3, light}}, cut, map);
    occ::synchronize();
    gmsh::option::setNumber("Mesh.MeshSizeMax", 7);
    gmsh::option::setNumber("Mesh.MeshSizeFromCurvature", 12);
    generate(3);
    return make_quadratic(true, 1e-3);
  });
}

/// A directory of its own that goes with the test.
struct Scratch {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("tactus_ccx_" + std::to_string(getpid()));
  Scratch() { std::filesystem::create_directories(path); }
  ~Scratch() { std::filesystem::remove_all(path); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
};

struct Printed {
  std::vector<Vector3> displacement;
  std::vector<Stress> stress; ///< mean of each element's integration points
};

/// CalculiX' .dat: displacements by node, stresses by element and point (xx yy zz xy xz yz).
Printed read_dat(const std::filesystem::path& path, const Mesh& mesh) {
  Printed printed{std::vector<Vector3>(mesh.nodes.size()),
                  std::vector<Stress>(mesh.elements.size(), Stress{})};
  std::vector<int> points(mesh.elements.size(), 0);
  std::ifstream file(path);
  std::string line;
  bool stresses = false;
  while (std::getline(file, line)) {
    if (line.find("displacements") != std::string::npos)
      stresses = false;
    else if (line.find("stresses") != std::string::npos)
      stresses = true;
    std::istringstream words(line);
    std::size_t id = 0;
    if (!(words >> id) || id == 0)
      continue;
    if (stresses) {
      int point = 0;
      Stress s;
      if (words >> point >> s[0] >> s[1] >> s[2] >> s[5] >> s[4] >> s[3]) {
        ++points[id - 1];
        for (std::size_t v = 0; v < 6; ++v)
          printed.stress[id - 1][v] += s[v];
      }
    } else {
      Vector3& u = printed.displacement[id - 1];
      words >> u.x >> u.y >> u.z;
    }
  }
  for (std::size_t e = 0; e < points.size(); ++e)
    for (double& s : printed.stress[e])
      s /= std::max(points[e], 1);
  return printed;
}

/// Ours and theirs on one mesh: the largest differences, of the largest displacement, and of the
/// stress at ten places from the most stressed tenth of the elements.
void compare(const Mesh& mesh, const StaticModel& model) {
  const Scratch scratch;
  write_static_inp((scratch.path / "part.inp").string(), mesh, model);
  const std::string command =
      "cd '" + scratch.path.string() + "' && OMP_NUM_THREADS=1 timeout 300 ccx part > ccx.log 2>&1";
  REQUIRE(std::system(command.c_str()) == 0);
  const Printed theirs = read_dat(scratch.path / "part.dat", mesh);
  const StaticAnalysis ours = solve_static(mesh, model);
  const auto& u = ours.solution.displacement;
  double worst = 0, largest = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const Vector3 own{u[3 * n], u[3 * n + 1], u[3 * n + 2]};
    worst = std::max(worst, length(own - theirs.displacement[n]));
    largest = std::max(largest, length(own));
  }
  MESSAGE(mesh.dofs() << " unknowns, displacement " << worst / largest << " of the largest");
  CHECK(largest > 1e-7);
  CHECK(worst < 1e-4 * largest); // the specification asks for 5e-3
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    order.emplace_back(-von_mises(theirs.stress[e]), e);
  std::sort(order.begin(), order.end());
  const auto laws = elastic_laws(mesh, model.materials);
  double worst_stress = 0;
  for (std::size_t k = 0; k < 10; ++k) {
    const std::size_t e = order[k * order.size() / 100].second;
    const Element& element = mesh.elements[e];
    Stress mean{};
    const auto points = stiffness_points(element.shape);
    for (const QuadraturePoint& q : points) {
      const Stress s =
          stress_at(mesh, element, laws[static_cast<std::size_t>(element.region)], u, q.at);
      for (std::size_t v = 0; v < 6; ++v)
        mean[v] += s[v] / static_cast<double>(points.size());
    }
    worst_stress =
        std::max(worst_stress, std::abs(von_mises(mean) / von_mises(theirs.stress[e]) - 1));
  }
  MESSAGE("von Mises at ten places " << worst_stress);
  CHECK(worst_stress < 1e-3); // the specification asks for 2e-2
}

bool has_ccx() { return std::system("command -v ccx > /dev/null") == 0; }

} // namespace

TEST_CASE("a lever with holes bends in CalculiX as here") {
  if (!has_ccx()) {
    MESSAGE("SKIPPED: CalculiX (ccx, Debian calculix-ccx) is not installed");
    return;
  }
  set_solver_threads(1);
  const Mesh mesh = lever();
  StaticModel model;
  model.materials = {steel()};
  const Vector3 up{0, 0, .04};
  const auto wall = [&](double x, double y, double r) {
    const Vector3 at{x, y, -.01};
    return select_faces(mesh, {OnCylinder{at, at + up, r, false}, 2e-6});
  };
  model.fixed = {{"bore", nodes_of_faces(mesh, wall(0, 0, .01)), {true, true, true}, {}}};
  model.loads = {BoltLoad{"pin", wall(.12, .02, .006), {0, 0, 1}, {800, -2500, 0}},
                 TotalForce{"side", select_faces(mesh, plane(2, .02)), {0, 0, 300}},
                 Gravity{{0, -9.81, 0}}};
  compare(mesh, model);
}

TEST_CASE("a wooden plate with a hole, pulled apart, yields in CalculiX as here") {
  if (!has_ccx()) {
    MESSAGE("SKIPPED: CalculiX (ccx, Debian calculix-ccx) is not installed");
    return;
  }
  set_solver_threads(1);
  const Mesh mesh = quarter_plate(.01, .05, .01, true, 6, 8, 1.3);
  StaticModel model;
  Material wood;
  wood.density = 450;
  wood.young_pa = {11e9, 0.8e9, 0.45e9};
  wood.poisson = {0.44, 0.38, 0.36};
  wood.shear_pa = {0.04e9, 0.6e9, 0.75e9};
  wood.axis_1 = {1, 1, 0};
  wood.axis_2 = {-1, 1, 0};
  model.materials = {wood};
  model.fixed = {{"x", select_nodes(mesh, plane(0, 0)), {true, true, true}, {}},
                 {"grip", select_nodes(mesh, plane(0, .05)), {true, false, false}, {1e-5, 0, 0}}};
  model.loads = {Pressure{"rim", select_faces(mesh, plane(1, .05)), 1e4}};
  compare(mesh, model);
}
