#pragma once

#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/effects/effect_model.hpp"
#include "core/haptic/servo/clock_map.hpp"
#include "core/object.hpp"
#include "devices/servo_thread.hpp"
#include "externals/phantom/declaration.hpp"
#include "externals/phantom/device_worker.hpp"
#include "externals/phantom/live_connections.hpp"
#include "externals/phantom/named_network.hpp"
#include "externals/phantom/named_scene.hpp"
#include "externals/phantom/servo_rig.hpp"
#include "externals/phantom/trace.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactus {

/// [phantom], the object for a haptic device: forces in, normalised positions out. The servo of
/// core/haptic runs between them; it is stepped by the host's logical time, by a thread or by the
/// device's driver.
class Phantom final : private phantom::LiveConnection {
public:
  static constexpr Declaration declaration{
      "phantom",
      "haptic device: force in, position out",
      "Reads a haptic device, or a simulated one, a thousand times a second, sends the position of "
      "its handle and applies the forces that the patch sends and those of the scene that the "
      "handle touches, through a chain that keeps the hand safe: interpolation, limit, watchdog, "
      "slew and passivity control.",
      "haptic force feedback device simulation",
      phantom::kInlets,
      phantom::kOutlets,
      phantom::kParameters,
      phantom::kMessages,
      phantom::kArguments,
      "phantom~, haptic_server, struck_disk.pd",
      "in a patch: phantom.md, safety of the hand: phantom_safety.md, bodies to touch: scene.md, "
      "force effects: effects.md, masses and springs: network.md, the simulated hand: "
      "phantom_simulation.md, clock and trace: phantom_time.md, real devices: devices/README.md, "
      "theory: theory/phantom.md",
      "strike/struck_disk.wav: a hand strikes a disk"};
  static constexpr std::size_t timers = 3;

  Phantom();
  ~Phantom();
  Phantom(const Phantom&) = delete;
  Phantom& operator=(const Phantom&) = delete;

  void set(std::size_t parameter, double value) noexcept;
  [[nodiscard]] double get(std::size_t parameter) const noexcept { return values_[parameter]; }
  void message(std::size_t index, std::span<const Atom> arguments, Host& host);
  void scalar(std::size_t inlet, double value, Host& host);
  void tick(std::size_t timer, Host& host);
  void posted(Host& host);
  void created(Host& host);
  void dump(Host& host);

private:
  enum Timer : std::size_t { kSchedule, kForces, kWatchWorker };
  enum class Clock { kAuto, kLogical, kWall };
  enum class Link { kClosed, kOpening, kOpen, kLost };
  using Words = std::span<const Atom>;
  using Device = phantom::DeviceWorker::Device;

  // phantom.cpp: time and exchange
  [[nodiscard]] bool on(phantom::ParameterIndex p) const noexcept { return values_[p] >= 0.5; }
  [[nodiscard]] bool open() const noexcept { return link_ == Link::kOpen; }
  [[nodiscard]] double period_s() const noexcept;
  [[nodiscard]] haptic::Exchange& exchange() const noexcept { return rig_->servo.exchange(); }
  void begin(Host& host);
  void schedule(Host& host);
  void force_changed(Host& host);
  void step(double now_s) noexcept;
  void step_with_audio() noexcept;
  void configure_signals() noexcept;
  [[nodiscard]] bool audio_steps(Host& host) noexcept;
  void publish(double now_s) noexcept;
  void apply_settings() noexcept;
  void apply_simulation_settings() noexcept;
  void restart(Host& host);
  void fade_out() noexcept;
  void attach() noexcept;
  /// Changes the simulated device between two ticks, whoever steps it.
  template <class Change> void with_simulation(Change&& change) {
    const bool was_running = !driver_ && runner_->running();
    if (was_running)
      static_cast<void>(runner_->stop()); // waits: a simulated step cannot hang
    change();
    if (was_running)
      thread_refusal_ = runner_->start(rig_->servo, period_s()); // reported at the next tick
  }
  void without_thread(const std::string& refusal, Host& host);

  // connection.cpp: choosing, opening and closing the device
  [[nodiscard]] const haptic::Backend& device() const noexcept;
  [[nodiscard]] std::string_view driver_name() const noexcept;
  [[nodiscard]] phantom::DeviceWorker& worker(Host& host);
  void watch_worker(Host& host);
  void replace_rig(Host& host);
  void store_heat() noexcept;
  void end_session(Host& host);
  [[nodiscard]] static std::string configure(haptic::Backend& device, Words words, bool which);
  [[nodiscard]] static std::string configure_new(haptic::Backend& device, Words words);
  void connect(Words which, Host& host);
  void connect_simulation(Host& host);
  void disconnect(Host& host);
  void opened(const phantom::DeviceWorker::Answer&, Host&);
  void listed(const phantom::DeviceWorker::Answer&, Host&);
  void closed(std::string_view why, Host&);
  void send_identity(Host& host) const;
  void send_status(std::string_view word, Host& host) const;
  [[nodiscard]] bool for_simulation(std::string_view message, Host& host) const;
  void let_go() noexcept override;
  void on_backend(Words, Host&);
  void on_setting(Words, Host&, std::string_view name = {});
  void on_devices(Host&);
  void on_name(Words, Host&);

  // motors.cpp: motors on and off, emergency stop
  void set_motors() noexcept;
  void on_estop(Host& host);
  void latch_stop() noexcept;
  void inherit_stop(const std::string& key, Host& host);
  void send_estop(Host& host);
  void switch_off() noexcept;

  // trouble.cpp: what is wrong with a real device
  void watch_device(Host& host);
  void handle_lost_device(Host& host);
  void handle_device_fault(Host& host);
  void send_trouble(std::string_view sentence, Host& host) const;
  void watch_trouble(Host& host);
  void watch_chain(Host& host);

  // output.cpp: positions, events, statistics, trace
  void collect(Host& host);
  void send_position(Host& host, bool always);
  void send_values(Host& host, bool all);
  void send_event(const haptic::Event& event, Host& host);
  void send_contact(const haptic::ContactEvent& event, Host& host);
  void send_timing(Host& host);
  void send_workspace(Host& host) const;
  void drain_trace();
  [[nodiscard]] double patch_ms(double servo_s) const noexcept;
  void watch_queues(Host& host);
  [[nodiscard]] haptic::ServoStatistics statistics() noexcept;
  void on_stats(Words, Host&);
  void on_trace(Words, Host&);
  void on_report(Words, Host&);

  // messages.cpp: settings
  void on_list(Words, Host&);
  void on_clock(Words, Host&);
  void on_workspace(Words, Host&);
  void on_map(Words, Host&);
  void on_interp(Words, Host&);
  void on_watchdog(Words, Host&);
  void on_scene(Words, Host&);
  [[nodiscard]] bool renders_force() const noexcept;
  void warn_of_scene(Host&);
  void warn_of_stiffness(const std::string& what, double stiffness_n_per_m, Host& host,
                         double share = 1);
  void warn_of_damping(const std::string& what, double damping_n_s_per_m, Host& host);
  void update_limits() noexcept;

  // network.cpp: the mass-spring network
  void on_network(Words, Host&);
  void check_network(Host&);

  // effect_message.cpp: force effects by name
  void on_effect(Words, Host&);
  void warn_of_effect(const std::string& name, Host&);

  // torque.cpp: torque and gripper force
  void on_torques(Words, Host&);
  void on_torque(Words, Host&);
  void on_grip(Words, Host&);
  void set_wrist(const haptic::WristCommand& command, std::string_view message, Host& host);
  void send_wrist(Host& host, bool all);

  // simulation.cpp: messages of the simulated device
  void on_hand(Words, Host&);
  void on_path(Words, Host&);
  void on_target(Words, Host&);
  void on_seek(Words, Host&);
  void on_button(Words, Host&);
  void dump_hand(Host& host) const;

  std::array<double, phantom::kParameterCount> values_{};
  haptic::SimulatedDevice simulated_{};
  std::shared_ptr<phantom::ServoRig> rig_ = std::make_shared<phantom::ServoRig>();
  std::shared_ptr<devices::ServoThread> runner_ = std::make_shared<devices::ServoThread>();
  bool running_ = false;         // a thread steps a real device's servo
  std::string thread_refusal_{}; // why the simulated device's thread did not start again
  phantom::Trace trace_{};
  phantom::NamedScene scene_{};
  phantom::NamedNetwork network_{};
  haptic::EffectSettings effect_settings_{};

  haptic::ServoSettings settings_{};
  haptic::SimulatedDevice::Settings simulation_{};
  haptic::Command command_{};
  haptic::WristRequest wrist_{};
  Vec3 input_force_{}; // inlets, in the chosen units
  bool input_refused_ = false, input_changed_ = false;

  const devices::Driver* driver_ = nullptr; // null: the simulated device
  Device device_{};                         // the driver's
  Link link_ = Link::kClosed;
  std::uint64_t ticket_ = 0;             // of the newest request to open
  std::optional<std::uint32_t> flags_{}; // none: not reported since opening
  std::uint32_t faults_ = 0;
  std::string trouble_{}, driver_trouble_{}; // as sent to the patch; as last read from the driver
  double trouble_ms_ = 0;                    // when driver_trouble_ last changed
  double trouble_polled_ms_ = -1e9;
  std::string device_key_{};              // of the real device that was opened last
  std::vector<std::string> estop_keys_{}; // the latches that motors 1 releases
  bool estop_reported_ = false, warm_reported_ = false, clipping_reported_ = false;
  bool braking_reported_ = false, frozen_reported_ = false, clipping_told_ = false;
  std::unique_ptr<phantom::DeviceWorker> worker_{}, lister_{};

  std::string path_name_ = "still";
  std::string name_ = "-";
  Clock clock_ = Clock::kAuto;
  bool wall_ = false; // stepped by a thread instead of the host's logical time
  bool created_ = false, learning_ = false, restart_grids_ = false, own_workspace_ = false;
  bool signals_offered_ = false;                // the rig's signals are published under name_
  double origin_ms_ = 0, output_origin_ms_ = 0; // of the two grids
  std::uint64_t steps_ = 0, outputs_ = 0;       // grid points since their origins
  std::uint64_t index_ = 0;                     // servo ticks in logical time
  double stepped_s_ = 0;                        // time of the last of them
  std::uint64_t audio_blocks_ = 0, ticks_since_offer_ = 0;
  double audio_ms_ = -1e9; // when audio was last seen to step

  std::optional<Vec3> sent_{};
  bool has_report_ = false;
  haptic::ClockMap clock_map_{};          // of ServoThread's clock
  double report_s_ = 0, collected_s_ = 0; // newest report, last look for one; ServoThread's clock
  std::array<bool, 13> reported_{false, false, false, true,  true,  false, true,
                                 true,  true,  true,  false, false, false};
  double last_error_ms_ = -1e9, last_timing_ms_ = 0;
  double last_loss_ms_ = -1e9;
  std::uint64_t lost_reported_ = 0; // entries dropped by full queues
  double warned_n_per_m_ = 0, warned_n_s_per_m_ = 0;
  bool scheduling_reported_ = false;
};

} // namespace tactus
