#pragma once
#include "fem/mesh/mesh.hpp"

#include <functional>

namespace tactus::fem {

/// A volume mesh file: MSH 2.2 or 4.1, text or binary. `unit` is metres a unit of the file.
/// Physical volumes are regions; physical surfaces, curves and points are node sets. Volumes in no
/// group are called "body" when there is one, else "volume" and their tag; groups without a name
/// "region" or "set" and their tag. In MSH 2 an element carries its group itself: one that is
/// written once for each of its groups counts once, and belongs to the region of the highest tag.
/// Never executes anything: the format is parsed here, not by gmsh, whose own reader takes a script
/// under any ending. Refuses damaged files, see read_msh_sections().
/// `notify` is told of sections that are passed over.
[[nodiscard]] Mesh read_msh(const std::string& path, double unit,
                            const std::function<void(const std::string&)>& notify = {});

} // namespace tactus::fem
