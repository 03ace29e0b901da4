#pragma once

#include "core/contact/dense_kernel.hpp"
#include "core/contact/exciter.hpp"
#include "core/contact/mode_array.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace tactus::contact {

/// Solves for the forces of all contacts of one step at once.
///
/// Each contact's force is linear in its own mean relative velocity, F = offset + slope v, slope >=
/// 0. The velocities are linear in all forces, v = v_free - Y F, with the symmetric positive
/// semidefinite mobility matrix Y. So the forces solve one positive definite linear system, and no
/// contact takes precedence. Impacts whose force would be negative are removed together, and the
/// system of the others is solved again.
class ContactSystem {
public:
  explicit ContactSystem(std::size_t max_contacts, simd::VectorSet widest = simd::kWidest);

  /// One of several independent systems in the same memory: index of its first contact, offset of
  /// its coupling matrix, and the length of that matrix's columns.
  struct Block {
    std::size_t first = 0, at = 0, stride = 0;
  };
  /// Selects the system that all other functions refer to.
  void select(const Block& block) noexcept { block_ = block; }
  /// Selects a single system of up to max_contacts contacts.
  void select_all() noexcept { block_ = {0, 0, stride_}; }

  /// Term of a contact of the selected system.
  [[nodiscard]] ContactTerm& operator[](std::size_t contact) noexcept {
    return terms_[block_.first + contact];
  }
  [[nodiscard]] const ContactTerm& operator[](std::size_t contact) const noexcept {
    return terms_[block_.first + contact];
  }
  /// Element of Y without the exciters' own mobility, m/(N s): mean velocity at one contact point
  /// per force at another. Set both triangles; columns are padded to `stride`, and the padding is
  /// read too.
  [[nodiscard]] double& coupling(std::size_t row, std::size_t column) noexcept {
    return coupling_[block_.at + column * block_.stride + row];
  }
  /// Sets the first columns to 0.
  void clear_coupling(std::size_t contacts) noexcept;

  /// Solves for the forces and mean velocities of the first `contacts` terms.
  /// `alternative_solver(acting)` may set those of the acting contacts itself and return true.
  template <class AlternativeSolver>
  void solve(std::size_t contacts, const AlternativeSolver& alternative_solver) noexcept {
    for (std::size_t c = 0; c < contacts; ++c)
      (*this)[c].acts = (*this)[c].law.slope_ns_per_m > kMinSlope;
    // Every round but the last removes at least one contact, so the loop ends.
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
  /// Mean velocities of the contacts without a force, under the forces of the others.
  void find_inactive_velocities(std::size_t contacts) noexcept;
  /// The contacts with a force in the last solution.
  [[nodiscard]] std::span<const std::size_t> acting() const noexcept { return acting_; }

  [[nodiscard]] const DenseKernel& dense() const noexcept { return *dense_; }

  static constexpr double kMinSlope = 1e-250; ///< N s/m; a contact below it has no force

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
