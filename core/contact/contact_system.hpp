#pragma once

#include "core/contact/dense_kernel.hpp"
#include "core/contact/exciter.hpp"
#include "core/contact/mode_array.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace tactus::contact {

/// All contacts of one step, solved together.
///
/// Each contact's force is a linear function of its own mean relative velocity, F = offset + slope
/// v with a slope >= 0, and these velocities follow linearly from all forces, v = v_free - Y F, Y
/// symmetric and positive. So the forces are the solution of one positive definite linear system:
/// no contact goes before another, and the energy balance of each holds exactly. Impacts that would
/// pull are taken out together and the rest solved again.
class ContactSystem {
public:
  explicit ContactSystem(std::size_t max_contacts);

  /// One of several independent systems in the same memory: its first contact among all of them,
  /// and where its coupling begins, columns of `stride` numbers.
  struct Block {
    std::size_t first = 0, at = 0, stride = 0;
  };
  /// From now on the system is this one.
  void select(const Block& block) noexcept { block_ = block; }
  /// The only one, of up to max_contacts.
  void select_all() noexcept { block_ = {0, 0, stride_}; }

  /// One contact's part in the step, by its position among those that take part.
  [[nodiscard]] ContactTerm& operator[](std::size_t contact) noexcept {
    return terms_[block_.first + contact];
  }
  [[nodiscard]] const ContactTerm& operator[](std::size_t contact) const noexcept {
    return terms_[block_.first + contact];
  }
  /// Y without the exciters' own masses, m/(N s): mean velocity of one place for a force at
  /// another. Columns of whole lanes, symmetric; all of a column is read.
  [[nodiscard]] double& coupling(std::size_t row, std::size_t column) noexcept {
    return coupling_[block_.at + column * block_.stride + row];
  }
  void clear_coupling(std::size_t contacts) noexcept;

  /// Finds all forces and mean velocities of the first so many. `alternative_solver(acting)` may
  /// find those of the contacts that act in another way and return true.
  template <class AlternativeSolver>
  void solve(std::size_t contacts, const AlternativeSolver& alternative_solver) noexcept {
    for (std::size_t c = 0; c < contacts; ++c)
      (*this)[c].acts = (*this)[c].law.slope_ns_per_m > kMinSlope;
    // Every round takes out at least one: it ends.
    for (bool has_tension = true; has_tension;) {
      acting_.clear();
      for (std::size_t c = 0; c < contacts; ++c)
        if ((*this)[c].acts)
          acting_.push_back(c);
      if (acting_.empty())
        return;
      if (!alternative_solver(acting()))
        solve_acting(contacts);
      has_tension = false;
      for (const std::size_t c : acting_)
        if (ContactTerm& t = (*this)[c]; t.force < 0 && !t.may_be_negative) {
          t.acts = false;
          has_tension = true;
        }
    }
  }
  void solve(std::size_t contacts) noexcept {
    solve(contacts, [](std::span<const std::size_t>) { return false; });
  }
  /// The mean velocities of those that have no force, under the others' forces.
  void find_inactive_velocities(std::size_t contacts) noexcept;
  /// The contacts with a force in the last solution.
  [[nodiscard]] std::span<const std::size_t> acting() const noexcept { return acting_; }

  void use_baseline() noexcept { dense_ = &baseline_dense_kernel(); }
  [[nodiscard]] const DenseKernel& dense() const noexcept { return *dense_; }

  static constexpr double kMinSlope = 1e-250; ///< N s/m; a softer contact has no force

private:
  void solve_acting(std::size_t contacts) noexcept;
  void solve_one() noexcept;
  void solve_two() noexcept;

  const DenseKernel* dense_;
  std::size_t stride_;
  Block block_;
  std::vector<ContactTerm> terms_;
  std::vector<std::size_t> acting_;
  ModeArray coupling_, matrix_;
  ModeArray right_, other_, root_, solution_, column_;
};

} // namespace tactus::contact
