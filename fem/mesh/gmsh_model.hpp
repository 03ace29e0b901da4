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
    gmsh::initialize(0, nullptr, false); // reads no ~/.gmshrc and no ~/.gmsh-options
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

/// Returns whether `work` ended without an exception; gmsh's exceptions may not be derived from
/// std::exception. std::bad_alloc and TooLarge are rethrown.
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

/// Meshes the model up to a dimension. Refuses with gmsh's error, after which another attempt may
/// follow. An exception from gmsh's own generate() would leave gmsh locked and all later meshes
/// empty.
void generate(int dimension);

/// Converts gmsh's volume elements, nodes and names to a Mesh, with lengths multiplied by `unit`.
/// With `face_sets` the model's faces become node sets (face_set()).
[[nodiscard]] Mesh import_mesh(double unit, bool face_sets = false);

/// Curves of the model at which the body turns inward. Compares the two facets at each mesh edge on
/// a curve: the angle is concave if the far corner of one facet rises above the outward plane of
/// the other.
[[nodiscard]] std::vector<double> concave_curves();

/// The requested element size, or that of `size_for` limited to twice the wall thickness and to 60
/// thousand triangles on the skin. Metres.
[[nodiscard]] double first_size(const LoadChoice&, double volume, double skin, double largest);

/// The predicted size of the mesh: with one size h, with a surface that already has `faces`
/// triangles, or with the sizes of a refinement.
[[nodiscard]] MeshSize predicted_mesh_size(const LoadChoice&, double volume, double skin,
                                           const Vec3& box, double h, double faces);

/// Sets the element size to h everywhere, and finer towards these curves.
void set_sizes(double h, const std::vector<double>& concave);
/// Sets the sizes of a refinement times `finer`; coordinates and sizes of the model are in `unit`
/// metres. The field must live until the mesh is made.
void set_sizes(const SizeField&, double unit, double finer = 1);

/// Raises the mesh to second order; edges that invert an element are straightened
/// (straighten_inverted). Elements that are inverted even with straight edges stay inverted.
[[nodiscard]] Mesh make_quadratic(bool curved, double unit, bool face_sets = false);

} // namespace tactus::fem
