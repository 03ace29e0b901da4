#pragma once

#include "core/haptic/chain/chain.hpp"
#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/effects/effect_model.hpp"
#include "core/haptic/servo/clock_map.hpp"
#include "core/rows.hpp"
#include "devices/servo_thread.hpp"
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
  static const Declaration declaration;
  static constexpr std::size_t timers = 3;

  Phantom();
  ~Phantom();
  Phantom(const Phantom&) = delete;
  Phantom& operator=(const Phantom&) = delete;

  void scalar(std::size_t inlet, double value, Host& host);
  void tick(std::size_t timer, Host& host);
  void posted(Host& host);
  void created(Host& host);
  void dump(Host& host);

private:
  struct Rows;
  /// Parameters in the user's units.
  struct Settings {
    double rate_hz = 1000, outrate_hz = 1000;
    bool repeat = false, in_shares_of_limit = false; ///< forces at the inlets: 1 is forcemax
    double forcemax_n = 8, slew_n_per_ms = 2, extrap_ms = 0;
    bool strict = false, resume = false, passivity = true;
    double tank_j = 5e-3, allowance_w = haptic::kAllowance_w, damp_n_s_per_m = 0, walls_n_per_m = 0;
    bool motors = true;
  };
  struct SimulationSettings {
    double mass_kg = 0.1, viscous_n_s_per_m = 0.5;
    bool stops = true;
    double resolution_mm = 0, noise_mm = 0, latency_ticks = 0;
    unsigned seed = 1;
  };
  enum Timer : std::size_t { kSchedule, kForces, kWatchWorker };
  enum class Clock { kAuto, kLogical, kWall };
  enum class Link { kClosed, kOpening, kOpen, kLost };
  using Words = std::span<const Atom>;
  using Device = phantom::DeviceWorker::Device;

  // phantom.cpp: time and exchange
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
  void send_all(Host& host) {
    collect(host);
    send_values(host, true);
    send_position(host, true);
  }
  void rate_changed();
  void outrate_changed() noexcept {
    restart_grids_ = true;
    apply_settings();
  }
  [[nodiscard]] bool motors() const noexcept { return given_.motors; }
  void switch_motors(bool on) noexcept;
  void on_backend(Words, Host&);
  void on_setting(Words, Host&, std::string_view name = {});
  void on_driver(Words words, Host& host) { on_setting(words, host); }
  void on_firmware(Words words, Host& host) { on_setting(words, host, "firmware"); }
  void on_home(Words words, Host& host) { on_setting(words, host, "home"); }
  void on_calibrate(Words words, Host& host) { on_setting(words, host, "calibrate"); }
  void on_devices(Host&);
  void on_name(Words, Host&);

  // motors.cpp: motors on and off, emergency stop
  void set_motors() noexcept;
  void on_estop(Host& host);
  void latch_stop() noexcept;
  void inherit_stop(const std::string& key, Host& host);
  void send_estop(Host& host);
  void switch_off() noexcept;

  // trouble.cpp: faults of a real device
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
  void send(const haptic::ButtonEvent& event, Host& host);
  void send(const haptic::WatchdogEvent& event, Host& host);
  void send(const haptic::HitEvent& event, Host& host);
  void send(const haptic::ContactEvent& event, Host& host);
  void send(const haptic::ReleaseEvent& event, Host& host);
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

  Settings given_;
  SimulationSettings given_simulation_;
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
  bool braking_reported_ = false, frozen_reported_ = false, clipping_logged_ = false;
  std::unique_ptr<phantom::DeviceWorker> worker_{}, lister_{};

  std::string path_name_ = "still";
  std::string name_ = "-";
  Clock clock_ = Clock::kAuto;
  bool wall_ = false; // stepped by a thread instead of the host's logical time
  bool created_ = false, learning_ = false, restart_grids_ = false, own_workspace_ = false;
  bool signals_published_ = false;              // the rig's signals are published under name_
  double origin_ms_ = 0, output_origin_ms_ = 0; // origins of the tick and output grids
  std::uint64_t steps_ = 0, outputs_ = 0;       // grid points since their origins
  std::uint64_t index_ = 0;                     // servo ticks in logical time
  double stepped_s_ = 0;                        // time of the last of them
  std::uint64_t audio_blocks_ = 0, ticks_since_publish_ = 0;
  double audio_ms_ = -1e9; // when audio last stepped the servo

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

struct Phantom::Rows {
  using Self = Phantom;
  using Simulation = SimulationSettings;
  static constexpr std::array<std::string_view, 2> units{"newton", "norm"};
  template <auto setting>
  static constexpr auto
      given = member<&Self::given_, setting>.template then<&Self::apply_settings>();
  template <auto setting>
  static constexpr auto simulated =
      member<&Self::given_simulation_, setting>.template then<&Self::apply_simulation_settings>();
  static constexpr std::array parameters{
      member<&Self::given_, &Settings::rate_hz>.then<&Self::rate_changed>().row(
          "rate", "Hz", 200, 4000, "rate of the servo, ticks a second"),
      member<&Self::given_, &Settings::outrate_hz>.then<&Self::outrate_changed>().row(
          "outrate", "Hz", 0, 4000, "rate of positions at the outlets; 0: only on `bang`"),
      given<&Settings::repeat>.row("repeat",
                                   "switch: 1 also sends positions that have not changed"),
      given<&Settings::in_shares_of_limit>.row("units", units,
                                               "unit of the force inlets; norm: 1 is `forcemax`"),
      given<&Settings::forcemax_n>.row("forcemax", "N", 0, 40,
                                       "largest magnitude of the force sent to the device"),
      given<&Settings::slew_n_per_ms>.row("slew", "N/ms", 1e-3, 1000,
                                          "largest rate of change of the force"),
      given<&Settings::extrap_ms>.row("extrap", "ms", 0, 20,
                                      "time for which the force is extrapolated after a target"),
      given<&Settings::strict>.row("strict",
                                   "switch: 1 lets the force fall when force messages stop"),
      given<&Settings::resume>.row(
          "resume",
          "switch: 1 returns a real device's force after a freeze of the host without `motors 1`"),
      given<&Settings::passivity>.row(
          "passivity",
          "switch of the passivity controller: 1 removes energy that the sampled force creates"),
      given<&Settings::tank_j>.row("tank", "J", 0, 1000,
                                   "largest energy of a contact that a bounce may return"),
      given<&Settings::allowance_w>.row(
          "allowance", "W", 0, 10,
          "power that the delay of the patch's forces may create before it is braked"),
      given<&Settings::damp_n_s_per_m>.row("damp", "N s/m", 0, 100,
                                           "viscosity added to all forces"),
      given<&Settings::walls_n_per_m>.row("walls", "N/m", 0, 5000,
                                          "stiffness of soft walls at the faces of the workspace"),
      not_stored(property<&Self::motors, &Self::switch_motors>.row(
          "motors",
          "switch of the force: 0 off; 1 ramps it up over half a second and ends an emergency stop",
          1)),
      simulated<&Simulation::mass_kg>.row("mass", "kg", 1e-3, 100, "mass of the simulated handle"),
      simulated<&Simulation::viscous_n_s_per_m>.row("viscous", "N s/m", 0, 1000,
                                                    "viscosity of the simulated handle"),
      simulated<&Simulation::stops>.row(
          "stops", "switch: 1 gives the simulated device hard stops 5 mm outside the workspace"),
      simulated<&Simulation::resolution_mm>.row("resolution", "mm", 0, 10,
                                                "encoder step of the simulated device; 0: exact"),
      simulated<&Simulation::noise_mm>.row("noise", "mm", 0, 10,
                                           "amplitude of the simulated device's reading noise"),
      simulated<&Simulation::seed>.seed<"simulated: seed of noise, tremor and wander">(),
      simulated<&Simulation::latency_ticks>.row("latency", "ticks", 0, 8,
                                                "delay of the simulated device's readings"),
  };
  static constexpr std::array messages{
      action<&Self::send_all>("bang", "", 0, 0, "send position and reported values"),
      action<&Self::on_list>("list", "fx fy fz", 3, 3, "force in x, y and z"),
      action<&Self::on_backend>("backend", "name ...", 1, 8,
                                "driver of the device, and its options"),
      action<&Self::connect>("open", "index|serial|path", 0, 1, "connect the device"),
      action<&Self::disconnect>("close", "", 0, 0, "ramp the force down and disconnect"),
      action<&Self::on_name>("name", "word", 1, 1,
                             "name of this device among others, shown by `devices` and `dump`"),
      action<&Self::on_devices>("devices", "", 0, 0,
                                "list the devices of all drivers; those in use are not queried"),
      action<&Self::on_driver>("driver", "word ...", 1, 16, "setting of the device's own driver"),
      action<&Self::on_firmware>("firmware", "file", 1, 1,
                                 "file of firmware that the device needs at power-up"),
      action<&Self::on_home>("home", "", 0, 0, "find the device's zero again"),
      action<&Self::on_calibrate>("calibrate", "", 0, 0, "calibrate the device by its driver"),
      action<&Self::on_clock>("clock", "auto|logical|wall", 1, 1, "clock of the servo"),
      action<&Self::on_workspace>("workspace", "device | learn 0|1 | xmin ymin zmin xmax ymax zmax",
                                  1, 6, "workspace in mm, 0..1 at the outlets"),
      action<&Self::on_map>("map", "axes signs", 1, 4,
                            "axes of the patch from the device's, such as zxy 1 -1 1"),
      action<&Self::on_interp>("interp", "auto|off|ms", 1, 1,
                               "interpolation from one force to the next"),
      action<&Self::on_watchdog>(
          "watchdog", "hold_ms ramp_ms", 2, 2,
          "time without messages before the force falls, and duration of its fall"),
      action<&Self::on_scene>("scene",
                              "add name shape ... | mat name k b mu | move name x y z [ms] | del "
                              "name|all | tool mm | k N/m | load file",
                              2, 16, "scene of bodies that the handle touches; mm, N/m, N s/m")
          .with_name_behind("load"),
      action<&Self::on_effect>(
          "effect",
          "constant fx fy fz | spring k x y z [N] | viscous b | inertia kg [k b] | friction N [k] "
          "| texture N mm [dx dy dz] | relief mm mm [dx dy dz] | name off | off",
          1, 6, "force effects, several at a time; N, N/m, N s/m, kg, mm"),
      action<&Self::on_network>(
          "network",
          "string name n ... | membrane name nx ny ... | mass name kg x y z | anchor name [x y z] "
          "| link name name k [b l0 pull|push] | load file | del name|all | touch mm [k b] | grab "
          "name|nearest|off | pluck name fx fy fz ms | listen name axis ... | drag 1/s | gravity "
          "gx gy gz | rate Hz | reset",
          1, 16, "masses and springs that the hand feels and phantom~ plays: docs/network.md")
          .with_name_behind("load"),
      action<&Self::on_torques>("torques", "0|1", 1, 1,
                                "switch: 1 sends torque and grip to a device that has them"),
      action<&Self::on_torque>("torque", "tx ty tz", 3, 3,
                               "torque on the handle about x, y, z; N m"),
      action<&Self::on_grip>("grip", "N", 1, 1, "force of the gripper"),
      action<&Self::on_estop>("estop", "", 0, 0,
                              "emergency stop: no force until `motors 1`, also for the next "
                              "phantom of this name or device"),
      action<&Self::on_report>("report", "tag 0|1", 2, 2,
                               "reports to the info outlet: mm, vel, force, button, status, "
                               "jitter, error, hit, contact, release, rot, torque, grip"),
      action<&Self::on_stats>("stats", "[reset]", 0, 1, "send counters and timing of the servo"),
      action<&Self::on_trace>("trace", "file|stop", 1, 1, "record every tick to a CSV file"),
      action<&Self::on_hand>("hand",
                             "free | rigid | spring [K B] | person [K B tremor wander yield]", 1, 6,
                             "simulated hand that holds the handle; N/m, N s/m, mm, mm, ms"),
      takes_file(action<&Self::on_path>(
                     "path", "file | line ... | circle ... | lissajous ... | array x y z [ms]", 1,
                     10, "path of the simulated hand; mm, ms, Hz"))
          .with_name_behind("array"),
      action<&Self::on_target>("target", "x y z", 3, 3,
                               "target to which the simulated hand moves smoothly; mm"),
      action<&Self::on_seek>("seek", "ms", 1, 1, "time on the path of the simulated hand"),
      action<&Self::on_button>("button", "number 0|1", 2, 2,
                               "button of the simulated device: 1 pressed, 0 released"),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kControl, "fx", "N", "force to the right; all messages"},
      Port{Port::Kind::kControl, "fy", "N", "force up"},
      Port{Port::Kind::kControl, "fz", "N", "force towards the user"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kControl, "x", "", "position from left to right, 0..1 over the workspace"},
      Port{Port::Kind::kControl, "y", "", "position from bottom to top, 0..1"},
      Port{Port::Kind::kControl, "z", "", "position from far to near, 0..1"},
  };
  static constexpr std::array arguments{CreationArgument{"backend"}};
};

inline constexpr Declaration Phantom::declaration{
    "phantom",
    "haptic device: force in, position out",
    "Reads a haptic device, or a simulated one, a thousand times a second, sends the position of "
    "its handle and applies the forces that the patch sends and those of the scene that the "
    "handle touches, through a chain that keeps the hand safe: interpolation, limit, watchdog, "
    "slew and passivity control.",
    "haptic force feedback device simulation",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    Rows::arguments,
    "phantom~, haptic_server, struck_disk.pd",
    "in a patch: phantom.md, safety of the hand: phantom_safety.md, bodies to touch: scene.md, "
    "force effects: effects.md, masses and springs: network.md, the simulated hand: "
    "phantom_simulation.md, clock and trace: phantom_time.md, real devices: devices/README.md, "
    "theory: theory/phantom.md",
    "strike/struck_disk.wav: a hand strikes a disk"};

} // namespace tactus
