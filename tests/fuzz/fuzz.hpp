#pragma once

#include <cstdint>
#include <span>

namespace tactus::fuzz {

/// The decoder under test; defined by each fuzz program.
void decode(std::span<const std::uint8_t> input);

/// Ends the run when a property does not hold.
void check(bool holds, const char* what);

} // namespace tactus::fuzz
