#pragma once
#include <string>
#include <vector>

namespace tactus::fem {

/// `modal_fem serve FILE.modal.npz`: finds the modes of a table's body at other shapes, asked on
/// stdin, answered on stdout, until stdin ends. Externals, which link no finite elements, start it
/// as a child process; core/serve/modal_fem.hpp states the messages. The table must hold
/// its mesh, as modal_fem writes it with --lattice. Returns the process's exit status: 0 at the end
/// of stdin or `quit`, 1 where the stream is broken.
[[nodiscard]] int serve(const std::vector<std::string>& words);

} // namespace tactus::fem
