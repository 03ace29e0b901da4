#pragma once

#include <functional>
#include <string>

#include <umockdev.h>

namespace tactus::mock {

/// A test bed whose threads run, where the system allows it, above the real-time threads of the
/// program under test: hardware does not wait for a processor that the program uses. Called before
/// any other thread is started.
[[nodiscard]] UMockdevTestbed* new_test_bed();

/// Runs a program and serves its commands: lines that it writes to the descriptor named in its
/// environment variable TACTUS_DOUBLE ("READ WRITE") are answered with one line each (see
/// tests/devices/mock/control.hpp). idle is called every few milliseconds.
/// With from_stdin, lines of the standard input are commands too, answered on standard output.
/// The program's exit status; 128 + signal when it was killed.
int run_child(char** arguments, const std::function<std::string(const std::string&)>& answer,
              const std::function<void()>& idle, bool from_stdin = false);

} // namespace tactus::mock
