/* Included before every source of these tests on Windows, whose C library has other names. */
#ifndef TACTUS_TESTS_DEVICES_ENVIRONMENT_WINDOWS_H
#define TACTUS_TESTS_DEVICES_ENVIRONMENT_WINDOWS_H
#include <stdlib.h>

static inline int setenv(const char* name, const char* value, int overwrite) {
  return !overwrite && getenv(name) ? 0 : _putenv_s(name, value);
}
static inline int unsetenv(const char* name) { return _putenv_s(name, ""); }

#endif
