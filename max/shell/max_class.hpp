#pragma once

#include "core/module_object.hpp"

/// Makes a Max class out of an object's declaration: its methods, an attribute for each parameter,
/// and Max's callbacks. See max/README.md.
namespace tactus::max {

/// Registers the class of this module; what is passed lives as long as the module.
void register_class(const ModuleObject<double>& module);

} // namespace tactus::max
