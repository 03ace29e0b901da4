#pragma once

#include <cstddef>

#include <m_pd.h>

/// Functions of the running Pd that the 0.53 header lacks. They are looked up by name, so that one
/// binary serves old and new hosts.
namespace tactus::pd {

struct HostFeatures {
  /// Brackets every process() in tests that forbid allocation and locks; null in normal use.
  void (*audio_guard)(int);
  /// Sets an outlet's channel count (Pd 0.54).
  void (*signal_setmultiout)(t_signal**, int);
  /// Runs a function on Pd's thread; any other thread may call it (Pd 0.56).
  void (*queue_message)(struct _pdinstance*, t_pd*, void*, void (*)(t_pd*, void*));
  void (*queue_cancel)(t_pd*);
};
[[nodiscard]] const HostFeatures& host_features() noexcept;

/// Whether Pd was started to render as fast as it can (-batch). Pd exports no variable for it; the
/// command line shows it.
[[nodiscard]] bool runs_in_batch() noexcept;

/// The instance of Pd that this thread works for. A libpd that is built for several instances
/// (MULTI, as in plugdata) has one for each thread, and no symbols like s_list.
[[nodiscard]] t_pdinstance* current_instance() noexcept;

/// The class flag of multichannel objects (CLASS_MULTICHANNEL since 0.54).
inline constexpr int kMultichannelFlag = 0x10;

/// Channels of a signal; the field exists since 0.54, after the three fields of the 0.53 header.
[[nodiscard]] int channel_count(const t_signal* signal) noexcept;

} // namespace tactus::pd
