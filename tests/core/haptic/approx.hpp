#pragma once

#include "tests/approx.hpp"

namespace tactus::haptic::test {

using tactus::test::approx;

} // namespace tactus::haptic::test
