#pragma once

#include "core/declaration_text.hpp"
#include "core/object.hpp"
#include "core/reed/instrument/parameter_rows.hpp"
#include "core/reed/instrument/presets.hpp"
#include "core/reed/playability/gradient_plane.hpp"
#include "core/refusal.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// Shared by [greed~], [greed_gradient~] and [playability_map]: presets and the message `range`.
namespace tactus::greed {

/// The messages `preset` and `range`, and the box's positional argument.
inline constexpr Message kPresetMessage{
    "preset", "clarinet|sax|oboe|trumpet|trombone|voice|syrinx", 1, 1,
    "instrument: sets valve and bore; in objects with a range, also a range in which it plays"};
inline constexpr Message kRangeMessage{
    "range", "p_lo p_hi f_lo f_hi", 4, 4,
    "range of the plane: mouth pressure in Pa at y = 0 and 1, reed frequency in Hz at z = 0 and 1"};
inline constexpr std::array kArguments{CreationArgument{"preset"}};

/// The parameter table with another initial value of one parameter.
template <std::size_t count>
[[nodiscard]] constexpr auto with_initial(std::string_view name, double value,
                                          std::array<Parameter, count> all) {
  for (Parameter& parameter : all)
    if (parameter.name == name)
      parameter.initial = value;
  return all;
}

/// Valve and bore of the preset with the numerics, player and air of `now`.
[[nodiscard]] inline reed::Parameters with_numerics(reed::Parameters preset,
                                                    const reed::Parameters& now) {
  for (const reed::Row& row : reed::kRows)
    if (row.preset == reed::Row::Preset::kLeaves)
      row.set(&preset, row.get(&now));
  return preset;
}

/// Sends the name of the preset that equals the parameters, except gain, note and the parameters
/// that a preset does not set. Compared to 24 bits, the precision of Pd's numbers.
inline void dump_preset(const reed::Parameters& now, Host& host) {
  const auto same = [&](const reed::Parameters& preset) {
    return std::all_of(reed::kRows.begin(), reed::kRows.end(), [&](const reed::Row& row) {
      return row.preset != reed::Row::Preset::kSets ||
             static_cast<float>(row.get(&preset)) == static_cast<float>(row.get(&now));
    });
  };
  for (const reed::Preset& preset : reed::presets())
    if (same(preset.parameters))
      host.info({"preset", preset.name});
}

/// Returns with_numerics() for the preset of that name. If there is none, reports an error and
/// returns nullopt.
[[nodiscard]] inline std::optional<reed::Parameters>
preset_of(const Atom& name, const reed::Parameters& now, Host& host) {
  const auto preset = name.is_word ? reed::find_preset(name.word) : std::nullopt;
  if (!preset) {
    std::string sentence = "preset " +
                           (name.is_word ? std::string(name.word) : number_text(name.number)) +
                           ": expected ";
    const auto all = reed::presets();
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i > 0)
        sentence += i + 1 == all.size() ? " or " : ", ";
      sentence += all[i].name;
    }
    host.error(sentence);
    return std::nullopt;
  }
  return with_numerics(*preset, now);
}

/// The range p_lo p_hi (Pa) f_lo f_hi (Hz) of the message `range`. Reports an error and returns
/// nullopt unless both pairs increase within their limits.
[[nodiscard]] inline std::optional<reed::ControlRange> range_of(std::span<const Atom> words,
                                                                Host& host) {
  constexpr double kHighestPressure = 50e3, kLowestFrequency = 1, kHighestFrequency = 20e3;
  const auto is_number = [&](std::size_t i, double low, double high) {
    return !words[i].is_word && words[i].number >= low && words[i].number <= high;
  };
  if (words.size() == 4 && is_number(0, -kHighestPressure, kHighestPressure) &&
      is_number(1, -kHighestPressure, kHighestPressure) &&
      is_number(2, kLowestFrequency, kHighestFrequency) &&
      is_number(3, kLowestFrequency, kHighestFrequency) && words[0].number < words[1].number &&
      words[2].number < words[3].number)
    return reed::ControlRange{words[0].number, words[1].number, words[2].number, words[3].number};
  host.error(
      refusal("range", words, "p_lo < p_hi in -50000..50000 Pa and f_lo < f_hi in 1..20000 Hz"));
  return std::nullopt;
}

} // namespace tactus::greed
