#pragma once

#include "core/footstep/drive.hpp"
#include "core/footstep/ground.hpp"
#include "core/footstep/recipe.hpp"
#include "core/footstep/room.hpp"
#include "core/footstep/step_event.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::footstep {

/// One foot: SoleState in, sound pressure and the two actuator signals out. The foot stands on a
/// mixture of up to two grounds. The sound of a ground that it leaves decays and fades out. The
/// rooms of the two grounds are mixed in the same proportion.
class Foot {
public:
  Foot();
  Foot(const Foot&) = delete; // a_, b_ and active_ point into slots_
  Foot& operator=(const Foot&) = delete;
  void prepare(double sample_rate); ///< may allocate
  void seed(std::uint64_t value) noexcept;
  void set_shoe(double shoe) noexcept;
  /// Factor on the amplitude of the recipes' rooms; 0: no room.
  void set_room(double factor) noexcept { room_factor_ = factor > 0 ? factor : 0; }
  /// Weight of the body, N.
  void set_weight(double weight_n) noexcept;
  /// Sets the two grounds. A ground whose id is in use keeps its sound. mix 0: only a, 1: only b.
  void set_grounds(std::uint64_t a_id, const Recipe& a, std::uint64_t b_id, const Recipe& b,
                   double mix) noexcept;
  void set_mix(double mix) noexcept;
  ActuatorSignals& drive() noexcept { return drive_; }
  void reset() noexcept;

  struct Out {
    double pressure_pa = 0, heel_drive = 0, ball_drive = 0;
  };
  Out next(const SoleState& sole) noexcept;

private:
  static constexpr std::size_t kGrounds = 4;
  /// Vibration and pressure of the grounds, and the input of the room.
  struct Sum {
    double heel_vibration = 0, ball_vibration = 0, pressure_pa = 0, reverb_send = 0;
    void add(const Sum& other, double gain) noexcept {
      heel_vibration += gain * other.heel_vibration;
      ball_vibration += gain * other.ball_vibration;
      pressure_pa += gain * other.pressure_pa;
      reverb_send += gain * other.reverb_send;
    }
  };
  struct GroundSlot {
    Ground ground;
    Recipe recipe;
    double reverb_send = 0;      ///< amplitude of the room
    std::uint64_t id = 0;        ///< 0: unused
    double gain = 0, target = 0; ///< gain of the sound: smoothed value and its target
    Sum last;                    ///< its contribution to the last sample
    std::uint64_t since = 0;     ///< clock_ at the last use
  };
  void update_room() noexcept;
  GroundSlot* acquire_slot(std::uint64_t id, const Recipe& recipe, const GroundSlot* keep) noexcept;

  std::array<GroundSlot, kGrounds> slots_;
  std::array<GroundSlot*, kGrounds> active_{}; ///< slots with an id
  std::size_t active_count_ = 0;
  GroundSlot *a_ = nullptr, *b_ = nullptr;
  double mix_ = 0, weight_n_ = 700, shoe_ = 0.4, glide_coefficient_ = 0.001,
         leave_coefficient_ = 0.0001;
  double room_factor_ = 1;
  std::uint64_t clock_ = 0;
  Sum cut_; ///< last sample of the grounds that lost their slots; fades out
  double cut_gain_ = 0, cut_step_ = 0.004;
  ActuatorSignals drive_;
  Room room_;
};

} // namespace tactus::footstep
