#include "core/footstep/recipe.hpp"
#include "files/recipe.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <set>
#include <sstream>
#include <string>

// The text of a recipe, from every key to the number that it sets.

using namespace tactus::footstep;
using tactus::files::read_recipe;

namespace {

std::string read(const std::string& text) {
  Recipe recipe;
  return read_recipe(text, recipe);
}

std::string number(double value) {
  std::ostringstream text;
  text << std::setprecision(12) << value;
  return text.str();
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

TEST_CASE("ranges and defaults are those of docs/formats/surface.md") {
  // Users' files rely on these: they are changed with a line in the change log, not in passing.
  std::ifstream page(std::filesystem::path(__FILE__).parent_path() /
                     "../../docs/formats/surface.md");
  std::string section, line, cell, name, range, initial;
  std::size_t rows = 0;
  while (std::getline(page, line)) {
    if (line.starts_with("### `["))
      section = line.substr(6, line.find(']') - 6);
    name.clear();
    std::istringstream cells(line);
    for (std::string* text : {&cell, &name, &range, &initial})
      std::getline(cells, *text, '|');
    if (!name.starts_with(" `") || range.find("..") == std::string::npos)
      continue;
    ++rows;
    CAPTURE(section);
    CAPTURE(line);
    const auto keys = recipe_keys();
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const RecipeKey& k) {
      return k.section == section && " `" + std::string(k.name) + "` " == name;
    });
    REQUIRE(key != keys.end());
    Recipe recipe;
    REQUIRE(read_recipe((section.empty() ? "" : "[" + section + "]\n") + "[solid]\n", recipe) ==
            "");
    CHECK(key->lowest == std::stod(range));
    CHECK(key->highest == std::stod(range.substr(range.find("..") + 2)));
    CHECK(key->member(recipe) == std::stod(initial));
  }
  CHECK(rows == recipe_keys().size());
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
  CHECK(read("colour 3\n[solid]\n") == "line 1: unknown key 'colour' before the first section");
  CHECK(read("[room]\ngains 3\n[solid]\n") == "line 2: unknown key 'gains' in [room]");
  CHECK(
      read("") ==
      "it has no sounding section: expected [solid], [friction], [grains], [bubbles] or [rustle]");
  CHECK(
      read("[room]\n") ==
      "it has no sounding section: expected [solid], [friction], [grains], [bubbles] or [rustle]");
  CHECK(read("[solid]\nfrequency 300000\n") == "line 2: frequency 300000 Hz: expected 20..12000");
  CHECK(read("# a\n[soild]\n") ==
        "line 2: [soild]: expected [solid], [friction], [grains], [bubbles], [rustle] or [room]");
  CHECK(read("[grains]\ncolour 3") == "line 2: unknown key 'colour' in [grains]");
  CHECK(read("[solid]\ngains 1 2 x") == "line 2: gains x dB: expected -120..120");
  CHECK(read("[grains]\n[grains]\n[grains]\n[bubbles]\n[grains]") ==
        "line 5: more than 4 sections of grains, bubbles and rustle");
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
