// A host as old as Pd 0.53: no multichannel signals, no posting from threads.
#include "tests/pd/host/internal.hpp"

bool tactus::test::is_newer() { return false; }
void tactus::test::deliver_queue() {}
