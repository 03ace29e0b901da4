#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace tactus::fem {

/// `part_stress serve FILE.stress.npz`: solves the part of a table at other shapes, asked on stdin,
/// answered on stdout, until stdin ends. Externals, which link no finite elements, start it as a
/// child process. Numbers are little-endian; docs/part_stress.md lists the messages. A message is a
/// header, then `size` bytes.
struct ServeHeader {
  static constexpr std::uint32_t kMagic = 0x31525354; ///< "TSR1"
  std::uint32_t magic = kMagic, kind = 0;
  std::uint64_t size = 0;
};
enum class ServeKind : std::uint32_t {
  solve = 1,   ///< u32 method, u32 with sensitivities (0, 1), f64 parameters [P], m
  quit = 2,    ///< nothing
  ready = 16,  ///< u64 N, u64 P, f64 seconds of a product, a solution, a factorisation
  stress = 17, ///< see StressAnswer
  refused = 18 ///< one sentence
};
enum class ServeMethod : std::uint32_t { chosen = 0, pcg = 1, refactor = 2 };

/// The fixed part of an answer; f64 parameters [P] that were reached, f32 von Mises [N], f32 max
/// shear [N] and, if asked for, f32 S [P,N], f32 S_shear [P,N] follow.
struct StressAnswer {
  std::uint32_t method = 0, iterations = 0;
  double seconds = 0;
  double fraction = 1; ///< of the move that keeps the mesh valid
  double residual = 0;
};

/// Returns the process's exit status: 0 at the end of stdin or `quit`, 1 where the stream is
/// broken.
[[nodiscard]] int serve(const std::vector<std::string>& words);

} // namespace tactus::fem
