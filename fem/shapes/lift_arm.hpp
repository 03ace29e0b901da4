#pragma once
#include "fem/io/load.hpp"

#include <array>

namespace tactus::fem {

/// A tractor's lift arm, like the one of Ryken & Vance 2000: a curved plate with three bosses. It
/// is splined to the rock shaft at the hub, a cylinder pushes at the eye in its middle, the lift
/// rod hangs from the eye at its end. Lengths in m.
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
  double length = .380;    ///< from hub to rod eye
  double rise = .055;      ///< of the centreline above the line from hub to rod eye
  double depth = .108;     ///< of the plate at mid-length, along y
  double thickness = .022; ///< of the plate, along z
  Boss hub{.060, .096, .062}, lift_eye{.030, .056, .054}, rod_eye{.026, .050, .050};
  double lift_position = .46; ///< of the lift eye along the centreline, 0 to 1
  double shoulder = .016;     ///< of the plate around the hub's and the rod eye's bosses
  double fillet = .008;       ///< radius where bosses meet the plate
  double slot_width = .028;   ///< of the two lightening holes along the centreline; 0: none
  double web = .014;          ///< between a boss and a lightening hole
  double edge_radius = 0;     ///< rounds the plate's outline
};

/// A hole for a pin through the whole boss, along z and about its centre.
struct Pin {
  const char* name; ///< hub, lift_eye, rod_eye
  Vec3 centre;
  double radius = 0, width = 0;
};
[[nodiscard]] std::array<Pin, 3> pins(const LiftArm&);

/// Refuses dimensions with which bosses, fillets, holes or outline would meet, naming the
/// dimension.
void check(const LiftArm&);

/// m^3, in closed form: areas within circular arcs (Green), fillets and rounded edges by Pappus and
/// Guldin.
[[nodiscard]] double volume(const LiftArm&);

/// The solid as a STEP file in mm, by Open CASCADE. Refuses as check() does.
void write_step(const std::string& path, const LiftArm&);

/// The solid in curved tet10. Node sets hub, lift_eye and rod_eye hold the nodes on the walls of
/// the holes. `part` and `unit` of the choice do not apply.
[[nodiscard]] Mesh mesh_lift_arm(const LiftArm&, const LoadChoice&);

} // namespace tactus::fem
