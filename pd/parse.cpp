#include "pd/parse.hpp"

#include "core/declaration_text.hpp"

#include <cmath>

namespace tactus::pd {
namespace {

bool is_flag(const Atom& atom) {
  return atom.is_word && atom.word.size() > 1 && (atom.word[0] == '-' || atom.word[0] == '@');
}

std::string set_parameter(const Declaration& declaration, std::size_t index,
                          std::span<const Atom> arguments, const Receiver& receiver) {
  const Parameter& parameter = declaration.parameters[index];
  if (arguments.size() != 1)
    return std::string(parameter.name) + ": expected one " +
           (parameter.choices.empty() ? "number" : "word") + ", got " +
           std::to_string(arguments.size());
  const Atom& given = arguments[0];
  double value = given.number;
  if (given.is_word) {
    const auto choice = find_choice(parameter, given.word);
    if (!choice)
      return out_of_range_text(parameter, given.word);
    value = static_cast<double>(*choice);
  } else if (!parameter.choices.empty()) {
    value = std::floor(value);
  }
  // A bound such as 1e-6 need not be a t_float; the t_float nearest to it means the bound.
  for (const double bound : {parameter.lowest, parameter.highest})
    if (static_cast<t_float>(value) == static_cast<t_float>(bound))
      value = bound;
  if (!is_allowed(parameter, value))
    return out_of_range_text(parameter, number_text(given.number));
  receiver.set(index, value);
  return {};
}

std::string argument_count(const Message& message, std::size_t given) {
  const std::string name(message.name);
  if (message.max_arguments == 0)
    return name + ": expected no arguments, got " + std::to_string(given);
  std::string count = std::to_string(message.min_arguments);
  if (message.max_arguments != message.min_arguments)
    count += message.max_arguments > 64 ? " or more" : ".." + std::to_string(message.max_arguments);
  return name + ": expected " + count +
         (message.max_arguments == 1 ? " argument (" : " arguments (") +
         std::string(message.arguments) + "), got " + std::to_string(given);
}

} // namespace

std::vector<Atom> to_atoms(int count, const t_atom* atoms) {
  std::vector<Atom> result;
  result.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    if (atoms[i].a_type == A_FLOAT)
      result.emplace_back(static_cast<double>(atoms[i].a_w.w_float));
    else if (atoms[i].a_type == A_SYMBOL)
      result.emplace_back(atoms[i].a_w.w_symbol->s_name);
    else
      result.emplace_back("pointer");
  }
  return result;
}

std::string text_of(const Atom& atom) {
  return atom.is_word ? std::string(atom.word) : number_text(atom.number);
}

std::string creation_commands(const Declaration& declaration, int count, const t_atom* atoms,
                              std::vector<Command>& commands) {
  const std::vector<Atom> given = to_atoms(count, atoms);
  std::size_t i = 0;
  for (std::size_t position = 0; i < given.size() && !is_flag(given[i]); ++position) {
    if (position >= declaration.arguments.size())
      return "creation argument '" + text_of(given[i]) + "': expected " +
             (declaration.arguments.empty()
                  ? std::string("-name value")
                  : "at most " + std::to_string(declaration.arguments.size()) +
                        " before the flags (-name value)");
    Command command{declaration.arguments[position].parameter, {given[i++]}};
    if (find_message(declaration, command.name))
      while (i < given.size() && !is_flag(given[i]))
        command.arguments.push_back(given[i++]);
    commands.push_back(std::move(command));
  }
  while (i < given.size()) {
    Command command{given[i].word.substr(1), {}};
    if (!find_parameter(declaration, command.name) && !find_message(declaration, command.name))
      return "creation flag '" + text_of(given[i]) +
             "': " + unknown_name_text(declaration, command.name);
    for (++i; i < given.size() && !is_flag(given[i]); ++i)
      command.arguments.push_back(given[i]);
    commands.push_back(std::move(command));
  }
  return {};
}

std::string execute(const Declaration& declaration, const Command& command,
                    const Receiver& receiver) {
  if (const auto parameter = find_parameter(declaration, command.name))
    return set_parameter(declaration, *parameter, command.arguments, receiver);
  const auto index = find_message(declaration, command.name);
  if (!index)
    return unknown_name_text(declaration, command.name);
  const Message& message = declaration.messages[*index];
  if (command.arguments.size() < message.min_arguments ||
      command.arguments.size() > message.max_arguments)
    return argument_count(message, command.arguments.size());
  receiver.message(*index, command.arguments);
  return {};
}

} // namespace tactus::pd
