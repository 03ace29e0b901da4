#include "fem/io/load.hpp"

#include "fem/io/inp.hpp"
#include "fem/io/msh.hpp"
#include "fem/io/words.hpp"
#include "fem/mesh/cad.hpp"
#include "fem/mesh/surface_file.hpp"

#include <filesystem>

namespace tactus::fem {

namespace {

bool is_cad(const std::string& ending) {
  return ending == ".step" || ending == ".stp" || ending == ".brep" || ending == ".brp";
}

Mesh load_here(const std::string& path, const std::string& ending, const LoadChoice& choice) {
  const auto unit = [&](double habit) { return choice.unit > 0 ? choice.unit : habit; };
  if (ending == ".msh")
    return read_msh(path, unit(1));
  if (ending == ".inp")
    return read_inp(path, unit(1));
  if (is_cad(ending))
    return mesh_cad(path, choice);
  return mesh_surface_file(path, unit(1e-3), choice);
}

} // namespace

std::string face_set(int number) { return "face " + std::to_string(number); }

Mesh load_body(const std::string& path, const LoadChoice& choice) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw Refusal("cannot read " + path + ": no such file");
  const std::string ending = lower(std::filesystem::path(path).extension().string());
  if (!is_cad(ending) && ending != ".stl" && ending != ".obj" && ending != ".msh" &&
      ending != ".inp")
    throw Refusal(path + ": expected a .step, .stp, .brep, .stl, .obj, .msh or .inp file");
  if (choice.fillet > 0 && !is_cad(ending))
    throw Refusal("--fillet rounds edges of .step and .brep bodies, " + path +
                  " has none to round");
  Mesh mesh = run_isolated(path, choice.limits, {choice.say, choice.report},
                           [&](const ChildProgress& progress) {
                             LoadChoice in_child = choice;
                             in_child.say = progress.say;
                             in_child.report = progress.report;
                             return load_here(path, ending, in_child);
                           });
  check_range(path, mesh.nodes);
  return mesh;
}

} // namespace tactus::fem
