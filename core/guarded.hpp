#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <utility>

namespace tactus {

/// Calls work() for a host written in C, through which no exception may pass: each call of a host
/// into an object goes through here. A failure becomes say(why), a text that needs no memory; what
/// say() itself throws is dropped. True if work() came to its end.
template <class Work, class Say> bool guarded(Work&& work, Say&& say) noexcept {
  const auto tell = [&say](const char* why) {
    try {
      say(why);
    } catch (...) { // no memory for the sentence either
    }
    return false;
  };
  constexpr const char* kNoMemory = "not enough memory";
  try {
    std::forward<Work>(work)();
    return true;
  } catch (const std::bad_alloc&) {
    return tell(kNoMemory);
  } catch (const std::length_error&) { // a container of more than all memory
    return tell(kNoMemory);
  } catch (const std::exception& failure) {
    return tell(failure.what());
  } catch (...) {
    return tell("failed without a reason");
  }
}

} // namespace tactus
