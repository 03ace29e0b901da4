#pragma once

#include "core/declaration.hpp"

#include <optional>
#include <string>
#include <string_view>

/// Look-ups in a Declaration, and the error sentences made from it.
namespace tactus {

/// Shortest text that reads back as the number to 7 digits: "0.03", "1e-06", "440". Allocates and
/// locks nothing, since error texts of realtime messages use it.
[[nodiscard]] std::string number_text(double value);

/// Index of the parameter or message of this name, if there is one.
[[nodiscard]] std::optional<std::size_t> find_parameter(const Declaration&, std::string_view name);
[[nodiscard]] std::optional<std::size_t> find_message(const Declaration&, std::string_view name);
/// Whether the number is within the parameter's range and among its values, if it has some.
[[nodiscard]] bool is_allowed(const Parameter&, double value);
/// Index of the word among the parameter's choices, if it is one of them.
[[nodiscard]] std::optional<std::size_t> find_choice(const Parameter&, std::string_view word);

/// Sentence for a refused value: "theta0 9 rad: expected -1..1", "type oval: expected closed, open
/// or swing", "os 3: expected 0, 1, 2 or 4".
[[nodiscard]] std::string out_of_range_text(const Parameter&, std::string_view given);
/// Sentence for an unknown message: "no message 'presset'; did you mean 'preset'?", "no message
/// 'bang'; there are preset, reset and tongue", "no message 'p_m'; it is inlet 1, a signal in Pa".
[[nodiscard]] std::string unknown_name_text(const Declaration&, std::string_view name);
/// Sentence for `get` of a name without a value: "get gian: unknown name; did you mean 'gain'?",
/// "get reset: a message has no value; 'dump' lists all values".
[[nodiscard]] std::string no_answer_text(const Declaration&, std::string_view name);

} // namespace tactus
