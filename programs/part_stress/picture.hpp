#pragma once
#include "programs/part_stress/part.hpp"

#include <optional>

namespace tactus::fem {

/// One state of the part for the sheet: its shape, and the stress there.
struct PictureState {
  std::vector<Vec3> nodes;                 ///< positions of the mesh's nodes, m
  std::vector<double> von_mises;           ///< recovered at the nodes, Pa
  std::vector<double> error;               ///< estimated error of `von_mises`
  std::vector<double> at_elements;         ///< at the centroids, Pa
  std::vector<double> missing_at_elements; ///< estimated amount by which `at_elements` are too low
  double max_displacement = 0;             ///< m
  double volume = 0;                       ///< m^3
  std::size_t peak = 0;                    ///< node of the largest stress
  /// The node of the largest stress away from singular corners, if it is another node. At a corner
  /// the stress has no limit as the mesh is refined.
  std::optional<std::size_t> peak_away;
};

[[nodiscard]] double mean(std::span<const double>);

/// The state of a solved shape.
[[nodiscard]] PictureState picture_of(const Mesh&, const StaticModel&, const StaticSolution&,
                                      std::vector<double> von_mises_at_elements);

/// Texts and numbers beside the pictures.
struct PictureLabels {
  std::string title, subtitle;
  std::vector<double> parameters{}; ///< parameters of the moved shape; empty if not moved
  std::vector<double> taylor{};     ///< stress at the centroids of the moved shape, or empty
};

/// Draws the sheet: the part before and, with a second state, after its control points moved.
void draw_part(const std::string& picture, const StaticModel&, const DesignSpace&,
               const Mesh& start, std::span<const PictureState> states, const PictureLabels&);

} // namespace tactus::fem
