#pragma once

#include "core/footstep/foot.hpp"
#include "core/footstep/gait.hpp"
#include "core/footstep/sole_sensor.hpp"
#include "core/modal/body/timed_queue.hpp"
#include "core/object.hpp"
#include "externals/footstep~/declaration.hpp"
#include "externals/footstep~/surface_store.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

namespace tactus::footstep {

/// [footstep~]: footsteps on any ground as sound and vibration, from the force under the sole
/// (core/footstep, docs/footstep.md).
class Footstep {
public:
  static constexpr Declaration declaration{
      "footstep~",
      "steps on any ground, heard and felt",
      "The force under heel and ball, from sensors, a recording or a walker made here, meets a "
      "ground made of a readable recipe: masses that strike, boards that rub, grains and bubbles. "
      "Sound for the ears and drives for actuators under heel and ball come from the same motion.",
      "footsteps walking gait ground surface haptic vibrotactile physical model",
      kInlets,
      kOutlets,
      kParameters,
      kMessages,
      kArguments,
      "particle~, modal_impact~, footstep_map.pd",
      "the model: footstep.md, your own surface: surfaces.md",
      "walking/tour.wav: one walker in one take"};

  Footstep();
  void prepare(double sample_rate, std::size_t max_block);
  void set(std::size_t parameter, double value) noexcept;
  [[nodiscard]] double get(std::size_t parameter) const noexcept { return value_[parameter]; }
  void message(std::size_t index, std::span<const Atom> arguments, Host& host);
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
  static constexpr std::size_t kMaxEvents = 64; ///< between two reports
  struct Event {
    std::size_t foot;
    Phase phase;
    double speed;
  };
  struct Side {
    Foot foot;
    SoleSensor sensor;
    double heel_squares = 0, ball_squares = 0; ///< of the drives since the last dump
    std::shared_ptr<const Surface> first, second;
  };
  /// The last sample before a reset, which fades out.
  struct Fade {
    std::array<double, 8> last{}, from{};
    double left = 0, whole = 1; ///< samples
  };

  /// What a message asks of the gait, from its sample on.
  struct Movement {
    MessageIndex what = kStep;
    std::size_t foot = 0;
    double value = 0, speed = 0; ///< angle, height or length; of a drag
  };
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
  /// Alternates between the feet; always the left one with feet 1.
  std::size_t next_side() noexcept;
  void turn(std::span<const Atom> arguments, Host& host);
  void jump(std::span<const Atom> arguments, Host& host);
  void scuff(std::span<const Atom> arguments, Host& host);
  void drag(std::span<const Atom> arguments, Host& host);
  void set_surface(std::span<const Atom> arguments, Host& host);
  void calibrate(std::span<const Atom> arguments, Host& host);
  void equalise(std::span<const Atom> arguments, Host& host);

  std::array<double, kParameters.size()> value_{};
  Gait gait_;
  modal::TimedQueue<Movement, kMaxMovements> movements_;
  double sample_rate_ = 48000;
  std::int64_t clock_ = 0; ///< sample of the logical time
  std::unique_ptr<std::array<Side, Gait::kFeet>> sides_;
  SurfaceStore store_;
  Fade fade_;
  double second_foot_ = 0;              ///< 0: it is off, 1: it sounds, between: it fades
  double gain_ = 1, smoothed_gain_ = 1; ///< smoothed while something sounds
  std::size_t next_foot_ = 0;           ///< of a bang and its like
  std::array<Event, kMaxEvents> events_{};
  std::size_t event_count_ = 0;
  double measured_ = 0; ///< samples since the last dump
};

} // namespace tactus::footstep
