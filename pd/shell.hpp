#pragma once

#include "core/instance_numbers.hpp"
#include "core/module_object.hpp"

#include <m_pd.h>

/// The typed shell over Pd. It makes a Pd class from an object's declaration. See pd/README.md.
namespace tactus::pd {

/// One Pd class; lives as long as the module.
struct PdClass {
  t_class* handle;
  const ModuleObject<t_sample>* module;
  InstanceNumbers numbers;
  [[nodiscard]] const Traits& traits() const { return module->traits; }
};

/// Registers the class under its declared name; create is Pd's new-method for it.
using Create = void* (*)(t_symbol*, int, t_atom*);
void register_class(PdClass& record, Create create);
/// Makes an instance; null, after one error sentence, when the creation arguments are malformed.
[[nodiscard]] void* create_instance(PdClass& record, int count, t_atom* atoms);

} // namespace tactus::pd
