#pragma once

#include "core/footstep/foot.hpp"
#include "core/footstep/gait.hpp"
#include "core/footstep/sole_sensor.hpp"
#include "core/modal/body/timed_queue.hpp"
#include "core/rows.hpp"
#include "externals/footstep~/surface_store.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

namespace tactus::footstep {

/// [footstep~]: footsteps on any ground as sound and vibration, from the force under the sole
/// (core/footstep, docs/footstep.md).
class Footstep {
public:
  static const Declaration declaration;

  Footstep();
  void prepare(double sample_rate, std::size_t max_block);
  void report(Host& host);
  void dump(Host& host);

  template <class S> void process(const Block<S>& block) noexcept {
    begin_block(block.start_ms);
    for (std::size_t n = 0; n < block.frames; ++n) {
      for (; movements_.next() <= clock_;)
        move(movements_.pop());
      ++clock_;
      // Inputs and outputs may share memory, so all inputs are read first.
      std::array<double, 4> in{};
      for (std::size_t i = 0; i < in.size(); ++i)
        in[i] = static_cast<double>(block.inputs[i][n]);
      const std::array<double, 8> out = next(in);
      for (std::size_t i = 0; i < out.size(); ++i)
        block.outputs[i][n] = static_cast<S>(out[i]);
    }
  }

private:
  static constexpr std::array<std::string_view, 2> kSideNames{"left", "right"};
  static constexpr std::size_t kMaxEvents = 64; ///< maximum between two reports
  struct Event {
    std::size_t foot;
    Phase phase;
    double speed;
  };
  struct Side {
    Foot foot;
    SoleSensor sensor;
    double heel_squares = 0, ball_squares = 0; ///< sums of squares since the last dump
    std::shared_ptr<const Surface> first, second;
  };
  /// The last sample before a reset, which fades out.
  struct Fade {
    std::array<double, 8> last{}, from{};
    double left = 0, whole = 1; ///< samples
  };

  struct Rows;
  struct Settings {
    bool sensors = false, walk = false;
    double speed_m_per_s = 1.4, weight_n = 700, shoe = 0.4, feet = 1, variation = 0.04;
    bool in_weights = false; ///< forces at the inlets are in body weights, not newtons
    double mix = 0, gain = 1, drive_gain = 1, sensitivity_g = 3, limit_g = 3, delay_ms = 0;
    double common = 0, room = 1;
    Style gait = Style::kWalk;
    unsigned seed = 1;
  };

  // Commands of messages to the gait; each takes effect at its sample.
  struct Step {
    std::size_t foot;
  };
  struct Turn {
    double angle_rad;
    std::size_t foot;
  };
  struct Jump {
    double height_m;
  };
  struct Scuff {
    std::size_t foot;
  };
  struct Drag {
    std::size_t foot;
    double length_m, speed_m_per_s;
  };
  using Movement = std::variant<Step, Turn, Jump, Scuff, Drag>;
  static constexpr std::size_t kMaxMovements = 64;

  void begin_block(double start_ms) noexcept;
  void schedule(const Movement& movement, const Host& host) noexcept;
  void move(const Movement& movement) noexcept;
  std::array<double, 8> next(const std::array<double, 4>& in) noexcept;
  double second_foot_share(bool on) noexcept;
  void record_events(std::size_t foot, const SoleState& sole) noexcept;
  void apply() noexcept;
  void update_grounds() noexcept;
  void fade(std::array<double, 8>& out) noexcept;
  /// The foot that the first word names, if any.
  [[nodiscard]] static std::optional<std::size_t>
  side_named(std::span<const Atom> arguments) noexcept;
  /// Returns the feet in turn; with `feet 1` always the left foot.
  std::size_t next_side() noexcept;
  [[nodiscard]] bool walks() const noexcept { return settings_.walk; }
  void set_walk(bool on) noexcept;
  [[nodiscard]] bool runs() const noexcept { return settings_.gait == Style::kRun; }
  void set_run(bool on) noexcept;
  [[nodiscard]] unsigned seed() const noexcept { return settings_.seed; }
  void set_seed(unsigned value) noexcept;
  void step(std::span<const Atom> arguments, Host& host);
  void step_next(Host& host) { schedule(Step{next_side()}, host); }
  void turn(std::span<const Atom> arguments, Host& host);
  void jump(std::span<const Atom> arguments, Host& host);
  void scuff(std::span<const Atom> arguments, Host& host);
  void drag(std::span<const Atom> arguments, Host& host);
  void set_surface(std::span<const Atom> arguments, Host& host);
  void calibrate(std::span<const Atom> arguments, Host& host);
  void equalise(std::span<const Atom> arguments, Host& host);
  void list_surfaces(Host& host);
  void reset();

  Settings settings_;
  Gait gait_;
  modal::TimedQueue<Movement, kMaxMovements> movements_;
  double sample_rate_ = 48000;
  std::int64_t clock_ = 0; ///< sample of the logical time
  std::unique_ptr<std::array<Side, Gait::kFeet>> sides_;
  SurfaceStore store_;
  Fade fade_;
  double second_foot_ = 0;              ///< gain before the cosine: 0 off, 1 on, else fading
  double gain_ = 1, smoothed_gain_ = 1; ///< smoothed while something sounds
  std::size_t next_foot_ = 0;           ///< for messages that name no foot
  std::array<Event, kMaxEvents> events_{};
  std::size_t event_count_ = 0;
  double measured_ = 0; ///< samples since the last dump
};

struct Footstep::Rows {
  using Self = Footstep;
  static constexpr std::array<std::string_view, 2> sources{"gait", "sensors"};
  static constexpr std::array<std::string_view, 5> styles{"walk", "run", "sneak", "upstairs",
                                                          "downstairs"};
  static constexpr std::array<std::string_view, 2> units{"newton", "weight"};
  /// A setting whose change calls apply().
  template <auto setting>
  static constexpr auto applied = member<&Self::settings_, setting>.template then<&Self::apply>();
  static constexpr std::array parameters{
      member<&Self::settings_, &Settings::sensors>.row(
          "source", sources,
          "source of the steps: the built-in walker, or the forces at the inlets"),
      property<&Self::walks, &Self::set_walk>.row(
          "walk", "switch of the walker: 1 starts; 0 stops after one more step", 0),
      applied<&Settings::speed_m_per_s>.row(
          "speed", "m/s", 0.3, 8, "walking speed on level ground; sneaking and stairs are slower"),
      property<&Self::runs, &Self::set_run>.row(
          "run", "switch between gait run (1, at 1.5 m/s or more) and gait walk (0)", 0),
      applied<&Settings::weight_n>.row("weight", "N", 1, 10000,
                                       "body weight, which scales forces and impacts"),
      applied<&Settings::shoe>.row("shoe", "", 0, 1,
                                   "hardness of the sole: 0: soft or barefoot, 1: hard"),
      member<&Self::settings_, &Settings::feet>.row("feet", "", 1, 2, "number of feet"),
      applied<&Settings::variation>.row("variation", "", 0, 0.5,
                                        "variation from step to step (people: 0.03 to 0.05)"),
      member<&Self::settings_, &Settings::in_weights>.row(
          "unit", units, "unit of the inlets' forces: newtons or body weights"),
      applied<&Settings::mix>.row("mix", "", 0, 1,
                                  "mix of two surfaces: 0: the first, 1: the second"),
      member<&Self::settings_, &Settings::gain>.row("gain", "", 0, 1000, "gain of the sound"),
      applied<&Settings::drive_gain>.row("drive_gain", "", 0, 1000, "gain of the actuator signals"),
      applied<&Settings::sensitivity_g>.row("sensitivity", "g", 0.01, 100,
                                            "acceleration of the actuator at a signal of 1"),
      applied<&Settings::limit_g>.row("limit", "g", 0, 3, "maximum acceleration of the actuator"),
      applied<&Settings::delay_ms>.row(
          "delay", "ms", 0, 200, "delay of the actuator signals, to match a slower audio path"),
      applied<&Settings::common>.row("common", "", 0, 1,
                                     "distribution of the actuator signals: 0: own contact in "
                                     "each; 1: the whole foot in both, weighted by force"),
      property<&Self::seed, &Self::set_seed>.seed<"seed of all random numbers">(),
      applied<&Settings::room>.row("room", "", 0, 10,
                                   "gain of the surface's own room response; 0: outdoors"),
      applied<&Settings::gait>.row("gait", styles, "gait of the walker"),
  };
  static constexpr std::array messages{
      takes_file(action<&Self::set_surface>(
          "surface",
          "[left|right] "
          "wood|creak|underbrush|snow|frozensnow|sand|gravel|metal|highgrass|dryleaves|concrete|"
          "dirt|puddle|water|carpet|file.txt [another [mix]]",
          1, 4, "surface under both feet or one foot; second surface and its share")),
      realtime(action<&Self::step>(
          "step", "[left|right]", 0, 1,
          "make one step; a foot on the ground lands again beside its position")),
      realtime(action<&Self::step_next>("bang", "", 0, 0,
                                        "make one step; with `feet 2` alternate left and right")),
      realtime(action<&Self::turn>(
          "turn", "[degrees]", 0, 1,
          "pivot in the next step by 1 to 180 degrees (90): the loaded ball of the foot slides")),
      realtime(action<&Self::jump>(
          "jump", "[m]", 0, 1,
          "crouch, jump 0.01 to 1 m high (0.3) with both feet, land; a walker stops first")),
      realtime(action<&Self::scuff>(
          "scuff", "[left|right]", 0, 1,
          "scuff: the ball of the foot strikes and slides 15 cm, in its next swing or at once")),
      realtime(action<&Self::drag>("drag", "[left|right] [m [m/s]]", 0, 3,
                                   "slide a foot 0.01 to 20 m (0.5) at 0.02 to 5 m/s (0.5) under "
                                   "30 % of the weight; a walker does it in its next swing")),
      action<&Self::calibrate>("calibrate", "heel|ball [reading N reading N ...]", 1, 65,
                               "calibration of a sensor: at least five rising pairs of reading and "
                               "newtons; without pairs the reading is the force"),
      action<&Self::equalise>("equalise", "[f1 dB1 f2 dB2 ...]", 0, 32,
                              "equaliser of the actuator signals, from the actuator's response in "
                              "dB at frequencies in Hz; without numbers: flat"),
      action<&Self::list_surfaces>("surfaces", "", 0, 0,
                                   "send the names of the fifteen surfaces to the info outlet"),
      realtime(action<&Self::reset>("reset", "", 0, 0,
                                    "stop: silence within 5 ms, both feet in the air")),
  };
  static constexpr std::array arguments{CreationArgument{"surface"}};
  static constexpr std::array inlets{
      Port{Port::Kind::kSignal, "heel", "N", "sensor force under the (left) heel"},
      Port{Port::Kind::kSignal, "ball", "N", "force under the ball of the (left) foot"},
      Port{Port::Kind::kSignal, "heel_2", "N", "force under the right heel (feet 2)"},
      Port{Port::Kind::kSignal, "ball_2", "N", "force under the right ball (feet 2)"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kSignal, "sound", "", "sound of the (left) foot, within +-1"},
      Port{Port::Kind::kSignal, "heel_drive", "", "actuator signal under the heel"},
      Port{Port::Kind::kSignal, "ball_drive", "", "actuator signal under the ball"},
      Port{Port::Kind::kSignal, "force", "N", "force under the foot"},
      Port{Port::Kind::kSignal, "sound_2", "", "sound of the right foot (feet 2)"},
      Port{Port::Kind::kSignal, "heel_drive_2", "", "right heel's actuator (feet 2)"},
      Port{Port::Kind::kSignal, "ball_drive_2", "", "right ball's actuator (feet 2)"},
      Port{Port::Kind::kSignal, "force_2", "N", "force under the right foot (feet 2)"},
      Port{Port::Kind::kControl, "info", "",
           "step left|right heel|ball (with m/s), heel_up|toe_off; answers"},
  };
};

inline constexpr Declaration Footstep::declaration{
    "footstep~",
    "steps on any ground, heard and felt",
    "The force under heel and ball comes from sensors, a recording or a simulated walker. It acts "
    "on a surface whose recipe is a text file: masses that strike, boards that rub, grains and "
    "bubbles. Sound and signals for actuators under heel and ball come from the same motion.",
    "footsteps walking gait ground surface haptic vibrotactile physical model",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    Rows::arguments,
    "particle~, modal_impact~, footstep_map.pd",
    "how to use it: footstep.md, the model: theory/footstep.md, your own surface: surfaces.md",
    "walking/tour.wav: one walker in one take"};

} // namespace tactus::footstep
