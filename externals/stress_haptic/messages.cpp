#include "core/declaration_text.hpp"
#include "externals/stress_haptic/stress_haptic.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tactus::stress {

namespace {

constexpr double kM_per_mm = 1e-3, kMaxPosition_mm = 1e6, kMaxSpeed_m_per_s = 100;

/// The numbers of a message; empty after one error if one is a word or out of range.
std::vector<double> numbers_of(std::string_view message, std::span<const Atom> atoms, Host& host) {
  std::vector<double> numbers;
  for (const Atom& atom : atoms) {
    if (atom.is_word || !(std::abs(atom.number) <= kMaxPosition_mm)) {
      host.error(std::string(message) + ": '" +
                 (atom.is_word ? std::string(atom.word) : number_text(atom.number)) +
                 "': expected numbers in -1e+06..1e+06");
      return {};
    }
    numbers.push_back(atom.number);
  }
  return numbers;
}

} // namespace

std::string sentence_of(std::string_view message, std::span<const Atom> arguments) {
  std::string sentence(message);
  for (const Atom& atom : arguments)
    sentence += " " + (atom.is_word ? std::string(atom.word) : number_text(atom.number));
  return sentence;
}

void StressHaptic::reset(Host& host) {
  if (!has_table("reset", host))
    return;
  std::fill(request_.displacement_m.begin(), request_.displacement_m.end(), 0.0);
  submit(host);
}

void StressHaptic::scalar(std::size_t inlet, double value, Host& host) {
  const Atom atom(value);
  if (inlet == 0)
    set_parameters(std::span(&atom, 1), host);
}

/// Handles inlet 2: position, or position and velocity, of the handle.
void StressHaptic::list(std::size_t, std::span<const Atom> atoms, Host& host) {
  if (atoms.size() != 3 && atoms.size() != 6)
    return host.error("device: " + std::to_string(atoms.size()) +
                      " numbers: expected x y z in mm, or x y z vx vy vz in mm and m/s");
  const std::vector<double> numbers = numbers_of("device", atoms, host);
  if (numbers.empty())
    return;
  const double now_s = 1e-3 * host.now_ms();
  const Vec3 position_m = Vec3{numbers[0], numbers[1], numbers[2]} * kM_per_mm;
  const Vec3 estimate = velocity_estimate_.update(position_m, now_s);
  const Vec3 velocity = numbers.size() == 6 ? Vec3{numbers[3], numbers[4], numbers[5]} : estimate;
  position_m_ = position_m;
  velocity_m_per_s_ = limited(velocity, kMaxSpeed_m_per_s);
  has_position_ = true;
  sent_force_n_.reset(); // every position sends a force, even an unchanged one
  if (!anchored_) {
    anchor_.jump(position_m_);
    anchored_ = true;
  }
  if (table_ && request_.control_point >= 0 && device_.drag) {
    displace(static_cast<std::size_t>(request_.control_point),
             grab_displacement_m_ + (position_m_ - grab_position_m_) * device_.scale);
    submit(host);
  }
  collect(host);
}

bool StressHaptic::has_table(std::string_view message, Host& host) const {
  if (!table_)
    host.error(std::string(message) + ": no table is loaded: send load FILE first");
  return table_ != nullptr;
}

std::optional<std::size_t> StressHaptic::control_point(std::string_view message, double id,
                                                       Host& host) const {
  if (!has_table(message, host))
    return {};
  if (const std::string refusal =
          design::control_point_refusal(table_->parameters, table_->control_point_m.size(), id);
      !refusal.empty()) {
    host.error(std::string(message) + ": " + refusal);
    return {};
  }
  return static_cast<std::size_t>(id);
}

void StressHaptic::displace(std::size_t control_point, const Vec3& displacement_m) noexcept {
  design::displace(table_->parameters, control_point, displacement_m, request_.displacement_m);
}

Vec3 StressHaptic::displacement_of(std::size_t control_point) const noexcept {
  return design::displacement_of(table_->parameters, control_point, request_.displacement_m);
}

void StressHaptic::set_control_point(std::span<const Atom> arguments, Host& host) {
  const std::vector<double> numbers = numbers_of("cp", arguments, host);
  if (numbers.empty())
    return;
  const auto point = control_point("cp", numbers[0], host);
  if (!point)
    return;
  displace(*point,
           Vec3{numbers[1], numbers[2], numbers[3]} * kM_per_mm - table_->control_point_m[*point]);
  submit(host);
}

void StressHaptic::set_parameters(std::span<const Atom> arguments, Host& host) {
  const std::vector<double> numbers = numbers_of("list", arguments, host);
  if (numbers.empty())
    return;
  if (!has_table("list", host))
    return;
  const auto& parameters = table_->parameters;
  if (numbers.size() != parameters.size())
    return host.error("list: " + std::to_string(numbers.size()) + " numbers: expected " +
                      std::to_string(parameters.size()) + ", one for each parameter of the table");
  for (std::size_t p = 0; p < parameters.size(); ++p)
    request_.displacement_m[p] =
        std::clamp(numbers[p] * kM_per_mm, parameters[p].low_m, parameters[p].high_m);
  submit(host);
}

void StressHaptic::grab(std::span<const Atom> arguments, Host& host) {
  const std::vector<double> numbers = numbers_of("grab", arguments, host);
  if (numbers.empty())
    return;
  const auto point = control_point("grab", numbers[0], host);
  if (!point)
    return;
  if (numbers.size() == 2 && numbers[1] != 0 && numbers[1] != 1)
    return host.error("grab: " + number_text(numbers[1]) +
                      ": expected 1 to grab the control point or 0 to release it");
  if (numbers.size() == 2 && numbers[1] == 0) {
    if (request_.control_point == static_cast<int>(*point))
      release(host);
    return;
  }
  request_.control_point = static_cast<int>(*point);
  grab_position_m_ = position_m_;
  grab_displacement_m_ = displacement_of(*point);
  submit(host);
}

void StressHaptic::release(Host& host) {
  if (request_.control_point < 0)
    return;
  request_.control_point = -1;
  submit(host);
}

void StressHaptic::set_range(std::span<const Atom> arguments, Host& host) {
  auto& settings = request_.settings;
  const std::string_view word = arguments[0].is_word ? arguments[0].word : std::string_view();
  if (arguments.size() == 1 && (word == "current" || word == "initial")) {
    settings.range = word == "current" ? Range::kCurrent : Range::kInitial;
  } else if (arguments.size() == 3 && word == "fixed" && !arguments[1].is_word &&
             !arguments[2].is_word && std::isfinite(arguments[1].number) &&
             std::isfinite(arguments[2].number) && arguments[1].number < arguments[2].number) {
    settings.range = Range::kFixed;
    settings.fixed_min = arguments[1].number;
    settings.fixed_max = arguments[2].number;
  } else {
    return host.error(sentence_of("range", arguments) +
                      ": expected current, initial, or fixed a b with a below b");
  }
  submit(host);
}

void StressHaptic::set_gains(std::span<const Atom> arguments, Host& host) {
  const std::vector<double> numbers = numbers_of("gains", arguments, host);
  if (numbers.empty())
    return;
  if (const auto x = std::find_if(numbers.begin(), numbers.end(), [](double g) { return g < 0; });
      x != numbers.end())
    return host.error("gains: " + number_text(*x) +
                      ": expected kmin kmax bmin bmax, each 0 or more (N/m, N s/m)");
  gains_ = {numbers[0], numbers[1], numbers[2], numbers[3]};
  if (const double k = std::max(numbers[0], numbers[1]); k > stiffness_limit())
    host.error("gains: " + number_text(k) + " N/m: expected at most " +
               number_text(stiffness_limit()) +
               ", the device's nominal stiffness times share; limited to that value");
  else if (const double b = std::max(numbers[2], numbers[3]); b > device_.damping_n_s_per_m)
    host.error("gains: " + number_text(b) + " N s/m: expected at most " +
               number_text(device_.damping_n_s_per_m) +
               ", the limit damping; limited to that value");
  if (host_)
    collect(host);
}

void StressHaptic::set_anchor(std::span<const Atom> arguments, Host& host) {
  Vec3 anchor_m = position_m_;
  if (arguments.size() == 3) {
    const std::vector<double> numbers = numbers_of("anchor", arguments, host);
    if (numbers.empty())
      return;
    anchor_m = Vec3{numbers[0], numbers[1], numbers[2]} * kM_per_mm;
  } else if (arguments.size() != 1 || !arguments[0].is_word || arguments[0].word != "here") {
    return host.error(sentence_of("anchor", arguments) + ": expected here, or x y z in mm");
  } else if (!has_position_) {
    anchored_ = false; // the next position becomes the anchor
    return;
  }
  if (has_position_ && anchored_)
    anchor_.fade(anchor_m, 1e-3 * host.now_ms(), kFade_s);
  else
    anchor_.jump(anchor_m);
  anchored_ = true;
  if (host_)
    collect(host);
}

} // namespace tactus::stress
