#include "core/reed/playability/playability.hpp"

#include <utility>

namespace tactus::reed {
namespace {

// Silence begins and ends at these shares of the reference amplitude.
constexpr double kSilenceBegins = 0.01, kSilenceEnds = 0.02;
constexpr double kPeriodic = 0.985, kQuasiPeriodic = 0.85;

} // namespace

void Playability::prepare(double sample_rate, std::shared_ptr<RealTransform> transform) {
  follower_.prepare(sample_rate);
  analysis_.prepare(sample_rate, std::move(transform));
}

void Playability::set(const PlayabilityParameters& parameters) noexcept {
  follower_.set(parameters);
  choose_analysis();
}

void Playability::set_analysis(bool on) noexcept {
  requested_ = on;
  choose_analysis();
}

void Playability::choose_analysis() noexcept {
  const bool needed =
      requested_ || follower_.parameters().mode == PlayabilityParameters::Mode::kRobust;
  if (needed == analysing_)
    return;
  analysing_ = needed;
  analysis_.reset();
  frames_ = 0;
  regime_ = candidate_ = Regime::kSilent;
}

void Playability::reset() noexcept {
  follower_.reset();
  analysis_.reset();
  sounding_ = false;
  frames_ = 0;
  regime_ = candidate_ = Regime::kSilent;
}

void Playability::tick(double angle) noexcept {
  follower_.tick(angle);
  if (analysing_ && analysis_.tick(angle)) {
    ++frames_;
    update_regime();
  }
}

void Playability::update_regime() noexcept {
  const double level = follower_.envelope() / follower_.parameters().reference_rad;
  sounding_ = level > (sounding_ ? kSilenceBegins : kSilenceEnds);
  const double periodicity = analysis_.result().periodicity;
  Regime found = Regime::kSilent;
  if (sounding_)
    found = periodicity >= kPeriodic        ? Regime::kPeriodic
            : periodicity >= kQuasiPeriodic ? Regime::kQuasiPeriodic
                                            : Regime::kChaotic;
  if (found == candidate_)
    regime_ = found; // a new label needs two frames in succession
  candidate_ = found;
}

double Playability::playability() const noexcept {
  const bool known = analysing_ && frames_ > 0 && sounding_;
  return follower_.playability(0, known ? 1 - analysis_.result().periodicity : 0);
}

} // namespace tactus::reed
