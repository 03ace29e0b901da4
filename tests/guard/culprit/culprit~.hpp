#pragma once

#include "core/rows.hpp"

#include <array>
#include <chrono>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <sys/syscall.h>
#include <unistd.h>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace tactus::test {

/// Breaks one rule on demand, to prove that the guard or the sanitizers see it.
struct Culprit {
  static const Declaration declaration;
  struct Rows;

  template <class S> void process(const Block<S>& block) noexcept {
    for (std::size_t n = 0; n < block.frames; ++n)
      block.outputs[0][n] = block.inputs[0][n];
    switch (violation) {
    case 1:
      text = std::string(1000 + block.frames, 'x');
      break;
    case 2:
      mutex.lock(), mutex.unlock();
      break;
    case 3:
      static_cast<void>(!::write(2, "", 0));
      break;
    case 4:
      std::this_thread::sleep_for(std::chrono::microseconds(1));
      break;
    case 5:
      static_cast<void>(::syscall(SYS_gettid));
      break;
#if defined(__x86_64__)
    case 6:
      _mm_setcsr(_mm_getcsr() ^ 0x8000);
      break;
#endif
    case 7: {
      const std::vector<char> heap(8);
      const volatile std::size_t beyond = heap.size();
      const volatile char seen = heap.data()[beyond];
      static_cast<void>(seen);
      break;
    }
    default:
      break;
    }
  }

  int violation = 0;
  std::string text;
  std::mutex mutex;
};

struct Culprit::Rows {
  static constexpr std::array<std::string_view, 8> violations{
      "none", "allocate", "lock", "write", "sleep", "syscall", "float-mode", "overflow"};
  static constexpr std::array parameters{
      member<&Culprit::violation>.row("crime", violations, "to commit", 0)};
  static constexpr std::array ports{Port{Port::Kind::kSignal, "signal", "", "passed through"}};
  static constexpr std::array arguments{CreationArgument{"crime"}};
};

inline constexpr Declaration Culprit::declaration{"culprit~",
                                                  "breaks a rule",
                                                  "For the guard's own test.",
                                                  "test",
                                                  Rows::ports,
                                                  Rows::ports,
                                                  Rows::parameters,
                                                  {},
                                                  Rows::arguments};

} // namespace tactus::test
