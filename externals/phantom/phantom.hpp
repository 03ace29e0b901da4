#pragma once

#include "core/rows.hpp"
#include "externals/phantom/audio_link.hpp"
#include "externals/phantom/chain_watch.hpp"
#include "externals/phantom/device_worker.hpp"
#include "externals/phantom/emergency_stop.hpp"
#include "externals/phantom/felt_models.hpp"
#include "externals/phantom/live_connections.hpp"
#include "externals/phantom/reports.hpp"
#include "externals/phantom/servo_output.hpp"
#include "externals/phantom/servo_session.hpp"
#include "externals/phantom/servo_setup.hpp"
#include "externals/phantom/simulation.hpp"
#include "externals/phantom/tick_grid.hpp"
#include "externals/phantom/trouble.hpp"
#include "externals/phantom/wrist.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

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
  enum Timer : std::size_t { kSchedule, kForces, kWatchWorker };
  enum class Clock { kAuto, kLogical, kWall };
  enum class Link { kClosed, kOpening, kOpen, kLost };
  using Words = std::span<const Atom>;
  using Device = phantom::DeviceJob::Device;

  // phantom.cpp: time, forces and settings
  [[nodiscard]] bool open() const noexcept { return link_ == Link::kOpen; }
  [[nodiscard]] double period_s() const noexcept;
  [[nodiscard]] haptic::Exchange& exchange() const noexcept { return session_.exchange(); }
  [[nodiscard]] const haptic::Report& report() const noexcept {
    return exchange().reports.latest();
  }
  void begin(Host& host);
  void begin_grids(Host& host);
  void schedule(Host& host);
  void apply_forces(Host& host);
  void step_with_audio() noexcept;
  void configure_signals() noexcept;
  void attach() noexcept;
  void restart(Host& host);
  void without_thread(const std::string& refusal, Host& host);
  void collect(Host& host);
  void send_all(Host& host);
  void send_values(bool all, Host& host);
  void set_forces(Words words, Host& host);
  void set_clock(Words words, Host& host);
  void send_statistics(Words words, Host& host);
  void rate_changed();
  void restart_grids() noexcept { restart_grids_ = true; }
  void apply_settings() noexcept;
  void apply_simulation() noexcept;
  void update_limits() noexcept;
  [[nodiscard]] phantom::FeltModels::Limits stability_limits() const noexcept;
  [[nodiscard]] bool motors() const noexcept { return motors_; }
  void set_motors(bool on) noexcept;
  void stop(Host& host);
  void latch_stop() noexcept;
  void inherit_stop(const std::string& key, Host& host);
  void switch_off() noexcept;
  /// A message that a part carries out, which says why it refuses one.
  static void say(const std::string& refusal, Host& host) {
    if (!refusal.empty())
      host.error(refusal);
  }
  template <auto function> void to_setup(Words words, Host& host) {
    if (const std::string refusal = (setup_.*function)(words); !refusal.empty())
      return host.error(refusal);
    apply_settings();
  }
  template <auto function> void to_models(Words words, Host& host) {
    say((models_.*function)(words, session_.rig(), stability_limits(), host), host);
  }
  template <auto function> void to_wrist(Words words, Host& host) {
    say((wrist_.*function)(words, exchange()), host);
  }
  template <auto function> void to_simulation(const Message& row, Words words, Host& host) {
    if (!for_simulation(row.name, host))
      return;
    if constexpr (requires { (simulation_.*function)(words, host); })
      say((simulation_.*function)(words, host), host);
    else
      say((simulation_.*function)(words), host);
  }
  void set_workspace(Words words, Host& host);
  void play_network(Words words, Host& host);
  void enable_wrist(Words words, Host& host) {
    say(wrist_.enable(words, open(), device().caps(), exchange()), host);
  }
  void set_hand(const Message& row, Words words, Host& host);
  void set_reports(Words words, Host& host) { say(reports_.set(words), host); }
  void set_trace(Words words, Host& host) {
    say(output_.trace(words, session_.rig(), wall_, host), host);
  }
  [[nodiscard]] bool for_simulation(std::string_view message, Host& host) const;

  // connection.cpp: choosing, opening and closing the device
  [[nodiscard]] const haptic::Backend& device() const noexcept;
  [[nodiscard]] std::string_view driver_name() const noexcept;
  [[nodiscard]] phantom::DeviceWorker& worker(Host& host);
  void watch_worker(Host& host);
  void replace_rig(Host& host);
  void store_heat() noexcept;
  void end_session(Host& host);
  void connect(Words which, Host& host);
  void connect_simulation(Host& host);
  void disconnect(Host& host);
  void opened(Host&);
  void listed(const phantom::ListJob::Answer&, Host&);
  void closed(std::string_view why, Host&);
  void send_identity(Host& host) const;
  void send_status(std::string_view word, Host& host) const;
  void let_go() noexcept override;
  void choose_driver(Words words, Host& host);
  void set_driver(const Message& row, Words words, Host& host);
  void list_devices(Host& host);
  void set_name(const Atom& name, Host& host);
  // ... and what goes wrong with an open one
  void watch_device(Host& host);
  void handle_lost_device(Host& host);
  void handle_device_fault(Host& host);

  phantom::Reports reports_;
  phantom::ServoSetup setup_;
  phantom::ServoSession session_;
  phantom::Simulation simulation_;
  phantom::FeltModels models_{reports_};
  phantom::Wrist wrist_;
  phantom::ServoOutput output_{reports_};
  phantom::AudioLink audio_;
  phantom::EmergencyStop stop_;
  phantom::ChainWatch chain_watch_;
  phantom::Trouble trouble_;

  double rate_hz_ = 1000, output_hz_ = 1000;
  bool repeat_ = false, motors_ = true;
  bool in_shares_of_limit_ = false; // forces at the inlets: 1 is forcemax
  Vec3 input_force_{};              // inlets, in the chosen units
  bool input_refused_ = false, input_changed_ = false;
  double last_error_ms_ = -1e9;

  const devices::Driver* driver_ = nullptr; // null: the simulated device
  Device device_{};                         // the driver's
  Link link_ = Link::kClosed;
  std::uint64_t ticket_ = 0; // of the newest request to open
  std::uint32_t faults_ = 0;
  bool running_ = false;     // a thread steps the real device's servo
  std::string device_key_{}; // of the real device that was opened last
  std::unique_ptr<phantom::DeviceWorker> worker_{};
  std::unique_ptr<phantom::DeviceLister> lister_{};

  Clock clock_ = Clock::kAuto;
  bool wall_ = false; // stepped by a thread instead of the host's logical time
  bool created_ = false, restart_grids_ = false, scheduling_reported_ = false;
  phantom::TickGrid ticks_, outputs_;
};

struct Phantom::Rows {
  using Self = Phantom;
  using Setup = phantom::ServoSetup;
  using Given = Setup::Parameters;
  using Simulation = phantom::Simulation;
  using Simulated = Simulation::Parameters;
  using Models = phantom::FeltModels;
  using Wrist = phantom::Wrist;
  static constexpr std::array<std::string_view, 2> units{"newton", "norm"};
  template <auto setting>
  static constexpr auto
      given = member<&Self::setup_, &Setup::given, setting>.template then<&Self::apply_settings>();
  template <auto setting>
  static constexpr auto simulated =
      member<&Self::simulation_, &Simulation::given, setting>.template then<&Self::apply_simulation>();
  static constexpr std::array parameters{
      member<&Self::rate_hz_>.then<&Self::rate_changed>().row("rate", "Hz", 1000, 200, 4000,
                                                              "rate of the servo, ticks a second"),
      member<&Self::output_hz_>.then<&Self::restart_grids>().row(
          "outrate", "Hz", 1000, 0, 4000, "rate of positions at the outlets; 0: only on `bang`"),
      member<&Self::repeat_>.row("repeat", "switch: 1 also sends positions that have not changed",
                                 0),
      member<&Self::in_shares_of_limit_>.row("units", units,
                                             "unit of the force inlets; norm: 1 is `forcemax`", 0),
      given<&Given::forcemax_n>.row("forcemax", "N", 0, 40,
                                    "largest magnitude of the force sent to the device"),
      given<&Given::slew_n_per_ms>.row("slew", "N/ms", 1e-3, 1000,
                                       "largest rate of change of the force"),
      given<&Given::extrap_ms>.row("extrap", "ms", 0, 20,
                                   "time for which the force is extrapolated after a target"),
      given<&Given::strict>.row("strict", "switch: 1 lets the force fall when force messages stop"),
      given<&Given::resume>.row(
          "resume",
          "switch: 1 returns a real device's force after a freeze of the host without `motors 1`"),
      given<&Given::passivity>.row(
          "passivity",
          "switch of the passivity controller: 1 removes energy that the sampled force creates"),
      given<&Given::tank_j>.row("tank", "J", 0, 1000,
                                "largest energy of a contact that a bounce may return"),
      given<&Given::allowance_w>.row(
          "allowance", "W", 0, 10,
          "power that the delay of the patch's forces may create before it is braked"),
      given<&Given::damp_n_s_per_m>.row("damp", "N s/m", 0, 100, "viscosity added to all forces"),
      given<&Given::walls_n_per_m>.row("walls", "N/m", 0, 5000,
                                       "stiffness of soft walls at the faces of the workspace"),
      not_stored(property<&Self::motors, &Self::set_motors>.row(
          "motors",
          "switch of the force: 0 off; 1 ramps it up over half a second and ends an emergency stop",
          1)),
      simulated<&Simulated::mass_kg>.row("mass", "kg", 1e-3, 100, "mass of the simulated handle"),
      simulated<&Simulated::viscous_n_s_per_m>.row("viscous", "N s/m", 0, 1000,
                                                   "viscosity of the simulated handle"),
      simulated<&Simulated::stops>.row(
          "stops", "switch: 1 gives the simulated device hard stops 5 mm outside the workspace"),
      simulated<&Simulated::resolution_mm>.row("resolution", "mm", 0, 10,
                                               "encoder step of the simulated device; 0: exact"),
      simulated<&Simulated::noise_mm>.row("noise", "mm", 0, 10,
                                          "amplitude of the simulated device's reading noise"),
      simulated<&Simulated::seed>.seed<"simulated: seed of noise, tremor and wander">(),
      simulated<&Simulated::latency_ticks>.row("latency", "ticks", 0, 8,
                                               "delay of the simulated device's readings"),
  };
  static constexpr std::array messages{
      action<&Self::send_all>("bang", "", 0, 0, "send position and reported values"),
      action<&Self::set_forces>("list", "fx fy fz", 3, 3, "force in x, y and z"),
      action<&Self::choose_driver>("backend", "name ...", 1, 8,
                                   "driver of the device, and its options"),
      action<&Self::connect>("open", "index|serial|path", 0, 1, "connect the device"),
      action<&Self::disconnect>("close", "", 0, 0, "ramp the force down and disconnect"),
      action<&Self::set_name>("name", "word", 1, 1,
                              "name of this device among others, shown by `devices` and `dump`"),
      action<&Self::list_devices>("devices", "", 0, 0,
                                  "list the devices of all drivers; those in use are not queried"),
      action<&Self::set_driver>("driver", "word ...", 1, 16, "setting of the device's own driver"),
      action<&Self::set_driver>("firmware", "file", 1, 1,
                                "file of firmware that the device needs at power-up"),
      action<&Self::set_driver>("home", "", 0, 0, "find the device's zero again"),
      action<&Self::set_driver>("calibrate", "", 0, 0, "calibrate the device by its driver"),
      action<&Self::set_clock>("clock", "auto|logical|wall", 1, 1, "clock of the servo"),
      action<&Self::set_workspace>("workspace",
                                   "device | learn 0|1 | xmin ymin zmin xmax ymax zmax", 1, 6,
                                   "workspace in mm, 0..1 at the outlets"),
      action<&Self::to_setup<&Setup::set_map>>(
          "map", "axes signs", 1, 4, "axes of the patch from the device's, such as zxy 1 -1 1"),
      action<&Self::to_setup<&Setup::set_interpolation>>(
          "interp", "auto|off|ms", 1, 1, "interpolation from one force to the next"),
      action<&Self::to_setup<&Setup::set_watchdog>>(
          "watchdog", "hold_ms ramp_ms", 2, 2,
          "time without messages before the force falls, and duration of its fall"),
      action<&Self::to_models<&Models::scene>>(
          "scene",
          "add name shape ... | mat name k b mu | move name x y z [ms] | del "
          "name|all | tool mm | k N/m | load file",
          2, 16, "scene of bodies that the handle touches; mm, N/m, N s/m")
          .with_name_behind("load"),
      action<&Self::to_models<&Models::effect>>(
          "effect",
          "constant fx fy fz | spring k x y z [N] | viscous b | inertia kg [k b] | friction N [k] "
          "| texture N mm [dx dy dz] | relief mm mm [dx dy dz] | name off | off",
          1, 6, "force effects, several at a time; N, N/m, N s/m, kg, mm"),
      action<&Self::play_network>(
          "network",
          "string name n ... | membrane name nx ny ... | mass name kg x y z | anchor name [x y z] "
          "| link name name k [b l0 pull|push] | load file | del name|all | touch mm [k b] | grab "
          "name|nearest|off | pluck name fx fy fz ms | listen name axis ... | drag 1/s | gravity "
          "gx gy gz | rate Hz | reset",
          1, 16, "masses and springs that the hand feels and phantom~ plays: docs/network.md")
          .with_name_behind("load"),
      action<&Self::enable_wrist>("torques", "0|1", 1, 1,
                                  "switch: 1 sends torque and grip to a device that has them"),
      action<&Self::to_wrist<&Wrist::set_torque>>("torque", "tx ty tz", 3, 3,
                                                  "torque on the handle about x, y, z; N m"),
      action<&Self::to_wrist<&Wrist::set_grip>>("grip", "N", 1, 1, "force of the gripper"),
      action<&Self::stop>("estop", "", 0, 0,
                          "emergency stop: no force until `motors 1`, also for the next "
                          "phantom of this name or device"),
      action<&Self::set_reports>("report", "tag 0|1", 2, 2,
                                 "reports to the info outlet: mm, vel, force, button, status, "
                                 "jitter, error, hit, contact, release, rot, torque, grip"),
      action<&Self::send_statistics>("stats", "[reset]", 0, 1,
                                     "send counters and timing of the servo"),
      action<&Self::set_trace>("trace", "file|stop", 1, 1, "record every tick to a CSV file"),
      action<&Self::set_hand>("hand",
                              "free | rigid | spring [K B] | person [K B tremor wander yield]", 1,
                              6, "simulated hand that holds the handle; N/m, N s/m, mm, mm, ms"),
      takes_file(action<&Self::to_simulation<&Simulation::set_path>>(
                     "path", "file | line ... | circle ... | lissajous ... | array x y z [ms]", 1,
                     10, "path of the simulated hand; mm, ms, Hz"))
          .with_name_behind("array"),
      action<&Self::to_simulation<&Simulation::set_target>>(
          "target", "x y z", 3, 3, "target to which the simulated hand moves smoothly; mm"),
      action<&Self::to_simulation<&Simulation::seek>>("seek", "ms", 1, 1,
                                                      "time on the path of the simulated hand"),
      action<&Self::to_simulation<&Simulation::press>>(
          "button", "number 0|1", 2, 2, "button of the simulated device: 1 pressed, 0 released"),
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
