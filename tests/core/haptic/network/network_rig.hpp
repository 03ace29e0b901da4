#pragma once

#include "core/haptic/network/network_model.hpp"
#include "core/haptic/network/shapes.hpp"

#include <memory>
#include <vector>

/// A mass-spring network that is stepped tick by tick, with the handle where the test says.
namespace tactus::haptic::test {

class NetworkRig {
public:
  Network network;
  NetworkModel model;
  double period_s = 1e-3;
  std::uint64_t ticks = 0;

  NetworkRig() {
    network.touch = {0, 0, 0}; // nothing touches unless a test says so
    network.grab = {0, 0};
  }
  std::size_t mass(double kg, const Vec3& position) { return add_mass(kg, position, false); }
  std::size_t anchor(const Vec3& position) { return add_mass(1, position, true); }
  void link(std::size_t a, std::size_t b, double k, double l0 = 0, double damping = 0,
            NetworkLink::Kind kind = NetworkLink::Kind::kSpring) {
    NetworkLink& link = network.links.emplace_back();
    link.a = static_cast<std::uint16_t>(a);
    link.b = static_cast<std::uint16_t>(b);
    link.kind = kind;
    link.stiffness_n_per_m = k;
    link.rest_length_m = l0;
    link.damping_n_s_per_m = damping;
  }
  void add(const NetworkPart& part) {
    const auto first = static_cast<std::uint16_t>(network.masses.size());
    for (NetworkMass mass : part.masses) {
      mass.key = ++keys_;
      network.masses.push_back(mass);
    }
    for (NetworkLink link : part.links) {
      link.a = static_cast<std::uint16_t>(link.a + first);
      link.b = static_cast<std::uint16_t>(link.b + first);
      network.links.push_back(link);
    }
  }
  void publish() { model.publish(std::make_unique<const Network>(network)); }
  std::uint64_t key(std::size_t mass) const { return network.masses[mass].key; }
  void pluck(std::size_t mass, const Vec3& force_n, double duration_s) {
    model.queue_action(NetworkModel::Pluck{key(mass), force_n, duration_s});
  }
  void grab(std::size_t mass) { model.queue_action(NetworkModel::Grab{key(mass)}); }
  void act(const NetworkModel::Action& action) { model.queue_action(action); }

  Vec3 tick(const Vec3& handle = {0, 0.5, 0}) {
    State state;
    state.position = handle;
    const double time_s = static_cast<double>(ticks) * period_s;
    return model.force({ticks++, time_s, period_s}, state);
  }
  Vec3 tick_for(double seconds, const Vec3& handle = {0, 0.5, 0}) {
    Vec3 force;
    for (int n = static_cast<int>(seconds / period_s + 0.5); n > 0; --n)
      force = tick(handle);
    return force;
  }

private:
  std::size_t add_mass(double kg, const Vec3& position, bool fixed) {
    network.masses.push_back({++keys_, kg, position, fixed});
    return network.masses.size() - 1;
  }
  std::uint64_t keys_ = 0;
};

} // namespace tactus::haptic::test
