#include "core/modal/body/struck_body.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactus::modal {

void StruckBody::prepare(double sample_rate) {
  if (sample_rate == sample_rate_ && prepared_)
    return;
  sample_rate_ = sample_rate;
  prepared_ = true;
  schedule_.expire_all();
  direct_.prepare(sample_rate);
  hand_.prepare(sample_rate);
  output_.prepare(sample_rate);
  if (model_)
    output_.set_delays(*model_, false, true);
  fading_.prepare(sample_rate);
}

void StruckBody::set_options(const Options& options) noexcept {
  options_ = options;
  output_.set_gain(options.gain);
  rub_.set_seed(options.seed);
}

bool StruckBody::hit(const Hit& hit) noexcept {
  apply(Strike{hit, striker_});
  return model_ && hit.speed_m_per_s > 0;
}

void StruckBody::apply(const Event& event) noexcept {
  std::visit([this](const auto& what) { carry_out(what); }, event);
}

void StruckBody::schedule(const Event& event, std::int64_t sample) noexcept {
  if (schedule_.full())
    apply(schedule_.pop());
  schedule_.push(event, sample);
}

SurfacePoint StruckBody::point() const noexcept {
  const ForcePoint* const last = schedule_.last<ForcePoint>();
  return last ? last->point : point_.point;
}

Rub StruckBody::rub() const noexcept {
  const Rub* const last = schedule_.last<Rub>();
  return last ? *last : rub_.rub();
}

void StruckBody::carry_out(const Strike& strike) noexcept {
  if (model_ && strike.hit.speed_m_per_s > 0)
    strikers_.strike(strike, options_.coupled, options_.cull_db, *model_, direct_);
}

void StruckBody::carry_out(const ForcePoint& point) noexcept {
  point_ = point;
  point_set_ = true;
  if (model_)
    model_->solver.end(model_->hand_slot()); // a hand begins a new contact at the new point
  update_force_point();
}

void StruckBody::carry_out(const Reset& /*reset*/) noexcept {
  strikers_.pulses().end_all();
  strikers_.recordings().release();
  strikers_.drop_contacts();
  if (!model_)
    return;
  leave_contact();
  model_->bank.release();
}

void StruckBody::leave_contact() noexcept {
  if (!model_ || !model_->in_solver)
    return;
  model_->leave_contact(options_.gain, options_.cull_db);
  strikers_.end_contacts();
}

void StruckBody::update_force_point() noexcept {
  if (!model_)
    return;
  model_->set_force_point(point_);
  direct_.set_point(point_);
}

std::size_t StruckBody::contacts() const noexcept {
  std::size_t count = strikers_.pulses().count();
  if (model_)
    for (std::size_t i = 0; i <= model_->rub_slot(); ++i)
      count += model_->solver.contact(i).active ? 1 : 0;
  return count;
}

std::vector<double> StruckBody::levels(std::size_t limit) {
  std::vector<std::pair<double, double>> found;
  if (!model_)
    return {};
  model_->bank.flush_pending();
  for (std::size_t k = 0; k < model_->audible_modes; ++k) {
    const double output = model_->loudest_weight(k);
    const double size =
        math::abs(model_->in_solver ? model_->solver.state(k) : model_->bank.state(k));
    found.emplace_back(math::abs(model_->rate[k]),
                       std::max(20 * math::log10(size * output * options_.gain + 1e-12), -120.0));
  }
  std::sort(found.begin(), found.end());
  std::vector<double> levels;
  for (std::size_t k = 0; k < std::min(limit, found.size()); ++k)
    levels.push_back(found[k].second);
  return levels;
}

} // namespace tactus::modal
