#pragma once
#include "fem/mesh/mesh.hpp"

#include <functional>

namespace tactus::fem {

/// Reads a volume mesh file: MSH 2.2 or 4.1, text or binary. `unit`: metres per unit of the file.
/// Physical volumes become regions; physical surfaces, curves and points become node sets. A volume
/// in no group is named "body" if it is the only one, else "volume" and its tag. A group without a
/// name is named "region" or "set" and its tag. In MSH 2 elements contain their group: an element
/// that is written once for each of its groups counts once and belongs to the region of the highest
/// tag. No content of the file is executed: this reader parses it instead of gmsh, whose reader
/// accepts a script under any ending. Refuses damaged files, see read_msh_sections(). `notify`
/// reports skipped sections.
[[nodiscard]] Mesh read_msh(const std::string& path, double unit,
                            const std::function<void(const std::string&)>& notify = {});

} // namespace tactus::fem
