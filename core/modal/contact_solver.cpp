#include "core/modal/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactus::modal {
namespace {

constexpr double kStepsPerContact = 32; // error of the rebound below 0.1 %
constexpr double kMostLedSteps = 4;     // a hand's contact lasts: it is followed less finely
constexpr int kMostRounds = 40;
constexpr double kLongestFlight = 0.05; // s that a striker is followed after it has let go
constexpr std::size_t kMostWork =
    16384; // modes times steps in a sample, so that blows stay in time
constexpr unsigned kLeastSteps = 2;
constexpr double kUnheardOf = 8;   // of the root mean square of many modes' sum
constexpr double kLongestRest = 8; // contact times after which one that has not left lies still

} // namespace

ContactSolver::ContactSolver(std::span<const std::complex<double>> rate, double sample_rate,
                             std::size_t contacts, bool rigid, std::size_t listeners)
    : sample_rate_(sample_rate), has_rigid_(rigid), kernel_(&contact_kernel()), modes_(rate.size()),
      padded_(LaneArray(modes_).padded()), alpha_(modes_, 0), omega_(modes_, 1), finest_(modes_),
      turn_(modes_), push_(modes_), state_(modes_), weights_(listeners, Split(modes_)),
      contacts_(contacts), slots_(contacts), answer_(contacts * contacts, 0), free_(contacts, 0),
      force_(contacts, 0), next_force_(contacts, 0), touching_(contacts, 0) {
  for (std::size_t k = 0; k < modes_; ++k) {
    alpha_[k] = -rate[k].real();
    omega_[k] = rate[k].imag();
    const auto finest = std::exp(rate[k] * (1 / (sample_rate * kMostSteps)));
    finest_.real[k] = finest.real();
    finest_.imaginary[k] = finest.imag();
  }
  for (Slot& slot : slots_) {
    slot.gain = slot.place_gain = LaneArray(modes_);
    slot.push = Split(modes_);
  }
  const double most = kMostLedSteps * sample_rate;
  most_led_rate_ = most * most;
  while (most_steps_ > kLeastSteps && most_steps_ * modes_ > kMostWork)
    most_steps_ /= 2;
  set_steps(1);
}

void ContactSolver::choose_steps(double wanted) noexcept {
  // Coarser only when much coarser will do: a change costs as much as some steps.
  if (wanted <= steps_ && 4 * wanted > steps_)
    return;
  unsigned steps = 1;
  while (steps < most_steps_ && steps < wanted)
    steps *= 2;
  if (steps != steps_)
    set_steps(steps);
}

void ContactSolver::set_steps(unsigned steps) noexcept {
  steps_ = steps;
  std::copy_n(finest_.real.data(), modes_, turn_.real.data());
  std::copy_n(finest_.imaginary.data(), modes_, turn_.imaginary.data());
  for (unsigned s = steps; s < kMostSteps; s *= 2)
    for (std::size_t k = 0; k < modes_; ++k) {
      const double re = turn_.real[k], im = turn_.imaginary[k];
      turn_.real[k] = re * re - im * im;
      turn_.imaginary[k] = 2 * re * im;
    }
  for (std::size_t k = 0; k < modes_; ++k) { // divided by s = -alpha + j omega
    const double re = turn_.real[k] - 1, im = turn_.imaginary[k];
    const double square = alpha_[k] * alpha_[k] + omega_[k] * omega_[k];
    push_.real[k] = (im * omega_[k] - re * alpha_[k]) / square;
    push_.imaginary[k] = -(re * omega_[k] + im * alpha_[k]) / square;
  }
  for (std::size_t i = 0; i < slots_.size(); ++i)
    if (contacts_[i].active)
      work_out_pushes(i);
  work_out_answers();
}

void ContactSolver::work_out_pushes(std::size_t slot) noexcept {
  Slot& s = slots_[slot];
  for (std::size_t k = 0; k < modes_; ++k) {
    s.push.real[k] = s.gain[k] * push_.real[k];
    s.push.imaginary[k] = s.gain[k] * push_.imaginary[k];
  }
}

void ContactSolver::work_out_answers() noexcept {
  const double h = 1 / (sample_rate_ * steps_);
  const std::size_t count = contacts_.size();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j) {
      if (!contacts_[i].active || !contacts_[j].active)
        continue;
      double sum =
          kernel_->sum(slots_[i].place_gain.data(), slots_[j].push.imaginary.data(), padded_);
      if (has_rigid_)
        sum += rigid_at(slots_[i], slots_[j].rigid) * h * h / 2;
      if (i == j && !contacts_[i].led)
        sum += h * h / 2 / contacts_[i].striker_mass_kg;
      answer_[i * count + j] = sum;
    }
}

void ContactSolver::fill(Slot& s, const Contact& contact, std::span<const double> gain,
                         const Rigid& rigid_gain) noexcept {
  s.last_force = 0;
  s.out_of_reach = false;
  s.mobility = contact.led ? 0 : 1 / contact.striker_mass_kg;
  for (std::size_t k = 0; k < modes_; ++k) {
    s.gain[k] = k < gain.size() ? gain[k] : 0;
    s.place_gain[k] = s.gain[k] / omega_[k];
    s.mobility += s.gain[k] * s.gain[k];
  }
  s.rigid = has_rigid_ ? rigid_gain : Rigid{};
  for (const double b : s.rigid)
    s.mobility += b * b;
}

void ContactSolver::begin(std::size_t slot, const Contact& contact, std::span<const double> gain,
                          const Rigid& rigid_gain) noexcept {
  if (slot >= slots_.size())
    return;
  end(slot);
  Slot& s = slots_[slot];
  fill(s, contact, gain, rigid_gain);
  if (active_count_ == 0)
    rest_rigid();
  Contact& c = contacts_[slot] = contact;
  c.active = true;
  c.lies = false;
  ++active_count_;
  // No contact begins with work stored in it.
  const double surface = surface_place(slot);
  c.place_m = contact.led ? std::min(contact.place_m, surface) : contact.place_m + surface;
  c.compression_m = c.place_m - surface;
  s.steps = 1;
  s.patience_s = kLongestFlight;
  if (!contact.led && contact.speed_m_per_s > 0) {
    const double time = contact.law.duration(1 / s.mobility, contact.speed_m_per_s);
    s.steps = kStepsPerContact / (time * sample_rate_);
    s.patience_s =
        std::max(kLongestFlight, kLongestRest * contact.law.duration(contact.striker_mass_kg,
                                                                     contact.speed_m_per_s));
  }
  work_out_pushes(slot);
  work_out_answers();
  choose_steps(wanted_steps());
}

void ContactSolver::take_over(std::size_t slot, const ContactSolver& before, std::size_t old_slot,
                              std::span<const double> gain, const Rigid& rigid_gain) noexcept {
  if (slot >= slots_.size() || old_slot >= before.slots_.size() ||
      !before.contacts_[old_slot].active)
    return;
  end(slot);
  Slot& s = slots_[slot];
  Contact& c = contacts_[slot] = before.contacts_[old_slot];
  fill(s, c, gain, rigid_gain);
  s.steps = before.slots_[old_slot].steps;
  s.patience_s = before.slots_[old_slot].patience_s;
  s.last_force = before.slots_[old_slot].last_force;
  ++active_count_;
  // The shapes have changed, and with them where the surface is: the striker stays on it.
  const double surface = surface_place(slot);
  if (!c.led)
    c.place_m = c.compression_m + surface;
  c.compression_m = c.place_m - surface;
  work_out_pushes(slot);
  work_out_answers();
  choose_steps(wanted_steps());
}

void ContactSolver::take_over_rigid(const ContactSolver& before, double heavier,
                                    double longer) noexcept {
  for (std::size_t r = 0; r < kRigid; ++r) {
    const double scale = std::sqrt(heavier) * (r < kRigid / 2 ? 1 : longer);
    rigid_place_[r] = scale * before.rigid_place_[r];
    rigid_speed_[r] = scale * before.rigid_speed_[r];
  }
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
  std::fill_n(state_.real.data(), modes_, 0.0);
  std::fill_n(state_.imaginary.data(), modes_, 0.0);
  rest_rigid();
}

double ContactSolver::surface_place(std::size_t slot) const noexcept {
  const Slot& s = slots_[slot];
  return kernel_->sum(s.place_gain.data(), state_.imaginary.data(), padded_) +
         rigid_at(s, rigid_place_);
}

/// One step on without forces: where each contact would be.
void ContactSolver::move_freely(double h) noexcept {
  for (std::size_t r = 0; r < kRigid; ++r)
    rigid_place_[r] += h * rigid_speed_[r];
  bool turned = false;
  for (std::size_t a = 0; a < active_count_; ++a) {
    const std::size_t i = touching_[a];
    Contact& c = contacts_[i];
    const Slot& s = slots_[i];
    c.place_m += h * (c.speed_m_per_s + 0.5 * h * c.fall_m_per_s2);
    c.speed_m_per_s += h * c.fall_m_per_s2;
    c.age_s += h;
    const double swing = turned
                             ? kernel_->sum(s.place_gain.data(), state_.imaginary.data(), padded_)
                             : kernel_->turn(state_.view(), std::as_const(turn_).view(),
                                             s.place_gain.data(), padded_);
    turned = true;
    free_[i] = c.place_m - swing - rigid_at(s, rigid_place_);
  }
}

/// One contact needs one round. Several answer each other: rounds over all of them from the same
/// forces, until these stay.
void ContactSolver::find_forces(double h) noexcept {
  const std::size_t count = contacts_.size();
  if (active_count_ == 1) {
    const std::size_t i = touching_[0];
    force_[i] = series(contacts_[i])
                    .solve(contacts_[i].compression_m, free_[i], answer_[i * count + i], h,
                           slots_[i].last_force);
  } else {
    for (std::size_t a = 0; a < active_count_; ++a)
      force_[touching_[a]] = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      double change = 0, largest = 0;
      for (std::size_t a = 0; a < active_count_; ++a) {
        const std::size_t i = touching_[a];
        double free = free_[i];
        for (std::size_t b = 0; b < active_count_; ++b)
          if (b != a)
            free -= answer_[i * count + touching_[b]] * force_[touching_[b]];
        next_force_[i] = series(contacts_[i])
                             .solve(contacts_[i].compression_m, free, answer_[i * count + i], h,
                                    slots_[i].last_force);
        change = std::max(change, std::abs(next_force_[i] - force_[i]));
        largest = std::max(largest, next_force_[i]);
      }
      for (std::size_t a = 0; a < active_count_; ++a)
        force_[touching_[a]] = slots_[touching_[a]].last_force = next_force_[touching_[a]];
      if (change <= 1e-12 * largest)
        break;
    }
  }
  for (std::size_t a = 0; a < active_count_; ++a) {
    const std::size_t i = touching_[a];
    double depth = free_[i];
    for (std::size_t b = 0; b < active_count_; ++b)
      depth -= answer_[i * count + touching_[b]] * force_[touching_[b]];
    contacts_[i].compression_m = depth;
    slots_[i].last_force = force_[i];
  }
}

void ContactSolver::apply_forces(double h) noexcept {
  for (std::size_t a = 0; a < active_count_; ++a) {
    const std::size_t i = touching_[a];
    const double force = force_[i];
    if (force == 0)
      continue;
    Contact& c = contacts_[i];
    const Slot& s = slots_[i];
    c.force_n += force;
    kernel_->push(state_.view(), s.push.view(), force, padded_);
    if (has_rigid_)
      for (std::size_t r = 0; r < kRigid; ++r) {
        rigid_place_[r] += s.rigid[r] * force * h * h / 2;
        rigid_speed_[r] += s.rigid[r] * force * h;
      }
    if (!c.led) {
      c.place_m -= force * h * h / 2 / c.striker_mass_kg;
      c.speed_m_per_s -= force * h / c.striker_mass_kg;
    }
  }
}

double ContactSolver::wanted_steps() const noexcept {
  double wanted = 1, square = 1;
  for (std::size_t a = 0; a < contacts_.size(); ++a) {
    const Contact& c = contacts_[a];
    if (!c.active)
      continue;
    // A contact that stiffens as it is pressed in is followed in shorter steps.
    const double rate = c.law.slope(c.compression_m) * slots_[a].mobility * 5;
    square = std::max(square, c.led ? std::min(rate, most_led_rate_) : rate);
    if (!c.led && !slots_[a].out_of_reach)
      wanted = std::max(wanted, slots_[a].steps);
  }
  const double rate_of_steps = wanted * sample_rate_;
  if (square > rate_of_steps * rate_of_steps)
    wanted = std::sqrt(square) / sample_rate_;
  return std::min(wanted, static_cast<double>(most_steps_));
}

double ContactSolver::step() noexcept {
  std::size_t touching = 0;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    contacts_[i].force_n = 0;
    if (contacts_[i].active)
      touching_[touching++] = i;
  }
  choose_steps(wanted_steps());
  const double h = 1 / (sample_rate_ * steps_);
  for (unsigned s = 0; s < steps_; ++s) {
    move_freely(h);
    find_forces(h);
    apply_forces(h);
  }
  double force = 0;
  for (std::size_t a = 0; a < touching; ++a) {
    Contact& c = contacts_[touching_[a]];
    c.force_n /= steps_;
    force += c.force_n;
  }
  look_for_ends();
  return force;
}

void ContactSolver::look_for_ends() noexcept {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    Contact& c = contacts_[i];
    if (!c.active || c.led)
      continue;
    Slot& s = slots_[i];
    s.out_of_reach = false;
    if (c.compression_m > 0 || c.force_n > 0) {
      c.lies = c.fall_m_per_s2 > 0 && c.age_s > s.patience_s;
      if (c.lies)
        end(i);
      continue;
    }
    // It has let go. It meets the surface again only if that can still catch up with it. No point
    // moves further or faster than all modes together; of many modes, which never meet, no more
    // than kUnheardOf times their root of the mean square.
    double place = 0, speed = 0, place_square = 0, speed_square = 0;
    for (std::size_t k = 0; k < modes_; ++k) {
      const double square =
          state_.real[k] * state_.real[k] + state_.imaginary[k] * state_.imaginary[k];
      const double size = std::sqrt(square);
      place += std::abs(s.place_gain[k]) * size;
      speed += std::abs(s.gain[k]) * size;
      place_square += s.place_gain[k] * s.place_gain[k] * square;
      speed_square += s.gain[k] * s.gain[k] * square;
    }
    place = std::min(place, kUnheardOf * std::sqrt(0.5 * place_square));
    speed = std::min(speed, kUnheardOf * std::sqrt(0.5 * speed_square));
    const double away = rigid_at(s, rigid_speed_) - c.speed_m_per_s;
    s.out_of_reach = -c.compression_m > 2 * std::max(speed - away, 0.0) / sample_rate_;
    if (away > speed || (away >= 0 && height(i) > place) || c.age_s > kLongestFlight)
      end(i);
  }
}

void ContactSolver::kick(std::span<const float> gain, double impulse) noexcept {
  for (std::size_t k = 0; k < std::min(gain.size(), modes_); ++k)
    state_.real[k] += static_cast<double>(gain[k]) * impulse;
}

void ContactSolver::set_weight(std::size_t listener,
                               std::span<const std::complex<double>> weight) noexcept {
  if (listener >= weights_.size())
    return;
  for (std::size_t k = 0; k < std::min(modes_, weight.size()); ++k) {
    weights_[listener].real[k] = weight[k].real();
    weights_[listener].imaginary[k] = weight[k].imag();
  }
}

double ContactSolver::hear(std::span<const std::complex<double>> weight) const noexcept {
  double sum = 0;
  for (std::size_t k = 0; k < std::min(weight.size(), modes_); ++k)
    sum += weight[k].real() * state_.imaginary[k] + weight[k].imag() * state_.real[k];
  return sum;
}

double ContactSolver::energy() const noexcept {
  double sum = 0;
  for (std::size_t k = 0; k < modes_; ++k) {
    const double q = state_.imaginary[k] / omega_[k];
    const double speed = state_.real[k] - alpha_[k] * q;
    const double stiffness = omega_[k] * omega_[k] + alpha_[k] * alpha_[k];
    sum += 0.5 * (speed * speed + stiffness * q * q);
  }
  for (const double speed : rigid_speed_)
    sum += 0.5 * speed * speed;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& c = contacts_[i];
    if (c.led || c.age_s == 0)
      continue;
    sum +=
        c.striker_mass_kg * (0.5 * c.speed_m_per_s * c.speed_m_per_s - c.fall_m_per_s2 * c.place_m);
    if (c.active)
      sum += series(c).stored(c.place_m - surface_place(i));
  }
  return sum;
}

} // namespace tactus::modal
