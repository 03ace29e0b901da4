#include "core/module_object.hpp"

#if defined(_WIN32)
#define TACTUS_TEST_EXPORT __declspec(dllexport)
#else
#define TACTUS_TEST_EXPORT __attribute__((visibility("default")))
#endif

// Gives render_object the object of a module that has no host.
extern "C" TACTUS_TEST_EXPORT const tactus::ModuleObject<double>* tactus_test_object();
const tactus::ModuleObject<double>* tactus_test_object() {
  return &tactus::module_object<double>();
}
