#include "bench/modal_bank/large_bodies.hpp"

#include "core/modal/body/struck_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <memory>
#include <numbers>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

double thread_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

namespace {

using namespace tactus::modal;
using tactus::Vec3;

constexpr double kWidth = 1.5, kHeight = 1.2, kThickness = 0.5e-3; // m
constexpr std::size_t kColumns = 60, kRows = 40;

/// The lowest modes of a simply supported steel sheet (Leissa 1969, section 4.1).
std::shared_ptr<const LoadedTable> sheet(std::size_t modes) {
  constexpr double kPi = std::numbers::pi, kE = 200e9, kNu = 0.29, kRho = 7850;
  ModalTable table;
  table.free = false;
  table.material = {"steel", kE, kNu, kRho};
  table.mass_kg = kRho * kWidth * kHeight * kThickness;
  for (std::size_t j = 0; j <= kRows; ++j)
    for (std::size_t i = 0; i <= kColumns; ++i)
      table.vertex_m.push_back({kWidth * (static_cast<double>(i) / kColumns - 0.5),
                                kHeight * (static_cast<double>(j) / kRows - 0.5), 0});
  for (std::size_t j = 0; j < kRows; ++j)
    for (std::size_t i = 0; i < kColumns; ++i) {
      const auto p = static_cast<std::int32_t>(j * (kColumns + 1) + i);
      const auto q = static_cast<std::int32_t>(p + static_cast<std::int32_t>(kColumns) + 1);
      table.triangle.push_back({p, p + 1, q + 1});
      table.triangle.push_back({p, q + 1, q});
    }
  const double factor =
      kPi / 2 * kThickness * std::sqrt(kE / (12 * (1 - kNu * kNu) * kRho)); // m^2/s
  std::vector<std::tuple<double, int, int>> found;
  for (int m = 1; m < 400; ++m)
    for (int n = 1; n < 400; ++n)
      found.emplace_back(factor * (m * m / (kWidth * kWidth) + n * n / (kHeight * kHeight)), m, n);
  std::sort(found.begin(), found.end());
  found.resize(std::min(modes, found.size()));
  const auto wave = [](int n, double x) { return std::sin(n * kPi * (x + 0.5)); };
  for (const auto& [frequency, m, n] : found) {
    table.frequency_hz.push_back(frequency);
    table.loss_factor.push_back(1e-3);
    for (const Vec3& v : table.vertex_m) {
      const double shape =
          2 / std::sqrt(table.mass_kg) * wave(m, v.x / kWidth) * wave(n, v.y / kHeight);
      table.shape.insert(table.shape.end(), {0, 0, static_cast<float>(shape)});
    }
  }
  return std::make_shared<const LoadedTable>(std::move(table));
}

struct Plate {
  Plate(const std::shared_ptr<const LoadedTable>& table, std::size_t listeners)
      : Plate(table, with(listeners)) {}
  Plate(const std::shared_ptr<const LoadedTable>& table, const BodySettings& settings) {
    body.prepare(48000);
    const double begin = thread_cpu_seconds();
    body.publish(std::make_unique<BodyModel>(table, settings), false);
    model_s = thread_cpu_seconds() - begin;
    body.adopt();
  }
  static BodySettings with(std::size_t listeners) {
    BodySettings settings;
    settings.listeners = listeners;
    settings.voices = 16;
    return settings;
  }
  void block() {
    const std::array<std::span<float>, 4> out{sound[0], sound[1], sound[2], sound[3]};
    body.process<float>(force, height, out, contact);
  }
  [[nodiscard]] SurfacePoint at(double x, double y) const {
    return body.model()->nearest({x, y, 1});
  }
  StruckBody body;
  double model_s = 0; ///< to make the model, beside the audio path
  std::array<float, 64> force{}, height{}, contact{};
  std::array<std::array<float, 64>, 4> sound{};
};

/// The longest of `blocks` blocks: the least and the largest of some rounds, s.
std::pair<double, double> longest_block(int blocks, const std::function<void(int)>& block) {
  double minimum = 1e30, largest = 0;
  for (int round = 0; round < 12; ++round) {
    double longest = 0;
    for (int n = 0; n < blocks; ++n) {
      const double begin = thread_cpu_seconds();
      block(n);
      longest = std::max(longest, thread_cpu_seconds() - begin);
    }
    minimum = std::min(minimum, longest);
    largest = std::max(largest, longest);
  }
  return {minimum, largest};
}

} // namespace

void large_bodies(std::size_t only) {
  constexpr double kBlock = 64.0 / 48000;
  for (const std::size_t modes : {1024UL, 4096UL, 20000UL}) {
    if (only > 0 && modes != only)
      continue;
    const auto table = sheet(modes);
    for (const std::size_t listeners : {1UL, 2UL, 4UL}) {
      Plate plate(table, listeners);
      const auto print = [&](const char* what, std::pair<double, double> time) {
        std::printf(
            "%5zu modes, %zu listeners, %-28s %.2f ms, %.2f of a block (worst round %.2f)\n", modes,
            listeners, what, time.first * 1e3, time.first / kBlock, time.second / kBlock);
      };
      std::printf("%5zu modes, %zu listeners: model made in %.2f s\n", modes, listeners,
                  plate.model_s);
      const auto rings = longest_block(40, [&](int) { plate.block(); });
      print("silence:", rings);
      for (const int strikes : {1, 8})
        print(strikes == 1 ? "1 strike:" : "8 strikes at one sample:",
              longest_block(40, [&](int n) {
                for (int i = 0; i < strikes && n == 0; ++i) {
                  const SurfacePoint point = plate.at(0.13 + 0.03 * i, 0.11 - 0.04 * i);
                  plate.body.schedule(Hit{point, point.normal, 1}, plate.body.clock());
                }
                plate.block();
              }));
      plate.force.fill(1);
      std::int64_t sample = plate.body.clock();
      print("point moved at 1 kHz:", longest_block(40, [&](int n) {
              for (; sample < plate.body.clock() + 64; sample += 48) {
                const SurfacePoint point = plate.at(0.01 * n, 0.1);
                plate.body.schedule(ForcePoint{point, point.normal}, sample);
              }
              plate.block();
            }));
      plate.force.fill(0);
      plate.height.fill(-1e-5F);
      StruckBody::Options options = plate.body.options();
      options.driven = true;
      plate.body.set_options(options);
      sample = plate.body.clock();
      print("hand dragged at 1 kHz:", longest_block(40, [&](int n) {
              for (; sample < plate.body.clock() + 64; sample += 48) {
                const SurfacePoint point = plate.at(0.01 * n, 0.1);
                plate.body.schedule(ForcePoint{point, point.normal}, sample);
              }
              plate.block();
            }));
      std::fflush(stdout);
    }
  }
}

void resting_bodies() {
  for (const std::size_t modes : {16UL, 64UL, 256UL}) {
    const auto table = sheet(modes);
    const auto both = std::make_shared<const LoadedTable>(table, table, Vec3{0.01, 0.02, -0.03});
    double apart = 0;
    for (const std::size_t points : {0UL, 1UL, 2UL, 4UL, 8UL}) {
      BodySettings settings;
      settings.rest.pressing_n = 20;
      for (std::size_t i = 0; i < points; ++i) {
        const auto along = static_cast<double>(i);
        settings.rest.point_m.push_back({-0.5 + 0.13 * along, 0.05 + 0.03 * along, 0});
      }
      Plate plate(both, settings);
      const SurfacePoint point = plate.at(0.13, 0.11);
      plate.body.schedule(Hit{point, point.normal, 1}, plate.body.clock());
      for (int n = 0; n < 75; ++n) // until the striker has gone
        plate.block();
      double minimum = 1e30;
      for (int round = 0; round < 12; ++round) {
        const double begin = thread_cpu_seconds();
        for (int n = 0; n < 20; ++n)
          plate.block();
        minimum = std::min(minimum, (thread_cpu_seconds() - begin) / (20 * 64));
      }
      if (points == 0)
        apart = minimum;
      std::printf(
          "two bodies of %3zu modes, %zu points of rest: %6.0f ns a sample, %5.1f times apart, "
          "%u steps\n",
          modes, points, minimum * 1e9, minimum / apart, plate.body.model()->solver.steps());
      std::fflush(stdout);
    }
  }
}
