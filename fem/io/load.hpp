#pragma once
#include "fem/io/isolated_process.hpp"
#include "fem/mesh/mesh_size.hpp"
#include "fem/mesh/size_field.hpp"

#include <functional>
#include <string>

namespace tactus::fem {

/// How a body's file is read and meshed.
struct LoadChoice {
  double unit = 0;        ///< metres per unit of the file; 0 for default_unit(). STEP states its
                          ///< own
  double h = 0;           ///< element size, m; 0 to use `size_for`
  double fillet = 0;      ///< radius that rounds a CAD body's concave edges, m; 0 for none
  double shrink_wrap = 0; ///< closes gaps narrower than this in a surface file, m; below 0 to
                          ///< choose
  bool grade_concave = true, curved = true, remesh = false;
  bool multi = false; ///< several separate bodies are allowed
  int elements_per_turn =
      12; ///< elements around curved CAD faces; sides deviate by 1e-4 of the radius
  /// For swept prisms: elements around curves, and their smallest size relative to h. The default
  /// of the first suffices for modes; the stress at a hole that is a tenth of the body wide needs
  /// finer values of both.
  int swept_elements_per_turn = 12;
  double swept_smallest = 1.0 / 3;
  /// If true, every face of a CAD body becomes a node set (face_set()) and one notify() sentence
  /// describes it. Prisms are then not swept.
  bool face_sets = false;
  std::string part{}; ///< name, or number from one, of the body to use if there are several
  /// Returns the element size (m) for a body's volume, skin area and largest extent (m^3, m^2, m);
  /// used if h is 0.
  std::function<double(double volume, double skin, double largest)> size_for{};
  /// Element sizes of a refinement, in place of h. A body that cannot be meshed with them is
  /// refused.
  const SizeField* sizes = nullptr;
  std::function<void(const std::string&)> notify{};
  /// Called with the predicted size before gmsh meshes; may throw to refuse it. It runs in the
  /// child process, so its changes in memory are lost.
  std::function<void(const MeshSize&, const std::function<void(const std::string&)>& notify)>
      on_prediction{};
  std::function<void(const std::string& stage, double share)> report{};
  ChildLimits limits{}; ///< limits of the process that reads and meshes
};

/// Whether a file is a mesh already, by its ending: .msh or .inp.
[[nodiscard]] bool is_volume_mesh(const std::string& path);

/// Metres per unit of length for a file without a unit: a metre for .msh and .inp, else a
/// millimetre. 0 for STEP, which contains its unit.
[[nodiscard]] double default_unit(const std::string& path);

/// The name of the node set of a CAD body's face, by its number from one.
[[nodiscard]] std::string face_set(int number);

/// Reads a body from a file, by the file's ending. .msh and .inp files are volume meshes and are
/// read unchanged; .step, .stp, .brep, .brp, .stl and .obj files are meshed with gmsh in tet10.
/// Reading and meshing run in a child process with `limits` (isolated_process.hpp,
/// docs/security.md). Refuses a file that it cannot read, and names file, line or element.
[[nodiscard]] Mesh load_body(const std::string& path, const LoadChoice&);

} // namespace tactus::fem
