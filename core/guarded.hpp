#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <utility>

namespace tactus {

/// Calls work() for a host written in C, whose frames no exception may cross: every call from a
/// host into an object goes through this function. An exception is reported by say(reason), whose
/// text needs no allocation; exceptions of say() are dropped. Returns true if work() returned.
template <class Work, class Say> bool guarded(Work&& work, Say&& say) noexcept {
  const auto tell = [&say](const char* why) {
    try {
      say(why);
    } catch (...) { // not enough memory for the sentence either
    }
    return false;
  };
  constexpr const char* kNoMemory = "not enough memory";
  try {
    std::forward<Work>(work)();
    return true;
  } catch (const std::bad_alloc&) {
    return tell(kNoMemory);
  } catch (const std::length_error&) { // a container beyond max_size()
    return tell(kNoMemory);
  } catch (const std::exception& failure) {
    return tell(failure.what());
  } catch (...) {
    return tell("unknown error");
  }
}

} // namespace tactus
