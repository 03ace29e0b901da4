#include "fem/io/load.hpp"

#include "fem/io/inp.hpp"
#include "fem/io/msh.hpp"
#include "fem/io/text.hpp"
#include "fem/mesh/cad.hpp"
#include "fem/mesh/surface_file.hpp"

#include <filesystem>

namespace tactus::fem {

namespace {

bool is_cad(const std::string& ending) {
  return ending == ".step" || ending == ".stp" || ending == ".brep" || ending == ".brp";
}

Mesh load_in_process(const std::string& path, const std::string& ending, const LoadChoice& choice) {
  const auto unit = [&](double default_unit) {
    return choice.unit > 0 ? choice.unit : default_unit;
  };
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
    throw InputError("cannot read " + path + ": no such file");
  const std::string ending = lower(std::filesystem::path(path).extension().string());
  if (!is_cad(ending) && ending != ".stl" && ending != ".obj" && ending != ".msh" &&
      ending != ".inp")
    throw InputError(path + ": expected a .step, .stp, .brep, .stl, .obj, .msh or .inp file");
  if (choice.fillet > 0 && !is_cad(ending))
    throw InputError("--fillet rounds edges of .step and .brep bodies, " + path +
                     " has none to round");
  Mesh mesh = run_isolated(path, choice.limits, {choice.notify, choice.report},
                           [&](const ChildProgress& progress) {
                             LoadChoice in_child = choice;
                             in_child.notify = progress.notify;
                             in_child.report = progress.report;
                             return load_in_process(path, ending, in_child);
                           });
  check_range(path, mesh.nodes);
  return mesh;
}

} // namespace tactus::fem
