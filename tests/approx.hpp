#pragma once

#include <doctest/doctest.h>

/// doctest::Approx adds 1 to the value before it takes the share that may be wrong, which lets any
/// small value pass; this one is relative to the value alone.
namespace tactus::test {

inline doctest::Approx approx(double value) { return doctest::Approx(value).scale(1e-300); }

} // namespace tactus::test
