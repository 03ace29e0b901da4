#pragma once

#include "core/object.hpp"

#include <vector>

namespace tactus {

/// What an object declares, and which host features it uses.
struct ObjectDescription {
  const Declaration* declaration;
  Traits traits;
};

/// Every object that pd_external() registered, in the order of the folders.
[[nodiscard]] std::vector<ObjectDescription> described_objects();

} // namespace tactus
