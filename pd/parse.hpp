#pragma once

#include "core/object.hpp"

#include <functional>
#include <string>
#include <vector>

#include <m_pd.h>

/// From Pd's atoms to settings and messages, by an object's declaration.
namespace tactus::pd {

[[nodiscard]] std::vector<Atom> to_atoms(int count, const t_atom* atoms);
[[nodiscard]] std::string text_of(const Atom& atom);

/// One message: a selector of the declaration and what came with it.
struct Command {
  std::string_view name;
  std::vector<Atom> arguments;
};

/// Splits creation arguments into commands: positional ones first, by the declaration's order
/// (a message takes all that are left), then `-name value ...` or `@name value ...`.
/// Returns a sentence when they are malformed, else an empty one.
[[nodiscard]] std::string creation_commands(const Declaration&, int count, const t_atom* atoms,
                                            std::vector<Command>& commands);

/// Carries out a command on whatever set and send do; returns a sentence when it is refused.
struct Receiver {
  std::function<void(std::size_t parameter, double value)> set;
  std::function<void(std::size_t message, std::span<const Atom>)> message;
};
[[nodiscard]] std::string execute(const Declaration&, const Command&, const Receiver&);

} // namespace tactus::pd
