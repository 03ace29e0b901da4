// Renders single steps of one foot: render_footstep RECIPE OUT STEPS [SEED [SPEED [RATE]]]
// OUT gets 32-bit floats, the steps one after another, each from 10 ms before the heel lands for
// one stride; the number of samples of a step is printed.

#include "core/footstep/foot.hpp"
#include "core/footstep/gait.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

using namespace tactus::footstep;

int main(int count, char** words) {
  if (count < 4) {
    std::fprintf(stderr, "render_footstep RECIPE OUT STEPS [SEED [SPEED [RATE]]]\n");
    return 2;
  }
  std::ifstream file(words[1]);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  Recipe recipe;
  if (const std::string error = read_recipe(text, recipe); !file || !error.empty()) {
    std::fprintf(stderr, "%s: %s\n", words[1], file ? error.c_str() : "cannot be read");
    return 1;
  }
  const long steps = std::atol(words[3]);
  const std::uint64_t seed = count > 4 ? std::strtoull(words[4], nullptr, 10) : 1;
  const double speed = count > 5 ? std::atof(words[5]) : 1.4;
  const double rate = count > 6 ? std::atof(words[6]) : 44100;

  const auto foot = std::make_unique<Foot>();
  foot->prepare(rate);
  foot->seed(seed);
  foot->stand_on(1, recipe, 1, recipe, 0);
  Gait gait;
  gait.prepare(rate);
  gait.seed(seed);
  gait.set({speed, 700, 0.4}, 0.04);
  gait.walk(true);
  GroundReaction usual;
  usual.set({speed, 700, 0.4});
  const auto length = static_cast<std::size_t>(usual.stride_s() * rate);
  const auto before = static_cast<std::size_t>(0.01 * rate);

  std::vector<float> sound;
  std::vector<std::size_t> contacts;
  std::array<SoleState, Gait::kFeet> feet{};
  sound.resize(before);
  while (static_cast<long>(contacts.size()) <= steps || sound.size() < contacts.back() + length) {
    gait.next(feet);
    if (feet[0].heel_landing > 0)
      contacts.push_back(sound.size());
    sound.push_back(static_cast<float>(foot->next(feet[0]).heard));
  }
  std::ofstream out(words[2], std::ios::binary);
  for (long k = 0; k < steps; ++k) {
    const std::size_t from = contacts[static_cast<std::size_t>(k)] - before;
    // What the next step of this foot sounds is cut off: a gap of varying length stays silent.
    const std::size_t to = std::min(from + length, contacts[static_cast<std::size_t>(k) + 1]);
    std::vector<float> step(sound.begin() + static_cast<long>(from),
                            sound.begin() + static_cast<long>(to));
    step.resize(length);
    out.write(reinterpret_cast<const char*>(step.data()),
              static_cast<std::streamsize>(length * sizeof(float)));
  }
  std::printf("%zu\n", length);
  return out ? 0 : 1;
}
