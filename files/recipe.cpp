#include "files/recipe.hpp"

#include "core/declaration_text.hpp"
#include "core/text.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace tactus::files {
namespace {

using footstep::CloudRecipe;
using footstep::kMaxClouds;
using footstep::ModesRecipe;
using footstep::Recipe;
using footstep::recipe_keys;
using footstep::RecipeKey;

constexpr double kDefaultRoomLevel = -10; // dB, for a section [room] without a level
constexpr std::array<std::string_view, 6> kSections{"solid",   "friction", "grains",
                                                    "bubbles", "rustle",   "room"};

class Reader {
public:
  std::string line(std::string_view text) {
    const auto words = split_words(text.substr(0, text.find('#')));
    if (words.empty())
      return {};
    if (words[0].front() == '[')
      return open(words[0]);
    if (words[0] == "gains" && (section_ == "solid" || section_ == "friction"))
      return gains(words);
    const auto keys = recipe_keys();
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const RecipeKey& k) {
      return k.section == section_ && k.name == words[0];
    });
    if (key == keys.end())
      return "unknown key '" + std::string(words[0]) + "' " +
             (section_.empty() ? "before the first section" : "in [" + std::string(section_) + "]");
    const std::string label = std::string(words[0]);
    const auto value = words.size() == 2 ? to_number(words[1]) : std::nullopt;
    if (!value)
      return label + ": expected one number";
    if (*value < key->lowest || *value > key->highest)
      return label + " " + number_text(*value) + (key->unit.empty() ? "" : " ") +
             std::string(key->unit) + ": expected " + number_text(key->lowest) + ".." +
             number_text(key->highest);
    key->member(recipe) = *value;
    return {};
  }

  Recipe recipe;

private:
  std::string open(std::string_view word) {
    const auto name = word.substr(1, word.size() - std::min<std::size_t>(word.size(), 2));
    const auto* section = std::find(kSections.begin(), kSections.end(), name);
    if (word.back() != ']' || section == kSections.end())
      return std::string(word) +
             ": expected [solid], [friction], [grains], [bubbles], [rustle] or [room]";
    section_ = *section;
    if (section_ == "solid") {
      recipe.solid.present = true;
    } else if (section_ == "friction") {
      recipe.friction.present = true;
    } else if (section_ == "room") {
      recipe.room.level_db = kDefaultRoomLevel;
    } else {
      if (recipe.clouds == kMaxClouds)
        return "more than " + number_text(kMaxClouds) + " sections of grains, bubbles and rustle";
      CloudRecipe& cloud = recipe.cloud[recipe.clouds++];
      if (section_ == "bubbles")
        cloud.settings.kind = particle::CloudSettings::Kind::kBubbles;
      else if (section_ == "rustle")
        cloud.settings.kind = particle::CloudSettings::Kind::kRustle;
    }
    return {};
  }

  std::string gains(const std::vector<std::string_view>& words) {
    ModesRecipe& modes = section_ == "solid" ? recipe.solid.modes : recipe.friction.modes;
    if (words.size() < 2 || words.size() > footstep::kMaxModes + 1)
      return "gains: expected 1.." + number_text(footstep::kMaxModes) + " numbers";
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto value = to_number(words[i], -120., 120.);
      if (!value)
        return "gains " + std::string(words[i]) + " dB: expected -120..120";
      modes.gains_db[i - 1] = *value;
    }
    return {};
  }

  std::string_view section_;
};

} // namespace

std::string read_recipe(std::string_view text, Recipe& recipe) {
  Reader reader;
  std::string refusal;
  for_each_line(text, [&](std::size_t number, std::string_view line) {
    if (const std::string why = reader.line(line); !why.empty())
      refusal = "line " + std::to_string(number) + ": " + why;
    return refusal.empty();
  });
  if (!refusal.empty())
    return refusal;
  if (!reader.recipe.solid.present && !reader.recipe.friction.present && reader.recipe.clouds == 0)
    return "it has no sounding section: expected [solid], [friction], [grains], [bubbles] or "
           "[rustle]";
  recipe = reader.recipe;
  return {};
}

} // namespace tactus::files
