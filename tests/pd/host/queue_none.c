/* A host as old as Pd 0.53: no multichannel signals, no posting from threads. */
#include "internal.h"

void host_deliver_queue(void) {}
