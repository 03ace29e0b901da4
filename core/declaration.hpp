#pragma once

#include <cstddef>
#include <span>
#include <string_view>

/// What an object says of itself, once. Both host shells (pd/, max/), the help patches, the docs
/// pages, the package's object list and the fuzz ranges are made from this one table.
namespace tactus {

/// A number the user can set: creation flag `-name value`, message `name value`, `get name`.
struct Parameter {
  std::string_view name;
  std::string_view unit; ///< SI; empty for pure numbers
  double initial;
  double lowest, highest; ///< inclusive; a value outside is refused and the old one kept
  std::string_view text;  ///< one line for people
  /// When not empty the parameter is one of these words, its value the word's index.
  std::span<const std::string_view> choices{};
  /// When not empty the parameter is one of these numbers, in ascending order from lowest to
  /// highest; another one between them is refused.
  std::span<const double> values{};
};

/// An inlet or outlet.
struct Port {
  /// kList: a control inlet, not the first, that takes whole lists.
  enum class Kind { kSignal, kControl, kList };
  Kind kind;
  std::string_view name;
  std::string_view unit;
  std::string_view text;
};

/// A message that is not the setting of one number, e.g. `reset`, `range 0 8000 80 900`.
struct Message {
  std::string_view name;
  std::string_view arguments;               ///< as the help shows them: "p_lo p_hi f_lo f_hi"
  std::size_t min_arguments, max_arguments; ///< number of arguments accepted
  std::string_view text;
};

/// A positional creation argument; it sets the parameter of that name.
struct CreationArgument {
  std::string_view parameter;
};

/// Where answers come out. An object has it at the right, or declares it among its outlets.
inline constexpr std::string_view kInfoOutlet = "info";

struct Declaration {
  std::string_view name;        ///< as typed in a box: "greed~"
  std::string_view title;       ///< half a line: "generalised pressure-controlled valve on a bore"
  std::string_view description; ///< one paragraph
  std::string_view keywords;
  std::span<const Port> inlets;
  std::span<const Port> outlets; ///< the shell adds the info outlet at the right, if none is here
  std::span<const Parameter> parameters;
  std::span<const Message> messages{};
  std::span<const CreationArgument> arguments{};
};

} // namespace tactus
