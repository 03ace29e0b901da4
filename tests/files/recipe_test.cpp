#include "core/footstep/recipe.hpp"
#include "files/recipe.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <string>
#include <vector>

// The text of a recipe, from every key to the number that it sets.

using namespace tactus::footstep;
using tactus::files::read_recipe;

namespace {

std::string read(const std::string& text) {
  Recipe recipe;
  return read_recipe(text, recipe);
}

std::string number(double value) {
  std::string text = std::to_string(value);
  if (std::abs(value) < 1e-3 && value != 0) {
    char small[32];
    std::snprintf(small, sizeof small, "%.9g", value);
    text = small;
  }
  return text;
}

/// A recipe of that key alone, in its section and with something that sounds.
std::string with(const RecipeKey& key, const std::string& value) {
  const std::string section = key.section.empty() ? "" : "[" + std::string(key.section) + "]\n";
  return section + std::string(key.name) + " " + value + "\n[solid]\n";
}

} // namespace

TEST_CASE("every key sets its own number within its range, and refuses values outside") {
  std::set<std::string> names;
  for (const RecipeKey& key : recipe_keys()) {
    CAPTURE(key.section);
    CAPTURE(key.name);
    CHECK(names.insert(std::string(key.section) + " " + std::string(key.name)).second);
    CHECK(key.lowest < key.highest);
    CHECK_FALSE(key.text.empty());
    for (const double value :
         {key.lowest, key.highest, key.lowest + 0.37 * (key.highest - key.lowest)}) {
      Recipe recipe;
      REQUIRE(read_recipe(with(key, number(value)), recipe) == "");
      CHECK(key.member(recipe) == doctest::Approx(value));
      // No other key of the section has moved.
      Recipe plain;
      REQUIRE(read_recipe(key.section.empty() ? "[solid]\n"
                                              : "[" + std::string(key.section) + "]\n[solid]\n",
                          plain) == "");
      for (const RecipeKey& other : recipe_keys())
        if (other.section == key.section && &other != &key)
          CHECK(other.member(recipe) == other.member(plain));
    }
    const double step = 0.01 * (key.highest - key.lowest);
    for (const double beyond : {key.lowest - step, key.highest + step}) {
      const std::string error_text = read(with(key, number(beyond)));
      CHECK(error_text.find(std::string(key.name) + " ") != std::string::npos);
      CHECK(error_text.find(": expected ") != std::string::npos);
      CHECK((key.unit.empty() ||
             error_text.find(" " + std::string(key.unit) + ": ") != std::string::npos));
    }
  }
  for (const char* section : {"solid", "friction", "grains", "bubbles", "rustle", "room", ""})
    CHECK(std::any_of(recipe_keys().begin(), recipe_keys().end(),
                      [&](const RecipeKey& key) { return key.section == section; }));
}

TEST_CASE("ranges set by physics or hearing: shares of one, static friction, audible frequencies") {
  struct Range {
    std::string section, name;
    double lowest, highest;
  };
  for (const Range& r :
       {Range{"friction", "breakaway", 0.01, 0.99}, Range{"bubbles", "rise", 0, 1},
        Range{"solid", "detune", 0, 1}, Range{"solid", "modes", 1, 32},
        Range{"solid", "frequency", 20, 12000}, Range{"grains", "frequency", 20, 20000},
        Range{"room", "level", -60, 40}, Range{"room", "t60", 0.02, 10},
        Range{"room", "bright", 100, 20000}, Range{"solid", "exponent", 1, 6},
        Range{"grains", "largest", 1.001, 1e6}, Range{"grains", "exponent", 0.05, 20},
        Range{"grains", "quality", 0.1, 200}, Range{"rustle", "quality", 0.1, 200}}) {
    CAPTURE(r.name);
    const auto keys = recipe_keys();
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const RecipeKey& k) {
      return k.section == r.section && k.name == r.name;
    });
    REQUIRE(key != keys.end());
    CHECK(key->lowest == r.lowest);
    CHECK(key->highest == r.highest);
  }
}

TEST_CASE("keys that a recipe omits keep their documented defaults") {
  // Users' files rely on these: they are changed with a line in the change log, not in passing.
  const auto value = [](Recipe& recipe, std::string_view section, std::string_view name) {
    for (const RecipeKey& key : recipe_keys())
      if (key.section == section && key.name == name)
        return key.member(recipe);
    FAIL("no such key");
    return 0.0;
  };
  struct Default {
    std::string_view name;
    double value;
  };
  const auto check = [&](const std::string& text, std::string_view section,
                         std::initializer_list<Default> defaults) {
    Recipe recipe;
    REQUIRE(read_recipe(text, recipe) == "");
    for (const Default& d : defaults) {
      CAPTURE(section);
      CAPTURE(d.name);
      CHECK(value(recipe, section, d.name) == d.value);
    }
  };
  check("[solid]", "",
        {{"level", 1},
         {"felt", 2},
         {"felt_ball", 1},
         {"radiation", 40},
         {"vary_frequency", 0},
         {"vary_decay", 0}});
  for (const char* section : {"solid", "friction"})
    check("[solid]\n[friction]", section,
          {{"modes", 6},
           {"frequency", 150},
           {"ratio", 1.4},
           {"detune", 0.05},
           {"t60", 0.1},
           {"t60_tilt", 0.5},
           {"tilt", 0.5},
           {"mass", 0.25},
           {"place", 0.3},
           {"level", 1},
           {"vary_frequency", 0.05},
           {"vary_decay", 0.1},
           {"vary_level", 0.15}});
  check("[solid]", "solid",
        {{"stiffness", 1e9},
         {"exponent", 1.5},
         {"dissipation", 0.3},
         {"heel", 0.08},
         {"ball_mass", 0.05},
         {"ball", 0.6},
         {"patches", 4},
         {"unevenness", 0.004},
         {"roughness", 1}});
  check("[friction]", "friction",
        {{"mu_s", 0.8},
         {"mu_d", 0.3},
         {"stribeck", 0.06},
         {"breakaway", 0.4},
         {"stiffness", 8e4},
         {"damping", 20},
         {"viscosity", 0.4},
         {"roughness", 0},
         {"pressed", 6},
         {"load", 20},
         {"slip", 0.02},
         {"joint", 90},
         {"joint_mass", 0.1},
         {"joint_t60", 0.05},
         {"wobble", 0.2}});
  for (const std::string section : {"grains", "bubbles", "rustle"})
    check("[" + section + "]", section,
          {{"attack", 0.01},
           {"decay", 0.05},
           {"frequency", 1500},
           {"spread", 0.8},
           {"level", 1},
           {"heel", 1},
           {"ball", 0.5},
           {"load", 0},
           {"release", 0},
           {"slide", 10},
           {"vary_frequency", 0.05},
           {"vary_decay", 0.1},
           {"vary_level", 0.15}});
  for (const std::string section : {"grains", "bubbles"})
    check("[" + section + "]", section,
          {{"count", 200}, {"exponent", 1.5}, {"largest", 100}, {"lower_by_size", 0}});
  check("[grains]", "grains", {{"quality", 1}, {"length", 0.004}});
  check("[bubbles]", "bubbles", {{"rise", 0.1}});
  check("[solid]\n[room]", "room", {{"level", -10}, {"t60", 0.3}, {"bright", 4000}});
}

TEST_CASE("sections, clouds and gains are stored in their members") {
  Recipe recipe;
  REQUIRE(
      read_recipe("[bubbles]\nlevel 2\n[grains]\nlevel 3\n[rustle]\nlevel 4\n[grains]\nlevel 5\n"
                  "[friction]\ngains -3 6\n[solid]\ngains 1 2 3\n[room]\n",
                  recipe) == "");
  using Kind = tactus::particle::CloudSettings::Kind;
  REQUIRE(recipe.clouds == 4);
  const Kind kinds[] = {Kind::kBubbles, Kind::kGrains, Kind::kRustle, Kind::kGrains};
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(recipe.cloud[i].settings.kind == kinds[i]);
    CHECK(recipe.cloud[i].settings.level == 2. + static_cast<double>(i));
  }
  CHECK(recipe.friction.present);
  CHECK(recipe.solid.present);
  CHECK(recipe.friction.modes.gains_db[0] == -3);
  CHECK(recipe.friction.modes.gains_db[1] == 6);
  CHECK(recipe.friction.modes.gains_db[2] == 0);
  CHECK(recipe.solid.modes.gains_db[2] == 3);
  CHECK(recipe.room.level_db == -10); // that of a room of which no more is said
  REQUIRE(read_recipe("[rustle]\n", recipe) == "");
  CHECK_FALSE(recipe.solid.present);
  CHECK_FALSE(recipe.friction.present);
  CHECK(recipe.clouds == 1);
  CHECK(recipe.room.level_db == -60); // none
}

TEST_CASE("errors are found in their line, and the recipe is unchanged") {
  Recipe recipe;
  REQUIRE(read_recipe("[solid]\nfrequency 333\n", recipe) == "");
  CHECK(read_recipe("[solid]\nfrequency 444\nt60 0\n", recipe).find("line 3: t60 0 s: ") == 0);
  CHECK(recipe.solid.modes.frequency_hz == 333);
  for (const char* wrong :
       {"[]\n", "[\n", "[solid\n", "[solid]x\n", "[solid ]\n", "solid]\n", "[Solid]\n"})
    CHECK(read(std::string("\n") + wrong).find("line 2: ") == 0);
  CHECK(read("level 1 2\n[solid]\n") == "line 1: level: expected one number");
  CHECK(read("level 1x\n[solid]\n") == "line 1: level: expected one number");
  CHECK(read("level inf\n[solid]\n") == "line 1: level: expected one number");
  CHECK(read("colour 3\n[solid]\n") == "line 1: there is no 'colour' before the first section");
  CHECK(read("[room]\ngains 3\n[solid]\n") == "line 2: there is no 'gains' in [room]");
  CHECK(read("[room]\n") == "it has no section that sounds");
  std::string gains = "[solid]\ngains";
  CHECK(read(gains) == "line 2: gains: expected 1..32 numbers");
  for (int i = 0; i < 32; ++i)
    gains += i % 2 ? " 120" : " -120";
  CHECK(read(gains) == "");
  CHECK(read(gains + " 0") == "line 2: gains: expected 1..32 numbers");
  CHECK(read("[solid]\ngains 121\n") == "line 2: gains 121 dB: expected -120..120");
  CHECK(read("[solid]\ngains -120.5\n") == "line 2: gains -120.5 dB: expected -120..120");
  // Blanks, comments and line ends of any system.
  CHECK(read("  # nothing\n\n\t[solid]  # a floor\r\n frequency\t300\r\n#") == "");
  CHECK(read("[solid]") == "");
}
