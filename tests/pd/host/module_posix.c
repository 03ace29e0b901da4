/* Loads modules by the system's loader. */
#include "host.h"

#include <dlfcn.h>
#include <string.h>

const char* host_load(const char* file, const char* setup) {
  void* module = dlopen(file, RTLD_NOW | RTLD_LOCAL);
  if (!module)
    return dlerror();
  void* symbol = dlsym(module, setup);
  if (!symbol)
    return dlerror();
  void (*function)(void);
  memcpy(&function, &symbol, sizeof function);
  function();
  return 0;
}
