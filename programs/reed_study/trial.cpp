#include "programs/reed_study/trial.hpp"

#include <bitset>
#include <cmath>
#include <span>

namespace tactus::study {
namespace {

constexpr std::size_t kRate = 48000;
// In samples: the servo's period, the patch's block, and the step that divides both and 32.
constexpr std::size_t kTick = 48, kBlock = 64, kStep = 16;
constexpr double kTick_s = static_cast<double>(kTick) / kRate;
constexpr double kBlock_s = static_cast<double>(kBlock) / kRate;
constexpr std::size_t kGrid = 10;

/// A random position, uniform over the silent positions.
reed::Gradient random_silent_position(const World& world, std::uint64_t seed) {
  Random random(seed);
  for (;;) {
    const double y = random.uniform(), z = random.uniform();
    if (world.played.field().value(y, z) < 0.01)
      return {y, z};
  }
}

/// The patch between reeds and device: computes the force from quantities at the hand's position.
class ForceLaw {
public:
  ForceLaw(const World& world, const TrialSettings& settings) : world_(world), settings_(settings) {
    reed::Guidance::Settings guidance;
    guidance.ceiling_n = settings.ceiling_n;
    guidance_.set(guidance);
  }

  Vec3 force(const reed::ReedGradient& reeds, double y, double z) noexcept {
    reed::PlaneForce force;
    switch (settings_.feel) {
    case Feel::kOff:
      break;
    case Feel::kReeds:
      force = slope_force(reeds.gradient());
      break;
    case Feel::kGrowth:
      force = slope_force(world_.growth.gradient(y, z));
      break;
    case Feel::kHeight:
      force = slope_force(world_.theory.height().gradient(y, z));
      break;
    case Feel::kGuidance:
      force = guidance_.advance(world_.guidance, y, z, reeds.playability(), kBlock_s);
      break;
    }
    return {0, force.y, force.z};
  }

private:
  reed::PlaneForce slope_force(const reed::Gradient& slope) noexcept {
    return smoother_.advance(gradient_force(slope, settings_.gain_n, settings_.ceiling_n),
                             kBlock_s);
  }

  const World& world_;
  const TrialSettings& settings_;
  reed::ForceSmoother smoother_;
  reed::Guidance guidance_;
};

/// Statistics collected while a trial runs.
class TrialStatistics {
public:
  void add_block(double y, double z, double playability, double force_n) {
    const bool sounding = playability > kPlays;
    ++blocks_;
    if (sounding) {
      ++playing_blocks_;
      playing_force_ += force_n;
      const auto square = [](double x) {
        return std::min(static_cast<std::size_t>(x * kGrid), kGrid - 1);
      };
      played_cells_.set(square(y) * kGrid + square(z));
    }
    silent_ += note_sounds_ ? 0 : 1;
    changed_ = sounding == note_sounds_ ? 0 : changed_ + 1;
    if (static_cast<double>(changed_) * kBlock_s < kMinDuration_s)
      return;
    note_sounds_ = sounding;
    changed_ = 0;
    if (!sounding)
      ++losses_;
    else if (++found_ == 1)
      first_s_ = static_cast<double>(blocks_) * kBlock_s - kMinDuration_s;
  }
  void feel(double force_n, double speed_m_per_s) {
    ++ticks_;
    force_ += force_n;
    speed_ += speed_m_per_s;
  }
  [[nodiscard]] TrialResult result(double duration_s) const {
    const auto count = [](std::size_t n) { return static_cast<double>(n); };
    TrialResult r;
    r.playing = count(playing_blocks_) / count(blocks_);
    r.losses = losses_;
    r.first_s = found_ > 0 ? first_s_ : duration_s;
    r.silence_s = count(silent_) * kBlock_s / count(note_sounds_ ? found_ : found_ + 1);
    r.force_n = force_ / count(ticks_);
    r.playing_force_n = playing_blocks_ > 0 ? playing_force_ / count(playing_blocks_) : 0;
    r.speed_m_per_s = speed_ / count(ticks_);
    r.played_cells = static_cast<int>(played_cells_.count());
    return r;
  }

private:
  std::size_t blocks_ = 0, playing_blocks_ = 0, silent_ = 0, changed_ = 0, found_ = 0, ticks_ = 0;
  int losses_ = 0;
  bool note_sounds_ = false;
  double first_s_ = 0, force_ = 0, playing_force_ = 0, speed_ = 0;
  std::bitset<kGrid * kGrid> played_cells_;
};

} // namespace

World::World(const reed::Parameters& given, const reed::ControlRange& plane)
    : parameters(given), range(plane) {
  constexpr std::size_t kPlayedNodes = 81, kNodes = reed::ReedGradient::kGrowthNodes;
  reed::PlayabilityMapSettings settings;
  settings.parameters = given;
  settings.range = plane;
  played.begin(settings, kPlayedNodes, kPlayedNodes);
  for (std::size_t n = 0; n < played.size();)
    n = played.advance(n);
  theory.prepare(kNodes, kNodes);
  theory.begin({reed::clamped(given), played.length()}, plane);
  (void)theory.advance(kNodes * kNodes);
  growth.resize(kNodes, kNodes);
  for (std::size_t k = 0; k < kNodes; ++k)
    for (std::size_t i = 0; i < kNodes; ++i)
      growth.node(i, k) = std::tanh(theory.growth().node(i, k) / 50);
  growth.differentiate();
  guidance.build(theory.height(), reed::Guidance::kQuickGrowth);
}

TrialResult run(const World& world, const TrialSettings& settings, std::vector<Sample>* trace) {
  // The person, the start and the search have unrelated random streams.
  Explorer explorer(settings.exploration, 3 * settings.seed + 1);
  haptic::SimulatedDevice::Settings handle;
  handle.hand = explorer.hand_settings(settings.hand);
  handle.hand.seed = 3 * settings.seed;
  haptic::SimulatedDevice device;
  device.set(handle);
  const haptic::Workspace& box = handle.workspace;
  const reed::Gradient start = random_silent_position(world, 3 * settings.seed + 2);
  explorer.begin(device,
                 {0, box.min.y + start.y * (box.max.y - box.min.y),
                  box.min.z + start.z * (box.max.z - box.min.z)},
                 kTick_s);

  haptic::ChainSettings limits;
  limits.workspace = box;
  limits.allowance_w = 0.05; // [phantom]'s default
  haptic::ChainState chain;
  reed::ReedGradient reeds;
  reeds.prepare(kRate);
  reeds.set(world.parameters);
  reeds.set_range(world.range);
  ForceLaw law(world, settings);

  TrialStatistics statistics;
  Vec3 hand_position{0, start.y, start.z}, force;
  std::array<double, kStep> sound{};
  const auto samples = static_cast<std::size_t>(settings.duration_s * kRate);
  for (std::size_t n = 0; n < samples; n += kStep) {
    const double time_s = static_cast<double>(n) / kRate;
    if (n % kTick == 0) {
      explorer.advance(device, time_s);
      haptic::State state;
      (void)device.read({n / kTick, time_s, kTick_s}, state);
      force = step(chain, limits, {time_s, time_s, state.position, state.velocity, {}});
      (void)device.write(force);
      hand_position = box.normalised(state.position);
      statistics.feel(norm(force), norm(state.velocity));
    }
    if (reeds.samples_until_hand() == 0)
      reeds.move(hand_position.y, hand_position.z, 0);
    reeds.process(sound);
    if ((n + kStep) % kBlock != 0)
      continue;
    if (settings.feel != Feel::kOff)
      (void)command(chain, limits, law.force(reeds, hand_position.y, hand_position.z), time_s);
    statistics.add_block(hand_position.y, hand_position.z, reeds.playability(), norm(force));
    if (trace != nullptr && (n + kStep) % (kRate / 100) < kBlock)
      trace->push_back(
          {time_s, hand_position.y, hand_position.z, reeds.playability(), force.y, force.z});
  }
  return statistics.result(settings.duration_s);
}

} // namespace tactus::study
