#pragma once

#include "core/haptic/network/network.hpp"

#include <cstddef>

namespace tactus::haptic {

/// The longest stable time step of a network and the mass that limits it.
struct StepBound {
  double step_s = 0;
  std::size_t mass = 0; ///< index into Network::masses
};

/// The bound of the time step. The scheme M (x+ - 2 x + x-)/h^2 + C (x - x-)/h + K x = 0 has the
/// energy
///   E = v^T (M - h C/2 - h^2 K/4) v / 2 + y^T K y / 2,   v = (x+ - x)/h,  y = (x+ + x)/2,
/// Only the dampers change this energy, so the scheme is stable while 4 M - 2 h C - h^2 K has no
/// negative eigenvalue. The eigenvalues of M^-1 (2 h C + h^2 K) are bounded by its block rows
/// (Gershgorin):
///   sum over the links of a mass of (2 h b + h^2 k) (1 + 1 if the other end moves) / m + 2 h alpha
/// for any directions of the links; touch and grab are counted on every mass. The tangent stiffness
/// of a link is at most k while it is longer than half its rest length. Infinite without movable
/// masses. Allocates.
[[nodiscard]] StepBound max_stable_step(const Network& network);

/// Steps in a servo tick. A pickup's sample is the mean of `stride` steps; stride divides steps.
struct NetworkSteps {
  int steps = 0, stride = 1;
};

/// The steps per tick for the network's rate, fewer if the work limit of a tick requires it, or
/// more if stability does; 0 steps if stability needs more than the work limit allows. Pickups have
/// a rate of 48 to 96 kHz, or the rate of the steps if that is lower.
[[nodiscard]] NetworkSteps steps_per_tick(const Network& network, double max_step_s,
                                          double period_s) noexcept;

inline constexpr int kMaxStepsPerTick = 1024;
/// Limit of (links + masses/4) x steps in one tick; bench/network_speed.cpp measures its cost.
inline constexpr double kMaxNetworkWork = 36000;
/// Fraction of the bound that is used: omega h <= 1.4. The highest mode is then still resolved, and
/// a network whose velocities are set to zero in each step still converges (h^2 omega^2 < 2).
inline constexpr double kStepMargin = 0.7;

} // namespace tactus::haptic
