#pragma once
#include "programs/part_stress/part.hpp"

#include <optional>

namespace tactus::fem {

/// One state of the part for the sheet: its shape, and the stress there.
struct PictureState {
  std::vector<Vec3> nodes;                 ///< of the mesh, m
  std::vector<double> von_mises;           ///< recovered at the nodes, Pa
  std::vector<double> error;               ///< estimated, of `von_mises`
  std::vector<double> at_elements;         ///< at the centroids, Pa
  std::vector<double> missing_at_elements; ///< estimated: how much too low `at_elements` are
  double max_displacement = 0;             ///< m
  double volume = 0;                       ///< m^3
  std::size_t peak = 0;                    ///< the node of the largest stress
  /// The same beyond singular corners, where it is another: at a corner the stress has no limit as
  /// the mesh is refined.
  std::optional<std::size_t> peak_away;
};

[[nodiscard]] double mean(std::span<const double>);

/// The state of a solved shape.
[[nodiscard]] PictureState picture_of(const Mesh&, const StaticModel&, const StaticSolution&,
                                      std::vector<double> von_mises_at_elements);

/// Texts and numbers beside the pictures.
struct PictureLabels {
  std::string title, subtitle;
  std::vector<double> parameters{}; ///< of the moved shape; empty: not moved
  std::vector<double> taylor{};     ///< at the centroids of the moved shape, or empty
};

/// Draws the sheet: the part before and, with a second state, after its control points moved.
void draw_part(const std::string& picture, const StaticModel&, const DesignSpace&,
               const Mesh& start, std::span<const PictureState> states, const PictureLabels&);

} // namespace tactus::fem
