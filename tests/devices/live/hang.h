/* For doubles of vendors' libraries: a call hangs while the file that HANG names has its name. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static void may_hang(const char* call) {
  const char* path = getenv("HANG");
  for (;;) {
    const struct timespec pause = {0, 2000000};
    char names[256] = "";
    FILE* file = path ? fopen(path, "r") : NULL;
    if (!file)
      return;
    names[fread(names, 1, sizeof names - 1, file)] = 0;
    fclose(file);
    if (!strstr(names, call))
      return;
    nanosleep(&pause, NULL);
  }
}
