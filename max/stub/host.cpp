#include "max/stub/host.hpp"

#include "max/stub/guarded.hpp"
#include "max/stub/realtime_watch.hpp"
#include "max/stub/script.hpp"

#include <cstdio>
#include <fstream>
#include <iostream>

using namespace tactus::stub;

int run_host(int count, char** arguments) {
  const std::string file = count > 1 ? arguments[1] : "-";
  if (file == "--help") {
    std::puts("usage: max_host [SCRIPT]   (standard input without)");
    for (const Script::Command& command : Script::commands())
      std::printf("  %s %s\n", std::string(command.name).c_str(),
                  std::string(command.usage).c_str());
    std::puts("  repeat COUNT ... end\n  threads VECTORS ... end");
    return 0;
  }
  install_fault_handler();
  install_realtime_watch();
  set_role(Role::kMain);
  Script script;
  int status = 0;
  try {
    std::ifstream stream;
    if (file != "-") {
      stream.open(file);
      if (!stream)
        throw ScriptError("cannot read " + file);
    }
    script.run(file == "-" ? std::cin : stream);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "script: %s\n", error.what());
    status = 2;
  }
  set_role(Role::kMain);
  try {
    script.finish();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "script: %s\n", error.what());
    status = 2;
  }
  if (const std::size_t violations = violation_count()) {
    print_line("violations: " + std::to_string(violations));
    status = 3;
  }
  return status;
}
