#pragma once
#include "fem/io/load.hpp"
#include "fem/io/text.hpp"

#include <gmsh.h>
#include <new>

namespace tactus::fem {

/// A gmsh session: initialize() on construction, finalize() on destruction. gmsh's errors become
/// InputErrors.
class Session {
public:
  Session() {
    gmsh::initialize(0, nullptr, false); // no ~/.gmshrc, no ~/.gmsh-options
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("General.NumThreads", 1);
    gmsh::option::setNumber("Mesh.RandomSeed", 1);
    gmsh::logger::start();
  }
  ~Session() { gmsh::finalize(); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  template <class Work> auto run(const std::string& what, Work&& work) {
    try {
      return work();
    } catch (const InputError&) {
      throw;
    } catch (const std::exception& error) {
      throw InputError(what + ": " + error_text(error.what()));
    } catch (...) {
      throw InputError(what + ": " + error_text("gmsh failed"));
    }
  }

private:
  /// gmsh's last error, or `reason` if there is none.
  static std::string error_text(std::string reason) {
    std::vector<std::string> log;
    gmsh::logger::get(log);
    for (const std::string& line : log)
      if (line.starts_with("Error"))
        reason = line;
    return reason;
  }
};

/// Whether `work` ended without an exception; those of gmsh may be no std::exception.
/// std::bad_alloc and TooLarge are passed on.
template <class Work> bool succeeds(Work&& work) {
  try {
    work();
    return true;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const TooLarge&) {
    throw;
  } catch (...) {
    return false;
  }
}

/// Meshes the model up to a dimension. Refuses with gmsh's error; another attempt may follow. (An
/// exception from gmsh's own generate() would leave gmsh locked and every later mesh empty.)
void generate(int dimension);

/// Converts gmsh's volume elements, nodes and names to a Mesh, with lengths multiplied by `unit`.
/// With `face_sets` the model's faces become node sets (face_set()).
[[nodiscard]] Mesh import_mesh(double unit, bool face_sets = false);

/// Model curves where the body turns inward. Compares the two facets at each mesh edge on a curve:
/// where the far corner of one rises above the outward plane of the other, the angle is concave.
[[nodiscard]] std::vector<double> concave_curves();

/// The requested element size, or that of `size_for` limited to twice the wall thickness and to 60
/// thousand triangles on the skin. Metres.
[[nodiscard]] double first_size(const LoadChoice&, double volume, double skin, double largest);

/// The predicted mesh: with one size h, with a surface that is meshed already in `faces` triangles,
/// or with the sizes of a refinement.
[[nodiscard]] MeshSize predicted_mesh_size(const LoadChoice&, double volume, double skin,
                                           const Vec3& box, double h, double faces);

/// Element sizes: h everywhere, finer towards these curves.
void set_sizes(double h, const std::vector<double>& concave);
/// Sizes of a refinement times `finer`; coordinates and sizes of the model are in `unit` metres.
/// The field must live until the mesh is made.
void set_sizes(const SizeField&, double unit, double finer = 1);

/// Raises the mesh to second order; edges that turn an element inside out are straightened
/// (straighten_inverted). Elements that are inside out with straight edges stay so.
[[nodiscard]] Mesh make_quadratic(bool curved, double unit, bool face_sets = false);

} // namespace tactus::fem
