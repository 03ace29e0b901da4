#pragma once
#include <string>
#include <vector>

namespace tactus::fem {

/// `part_stress serve FILE.stress.npz [--tolerance T]`: solves the part of a table at other shapes.
/// It reads requests on stdin and answers on stdout until stdin ends. Externals, which link no
/// finite elements, start it as a child process; core/serve/part_stress.hpp defines the messages. T
/// is the residual of PCG, ||f - K u|| / ||f||, 1e-6 unless given. Returns the process's exit
/// status: 0 at the end of stdin or after `quit`, 1 if the stream is broken.
[[nodiscard]] int serve(const std::vector<std::string>& words);

} // namespace tactus::fem
