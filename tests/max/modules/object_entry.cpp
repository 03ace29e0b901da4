#include "core/module_object.hpp"

// Gives render_object the object of a module that has no host.
extern "C" __attribute__((visibility("default"))) const tactus::ModuleObject<double>*
tactus_test_object();
const tactus::ModuleObject<double>* tactus_test_object() {
  return &tactus::module_object<double>();
}
