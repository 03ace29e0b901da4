// Renders single steps of one foot:
//   render_footstep RECIPE OUT STEPS [SEED [SPEED [RATE [shares]]]]
// OUT gets 32-bit floats, the steps one after another, each from 10 ms before the heel lands for
// one stride. Printed: the number of samples of a step, then with `shares` a line for each section
// of the recipe: its name and the energy of the same steps when it sounds alone, without the room.

#include "bench/recipe_sections.hpp"
#include "core/footstep/foot.hpp"
#include "core/footstep/gait.hpp"
#include "files/recipe.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

using namespace tactus::footstep;

namespace {

struct Walk {
  long steps = 1;
  std::uint64_t seed = 1;
  double speed = 1.4, rate = 44100;
};

struct Sound {
  std::vector<float> samples;
  std::vector<std::size_t> contacts; ///< samples at which the heel lands
};

std::size_t stride_samples(const Walk& walk) {
  GroundReaction usual;
  usual.set({walk.speed, 700, 0.4});
  return static_cast<std::size_t>(usual.stride_s() * walk.rate);
}

std::size_t samples_before(const Walk& walk) { return static_cast<std::size_t>(0.01 * walk.rate); }

Sound walked(const Recipe& recipe, const Walk& walk, bool room) {
  const auto foot = std::make_unique<Foot>();
  foot->prepare(walk.rate);
  foot->seed(walk.seed);
  if (!room)
    foot->set_room(0);
  foot->set_grounds(1, recipe, 1, recipe, 0);
  Gait gait;
  gait.prepare(walk.rate);
  gait.seed(walk.seed);
  gait.set({walk.speed, 700, 0.4}, 0.04);
  gait.walk(true);
  Sound sound;
  sound.samples.resize(samples_before(walk));
  std::array<SoleState, Gait::kFeet> feet{};
  while (static_cast<long>(sound.contacts.size()) <= walk.steps ||
         sound.samples.size() < sound.contacts.back() + stride_samples(walk)) {
    gait.next(feet);
    if (feet[0].heel_landing > 0)
      sound.contacts.push_back(sound.samples.size());
    sound.samples.push_back(static_cast<float>(foot->next(feet[0]).pressure_pa));
  }
  return sound;
}

bool write(const Sound& sound, const Walk& walk, const char* path) {
  const std::size_t length = stride_samples(walk);
  std::ofstream out(path, std::ios::binary);
  for (long k = 0; k < walk.steps; ++k) {
    const std::size_t from = sound.contacts[static_cast<std::size_t>(k)] - samples_before(walk);
    // What the next step of this foot sounds is cut off: a gap of varying length stays silent.
    const std::size_t to = std::min(from + length, sound.contacts[static_cast<std::size_t>(k) + 1]);
    std::vector<float> step(sound.samples.begin() + static_cast<long>(from),
                            sound.samples.begin() + static_cast<long>(to));
    step.resize(length);
    out.write(reinterpret_cast<const char*>(step.data()),
              static_cast<std::streamsize>(length * sizeof(float)));
  }
  return static_cast<bool>(out);
}

} // namespace

int main(int count, char** arguments) {
  if (count < 4) {
    std::fprintf(stderr, "render_footstep RECIPE OUT STEPS [SEED [SPEED [RATE [shares]]]]\n");
    return 2;
  }
  std::ifstream file(arguments[1]);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  Recipe recipe;
  if (const std::string error = tactus::files::read_recipe(text, recipe); !file || !error.empty()) {
    std::fprintf(stderr, "%s: %s\n", arguments[1], file ? error.c_str() : "cannot be read");
    return 1;
  }
  Walk walk;
  walk.steps = std::atol(arguments[3]);
  if (count > 4)
    walk.seed = std::strtoull(arguments[4], nullptr, 10);
  if (count > 5)
    walk.speed = std::atof(arguments[5]);
  if (count > 6)
    walk.rate = std::atof(arguments[6]);
  const bool shares = count > 7 && std::string(arguments[7]) == "shares";

  const bool written = write(walked(recipe, walk, true), walk, arguments[2]);
  std::printf("%zu\n", stride_samples(walk));
  if (shares)
    for (const auto& section : tactus::bench::sounding_sections(text)) {
      Recipe alone;
      if (const std::string error =
              tactus::files::read_recipe(tactus::bench::only(text, section), alone);
          !error.empty()) {
        std::fprintf(stderr, "%s: %s\n", arguments[1], error.c_str());
        return 1;
      }
      double energy = 0;
      for (const float x : walked(alone, walk, false).samples)
        energy += static_cast<double>(x) * static_cast<double>(x);
      std::printf("%s %.6g\n", section.name.c_str(), energy);
    }
  return written ? 0 : 1;
}
