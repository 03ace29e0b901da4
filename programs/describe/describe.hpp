#pragma once

#include "core/object.hpp"

#include <vector>

namespace tactus {

/// An object's declaration, and the host features that it uses.
struct ObjectDescription {
  const Declaration* declaration;
  Traits traits;
};

/// Every object that pd_external() registered, in the order of the folders.
[[nodiscard]] std::vector<ObjectDescription> described_objects();

} // namespace tactus
