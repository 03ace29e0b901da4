#include "core/contact/contact_system.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::contact {
namespace {

/// All pivots are at least 1 in exact arithmetic. A mobility matrix summed in single precision may
/// be slightly indefinite.
constexpr double kMinPivot = 0.5;

} // namespace

ContactSystem::ContactSystem(std::size_t max_contacts, simd::VectorSet widest)
    : dense_(dense_kernel(widest)), stride_(whole_lanes(max_contacts)), block_{0, 0, stride_},
      terms_(max_contacts), coupling_(max_contacts * stride_), matrix_(max_contacts * stride_),
      right_(max_contacts), other_(max_contacts), root_(max_contacts), solution_(max_contacts),
      column_(max_contacts) {
  acting_.reserve(max_contacts);
}

void ContactSystem::clear_coupling(std::size_t contacts) noexcept {
  std::fill_n(coupling_.data() + block_.at, contacts * block_.stride, 0.0);
}

void ContactSystem::find_inactive_velocities(std::size_t contacts) noexcept {
  for (std::size_t c = 0; c < contacts; ++c) {
    ContactTerm& t = (*this)[c];
    if (t.acts)
      continue;
    t.force = 0;
    t.mean = t.free;
    for (const std::size_t other : acting_)
      t.mean -= coupling(c, other) * (*this)[other].force;
  }
}

void ContactSystem::solve_one() noexcept {
  ContactTerm& t = (*this)[acting_[0]];
  t.solve(coupling(acting_[0], acting_[0]) + t.own_mobility);
}

/// Solves for two contacts by elimination, with the pivots of solve_acting().
void ContactSystem::solve_two() noexcept {
  ContactTerm &a = (*this)[acting_[0]], &b = (*this)[acting_[1]];
  const double y = coupling(acting_[1], acting_[0]);
  const double ya = coupling(acting_[0], acting_[0]) + a.own_mobility,
               yb = coupling(acting_[1], acting_[1]) + b.own_mobility;
  const double sa = a.law.slope_ns_per_m, sb = b.law.slope_ns_per_m;
  const double fa = a.law.offset_n, fb = b.law.offset_n;
  const double va = a.free - (ya * fa + y * fb), vb = b.free - (y * fa + yb * fb);
  const double pa = fa + sa * a.free, pb = fb + sb * b.free;
  const double first = 1 / (1 + sa * ya);
  const double second = 1 / std::max(1 + sb * yb - sa * sb * y * y * first, kMinPivot);
  b.mean = (vb - y * sa * first * va) * second;
  a.mean = (va - y * sb * b.mean) * first;
  b.force = (pb - y * sb * first * pa) * second;
  a.force = (pa - y * sa * b.force) * first;
}

/// With S = diag(sqrt(slope)) the velocities solve (1 + S Y S) S v = S (free - Y offset), and the
/// forces solve (1 + S Y S) F/S = offset/S + S free. Both systems are solved, so that neither the
/// velocities nor the forces are small differences of large numbers. The eigenvalues of the matrix
/// are at least 1.
void ContactSystem::solve_acting(std::size_t contacts) noexcept {
  if (acting_.size() == 1)
    return solve_one();
  if (acting_.size() == 2)
    return solve_two();
  const std::size_t count = acting_.size(), stride = whole_lanes(count);
  const DenseView matrix{matrix_.data(), count, stride};
  double *const root = root_.data(), *const solution = solution_.data();
  std::fill_n(root, stride, 0.0);
  std::fill_n(solution, stride, 0.0);
  for (std::size_t i = 0; i < count; ++i)
    root[i] = std::sqrt((*this)[acting_[i]].law.slope_ns_per_m);
  for (std::size_t j = 0; j < count; ++j) {
    const ContactTerm& t = (*this)[acting_[j]];
    const double* column = coupling_.data() + block_.at + acting_[j] * block_.stride;
    if (count < contacts) { // only the rows of the acting contacts
      for (std::size_t i = 0; i < count; ++i)
        column_[i] = column[acting_[i]];
      column = column_.data();
    }
    dense_->add_column(matrix.at + j * stride, solution, column, {root, root[j], t.law.offset_n},
                       stride);
    matrix(j, j) += 1 + t.law.slope_ns_per_m * t.own_mobility;
    solution[j] += t.own_mobility * t.law.offset_n;
  }
  std::fill_n(right_.data(), stride, 0.0);
  std::fill_n(other_.data(), stride, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const ContactTerm& t = (*this)[acting_[i]];
    right_[i] = root[i] * (t.free - solution[i]);
    other_[i] = t.law.offset_n / root[i] + root[i] * t.free;
  }
  dense_->factorise(matrix, kMinPivot);
  dense_->substitute(matrix, right_.data(), other_.data());
  for (std::size_t i = 0; i < count; ++i) {
    ContactTerm& t = (*this)[acting_[i]];
    t.mean = right_[i] / root[i];
    t.force = root[i] * other_[i];
  }
}

} // namespace tactus::contact
