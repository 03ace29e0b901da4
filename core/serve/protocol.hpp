#pragma once

#include <cstdint>

/// The common part of the messages of `part_stress serve` and `modal_fem serve`. The program loads
/// the part of a table and solves it at other shapes. It reads requests from stdin and writes
/// answers to stdout. Numbers are little-endian. A message is a header, then `size` bytes.
namespace tactus::serve {

struct ServeHeader {
  static constexpr std::uint32_t kMagic = 0x31525354; ///< "TSR1"
  std::uint32_t magic = kMagic, kind = 0;
  std::uint64_t size = 0;
};

enum class ServeKind : std::uint32_t {
  solve = 1,    ///< core/serve/part_stress.hpp, core/serve/modal_fem.hpp
  quit = 2,     ///< without data
  ready = 16,   ///< the part is loaded: ServeReady, ModesReady
  stress = 17,  ///< see StressAnswer
  refused = 18, ///< one sentence
  modes = 19    ///< see ModesAnswer
};

} // namespace tactus::serve
