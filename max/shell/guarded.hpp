#pragma once

#include "max/abi/max_abi.h"
#include "max/shell/max_object.hpp"

#include <exception>
#include <new>

namespace tactus::max {

/// Calls function(object) for an instance; no exception goes on into Max.
template <class Function> void guarded(Instance* instance, Function&& function) noexcept {
  if (!instance->self)
    return;
  try {
    function(*instance->self);
  } catch (const std::bad_alloc&) {
    object_error(&instance->object.z_ob, "%s", "not enough memory");
  } catch (const std::exception& failure) {
    object_error(&instance->object.z_ob, "%s", failure.what());
  }
}

} // namespace tactus::max
