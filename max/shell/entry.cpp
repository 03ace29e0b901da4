#include "core/guarded.hpp"
#include "core/module_object.hpp"
#include "max/shell/max_object.hpp"

// The function that Max calls after loading a module; the only one that a module exports.
extern "C" MAX_EXPORT void ext_main(void*);
extern "C" MAX_EXPORT void ext_main(void*) {
  tactus::guarded([] { tactus::max::register_class(tactus::module_object<double>()); },
                  [](const char* why) { object_error(nullptr, "%s", why); });
}
