#pragma once

#include "core/modal/body/struck_body.hpp"
#include "tests/core/modal/tables.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace tactus::test {

using namespace modal;

struct Output {
  std::vector<float> left, right, contact;
};

/// A body in a harness: the same table, struck and heard.
struct Rig {
  explicit Rig(double sample_rate = 48000, ModalTable table = plate()) {
    settings.sample_rate = sample_rate;
    settings.radiation = Radiation::kNone;
    settings.listener = {Vec3{0.051, 0.043, 0.1}, Vec3{-0.037, 0.021, 0.1}};
    loaded = std::make_shared<const LoadedTable>(std::move(table));
    body.prepare(sample_rate);
    options.gain = 1;
    options.cull_db = 200;
    rebuild(false);
  }
  void rebuild(bool same = true) {
    body.set_options(options);
    body.publish(std::make_unique<BodyModel>(loaded, settings), same);
    body.adopt();
  }
  void hit(Vec3 point, double speed) {
    body.set_options(options);
    const SurfacePoint at = body.model()->nearest(point);
    body.hit({at, at.normal, speed});
  }
  Output run(std::size_t frames, std::size_t block = 64, std::vector<float> force = {},
             std::vector<float> height = {}) {
    force.resize(frames);
    height.resize(frames);
    Output output{std::vector<float>(frames), std::vector<float>(frames),
                  std::vector<float>(frames)};
    for (std::size_t n = 0; n < frames; n += block) {
      const std::size_t count = std::min(block, frames - n);
      const auto part = [&](std::vector<float>& x) { return std::span(x).subspan(n, count); };
      const std::array<std::span<float>, 2> out{part(output.left), part(output.right)};
      body.process<float>(part(force), part(height), out, part(output.contact));
    }
    return output;
  }

  BodySettings settings;
  StruckBody::Options options;
  std::shared_ptr<const LoadedTable> loaded;
  StruckBody body;
};

inline double impulse(const Output& output, double rate) {
  double sum = 0;
  for (const float f : output.contact)
    sum += static_cast<double>(f) / rate;
  return sum;
}

} // namespace tactus::test
