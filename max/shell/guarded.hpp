#pragma once

#include "core/guarded.hpp"
#include "max/abi/max_abi.h"
#include "max/shell/max_object.hpp"

namespace tactus::max {

/// Calls function(object) for an instance; no exception goes on into Max.
template <class Function> void guarded(Instance* instance, Function&& function) noexcept {
  if (instance->self)
    tactus::guarded([&] { function(*instance->self); },
                    [&](const char* why) { object_error(&instance->object.z_ob, "%s", why); });
}

} // namespace tactus::max
