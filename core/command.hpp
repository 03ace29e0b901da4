#pragma once

#include "core/object.hpp"

#include <string>
#include <vector>

/// Maps messages of a host to the parameters and messages of an object's declaration. All hosts
/// share this code: a shell only converts its own atoms to and from Atom.
namespace tactus {

/// The word itself, or the number to 7 digits.
[[nodiscard]] std::string text_of(const Atom& atom);

/// One message: a selector, which is a name of the declaration, and arguments.
struct Command {
  std::string_view name;
  std::vector<Atom> arguments;
};

/// Splits creation arguments into commands. A flag is `-name value ...` or `@name value ...`, with
/// as many values as its parameter or message takes. Positional arguments come before, between or
/// after the flags, in the declaration's order. They become the first commands, so that flags
/// refine them. Returns an error sentence if the arguments are malformed, else an empty string.
[[nodiscard]] std::string creation_commands(const Declaration&, std::span<const Atom> given,
                                            std::vector<Command>& commands);

/// For a list to the first inlet of an object without a message `list`: an error sentence if the
/// list cannot be distributed from the left as one number per inlet; else empty.
[[nodiscard]] std::string list_refusal(const Declaration&, std::span<const Atom> numbers);

/// A command checked against the declaration: a new value of a parameter, a declared message, or
/// the reason why the command is refused.
struct Request {
  enum class Kind { kParameter, kMessage, kRefused };
  Kind kind;
  std::size_t index = 0;    ///< index of the parameter or message
  double value = 0;         ///< new value of the parameter, within its range
  std::string refusal = {}; ///< error sentence, if refused
};

/// True if a message with these arguments may refer to a file or an array of the host: one of its
/// words looks like a file's name, or the declaration says that a name follows.
[[nodiscard]] bool names_file(const Message& message, std::span<const Atom> arguments);

/// Precision of the numbers that a host passes. With kSingle the float nearest to a bound such as
/// 1e-6 counts as the bound.
enum class HostPrecision { kSingle, kDouble };

/// Checks a command against the declaration.
[[nodiscard]] Request resolve(const Declaration&, std::string_view name,
                              std::span<const Atom> arguments, HostPrecision precision);

} // namespace tactus
