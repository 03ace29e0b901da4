#include "core/modal/contact_force.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::modal {
namespace {

constexpr int kMostRounds = 60;
constexpr int kSecants = 12;     // rounds after which every other one halves the bracket
constexpr double kExact = 1e-12; // of the compression
constexpr int kBallRounds = 8;
constexpr double kExactRoot = 1e-5; // of the compression's root

} // namespace

double SeriesContact::elastic(double depth) const noexcept {
  if (!(compliance_m_per_n > 0) || !(depth > 0))
    return law.force(depth, 0);
  // depth = d + C f(d): the right side grows with d and bends upwards, so Newton's method from
  // above always arrives.
  double d = depth;
  for (int i = 0; i < kMostRounds; ++i) {
    const double over = d + compliance_m_per_n * law.force(d, 0) - depth;
    const double next = std::max(d - over / (1 + compliance_m_per_n * law.slope(d)), 0.0);
    if (!(std::abs(next - d) > 1e-12 * depth))
      break;
    d = next;
  }
  return (depth - d) / compliance_m_per_n;
}

double SeriesContact::stored(double depth) const noexcept {
  if (!(compliance_m_per_n > 0))
    return law.work(depth);
  const double force = elastic(depth);
  return law.work(depth - compliance_m_per_n * force) + 0.5 * compliance_m_per_n * force * force;
}

double SeriesContact::mean_force(double start, double stored_at_start, double end,
                                 double time_s) const noexcept {
  const double way = end - start;
  double force = 0;
  if (start > 0 && end > 0 && !(compliance_m_per_n > 0) && law.exponent == 1.5) {
    // (x^5 - y^5)/(x^2 - y^2) for the roots x and y of the compressions, without the difference.
    const double x = std::sqrt(end), y = std::sqrt(start), xy = x * y, squares = end + start;
    force = 0.4 * law.stiffness * (squares * squares + xy * (squares - xy)) / (x + y);
  } else if (start > 0 && end > 0 && !(compliance_m_per_n > 0) && law.exponent == 1) {
    force = 0.5 * law.stiffness * (start + end);
  } else if (std::abs(way) > 1e-4 * std::max(std::abs(start), std::abs(end))) {
    force = (stored(end) - stored_at_start) / way;
  } else {
    force = elastic(0.5 * (start + end));
  }
  return std::max(force * (1 + law.loss_s_per_m * way / time_s), 0.0);
}

double SeriesContact::solve_ball(double start, double free, double answer,
                                 double guess) const noexcept {
  // With the roots x of the compression sought and y of the one before,
  //   F = 2/5 k (x^5 - y^5)/(x^2 - y^2) = 2/5 k (x^4 + x^3 y + x^2 y^2 + x y^3 + y^4)/(x + y),
  // so (x^2 - free)(x + y) + c (x^4 + ... + y^4) = 0, c = 2/5 k answer: Halley's method, of third
  // order, without roots.
  const double y = std::sqrt(start), y2 = start, y3 = y2 * y, y4 = y2 * y2;
  const double c = 0.4 * law.stiffness * answer;
  const double near = free - answer * guess;
  double x = near > 0 ? std::sqrt(near) : y;
  for (int round = 0; round < kBallRounds; ++round) {
    const double x2 = x * x, sum = x + y;
    const double value = (x2 - free) * sum + c * (x2 * (x2 + x * y) + (y2 * x2 + x * y3 + y4));
    const double slope = 2 * x * sum + (x2 - free) + c * ((4 * x + 3 * y) * x2 + (2 * x * y2 + y3));
    const double bend = 2 * sum + 4 * x + c * (12 * x2 + 6 * x * y + 2 * y2);
    const double step = value * slope / (slope * slope - 0.5 * value * bend);
    x -= step;
    if (!(x > 0) || !(slope > 0))
      return -1;
    if (std::abs(step) < kExactRoot * x) // what is left is of the order of its cube
      return 0.4 * law.stiffness * ((x * x + y2) * (x * x + x * y) + y4) / (x + y);
  }
  return -1;
}

double SeriesContact::solve(double start, double free, double answer, double time_s,
                            double guess) const noexcept {
  if (start <= 0 && free <= 0)
    return 0;
  const bool elastic_only = !(compliance_m_per_n > 0) && start > 0;
  if (elastic_only && law.exponent == 1 && law.loss_s_per_m == 0) { // a spring that stays pressed
    const double force = 0.5 * law.stiffness * (start + free) / (1 + 0.5 * law.stiffness * answer);
    if (free - answer * force > 0)
      return force;
  }
  if (elastic_only && law.exponent == 1.5 && law.loss_s_per_m == 0)
    if (const double force = solve_ball(start, free, answer, guess); force >= 0)
      return force;
  // Balls and springs need it only where the contact opens (mean_force).
  const bool closed_form = elastic_only && (law.exponent == 1.5 || law.exponent == 1);
  double before = closed_form ? -1 : stored(start);
  // Secants from the guess. As F grows with d, the root lies between any d and free - answer F(d).
  double low = -1e300, high = free, last_d = 0, last_error = 0, force = 0;
  double d = free - answer * guess;
  for (int round = 0; round < kMostRounds; ++round) {
    if (before < 0 && !(d > 0))
      before = stored(start);
    force = mean_force(start, before, d, time_s);
    const double error = d + answer * force - free;
    if (!(std::abs(error) > kExact * (std::abs(d) + std::abs(start)) + 1e-30))
      break;
    low = std::max(low, std::min(d, d - error));
    high = std::min(high, std::max(d, d - error));
    double slope = 1;
    if (round == 0)
      slope += 0.5 * answer * law.slope(std::max(d, start));
    else if (d != last_d)
      slope = std::max((error - last_error) / (d - last_d), 1.0);
    last_d = d;
    last_error = error;
    d -= error / slope;
    if (!(d > low && d < high) || (round > kSecants && round % 2))
      d = 0.5 * (low + high);
  }
  return force;
}

} // namespace tactus::modal
