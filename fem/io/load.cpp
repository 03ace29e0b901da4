#include "fem/io/load.hpp"

#include "fem/io/inp.hpp"
#include "fem/io/msh.hpp"
#include "fem/io/words.hpp"
#include "fem/mesh/gmsh_mesher.hpp"
#include "fem/mesh/remesh.hpp"

#include <filesystem>

namespace tactus::fem {

Mesh load_body(const std::string& path, const LoadChoice& choice) {
  if (!std::filesystem::is_regular_file(path))
    throw Refusal("cannot read " + path + ": no such file");
  const std::string ending = lower(std::filesystem::path(path).extension().string());
  if (choice.fillet > 0 && ending != ".step" && ending != ".stp" && ending != ".brep")
    throw Refusal("--fillet rounds edges of .step and .brep bodies, " + path +
                  " has none to round");
  const auto unit = [&](double habit) { return choice.unit > 0 ? choice.unit : habit; };
  if (ending == ".msh")
    return read_msh(path, unit(1));
  if (ending == ".inp")
    return read_inp(path, unit(1));
  if (ending == ".step" || ending == ".stp" || ending == ".brep")
    return mesh_cad(path, choice);
  if (ending == ".stl" || ending == ".obj") {
    Triangles surface = read_triangles(path, unit(1e-3));
    try {
      close(surface);
      if (const auto pair = crossing(surface))
        throw Refusal("the surface crosses itself: " + place_of(surface, (*pair)[0]) + " cuts " +
                      place_of(surface, (*pair)[1]));
    } catch (const Refusal& refusal) {
      throw Refusal(path + ": " + refusal.what());
    }
    return mesh_surface(surface, choice);
  }
  throw Refusal(path + ": expected a .step, .stp, .brep, .stl, .obj, .msh or .inp file");
}

} // namespace tactus::fem
