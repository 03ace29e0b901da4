#pragma once

#include "core/haptic/network/network.hpp"

#include <cstddef>

namespace tactus::haptic {

/// The longest stable step of a network and the mass that asks for it.
struct StepBound {
  double step_s = 0;
  std::size_t mass = 0; ///< index into Network::masses
};

/// The scheme M (x+ - 2 x + x-)/h^2 + C (x - x-)/h + K x = 0 keeps the energy
///   E = v^T (M - h C/2 - h^2 K/4) v / 2 + y^T K y / 2,   v = (x+ - x)/h,  y = (x+ + x)/2,
/// but for what the dampers take, so it is stable while 4 M - 2 h C - h^2 K has no negative
/// eigenvalue. The eigenvalues of M^-1 (2 h C + h^2 K) are bounded by its block rows (Gershgorin):
///   sum over the links of a mass of (2 h b + h^2 k) (1 + 1 if the other end moves) / m + 2 h alpha
/// whatever the links' directions; touch and grab count on every mass. The tangent stiffness of a
/// link is at most k while it is not pressed below half its rest length. Infinite without masses
/// that move.
[[nodiscard]] StepBound max_stable_step(const Network& network);

/// How a servo tick is cut: the pickups keep the mean of `stride` steps, which divides `steps`.
struct NetworkSteps {
  int steps = 0, stride = 1;
};

/// As many steps as the network's rate asks for, fewer where a tick's work allows no more, more
/// where the bound needs them; none when it needs more than the work allows. Pickups are read at 48
/// to 96 kHz, or at each step if those are fewer.
[[nodiscard]] NetworkSteps steps_per_tick(const Network& network, double max_step_s,
                                          double period_s) noexcept;

inline constexpr int kMaxStepsPerTick = 1024;
/// Limit of (links + masses/4) x steps in one tick: bench/network_speed.cpp says what that costs.
inline constexpr double kMaxNetworkWork = 36000;
/// Share of the bound that is used: omega h <= 1.4, so that the highest mode is still resolved, and
/// a network whose velocities are taken away each step still settles (h^2 omega^2 < 2).
inline constexpr double kStepMargin = 0.7;

} // namespace tactus::haptic
