#include "pd/host_features.hpp"

#include "pd/host_process.hpp"

#include <string>
#include <string_view>

namespace tactus::pd {
namespace {

template <class Function> void look_up(Function& function, const char* name) noexcept {
  function = reinterpret_cast<Function>(host_symbol(name));
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

t_pdinstance* current_instance() noexcept {
  auto* const of_thread = reinterpret_cast<t_pdinstance**>(host_symbol("pd_this"));
  return of_thread ? *of_thread : &pd_maininstance;
}

int channel_count(const t_signal* signal) noexcept {
  if (!host_features().signal_setmultiout)
    return 1;
  return reinterpret_cast<const MultichannelSignal*>(signal)->channels;
}

} // namespace tactus::pd
