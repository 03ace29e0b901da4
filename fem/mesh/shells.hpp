#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// Finds the connected pieces of a surface whose edges have one triangle or two, and orients the
/// triangles of each consistently, outward by the sign of its volume. Refuses a non-orientable
/// piece (a Moebius strip), with its position.
void find_shells(Triangles&);

/// Volume enclosed by each shell, m^3, positive if its triangles look outward. For open shells it
/// depends on the origin.
[[nodiscard]] std::vector<double> shell_volumes(const Triangles&);

/// Edge with a triangle on one side only, and how many of them there are. Nothing for a closed
/// surface.
[[nodiscard]] std::string open_edge_sentence(const Triangles&);

/// find_shells() of a closed surface; refuses an open one with a triangle and its position.
void close(Triangles&);

/// Leaves out closed shells whose volume is below `thickness` (m) times their area: flat sheets
/// written from both sides. Returns how many.
std::size_t drop_flat_shells(Triangles&, double thickness);

/// The bodies of closed shells that neither cross nor touch. A shell inside an even number of
/// others bounds a body from outside, inside an odd number a cavity of the body around it, whatever
/// its orientation was; one that touches the shell around it is no cavity. Each body is a surface
/// of its own: shell 0 outward, then its cavities, inward.
[[nodiscard]] std::vector<Triangles> separate_bodies(const Triangles&);

/// Two triangles of different shells closer than `distance` (m), or none.
[[nodiscard]] bool shells_touch(const Triangles&, double distance);

} // namespace tactus::fem
