#include "core/guarded.hpp"
#include "core/module_object.hpp"
#include "pd/shell.hpp"

// The setup of every module when Pd loads it; the function in cmake/pd_setup.c.in with the module's
// name calls it.
namespace tactus::pd {
namespace {

PdClass the_class{};

void* create(t_symbol*, int count, t_atom* atoms) {
  return create_instance(the_class, count, atoms);
}

} // namespace
} // namespace tactus::pd

extern "C" void tactus_pd_setup();
extern "C" void tactus_pd_setup() {
  tactus::pd::the_class.module = &tactus::module_object<t_sample>();
  tactus::guarded([] { tactus::pd::register_class(tactus::pd::the_class, &tactus::pd::create); },
                  [](const char* why) { pd_error(nullptr, "%s", why); });
}
