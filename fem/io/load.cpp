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

std::string ending_of(const std::string& path) {
  return lower(std::filesystem::path(path).extension().string());
}

Mesh load_in_process(const std::string& path, const std::string& ending, const LoadChoice& choice) {
  const double unit = choice.unit > 0 ? choice.unit : default_unit(path);
  if (ending == ".msh")
    return read_msh(path, unit, choice.notify);
  if (ending == ".inp")
    return read_inp(path, unit, choice.notify);
  if (is_cad(ending))
    return mesh_cad(path, choice);
  return mesh_surface_file(path, unit, choice);
}

/// Refuses options that do not apply to this kind of file.
void check_options(const std::string& path, const std::string& ending, const LoadChoice& choice) {
  const bool surface = ending == ".stl" || ending == ".obj";
  const auto refuse = [&](const char* option, const char* kinds) {
    throw InputError(std::string(option) + " applies to " + kinds + " bodies, not to " + path);
  };
  if (choice.fillet > 0 && !is_cad(ending))
    refuse("--fillet", ".step and .brep");
  if (choice.shrink_wrap != 0 && !surface)
    refuse("--shrink-wrap", ".stl and .obj");
  if (choice.remesh && !surface)
    refuse("--remesh", ".stl and .obj");
  if (!choice.part.empty() && is_volume_mesh(path))
    refuse("--only", ".step, .brep, .stl and .obj");
  if (choice.h > 0 && is_volume_mesh(path) && choice.notify)
    choice.notify("warning: --h has no effect, since " + path + " is already a mesh");
}

} // namespace

double default_unit(const std::string& path) {
  const std::string ending = ending_of(path);
  return ending == ".step" || ending == ".stp" ? 0 : is_volume_mesh(path) ? 1 : 1e-3;
}

bool is_volume_mesh(const std::string& path) {
  return ending_of(path) == ".msh" || ending_of(path) == ".inp";
}

std::string face_set(int number) { return "face " + std::to_string(number); }

Mesh load_body(const std::string& path, const LoadChoice& choice) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw InputError("cannot read " + path + ": no such file");
  const std::string ending = ending_of(path);
  if (!is_cad(ending) && ending != ".stl" && ending != ".obj" && ending != ".msh" &&
      ending != ".inp")
    throw InputError(path + ": expected a .step, .stp, .brep, .stl, .obj, .msh or .inp file");
  check_options(path, ending, choice);
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
