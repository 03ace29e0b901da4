#include "core/modal/contact_solver.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace tactus::modal {
namespace {

constexpr double kStepsPerContact = 32; // error of the rebound below 0.1 %
constexpr double kStepRate = 176400;    // 1/s at least in a strike: the force true up to 20 kHz
constexpr double kMostLedSteps = 4;     // a hand's contact lasts: it is followed less finely
constexpr int kMostRounds = 40;
constexpr double kLongestFlight = 0.05; // s that a striker is followed after it has let go
constexpr std::size_t kMostWork =
    16384; // modes times steps in a sample, so that blows stay in time
constexpr unsigned kLeastSteps = 2;
constexpr std::size_t kMostContactSteps = 1024; // contacts times steps in a sample, of several
constexpr int kTrialRounds = 8;      // after which rounds must come nearer by half each time
constexpr double kUnheardOf = 8;     // of the root mean square of many modes' sum
constexpr unsigned kReachHolds = 64; // samples
constexpr double kLongestRest = 8;   // contact times after which one that has not left lies still

} // namespace

ContactSolver::ContactSolver(std::span<const std::complex<double>> rate, double sample_rate,
                             std::size_t contacts, bool rigid, std::size_t listeners, VectorSet set)
    : sample_rate_(sample_rate), has_rigid_(rigid), modes_(rate.size()), alpha_(modes_, 0),
      omega_(modes_, 1), contacts_(contacts), slots_(contacts), answer_(contacts * contacts, 0),
      swing_answer_(contacts, 0), free_(contacts, 0), force_(contacts, 0), next_force_(contacts, 0),
      touching_(contacts, 0), sampled_(contacts) {
  for (std::size_t k = 0; k < modes_; ++k) {
    alpha_[k] = -rate[k].real();
    omega_[k] = rate[k].imag();
  }
  const double most = kMostLedSteps * sample_rate;
  most_led_rate_ = most * most;
  while (most_steps_ > kLeastSteps && most_steps_ * modes_ > kMostWork)
    most_steps_ /= 2;
  swings_ = ContactModes::make(rate, sample_rate, most_steps_, contacts, listeners, set);
  steps_ = 1;
}

bool ContactSolver::choose_steps(double wanted) noexcept {
  // Coarser only when much coarser will do, or must do: a change costs as much as some steps.
  const bool too_many =
      active_count_ > 1 && steps_ * active_count_ > kMostContactSteps && steps_ > kLeastSteps;
  if (wanted <= steps_ && 4 * wanted > steps_ && !too_many)
    return false;
  unsigned steps = 1;
  while (steps < most_steps_ && steps < wanted)
    steps *= 2;
  if (steps == steps_)
    return false;
  set_steps(steps);
  return true;
}

void ContactSolver::set_steps(unsigned steps) noexcept {
  steps_ = steps;
  swings_->set_steps(steps);
  work_out_answers();
}

void ContactSolver::work_out_answers() noexcept {
  const double h = 1 / (sample_rate_ * steps_);
  const std::size_t count = contacts_.size();
  for (std::size_t a = 0; a < active_count_; ++a)
    for (std::size_t b = 0; b < active_count_; ++b) {
      const std::size_t i = touching_[a], j = touching_[b];
      double sum = swings_->answer(i, j, 0);
      if (has_rigid_)
        sum += rigid_at(slots_[i], slots_[j].rigid) * h * h / 2;
      if (i == j && !contacts_[i].led)
        sum += h * h / 2 / contacts_[i].striker_mass_kg;
      answer_[i * count + j] = sum;
      if (i == j && steps_ > 1)
        swing_answer_[i] = swings_->answer(i, i, 1);
    }
}

void ContactSolver::fill(std::size_t slot, const Contact& contact, std::span<const double> gain,
                         const Rigid& rigid_gain) noexcept {
  Slot& s = slots_[slot];
  s.last_force = s.force_before = 0;
  s.out_of_reach = false;
  s.reach_age = 0;
  s.mobility = contact.led ? 0 : 1 / contact.striker_mass_kg;
  s.rigid = has_rigid_ ? rigid_gain : Rigid{};
  for (const double b : s.rigid)
    s.mobility += b * b;
  s.mobility += swings_->set_gain(slot, gain);
}

void ContactSolver::begin(std::size_t slot, const Contact& contact, std::span<const double> gain,
                          const Rigid& rigid_gain) noexcept {
  if (slot >= slots_.size())
    return;
  end(slot);
  Slot& s = slots_[slot];
  fill(slot, contact, gain, rigid_gain);
  if (active_count_ == 0)
    rest_rigid();
  Contact& c = contacts_[slot] = contact;
  c.active = true;
  c.lies = false;
  list_touching();
  // No contact begins with work stored in it.
  const double surface = surface_place(slot);
  c.place_m = contact.led ? std::min(contact.place_m, surface) : contact.place_m + surface;
  c.compression_m = c.place_m - surface;
  s.steps = 1;
  s.patience_s = kLongestFlight;
  if (!contact.led && contact.speed_m_per_s > 0) {
    const double time = contact.law.duration(1 / s.mobility, contact.speed_m_per_s);
    s.steps = std::max(kStepsPerContact / time, kStepRate) / sample_rate_;
    s.patience_s =
        std::max(kLongestFlight, kLongestRest * contact.law.duration(contact.striker_mass_kg,
                                                                     contact.speed_m_per_s));
  }
  if (!choose_steps(wanted_steps()))
    work_out_answers();
}

void ContactSolver::take_over(std::size_t slot, const ContactSolver& before, std::size_t old_slot,
                              std::span<const double> gain, const Rigid& rigid_gain) noexcept {
  if (slot >= slots_.size() || old_slot >= before.slots_.size() ||
      !before.contacts_[old_slot].active)
    return;
  end(slot);
  Slot& s = slots_[slot];
  Contact& c = contacts_[slot] = before.contacts_[old_slot];
  fill(slot, c, gain, rigid_gain);
  s.steps = before.slots_[old_slot].steps;
  s.patience_s = before.slots_[old_slot].patience_s;
  s.last_force = s.force_before = before.slots_[old_slot].last_force;
  list_touching();
  // The shapes have changed, and with them where the surface is: the striker stays on it.
  const double surface = surface_place(slot);
  if (!c.led)
    c.place_m = c.compression_m + surface;
  c.compression_m = c.place_m - surface;
  if (!choose_steps(wanted_steps()))
    work_out_answers();
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
  contacts_[slot].force_n = 0;
  swings_->drop(slot);
  list_touching();
}

void ContactSolver::list_touching() noexcept {
  active_count_ = 0;
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (contacts_[i].active)
      touching_[active_count_++] = i;
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
  swings_->silence();
  forget_reach();
  rest_rigid();
}

double ContactSolver::surface_place(std::size_t slot) const noexcept {
  return swings_->place(slot) + rigid_at(slots_[slot], rigid_place_);
}

void ContactSolver::move_rigidly(double h) noexcept {
  for (std::size_t r = 0; r < kRigid; ++r)
    rigid_place_[r] += h * rigid_speed_[r];
}

void ContactSolver::move_striker(std::size_t slot, double h) noexcept {
  Contact& c = contacts_[slot];
  c.place_m += h * (c.speed_m_per_s + 0.5 * h * c.fall_m_per_s2);
  c.speed_m_per_s += h * c.fall_m_per_s2;
  c.age_s += h;
}

double ContactSolver::find_force(std::size_t slot, double free, double h) noexcept {
  const Slot& s = slots_[slot];
  const double guess = std::max(2 * s.last_force - s.force_before, 0.0);
  return series(contacts_[slot])
      .solve(contacts_[slot].compression_m, free, answer_[slot * contacts_.size() + slot], h,
             guess);
}

/// Several contacts answer each other: rounds over all of them from the same forces, until these
/// stay.
void ContactSolver::find_forces(double h) noexcept {
  const std::size_t count = contacts_.size();
  for (std::size_t a = 0; a < active_count_; ++a)
    force_[touching_[a]] = 0;
  double change_before = 0;
  for (int round = 0; round < kMostRounds; ++round) {
    double change = 0, largest = 0;
    for (std::size_t a = 0; a < active_count_; ++a) {
      const std::size_t i = touching_[a];
      double free = free_[i];
      for (std::size_t b = 0; b < active_count_; ++b)
        if (b != a)
          free -= answer_[i * count + touching_[b]] * force_[touching_[b]];
      next_force_[i] = find_force(i, free, h);
      change = std::max(change, std::abs(next_force_[i] - force_[i]));
      largest = std::max(largest, next_force_[i]);
    }
    for (std::size_t a = 0; a < active_count_; ++a) {
      const std::size_t i = touching_[a];
      force_[i] = slots_[i].last_force = slots_[i].force_before = next_force_[i];
    }
    // Contacts far stiffer than their steps go round without coming nearer.
    if (change <= 1e-12 * largest || (round > kTrialRounds && change > .5 * change_before))
      break;
    change_before = change;
  }
}

/// What a force does to all but the modes.
void ContactSolver::apply_force(std::size_t slot, double force, double h, unsigned step) noexcept {
  Contact& c = contacts_[slot];
  Slot& s = slots_[slot];
  s.force_before = s.last_force;
  s.last_force = force;
  if (force == 0)
    return;
  c.force_n += force;
  const double part = 1 / static_cast<double>(steps_);
  const double x = 1 - (2 * static_cast<double>(step) + 1) * part; // 2 v - 1 in the step's middle
  s.moments[0] += force * part;
  s.moments[1] += force * part * x;
  s.moments[2] += force * part * (1.5 * x * x - 0.5 + 0.5 * part * part);
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

/// The next steps of a contact that is the only one, one or two at a time, after so many.
void ContactSolver::step_one_contact(std::size_t i, std::size_t ahead, unsigned after) noexcept {
  const double h = 1 / (sample_rate_ * steps_);
  const double answer = answer_[i * contacts_.size() + i];
  const double* const place = swings_->look_ahead(i, ahead, after + ahead == steps_);
  std::array<double, ContactModes::kMostAhead> force{};
  for (std::size_t j = 0; j < ahead; ++j) {
    if (has_rigid_)
      move_rigidly(h);
    move_striker(i, h);
    double swing = place[j];
    if (j > 0)
      swing += swing_answer_[i] * force[j - 1];
    double free = contacts_[i].place_m - swing;
    if (has_rigid_)
      free -= rigid_at(slots_[i], rigid_place_);
    force[j] = find_force(i, free, h);
    contacts_[i].compression_m = free - answer * force[j];
    apply_force(i, force[j], h, after + static_cast<unsigned>(j));
  }
  swings_->give(force.data());
}

/// The next step of all contacts, after so many.
void ContactSolver::step_contacts(unsigned after) noexcept {
  const bool ends_sample = after + 1 == steps_;
  const double h = 1 / (sample_rate_ * steps_);
  const std::size_t count = contacts_.size();
  move_rigidly(h);
  for (std::size_t a = 0; a < active_count_; ++a) {
    const std::size_t i = touching_[a];
    move_striker(i, h);
    const double swing =
        a == 0 ? *swings_->look_ahead(i, 1, ends_sample) : swings_->place_besides(i);
    free_[i] = contacts_[i].place_m - swing - rigid_at(slots_[i], rigid_place_);
  }
  find_forces(h);
  for (std::size_t a = 0; a < active_count_; ++a) {
    const std::size_t i = touching_[a];
    double depth = free_[i];
    for (std::size_t b = 0; b < active_count_; ++b)
      depth -= answer_[i * count + touching_[b]] * force_[touching_[b]];
    contacts_[i].compression_m = depth;
  }
  for (std::size_t a = 0; a < active_count_; ++a) {
    const std::size_t i = touching_[a];
    apply_force(i, force_[i], h, after);
    if (a == 0)
      swings_->give(&force_[i]);
    else if (force_[i] != 0)
      swings_->give_besides(i, force_[i]);
  }
}

double ContactSolver::wanted_steps() const noexcept {
  double wanted = 1, square = 1;
  for (std::size_t a = 0; a < active_count_; ++a) {
    const Contact& c = contacts_[touching_[a]];
    const Slot& s = slots_[touching_[a]];
    // A contact that stiffens as it is pressed in is followed in shorter steps.
    const double rate = c.law.slope(c.compression_m) * s.mobility * 5;
    square = std::max(square, c.led ? std::min(rate, most_led_rate_) : rate);
    if (!c.led && !s.out_of_reach)
      wanted = std::max(wanted, s.steps);
  }
  const double rate_of_steps = wanted * sample_rate_;
  if (square > rate_of_steps * rate_of_steps)
    wanted = std::sqrt(square) / sample_rate_;
  double most = most_steps_;
  if (active_count_ > 1)
    most = std::min(most, static_cast<double>(std::bit_floor(kMostContactSteps / active_count_)));
  return std::min(wanted, std::max(most, static_cast<double>(kLeastSteps)));
}

double ContactSolver::step() noexcept {
  for (std::size_t a = 0; a < active_count_; ++a) {
    contacts_[touching_[a]].force_n = 0;
    slots_[touching_[a]].moments = {};
  }
  sampled_count_ = 0;
  choose_steps(wanted_steps());
  if (active_count_ == 1) {
    const unsigned ahead = steps_ > 1 ? 2 : 1;
    for (unsigned s = 0; s < steps_; s += ahead)
      step_one_contact(touching_[0], ahead, s);
  } else if (active_count_ > 1) {
    for (unsigned s = 0; s < steps_; ++s)
      step_contacts(s);
  }
  double force = 0;
  for (std::size_t a = 0; a < active_count_; ++a) {
    Contact& c = contacts_[touching_[a]];
    c.force_n /= steps_;
    force += c.force_n;
    if (c.force_n != 0)
      sampled_[sampled_count_++] = {touching_[a], slots_[touching_[a]].moments};
  }
  if (force > 0)
    forget_reach();
  look_for_ends();
  return force;
}

void ContactSolver::forget_reach() noexcept {
  for (std::size_t a = 0; a < active_count_; ++a)
    slots_[touching_[a]].reach_age = 0;
}

void ContactSolver::look_for_ends() noexcept {
  for (std::size_t a = active_count_; a > 0; --a) { // from behind: who ends leaves the list
    const std::size_t i = touching_[a - 1];
    Contact& c = contacts_[i];
    if (c.led)
      continue;
    Slot& s = slots_[i];
    s.out_of_reach = false;
    if (c.compression_m > 0 || c.force_n > 0) {
      c.lies = c.fall_m_per_s2 > 0 && c.age_s > s.patience_s;
      if (c.lies)
        end(i);
    } else if (gets_away(i)) {
      end(i);
    }
  }
}

/// It has let go. It meets the surface again only if that can still catch up with it. No point
/// moves further or faster than all modes together; of many modes, which never meet, no more than
/// kUnheardOf times their root of the mean square. Without forces that stays true for a while.
bool ContactSolver::gets_away(std::size_t slot) noexcept {
  const Contact& c = contacts_[slot];
  Slot& s = slots_[slot];
  if (s.reach_age == 0)
    s.reach = swings_->reach(slot);
  s.reach_age = (s.reach_age + 1) % kReachHolds;
  const double place = std::min(s.reach.place, kUnheardOf * std::sqrt(0.5 * s.reach.place_square));
  const double speed = std::min(s.reach.speed, kUnheardOf * std::sqrt(0.5 * s.reach.speed_square));
  const double away = rigid_at(s, rigid_speed_) - c.speed_m_per_s;
  s.out_of_reach = -c.compression_m > 2 * std::max(speed - away, 0.0) / sample_rate_;
  return away > speed || (away >= 0 && height(slot) > place) || c.age_s > kLongestFlight;
}

void ContactSolver::kick(std::span<const float> gain, double impulse) noexcept {
  swings_->kick(gain, impulse);
  forget_reach();
}

double ContactSolver::energy() const noexcept {
  double sum = 0;
  for (std::size_t k = 0; k < modes_; ++k) {
    const std::complex<double> z = state(k);
    const double q = z.imag() / omega_[k];
    const double speed = z.real() - alpha_[k] * q;
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
