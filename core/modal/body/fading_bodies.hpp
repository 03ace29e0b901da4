#pragma once

#include "core/modal/body/model_handover.hpp"
#include "core/modal/body/output_stage.hpp"
#include "core/modal/body/recording_voices.hpp"

#include <array>
#include <cstddef>

namespace tactus::modal {

/// Earlier bodies, kept until the last of their sound has reached the listeners.
class FadingBodies {
public:
  /// Allocates, and drops all earlier bodies.
  void prepare(double sample_rate);
  /// Lets modes without a successor, which fade out in the old model's bank, sound through the
  /// delay lines of the present body.
  void fade_unmatched(const ModelHandover::Use& before) noexcept;
  /// Lets an exchanged body ring separately while it fades out. Its direct sound and delay lines
  /// are taken and replaced by cleared ones.
  void fade_out(const ModelHandover::Use& before, const RecordingVoices& recordings,
                DirectSound& direct, DelayLines& delay) noexcept;
  /// Add the sounds before and after the delay lines of the present body.
  void add_before_delay(ChannelBlock& output, std::size_t listeners, std::size_t frames) noexcept;
  void add_after_delay(ChannelBlock& output, std::size_t listeners, std::size_t frames) noexcept;

private:
  struct FadingBody {
    ModelHandover::Use model;
    DelayLines delay{};
    RecordingVoices recordings;
    DirectSound direct;
    std::size_t left = 0;      ///< samples
    bool before_delay = false; ///< it sounds through the delay lines of the present body
  };
  FadingBody& free_entry() noexcept;
  void ring(BodyModel& model, std::size_t frames) noexcept;
  static void count_down(FadingBody& body, std::size_t frames) noexcept;

  std::array<FadingBody, 3> bodies_;
  ChannelBlock sound_{}; ///< sound of one body
};

} // namespace tactus::modal
