#include "pd/host_features.hpp"

#include <cstdio>
#include <string>
#include <string_view>

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif
#ifdef __APPLE__
#include <crt_externs.h>
#endif

namespace tactus::pd {
namespace {

template <class Function> void look_up(Function& function, const char* name) noexcept {
#ifdef _WIN32
  HMODULE host = nullptr;
  GetModuleHandleExA(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS |
                         GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                     reinterpret_cast<LPCSTR>(&pd_typedmess), &host);
  function = reinterpret_cast<Function>(GetProcAddress(host, name));
#else
  function = reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, name));
#endif
}

/// The process's arguments, each with a zero in front and behind.
std::string command_line() {
  std::string all(1, '\0');
#if defined(_WIN32)
  for (const char* c = GetCommandLineA(); *c; ++c)
    all += *c == ' ' ? '\0' : *c;
#elif defined(__APPLE__)
  for (int i = 0; i < *_NSGetArgc(); ++i)
    all.append((*_NSGetArgv())[i]).push_back('\0');
#else
  if (std::FILE* file = std::fopen("/proc/self/cmdline", "r")) {
    char part[4096];
    for (std::size_t n; (n = std::fread(part, 1, sizeof part, file)) > 0;)
      all.append(part, n);
    std::fclose(file);
  }
#endif
  all.push_back('\0');
  return all;
}

/// Layout published with Pd 0.54.
struct MultichannelSignal {
  int length;
  t_sample* samples;
  t_float sample_rate;
  int channels;
};

} // namespace

const HostFeatures& host_features() noexcept {
  static const HostFeatures features = [] {
    HostFeatures found{};
    look_up(found.audio_guard, "rtguard_set");
    look_up(found.signal_setmultiout, "signal_setmultiout");
    look_up(found.queue_message, "pd_queue_mess");
    look_up(found.queue_cancel, "pd_queue_cancel");
    if (!found.queue_cancel)
      found.queue_message = nullptr;
    return found;
  }();
  return features;
}

bool runs_in_batch() noexcept {
  static const bool batch = [] {
    constexpr std::string_view kFlag("\0-batch\0", 8);
    return command_line().find(kFlag) != std::string::npos;
  }();
  return batch;
}

int channel_count(const t_signal* signal) noexcept {
  if (!host_features().signal_setmultiout)
    return 1;
  return reinterpret_cast<const MultichannelSignal*>(signal)->channels;
}

} // namespace tactus::pd
