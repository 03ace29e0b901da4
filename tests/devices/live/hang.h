/* For doubles of vendors' libraries: a call hangs while the file that HANG names has its name. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static int asked_for(const char* word) {
  const char* path = getenv("HANG");
  char words[256] = "";
  FILE* file = path ? fopen(path, "r") : NULL;
  if (!file)
    return 0;
  words[fread(words, 1, sizeof words - 1, file)] = 0;
  fclose(file);
  return strstr(words, word) != NULL;
}

static void may_hang(const char* call) {
  const struct timespec pause = {0, 2000000};
  while (asked_for(call))
    nanosleep(&pause, NULL);
}
