#pragma once

#include "core/declaration.hpp"

#include <optional>
#include <string>
#include <string_view>

/// The sentences and look-ups that every shell shares, so that Pd and Max users read the same.
namespace tactus {

/// Shortest text that reads back as the number to 7 digits: "0.03", "1e-06", "440".
[[nodiscard]] std::string number_text(double value);

/// Index of the parameter or message of that name.
[[nodiscard]] std::optional<std::size_t> find_parameter(const Declaration&, std::string_view name);
[[nodiscard]] std::optional<std::size_t> find_message(const Declaration&, std::string_view name);
/// Whether the number is within the parameter's range and among its values, if it has some.
[[nodiscard]] bool is_allowed(const Parameter&, double value);
/// Index of the word among the parameter's choices.
[[nodiscard]] std::optional<std::size_t> find_choice(const Parameter&, std::string_view word);

/// "theta0 9 rad: expected -1..1", "type oval: expected closed, open or swing",
/// "os 3: expected 0, 1, 2 or 4".
[[nodiscard]] std::string out_of_range_text(const Parameter&, std::string_view given);
/// "no message 'presset'; did you mean 'preset'?"
[[nodiscard]] std::string unknown_name_text(const Declaration&, std::string_view name);

} // namespace tactus
