#pragma once

#include "core/rows.hpp"
#include "externals/phantom/device/live_connection.hpp"
#include "externals/phantom/device/simulation.hpp"
#include "externals/phantom/device/trouble.hpp"
#include "externals/phantom/force/force_inlets.hpp"
#include "externals/phantom/force/motors.hpp"
#include "externals/phantom/force/servo_setup.hpp"
#include "externals/phantom/force/wrist.hpp"
#include "externals/phantom/output/audio_link.hpp"
#include "externals/phantom/output/servo_output.hpp"
#include "externals/phantom/reports.hpp"
#include "externals/phantom/scene/felt_models.hpp"
#include "externals/phantom/servo/tick_grid.hpp"
#include "externals/phantom/words.hpp"

#include <array>
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
  using Words = phantom::Words;

  // Defined in phantom.cpp:
  void begin(Host& host);
  void begin_grids(Host& host);
  void schedule(Host& host);
  void step_with_audio() noexcept;
  void configure_signals() noexcept;
  void without_thread(const std::string& refusal, Host& host);
  [[nodiscard]] bool threaded() const noexcept { return link_.is_real() || session_.in_thread(); }
  void collect(Host& host);
  void send_values(bool all, Host& host);
  void send_all(Host& host);
  void send_statistics(Words words, Host& host);
  void set_forces(Words words, Host& host);
  void set_clock(const Atom& clock, Host& host);
  void set_name(const Atom& name, Host& host);
  void list_devices(Host& host) { link_.list(audio_.name(), host); }
  void change_rate() noexcept;
  void restart_grids() noexcept { restart_grids_ = true; }
  void apply_settings() noexcept { setup_.apply(); }
  void apply_simulation() noexcept { simulation_.apply(); }

  // Defined in connection.cpp:
  void choose_driver(Words words, Host& host);
  void connect(Words which, Host& host);
  void connect_simulation(Host& host);
  void request_open(Host& host);
  void opened(Host& host);
  void disconnect(Host& host);
  void end_session(Host& host);
  void replace_rig(Host& host);
  void closed(std::string_view why, Host& host);
  void let_go() noexcept override;
  void watch_worker(Host& host);
  void watch_device(Host& host);
  void handle_lost_device(Host& host);
  void handle_device_fault(Host& host);
  void send_status(std::string_view word, Host& host) const;

  phantom::Reports reports_;
  phantom::ServoSession session_;
  phantom::DeviceLink link_{session_};
  phantom::Simulation simulation_{session_, link_};
  phantom::ServoSetup setup_{session_, link_};
  phantom::ForceInlets forces_{session_, reports_};
  phantom::Motors motors_{session_, reports_};
  phantom::Wrist wrist_{session_, link_, reports_};
  phantom::FeltModels models_{session_, link_, setup_, reports_};
  phantom::ServoOutput output_{session_, models_, reports_};
  phantom::AudioLink audio_{session_};
  phantom::Trouble trouble_{session_, link_, reports_};

  double output_hz_ = 1000;
  bool repeat_ = false;
  Clock clock_ = Clock::kAuto;
  bool created_ = false, restart_grids_ = false, scheduling_reported_ = false;
  phantom::TickGrid ticks_, outputs_;
};

struct Phantom::Rows {
  using Self = Phantom;
  using Session = phantom::ServoSession;
  using Link = phantom::DeviceLink;
  using Setup = phantom::ServoSetup;
  using Given = Setup::Parameters;
  using Simulation = phantom::Simulation;
  using Simulated = Simulation::Parameters;
  using Models = phantom::FeltModels;
  using Inlets = phantom::ForceInlets;
  using Motors = phantom::Motors;
  using Wrist = phantom::Wrist;
  static constexpr std::array<std::string_view, 2> units{"newton", "norm"};
  template <auto setting>
  static constexpr auto
      given = member<&Self::setup_, &Setup::given, setting>.template then<&Self::apply_settings>();
  template <auto setting>
  static constexpr auto simulated =
      member<&Self::simulation_, &Simulation::given, setting>.template then<&Self::apply_simulation>();
  static constexpr std::array parameters{
      member<&Self::session_, &Session::rate_hz>.then<&Self::change_rate>().row(
          "rate", "Hz", 1000, 200, 4000, "rate of the servo in ticks a second"),
      member<&Self::output_hz_>.then<&Self::restart_grids>().row(
          "outrate", "Hz", 1000, 0, 4000, "rate of positions at the outlets; 0: only on `bang`"),
      member<&Self::repeat_>.row("repeat", "switch: 1 also sends positions that have not changed",
                                 0),
      member<&Self::forces_, &Inlets::in_shares_of_limit>.row(
          "units", units, "unit of the force inlets; norm: 1 means `forcemax`", 0),
      given<&Given::forcemax_n>.row("forcemax", "N", 0, 40,
                                    "maximum magnitude of the force sent to the device"),
      given<&Given::slew_n_per_ms>.row("slew", "N/ms", 1e-3, 1000,
                                       "maximum rate of change of the force"),
      given<&Given::extrap_ms>.row("extrap", "ms", 0, 20,
                                   "time for which the force is extrapolated after a target"),
      given<&Given::strict>.row("strict", "switch: 1 lets the force fall if force messages stop"),
      given<&Given::resume>.row("resume", "switch: 1 restores a real device's force after a freeze "
                                          "of the host, without `motors 1`"),
      given<&Given::passivity>.row(
          "passivity",
          "switch: 1 turns on the passivity controller, which removes energy created by sampling"),
      given<&Given::tank_j>.row("tank", "J", 0, 1000,
                                "maximum energy of a contact that a bounce may return"),
      given<&Given::allowance_w>.row(
          "allowance", "W", 0, 10,
          "power that delayed forces of the patch may create before the controller brakes"),
      given<&Given::damp_n_s_per_m>.row("damp", "N s/m", 0, 100, "damping added to all forces"),
      given<&Given::walls_n_per_m>.row("walls", "N/m", 0, 5000,
                                       "stiffness of soft walls at the faces of the workspace"),
      not_stored(property<&Motors::on, &Motors::set, &Self::motors_>.row(
          "motors",
          "switch of the force: 0: off; 1: ramps it up over half a second and ends an emergency "
          "stop",
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
      simulated<&Simulated::seed>.seed<"seed of the simulated noise, tremor and wander">(),
      simulated<&Simulated::latency_ticks>.row("latency", "ticks", 0, 8,
                                               "delay of the simulated device's readings"),
  };
  static constexpr std::array messages{
      action<&Self::send_all>("bang", "", 0, 0, "send position and reported values"),
      action<&Self::set_forces>("list", "fx fy fz", 3, 3, "force in x, y and z"),
      action<&Self::choose_driver>("backend", "name ...", 1, 8,
                                   "driver of the device and its options"),
      action<&Self::connect>("open", "index|serial|path", 0, 1, "connect the device"),
      action<&Self::disconnect>("close", "", 0, 0, "ramp the force down and disconnect"),
      action<&Self::set_name>("name", "word", 1, 1,
                              "name of this object, shown by `devices` and `dump`"),
      action<&Self::list_devices>(
          "devices", "", 0, 0, "list the devices of all drivers, without a query of those in use"),
      action<&Self::link_, &Link::configure>("driver", "word ...", 1, 16,
                                             "setting of the device's own driver"),
      action<&Self::link_, &Link::configure>("firmware", "file", 1, 1,
                                             "firmware file that the device needs at power-up"),
      action<&Self::link_, &Link::configure>("home", "", 0, 0, "find the device's zero again"),
      action<&Self::link_, &Link::configure>("calibrate", "", 0, 0,
                                             "calibrate the device with its driver"),
      action<&Self::set_clock>("clock", "auto|logical|wall", 1, 1, "clock of the servo"),
      action<&Self::setup_, &Setup::set_workspace>(
          "workspace", "device | learn 0|1 | xmin ymin zmin xmax ymax zmax", 1, 6,
          "workspace in mm: 0..1 at the outlets"),
      action<&Self::setup_, &Setup::set_map>(
          "map", "axes signs", 1, 4, "axes of the patch from device axes, such as zxy 1 -1 1"),
      action<&Self::setup_, &Setup::set_interpolation>("interp", "auto|off|ms", 1, 1,
                                                       "interpolation from each force to the next"),
      action<&Self::setup_, &Setup::set_watchdog>(
          "watchdog", "hold_ms ramp_ms", 2, 2,
          "time without messages until the force falls, and duration of the fall"),
      action<&Self::models_, &Models::scene>(
          "scene",
          "add name shape ... | mat name k b mu | move name x y z [ms] | del "
          "name|all | tool mm | k N/m | load file",
          2, 16, "scene of bodies that the handle can touch; mm, N/m, N s/m")
          .with_name_behind("load"),
      action<&Self::models_, &Models::effect>(
          "effect",
          "constant fx fy fz | spring k x y z [N] | viscous b | inertia kg [k b] | friction N [k] "
          "| texture N mm [dx dy dz] | relief mm mm [dx dy dz] | name off | off",
          1, 6, "force effects, several at a time; N, N/m, N s/m, kg, mm"),
      action<&Self::models_, &Models::network>(
          "network",
          "string name n ... | membrane name nx ny ... | mass name kg x y z | anchor name [x y z] "
          "| link name name k [b l0 pull|push] | load file | del name|all | touch mm [k b] | grab "
          "name|nearest|off | pluck name fx fy fz ms | listen name axis ... | drag 1/s | gravity "
          "gx gy gz | rate Hz | reset",
          1, 16, "masses and springs, felt by the hand and played by phantom~: docs/network.md")
          .with_name_behind("load"),
      action<&Self::wrist_, &Wrist::enable>(
          "torques", "0|1", 1, 1, "switch: 1 sends torque and grip to devices that have them"),
      action<&Self::wrist_, &Wrist::set_torque>("torque", "tx ty tz", 3, 3,
                                                "torque on the handle about x, y, z; N m"),
      action<&Self::wrist_, &Wrist::set_grip>("grip", "N", 1, 1, "force of the gripper"),
      action<&Self::motors_, &Motors::stop>("estop", "", 0, 0,
                                            "emergency stop: no force until `motors 1`, also for "
                                            "the next phantom with this name or device"),
      action<&Self::reports_, &phantom::Reports::set>(
          "report", "tag 0|1", 2, 2,
          "reports to the info outlet: mm, vel, force, button, status, "
          "jitter, error, hit, contact, release, rot, torque, grip"),
      action<&Self::send_statistics>("stats", "[reset]", 0, 1,
                                     "send counters and timing of the servo"),
      action<&Self::output_, &phantom::ServoOutput::trace>("trace", "file|stop", 1, 1,
                                                           "record every tick to a CSV file"),
      action<&Self::simulation_, &Simulation::run<&Simulation::set_hand>>(
          "hand", "free | rigid | spring [K B] | person [K B tremor wander yield]", 1, 6,
          "simulated hand that holds the handle; N/m, N s/m, mm, mm, ms"),
      takes_file(action<&Self::simulation_, &Simulation::run<&Simulation::set_path>>(
                     "path", "file | line ... | circle ... | lissajous ... | array x y z [ms]", 1,
                     10, "path of the simulated hand; mm, ms, Hz"))
          .with_name_behind("array"),
      action<&Self::simulation_, &Simulation::run<&Simulation::set_target>>(
          "target", "x y z", 3, 3, "target to which the simulated hand moves smoothly; mm"),
      action<&Self::simulation_, &Simulation::run<&Simulation::seek>>(
          "seek", "ms", 1, 1, "time on the simulated hand's path"),
      action<&Self::simulation_, &Simulation::run<&Simulation::press>>(
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
    "Reads a haptic device, or a simulated one, a thousand times a second and outputs the position "
    "of its handle. Applies the forces of the patch and of the scene that the handle touches. A "
    "chain keeps the hand safe: interpolation, force limit, watchdog, slew limit and passivity "
    "control.",
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
