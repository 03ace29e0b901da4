#pragma once
#include <string>
#include <vector>

namespace tactus::fem {

/// `modal_fem serve FILE.modal.npz`: finds the modes of a table's body at other shapes. It reads
/// requests on stdin and answers on stdout until stdin ends. Externals, which link no finite
/// elements, start it as a child process; core/serve/modal_fem.hpp defines the messages. The table
/// must contain its mesh, as modal_fem writes it with --lattice. Returns the process's exit status:
/// 0 at the end of stdin or after `quit`, 1 if the stream is broken.
[[nodiscard]] int serve(const std::vector<std::string>& words);

} // namespace tactus::fem
