#pragma once

#include "core/haptic/servo.hpp"
#include "core/haptic/simulated_device.hpp"
#include "core/object.hpp"
#include "devices/servo_thread.hpp"
#include "externals/phantom/declaration.hpp"
#include "externals/phantom/trace.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace tactus {

/// [phantom]: a haptic device in a patch. Forces in, normalised positions out; between them the
/// servo of core/haptic, stepped by the host's logical time or by a thread of its own.
class Phantom {
public:
  static constexpr Declaration declaration{
      "phantom",
      "haptic device: force in, position out",
      "Reads a haptic device, or a simulated one, a thousand times a second, sends the position of "
      "its handle and applies the forces that the patch sends, through a chain that keeps the hand "
      "safe: interpolation, limit, watchdog, slew and passivity control.",
      "haptic force feedback device simulation",
      phantom::kInlets,
      phantom::kOutlets,
      phantom::kParameters,
      phantom::kMessages,
      phantom::kArguments};
  static constexpr std::size_t timers = 2;

  Phantom();
  ~Phantom();
  Phantom(const Phantom&) = delete;
  Phantom& operator=(const Phantom&) = delete;

  void set(std::size_t parameter, double value) noexcept;
  [[nodiscard]] double get(std::size_t parameter) const noexcept { return values_[parameter]; }
  void message(std::size_t index, std::span<const Atom> arguments, Host& host);
  void scalar(std::size_t inlet, double value, Host& host);
  void tick(std::size_t timer, Host& host);
  void created(Host& host);
  void dump(Host& host);

private:
  enum Timer : std::size_t { kSchedule, kForces };
  using Words = std::span<const Atom>;

  // phantom.cpp: time and exchange
  [[nodiscard]] bool on(phantom::ParameterIndex p) const noexcept { return values_[p] >= 0.5; }
  [[nodiscard]] double period_s() const noexcept { return 1.0 / values_[phantom::kRate]; }
  void begin(Host& host);
  void schedule(Host& host);
  void step(Host& host);
  void publish(double now_s) noexcept;
  void settle() noexcept;
  void settle_device() noexcept;
  void open(Host& host);
  void close(Host& host);
  void restart(Host& host);
  void fade_out() noexcept;
  /// Changes the device between two ticks, whoever steps it.
  template <class Change> void with_device(Change&& change) {
    const bool was_running = runner_.running();
    runner_.stop();
    change();
    if (was_running)
      runner_.start(servo_, period_s());
  }
  void collect(Host& host);
  void send_position(Host& host, bool always);
  void send_values(Host& host, bool all);
  void send_event(const haptic::Event& event, Host& host);
  void send_timing(Host& host);
  void drain_trace();
  [[nodiscard]] haptic::ServoStatistics statistics() noexcept;

  // messages.cpp
  void on_list(Words, Host&);
  void on_backend(Words, Host&);
  void on_clock(Words, Host&);
  void on_workspace(Words, Host&);
  void on_map(Words, Host&);
  void on_interp(Words, Host&);
  void on_watchdog(Words, Host&);
  void on_report(Words, Host&);
  void on_stats(Words, Host&);
  void on_trace(Words, Host&);
  void on_hand(Words, Host&);
  void on_path(Words, Host&);
  void on_target(Words, Host&);
  void on_seek(Words, Host&);
  void on_button(Words, Host&);
  void send_workspace(Host& host) const;

  std::array<double, phantom::kParameterCount> values_{};
  haptic::Servo servo_{};
  haptic::SimulatedDevice simulated_{};
  devices::ServoThread runner_{};
  phantom::Trace trace_{};

  haptic::ServoSettings settings_{};
  haptic::SimulatedDevice::Settings simulation_{};
  haptic::Command command_{};
  haptic::Vec3 asked_{}; // inlets, in the chosen units
  bool refused_now_ = false, changed_now_ = false;

  std::string path_name_ = "still";
  std::string name_ = "-";
  bool wall_ = false; // stepped by a thread instead of the host's logical time
  bool created_ = false, open_ = false, learning_ = false, new_grids_ = false;
  double origin_ms_ = 0, output_origin_ms_ = 0; // of the two grids
  std::uint64_t steps_ = 0, outputs_ = 0;       // grid points since their origins
  std::uint64_t index_ = 0;                     // servo ticks in logical time

  std::optional<haptic::Vec3> sent_{};
  bool has_report_ = false;
  std::array<bool, 7> reported_{false, false, false, true, true, false, true};
  double last_error_ms_ = -1e9, last_timing_ms_ = 0;
  bool scheduling_told_ = false;
};

} // namespace tactus
