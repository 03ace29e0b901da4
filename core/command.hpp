#pragma once

#include "core/object.hpp"

#include <string>
#include <vector>

/// What a message of a host means to an object, by the object's declaration. The same for every
/// host: a shell translates its own atoms to and from Atom, and no more.
namespace tactus {

/// The word itself, or the number to 7 digits.
[[nodiscard]] std::string text_of(const Atom& atom);

/// One message: a selector of the declaration and what came with it.
struct Command {
  std::string_view name;
  std::vector<Atom> arguments;
};

/// Splits creation arguments into commands: flags, `-name value ...` or `@name value ...`, each
/// with as many values as its parameter or message takes, and before, between or after them
/// positional arguments in the declaration's order. Positional ones become the first commands, so
/// that flags refine them. Returns a sentence when they are malformed, else an empty one.
[[nodiscard]] std::string creation_commands(const Declaration&, std::span<const Atom> given,
                                            std::vector<Command>& commands);

/// Why a list to the first inlet of an object without a message `list` cannot be one number for
/// each inlet from the left; empty if it can.
[[nodiscard]] std::string list_refusal(const Declaration&, std::span<const Atom> numbers);

/// What a command asks for: a parameter's new value or one of the declared messages.
struct Request {
  enum class Kind { kParameter, kMessage, kRefused };
  Kind kind;
  std::size_t index = 0;    ///< of the parameter or message
  double value = 0;         ///< of the parameter, within its range
  std::string refusal = {}; ///< one sentence, of a refused command
};

/// Whether a message with these arguments may look for a file or an array of the host: one of its
/// words looks like a file's name, or the declaration says that a name follows.
[[nodiscard]] bool names_file(const Message& message, std::span<const Atom> arguments);

/// How precise the numbers are that a host passes: kSingle lets the float nearest to a bound such
/// as 1e-6 mean the bound.
enum class HostPrecision { kSingle, kDouble };

/// Checks a command against the declaration.
[[nodiscard]] Request resolve(const Declaration&, std::string_view name,
                              std::span<const Atom> arguments, HostPrecision precision);

} // namespace tactus
