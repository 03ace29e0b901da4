#include "core/contact/impact.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>

/// On a spring an impact lasts half a period of the mass on it: pi sqrt(m/k). Here m = 0.1 kg and
/// k = 1e5 N/m.
int main() {
  const tactus::contact::ImpactLaw law{1e5, 1, 0, 0};
  const double seconds = law.duration(0.1, 2), expected = std::numbers::pi * 1e-3;
  std::printf("%.9g s, expected %.9g s\n", seconds, expected);
  return std::abs(seconds / expected - 1) < 1e-9 ? 0 : 1;
}
