/* Loads modules by Windows' loader, as Pd does. */
#include "host.h"

#include <stdio.h>
#include <windows.h>

static const char* failed(const char* what) {
  static char text[128];
  snprintf(text, sizeof text, "%s: error %lu", what, GetLastError());
  return text;
}

const char* host_load(const char* file, const char* setup) {
  HMODULE module = LoadLibraryA(file);
  if (!module)
    return failed("LoadLibrary");
  void (*function)(void) = (void (*)(void))GetProcAddress(module, setup);
  if (!function)
    return failed("GetProcAddress");
  function();
  return 0;
}
