#pragma once
#include <string>
#include <vector>

namespace tactus::fem {

/// `part_stress serve FILE.stress.npz [--tolerance T]`: solves the part of a table at other shapes,
/// asked on stdin, answered on stdout, until stdin ends. Externals, which link no finite elements,
/// start it as a child process; core/serve/part_stress.hpp states the messages. T: residual of
/// PCG, ||f - K u|| / ||f||, 1e-6 unless given.
/// Returns the process's exit status: 0 at the end of stdin or `quit`, 1 where the stream is
/// broken.
[[nodiscard]] int serve(const std::vector<std::string>& words);

} // namespace tactus::fem
