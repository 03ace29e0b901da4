#pragma once

#include "core/declaration.hpp"
#include "max/abi/max_abi.h"

namespace tactus::max {

/// Adds an attribute for each parameter: @name in the box, the inspector, `name value`, `getname`,
/// presets and pattr. Its value lives in the object, which setters and getters ask. The value of
/// the box itself is the list of all of them.
void add_attributes(t_class* handle, const Declaration& declaration);

} // namespace tactus::max
