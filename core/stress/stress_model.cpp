#include "core/stress/stress_model.hpp"

#include "core/dsp/elementary.hpp"

#include <cmath>
#include <utility>

namespace tactus::stress {

StressModel::StressModel(std::shared_ptr<const StressTable> table) : table_(std::move(table)) {
  terms_.reserve(table_->parameters.size());
  moves_m_.resize(table_->control_point_m.size());
  prepare();
}

const StressField& StressModel::field(const StressBase& base) const noexcept {
  return settings_.state == State::kShear && table_->has_shear() ? base.max_shear : base.von_mises;
}

void StressModel::compute_weighting(const StressField& field, Weighting& weighting) const {
  weighting = {};
  if (settings_.mapping == Mapping::kMean)
    return;
  const std::size_t count = table_->elements();
  const auto row = [&](std::size_t p) { return field.sensitivity.data() + p * count; };
  const auto& parameters = table_->parameters;
  if (control_point_) {
    for (std::size_t p = 0; p < parameters.size(); ++p)
      if (parameters[p].control_point == *control_point_)
        weighting.h[static_cast<std::size_t>(parameters[p].axis)] = row(p);
    return;
  }
  std::vector<bool> movable(table_->control_point_m.size());
  for (const DesignParameter& parameter : parameters)
    movable[parameter.control_point] = true;
  const auto points = static_cast<double>(std::count(movable.begin(), movable.end(), true));
  std::vector<double> sum(count);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::fill(sum.begin(), sum.end(), 0.0);
    for (std::size_t p = 0; p < parameters.size(); ++p)
      if (parameters[p].axis == static_cast<int>(axis))
        for (std::size_t i = 0; i < count; ++i) {
          const double value = row(p)[i];
          sum[i] += settings_.sensitivity == Sensitivity::kAbsolute ? std::abs(value) : value;
        }
    auto& mean = weighting.mean[axis];
    mean.resize(count);
    for (std::size_t i = 0; i < count; ++i)
      mean[i] = static_cast<float>(sum[i] / points);
    weighting.h[axis] = mean.data();
  }
}

FeedbackTask StressModel::task(const StressField& field,
                               const Weighting& weighting) const noexcept {
  FeedbackTask task;
  task.stress = field.stress;
  if (settings_.weights == Weights::kVolume && !table_->weight.empty())
    task.weight = table_->weight.data();
  task.h = weighting.h;
  task.absolute = settings_.sensitivity == Sensitivity::kAbsolute;
  task.mapping = settings_.mapping;
  return task;
}

void StressModel::prepare() {
  compute_weighting(field(base()), weighting_);
  Weighting first;
  const StressField& own = field(table_->base);
  if (base_)
    compute_weighting(own, first);
  const FeedbackTask at_rest = task(own, base_ ? first : weighting_);
  initial_ = feedback_kernel()->run(at_rest);
  scale_pa_ = initial_.stress.max > 0 ? initial_.stress.max : 1;
  weight_sum_ = static_cast<double>(table_->elements());
  if (at_rest.weight) {
    weight_sum_ = 0;
    for (const float w : table_->weight)
      weight_sum_ += static_cast<double>(w);
  }
}

void StressModel::select(const FeedbackSettings& settings,
                         std::optional<std::size_t> control_point) {
  settings_ = settings;
  control_point_ = control_point;
  prepare();
}

void StressModel::rebase(std::shared_ptr<const StressBase> base) {
  base_ = std::move(base);
  prepare();
}

double StressModel::share() const noexcept {
  const double mean = 1 / weight_sum_;
  return settings_.norm == Norm::kSum ? mean * static_cast<double>(table_->elements()) : mean;
}

double StressModel::distance_m(std::span<const double> a, std::span<const double> b) noexcept {
  std::fill(moves_m_.begin(), moves_m_.end(), Vec3{});
  for (std::size_t p = 0; p < table_->parameters.size(); ++p) {
    const DesignParameter& parameter = table_->parameters[p];
    moves_m_[parameter.control_point][parameter.axis] = a[p] - b[p];
  }
  double longest = 0;
  for (const Vec3& move : moves_m_)
    longest = std::max(longest, norm(move));
  return longest;
}

void StressModel::stress_of(std::span<const std::size_t> elements,
                            std::span<const double> displacement_m,
                            std::span<double> stress_pa) const noexcept {
  const StressField& stress = field(base());
  const std::size_t count = table_->elements();
  for (std::size_t i = 0; i < elements.size(); ++i)
    stress_pa[i] = static_cast<double>(stress.stress[elements[i]]);
  for (std::size_t p = 0; p < table_->parameters.size(); ++p) {
    const double move = displacement_m[p] - base().displacement_m[p];
    if (move == 0 || !std::isfinite(move))
      continue;
    const float* row = stress.sensitivity.data() + p * count;
    for (std::size_t i = 0; i < elements.size(); ++i)
      stress_pa[i] += static_cast<double>(row[elements[i]]) * move;
  }
}

const Feedback& StressModel::update(std::span<const double> displacement_m) noexcept {
  const StressField& stress = field(base());
  const std::size_t count = table_->elements();
  terms_.clear();
  for (std::size_t p = 0; p < table_->parameters.size(); ++p)
    if (const double move = displacement_m[p] - base().displacement_m[p];
        move != 0 && std::isfinite(move))
      terms_.push_back({stress.sensitivity.data() + p * count, move});
  FeedbackTask now = task(stress, weighting_);
  now.terms = terms_;
  now.power = settings_.power;
  now.scale_pa = scale_pa_;
  const FeedbackSums found = feedback_kernel()->run(now);
  for (int axis = 0; axis < 3; ++axis) {
    const auto of = [&](const FeedbackSums& sums) -> const Extremes& {
      if (settings_.mapping == Mapping::kMean)
        return sums.stress;
      return sums.product[settings_.mapping == Mapping::kAxis ? static_cast<std::size_t>(axis) : 0];
    };
    const Extremes& range = of(settings_.range == Range::kInitial ? initial_ : found);
    const bool fixed = settings_.range == Range::kFixed;
    feedback_.raw[axis] = of(found).sum * share();
    if (settings_.mapping == Mapping::kMean && settings_.power > 1)
      feedback_.raw[axis] = scale_pa_ * math::pow(found.power.sum * share(), 1.0 / settings_.power);
    feedback_.min[axis] = fixed ? settings_.fixed_min : range.min;
    feedback_.max[axis] = fixed ? settings_.fixed_max : range.max;
    feedback_.gamma[axis] = gamma_of(feedback_.raw[axis], feedback_.min[axis], feedback_.max[axis]);
  }
  feedback_.mean_pa = found.stress.sum / weight_sum_;
  feedback_.peak_pa = found.stress.max;
  feedback_.trust_ratio = distance_m(displacement_m, base().displacement_m) / table_->trust_m;
  return feedback_;
}

} // namespace tactus::stress
