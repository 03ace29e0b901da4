#pragma once
#include "fem/io/load.hpp"

#include <array>

namespace tactus::fem {

/// A tractor's lift arm, like the one of Ryken & Vance 2000: a curved plate with three bosses. At
/// the hub it is splined to the rock shaft, a cylinder pushes at the eye in its middle, and the
/// lift rod hangs from the eye at its end. Lengths in m.
///
///                 ___-------------___
///            _--``   _____    ______  ``--_          y
///         ,-`   ,--``_____``  (  o  )  ____`-.       |
///       .`  __  (__--     lift eye    ``-___) `.     +-- x
///      (  (    ) slot                  slot  (o) )
///       `. `--` hub                           rod eye
///         ``--``
///
/// The plate lies in x y with its middle plane at z = 0. The hub's axis is the z axis, the rod
/// eye's is at (length, 0), and the centreline between them is an arc that rises by `rise`. Two
/// arcs touch the rounded ends and bound the plate; at mid-length they are depth / 2 above and
/// below the centreline's highest point.
struct LiftArm {
  struct Boss {
    double bore, diameter, width; ///< diameters; width along z, over both sides of the plate
  };
  double length = .380;    ///< distance from hub to rod eye
  double rise = .055;      ///< height of the centreline above the line from hub to rod eye
  double depth = .108;     ///< depth of the plate at mid-length, along y
  double thickness = .022; ///< thickness of the plate, along z
  Boss hub{.060, .096, .062}, lift_eye{.030, .056, .054}, rod_eye{.026, .050, .050};
  double lift_position = .46; ///< position of the lift eye along the centreline, 0 to 1
  double shoulder = .016;     ///< rim of the plate around the bosses of hub and rod eye
  double fillet = .008;       ///< radius where bosses meet the plate
  double slot_width = .028;   ///< width of the two lightening holes along the centreline; 0 for
                              ///< none
  double web = .014;          ///< distance between a boss and a lightening hole
  double edge_radius = 0;     ///< radius that rounds the plate's outline
};

/// A hole for a pin through the whole boss, along z and about its centre.
struct Pin {
  const char* name; ///< hub, lift_eye, rod_eye
  Vec3 centre;
  double radius = 0, width = 0;
};
[[nodiscard]] std::array<Pin, 3> pins(const LiftArm&);

/// Refuses dimensions with which bosses, fillets, holes or outline would meet, and names the
/// dimension.
void check(const LiftArm&);

/// The volume in m^3, in closed form: areas within circular arcs (Green), fillets and rounded edges
/// by Pappus and Guldin.
[[nodiscard]] double volume(const LiftArm&);

/// The solid as a STEP file in mm, by Open CASCADE. Refuses as check() does.
void write_step(const std::string& path, const LiftArm&);

/// Meshes the solid in curved tet10. The node sets hub, lift_eye and rod_eye contain the nodes on
/// the walls of the holes. `part` and `unit` of the choice do not apply.
[[nodiscard]] Mesh mesh_lift_arm(const LiftArm&, const LoadChoice&);

} // namespace tactus::fem
