#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// Finds the connected pieces of a surface whose edges have one or two triangles. Orients the
/// triangles of each piece consistently, outward by the sign of the piece's volume. Refuses a
/// non-orientable piece (a Moebius strip), with its position.
void find_shells(Triangles&);

/// Volume enclosed by each shell, m^3, positive if its triangles look outward. For open shells it
/// depends on the origin.
[[nodiscard]] std::vector<double> shell_volumes(const Triangles&);

/// Describes an edge with a triangle on one side only, with the number of such edges. Empty for a
/// closed surface.
[[nodiscard]] std::string open_edge_sentence(const Triangles&);

/// Calls find_shells() for a closed surface; refuses an open surface and names a triangle and its
/// position.
void close(Triangles&);

/// Leaves out closed shells whose volume is below `thickness` (m) times their area: flat sheets
/// whose triangles are written for both sides. Returns their number.
std::size_t drop_flat_shells(Triangles&, double thickness);

/// The bodies of closed shells that neither cross nor touch. A shell inside an even number of
/// others bounds a body from outside. A shell inside an odd number of others bounds a cavity of the
/// body around it, whatever its orientation was, unless it touches the shell around it. Each body
/// is a separate surface: shell 0 outward, then its cavities, inward.
[[nodiscard]] std::vector<Triangles> separate_bodies(const Triangles&);

/// Two triangles of different shells closer than `distance` (m), or none.
[[nodiscard]] bool shells_touch(const Triangles&, double distance);

} // namespace tactus::fem
