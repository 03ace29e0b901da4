#include "pd/host_features.hpp"

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
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

/// Layout published with Pd 0.54.
struct MultichannelSignal {
  int length;
  t_sample* samples;
  t_float sample_rate;
  int channels;
};

}  // namespace

const HostFeatures& host_features() noexcept {
  static const HostFeatures features = [] {
    HostFeatures found{};
    look_up(found.audio_guard, "rtguard_set");
    look_up(found.signal_setmultiout, "signal_setmultiout");
    look_up(found.queue_message, "pd_queue_mess");
    look_up(found.queue_cancel, "pd_queue_cancel");
    if (!found.queue_cancel) found.queue_message = nullptr;
    return found;
  }();
  return features;
}

int channel_count(const t_signal* signal) noexcept {
  if (!host_features().signal_setmultiout) return 1;
  return reinterpret_cast<const MultichannelSignal*>(signal)->channels;
}

}  // namespace tactus::pd
