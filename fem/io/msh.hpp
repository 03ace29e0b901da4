#pragma once
#include "fem/mesh/mesh.hpp"

#include <functional>

namespace tactus::fem {

/// Reads a volume mesh file: MSH 2.2 or 4.1, text or binary. `unit`: metres per unit of the file.
/// Physical volumes become regions; physical surfaces, curves and points become node sets. Volumes
/// in no group are named "body" if there is one, else "volume" and their tag; groups without a name
/// "region" or "set" and their tag. In MSH 2 elements contain their group: an element that is
/// written once for each of its groups counts once and belongs to the region of the highest tag. No
/// content of the file is executed: it is parsed here and not by gmsh, whose reader accepts a
/// script under any ending. Refuses damaged files, see read_msh_sections(). `notify` reports
/// skipped sections.
[[nodiscard]] Mesh read_msh(const std::string& path, double unit,
                            const std::function<void(const std::string&)>& notify = {});

} // namespace tactus::fem
