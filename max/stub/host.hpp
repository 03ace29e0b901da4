#pragma once

/// Runs the host: a script from a file or standard input. 0: no violation, 2: the script is wrong,
/// 3: there were violations, 4: an external crashed.
extern "C" int run_host(int count, char** arguments);
