#include "core/modal/contact_solver.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::modal {
namespace {

constexpr double kStepsPerContact = 32; // error of the rebound below 0.1 %
constexpr double kMostLedSteps = 4;     // a hand's contact lasts: it is followed less finely
constexpr int kMostRounds = 40;
constexpr double kLongestFlight = 0.05; // s that a striker is followed after it has let go
constexpr std::size_t kWays = 8;        // sums that run side by side

/// Always in the same order, whatever the compiler makes of it.
double sum_of_products(const double* a, const double* b, std::size_t count) noexcept {
  std::array<double, kWays> sum{};
  std::size_t i = 0;
  for (; i + kWays <= count; i += kWays)
    for (std::size_t w = 0; w < kWays; ++w)
      sum[w] += a[i + w] * b[i + w];
  for (; i < count; ++i)
    sum[i % kWays] += a[i] * b[i];
  return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
}

} // namespace

ContactSolver::ContactSolver(std::span<const std::complex<double>> rate, double sample_rate,
                             std::size_t contacts, bool rigid)
    : sample_rate_(sample_rate), has_rigid_(rigid), alpha_(rate.size()), omega_(rate.size()),
      finest_real_(rate.size()), finest_imaginary_(rate.size()), step_real_(rate.size()),
      step_imaginary_(rate.size()), push_real_(rate.size()), push_imaginary_(rate.size()),
      real_(rate.size(), 0), imaginary_(rate.size(), 0), contacts_(contacts), slots_(contacts),
      answer_(contacts * contacts, 0), free_(contacts, 0), force_(contacts, 0),
      next_force_(contacts, 0), touching_(contacts, 0) {
  for (std::size_t k = 0; k < rate.size(); ++k) {
    alpha_[k] = -rate[k].real();
    omega_[k] = rate[k].imag();
    const auto finest = std::exp(rate[k] * (1 / (sample_rate * kMostSteps)));
    finest_real_[k] = finest.real();
    finest_imaginary_[k] = finest.imag();
  }
  for (Slot& slot : slots_) {
    slot.gain.assign(rate.size(), 0);
    slot.place_gain.assign(rate.size(), 0);
  }
  choose_steps(1);
}

void ContactSolver::choose_steps(double wanted) noexcept {
  unsigned steps = 1;
  while (steps < kMostSteps && steps < wanted)
    steps *= 2;
  if (steps == steps_)
    return;
  steps_ = steps;
  std::copy(finest_real_.begin(), finest_real_.end(), step_real_.begin());
  std::copy(finest_imaginary_.begin(), finest_imaginary_.end(), step_imaginary_.begin());
  for (unsigned s = steps; s < kMostSteps; s *= 2)
    for (std::size_t k = 0; k < step_real_.size(); ++k) {
      const double re = step_real_[k], im = step_imaginary_[k];
      step_real_[k] = re * re - im * im;
      step_imaginary_[k] = 2 * re * im;
    }
  for (std::size_t k = 0; k < step_real_.size(); ++k) { // divided by s = -alpha + j omega
    const double re = step_real_[k] - 1, im = step_imaginary_[k];
    const double square = alpha_[k] * alpha_[k] + omega_[k] * omega_[k];
    push_real_[k] = (im * omega_[k] - re * alpha_[k]) / square;
    push_imaginary_[k] = -(re * omega_[k] + im * alpha_[k]) / square;
  }
  work_out_answers();
}

void ContactSolver::work_out_answers() noexcept {
  const double h = 1 / (sample_rate_ * steps_);
  const std::size_t count = contacts_.size();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j) {
      if (!contacts_[i].active || !contacts_[j].active)
        continue;
      double sum = 0;
      for (std::size_t k = 0; k < real_.size(); ++k)
        sum += slots_[i].place_gain[k] * slots_[j].gain[k] * push_imaginary_[k];
      if (has_rigid_)
        for (std::size_t r = 0; r < kRigid; ++r)
          sum += slots_[i].rigid[r] * slots_[j].rigid[r] * h * h / 2;
      if (i == j && !contacts_[i].led)
        sum += h * h / 2 / contacts_[i].striker_mass_kg;
      answer_[i * count + j] = sum;
    }
}

void ContactSolver::begin(std::size_t slot, const Contact& contact, std::span<const double> gain,
                          const std::array<double, kRigid>& rigid_gain) noexcept {
  if (slot >= slots_.size())
    return;
  end(slot);
  Slot& s = slots_[slot];
  s.mobility = contact.led ? 0 : 1 / contact.striker_mass_kg;
  for (std::size_t k = 0; k < s.gain.size(); ++k) {
    s.gain[k] = k < gain.size() ? gain[k] : 0;
    s.place_gain[k] = s.gain[k] / omega_[k];
    s.mobility += s.gain[k] * s.gain[k];
  }
  s.rigid = rigid_gain;
  if (has_rigid_)
    for (const double b : rigid_gain)
      s.mobility += b * b;
  if (active_count_ == 0)
    rest_rigid();
  contacts_[slot] = contact;
  contacts_[slot].active = true;
  // No contact begins with work stored in it.
  const double surface = surface_place(slot);
  contacts_[slot].place_m =
      contact.led ? std::min(contact.place_m, surface) : contact.place_m + surface;
  ++active_count_;
  contacts_[slot].compression_m = contacts_[slot].place_m - surface;
  double wanted = active_count_ > 1 ? steps_ : 1;
  if (!contact.led && contact.speed_m_per_s > 0) {
    const double time = contact.law.duration(1 / s.mobility, contact.speed_m_per_s);
    wanted = std::max(wanted, kStepsPerContact / (time * sample_rate_));
  }
  choose_steps(wanted);
  work_out_answers();
}

void ContactSolver::end(std::size_t slot) noexcept {
  if (slot >= contacts_.size() || !contacts_[slot].active)
    return;
  contacts_[slot].active = false;
  --active_count_;
}

void ContactSolver::lead(std::size_t slot, double place_m, double fastest_m_per_s) noexcept {
  if (slot >= contacts_.size() || !contacts_[slot].active)
    return;
  Contact& c = contacts_[slot];
  c.speed_m_per_s =
      std::clamp((place_m - c.place_m) * sample_rate_, -fastest_m_per_s, fastest_m_per_s);
}

void ContactSolver::silence() noexcept {
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    end(i);
  std::fill(real_.begin(), real_.end(), 0.0);
  std::fill(imaginary_.begin(), imaginary_.end(), 0.0);
  rest_rigid();
}

double ContactSolver::surface_place(std::size_t slot) const noexcept {
  const Slot& s = slots_[slot];
  double sum = sum_of_products(s.place_gain.data(), imaginary_.data(), imaginary_.size());
  if (has_rigid_)
    for (std::size_t r = 0; r < kRigid; ++r)
      sum += s.rigid[r] * rigid_place_[r];
  return sum;
}

double ContactSolver::elastic(const Contact& c, double depth) const noexcept {
  if (!(c.compliance_m_per_n > 0) || !(depth > 0))
    return c.law.force(depth, 0);
  // In series with the modes left out: depth = d + C f(d). The right side grows with d and bends
  // upwards, so Newton's method from above always arrives.
  double d = depth;
  for (int i = 0; i < kMostRounds; ++i) {
    const double over = d + c.compliance_m_per_n * c.law.force(d, 0) - depth;
    const double next = std::max(d - over / (1 + c.compliance_m_per_n * c.law.slope(d)), 0.0);
    if (!(std::abs(next - d) > 1e-12 * depth))
      break;
    d = next;
  }
  return (depth - d) / c.compliance_m_per_n;
}

double ContactSolver::stored(const Contact& c, double depth) const noexcept {
  if (!(c.compliance_m_per_n > 0))
    return c.law.work(depth);
  const double force = elastic(c, depth);
  return c.law.work(depth - c.compliance_m_per_n * force) +
         0.5 * c.compliance_m_per_n * force * force;
}

double ContactSolver::solve(const Contact& c, double free, double answer, double h,
                            double& force) const noexcept {
  const double start = c.compression_m;
  if (start <= 0 && free <= 0) {
    force = 0;
    return free;
  }
  const double before = stored(c, start);
  const auto mean_force = [&](double d) {
    const double way = d - start;
    const double size = std::max(std::abs(start), std::abs(d));
    double f = std::abs(way) > 1e-4 * size ? (stored(c, d) - before) / way
                                           : elastic(c, 0.5 * (start + d));
    f *= 1 + c.law.loss_s_per_m * way / h;
    return std::max(f, 0.0);
  };
  // d + answer F(d) = free; the force grows with d, so the root lies between where full force and
  // no force would lead. Secants, kept within the bracket.
  double high = free, high_force = mean_force(high);
  if (high_force == 0) {
    force = 0;
    return free;
  }
  double high_error = answer * high_force;
  double low = free - high_error, low_force = mean_force(low);
  double low_error = low + answer * low_force - free;
  double d = low;
  force = low_force;
  for (int i = 0; i < kMostRounds && high_error - low_error > 0; ++i) {
    d = low - low_error * (high - low) / (high_error - low_error);
    force = mean_force(d);
    const double error = d + answer * force - free;
    if (std::abs(error) <= 1e-11 * (std::abs(d) + std::abs(start)) + 1e-30)
      break;
    if (error > 0) {
      high = d;
      high_error = error;
      low_error *= 0.5; // Illinois: the end that stays loses weight, so that both close in
    } else {
      low = d;
      low_error = error;
      high_error *= 0.5;
    }
  }
  return d;
}

void ContactSolver::substep(double h) noexcept {
  const std::size_t modes = real_.size(), count = contacts_.size();
  // These arrays do not overlap, which a compiler cannot know.
  double* __restrict real = real_.data();
  double* __restrict imaginary = imaginary_.data();
  const double* __restrict turn_real = step_real_.data();
  const double* __restrict turn_imaginary = step_imaginary_.data();
  for (std::size_t k = 0; k < modes; ++k) {
    const double re = real[k], im = imaginary[k];
    real[k] = turn_real[k] * re - turn_imaginary[k] * im;
    imaginary[k] = turn_real[k] * im + turn_imaginary[k] * re;
  }
  for (std::size_t r = 0; r < kRigid; ++r)
    rigid_place_[r] += h * rigid_speed_[r];
  std::size_t touching = 0;
  for (std::size_t i = 0; i < count; ++i) {
    Contact& c = contacts_[i];
    if (!c.active)
      continue;
    c.place_m += h * c.speed_m_per_s;
    c.age_s += h;
    free_[i] = c.place_m - surface_place(i);
    touching_[touching++] = i;
    force_[i] = 0;
  }
  // One contact needs one round. Several answer each other: rounds over all of them from the same
  // forces, until these stay.
  for (int round = 0; round < (touching > 1 ? kMostRounds : 1); ++round) {
    double change = 0, largest = 0;
    for (std::size_t a = 0; a < touching; ++a) {
      const std::size_t i = touching_[a];
      double free = free_[i];
      for (std::size_t b = 0; b < touching; ++b)
        if (b != a)
          free -= answer_[i * count + touching_[b]] * force_[touching_[b]];
      static_cast<void>(solve(contacts_[i], free, answer_[i * count + i], h, next_force_[i]));
      change = std::max(change, std::abs(next_force_[i] - force_[i]));
      largest = std::max(largest, next_force_[i]);
    }
    for (std::size_t a = 0; a < touching; ++a)
      force_[touching_[a]] = next_force_[touching_[a]];
    if (change <= 1e-12 * largest)
      break;
  }
  for (std::size_t a = 0; a < touching; ++a) {
    const std::size_t i = touching_[a];
    Contact& c = contacts_[i];
    c.compression_m = free_[i];
    for (std::size_t b = 0; b < touching; ++b)
      c.compression_m -= answer_[i * count + touching_[b]] * force_[touching_[b]];
  }
  for (std::size_t a = 0; a < touching; ++a) {
    const std::size_t i = touching_[a];
    const double force = force_[i];
    if (force == 0)
      continue;
    Contact& c = contacts_[i];
    c.force_n += force;
    const double* __restrict gain = slots_[i].gain.data();
    const double* __restrict push_real = push_real_.data();
    const double* __restrict push_imaginary = push_imaginary_.data();
    for (std::size_t k = 0; k < modes; ++k) {
      const double push = gain[k] * force;
      real[k] += push * push_real[k];
      imaginary[k] += push * push_imaginary[k];
    }
    if (has_rigid_)
      for (std::size_t r = 0; r < kRigid; ++r) {
        rigid_place_[r] += slots_[i].rigid[r] * force * h * h / 2;
        rigid_speed_[r] += slots_[i].rigid[r] * force * h;
      }
    if (!c.led) {
      c.place_m -= force * h * h / 2 / c.striker_mass_kg;
      c.speed_m_per_s -= force * h / c.striker_mass_kg;
    }
  }
}

double ContactSolver::step() noexcept {
  // A contact that stiffens as it is pressed in is followed in shorter steps.
  double wanted = steps_;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    Contact& c = contacts_[i];
    c.force_n = 0;
    if (!c.active)
      continue;
    const double rate = std::sqrt(c.law.slope(c.compression_m) * slots_[i].mobility * 5);
    wanted = std::max(wanted, std::min(rate / sample_rate_, c.led ? kMostLedSteps : double{kMostSteps}));
  }
  choose_steps(wanted);
  const double h = 1 / (sample_rate_ * steps_);
  for (unsigned s = 0; s < steps_; ++s)
    substep(h);
  double force = 0;
  for (Contact& c : contacts_) {
    c.force_n /= steps_;
    force += c.force_n;
  }
  look_for_ends();
  if (active_count_ == 0)
    choose_steps(1);
  return force;
}

void ContactSolver::look_for_ends() noexcept {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    Contact& c = contacts_[i];
    if (!c.active || c.led || c.compression_m > 0 || c.force_n > 0)
      continue;
    // It has let go. It meets the surface again only if that can still catch up with it: no point
    // moves further or faster than all modes together.
    double place = 0, speed = 0, drift = 0;
    const Slot& s = slots_[i];
    for (std::size_t k = 0; k < real_.size(); ++k) {
      const double size = std::sqrt(real_[k] * real_[k] + imaginary_[k] * imaginary_[k]);
      place += std::abs(s.place_gain[k]) * size;
      speed += std::abs(s.gain[k]) * size;
    }
    double base = 0;
    if (has_rigid_)
      for (std::size_t r = 0; r < kRigid; ++r) {
        base += s.rigid[r] * rigid_place_[r];
        drift += s.rigid[r] * rigid_speed_[r];
      }
    const double away = drift - c.speed_m_per_s;
    if (away > speed || (away >= 0 && base - c.place_m > place) || c.age_s > kLongestFlight)
      end(i);
  }
}

void ContactSolver::kick(std::span<const float> gain, double impulse) noexcept {
  for (std::size_t k = 0; k < std::min(gain.size(), real_.size()); ++k)
    real_[k] += static_cast<double>(gain[k]) * impulse;
}

double ContactSolver::hear(std::span<const std::complex<double>> weight) const noexcept {
  std::array<double, kWays> sum{};
  const std::size_t count = std::min(weight.size(), real_.size());
  std::size_t k = 0;
  for (; k + kWays <= count; k += kWays)
    for (std::size_t w = 0; w < kWays; ++w)
      sum[w] += weight[k + w].real() * imaginary_[k + w] + weight[k + w].imag() * real_[k + w];
  for (; k < count; ++k)
    sum[k % kWays] += weight[k].real() * imaginary_[k] + weight[k].imag() * real_[k];
  return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
}

double ContactSolver::energy() const noexcept {
  double sum = 0;
  for (std::size_t k = 0; k < real_.size(); ++k) {
    const double q = imaginary_[k] / omega_[k];
    const double speed = real_[k] - alpha_[k] * q;
    const double stiffness = omega_[k] * omega_[k] + alpha_[k] * alpha_[k];
    sum += 0.5 * (speed * speed + stiffness * q * q);
  }
  for (const double speed : rigid_speed_)
    sum += 0.5 * speed * speed;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& c = contacts_[i];
    if (c.led || c.age_s == 0)
      continue;
    sum += 0.5 * c.striker_mass_kg * c.speed_m_per_s * c.speed_m_per_s;
    if (c.active)
      sum += stored(c, c.place_m - surface_place(i));
  }
  return sum;
}

} // namespace tactus::modal
