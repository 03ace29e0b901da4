#pragma once

#include "core/contact/excited_body.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

/// Random bodies with what strikes them, alone or with their modes in one list.
namespace tactus::test {

using namespace contact;

inline double random(std::mt19937& source, double low, double high) {
  return std::uniform_real_distribution<>(low, high)(source);
}
inline double log_random(std::mt19937& source, double low, double high) {
  return std::exp(random(source, std::log(low), std::log(high)));
}

/// A body with the strikers that are to meet it.
struct Part {
  struct Striker {
    ImpactLaw law;
    double mass_kg, gap_m, speed_m_per_s, push_n;
    std::vector<double> shape;
  };
  std::vector<Mode> modes;
  std::vector<Striker> strikers;
};

inline Part random_part(std::mt19937& source, std::size_t modes, std::size_t strikers,
                        double softest, double stiffest, double farthest_m = 1e-3) {
  Part part;
  for (std::size_t i = 0; i < modes; ++i)
    part.modes.push_back(
        {log_random(source, 40, 15000), log_random(source, .01, 2), log_random(source, .05, 5)});
  for (std::size_t i = 0; i < strikers; ++i) {
    Part::Striker s{
        {log_random(source, softest, stiffest), random(source, 1, 3), random(source, 0, 1)},
        log_random(source, 1e-3, 1),
        random(source, 0, farthest_m),
        random(source, .1, 3),
        random(source, 0, 20),
        {}};
    for (std::size_t k = 0; k < modes; ++k)
      s.shape.push_back(random(source, -1, 1));
    part.strikers.push_back(s);
  }
  return part;
}

/// Bodies of one, few and many modes, met by one, two and several strikers.
inline std::vector<Part> mixed(std::mt19937& source, double softest, double stiffest) {
  struct Size {
    std::size_t modes, strikers;
  };
  std::vector<Part> parts;
  for (const Size& size : {Size{1, 1}, {3, 1}, {9, 1}, {20, 1}, {1, 2}, {5, 2}, {11, 4}, {2, 6}})
    parts.push_back(random_part(source, size.modes, size.strikers, softest, stiffest));
  return parts;
}

inline std::size_t strikers(const std::vector<Part>& parts) {
  std::size_t sum = 0;
  for (const Part& part : parts)
    sum += part.strikers.size();
  return sum;
}

inline std::vector<std::size_t> in_order(std::size_t count) {
  std::vector<std::size_t> slots(count);
  std::iota(slots.begin(), slots.end(), 0);
  return slots;
}

/// Bodies in one list of modes, which are its parts one after another or, `interleaved`, mode by
/// mode in turn, with a pickup of each; `slots` names the slot of each striker of the first part,
/// then the second...
inline std::unique_ptr<ExcitedBody> combined_body(const std::vector<Part>& parts, bool interleaved,
                                                  const std::vector<std::size_t>& slots,
                                                  simd::VectorSet widest = simd::kWidest) {
  std::vector<std::vector<std::size_t>> at(parts.size());
  std::vector<Mode> modes;
  const auto take = [&](std::size_t part) {
    at[part].push_back(modes.size());
    modes.push_back(parts[part].modes[at[part].size() - 1]);
  };
  for (std::size_t round = 0; round < (interleaved ? 100 : 1); ++round)
    for (std::size_t p = 0; p < parts.size(); ++p)
      for (std::size_t k = round; k < (interleaved ? round + 1 : 100); ++k)
        if (k < parts[p].modes.size())
          take(p);
  auto body = std::make_unique<ExcitedBody>(modes.size(), slots.size(), parts.size(), widest);
  body->prepare(48000);
  body->set_modes(modes);
  std::size_t next = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    std::vector<double> pickup(modes.size(), 0.0);
    for (const std::size_t k : at[p])
      pickup[k] = 1;
    body->set_pickup(p, pickup);
    for (const Part::Striker& s : parts[p].strikers) {
      const std::size_t slot = slots[next++];
      std::vector<double> shape(modes.size(), 0.0);
      for (std::size_t k = 0; k < s.shape.size(); ++k)
        shape[at[p][k]] = s.shape[k];
      body->set_contact_shape(slot, shape);
      body->set_impact(slot, s.law, s.mass_kg);
      body->launch_mass(slot, s.gap_m, s.speed_m_per_s);
      body->set_mass_force(slot, s.push_n);
    }
  }
  return body;
}

inline std::unique_ptr<ExcitedBody> body_of(const Part& part) {
  return combined_body({part}, false, in_order(part.strikers.size()));
}

/// Adds to the modes' velocities, m/s at a point of shape 1, by an impulse at a contact point,
/// whose shape is then what that took.
inline void set_off(ExcitedBody& body, std::size_t slot, const std::vector<double>& velocities) {
  std::vector<double> shape;
  for (std::size_t k = 0; k < velocities.size(); ++k)
    shape.push_back(velocities[k] / std::pow(body.body().inverse_sqrt_mass(k), 2));
  body.set_contact_shape(slot, shape);
  body.apply_impulse(slot, 1);
}

} // namespace tactus::test
