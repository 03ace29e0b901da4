#include "core/command.hpp"

#include "core/declaration_text.hpp"

#include <cmath>
#include <utility>

namespace tactus {
namespace {

bool is_flag(const Atom& atom) {
  return atom.is_word && atom.word.size() > 1 && (atom.word[0] == '-' || atom.word[0] == '@');
}

Request refused(std::string sentence) {
  return {Request::Kind::kRefused, 0, 0, std::move(sentence)};
}

bool is_bound(double value, double bound, HostPrecision precision) {
  return precision == HostPrecision::kSingle
             ? static_cast<float>(value) == static_cast<float>(bound)
             : value == bound;
}

Request resolve_parameter(const Declaration& declaration, std::size_t index,
                          std::span<const Atom> arguments, HostPrecision precision) {
  const Parameter& parameter = declaration.parameters[index];
  if (arguments.size() != 1)
    return refused(std::string(parameter.name) + ": expected one " +
                   (parameter.choices.empty() ? "number" : "word") + ", got " +
                   std::to_string(arguments.size()));
  const Atom& given = arguments[0];
  double value = given.number;
  if (given.is_word) {
    const auto choice = find_choice(parameter, given.word);
    if (!choice)
      return refused(out_of_range_text(parameter, given.word));
    value = static_cast<double>(*choice);
  } else if (!parameter.choices.empty()) {
    value = std::floor(value);
  }
  for (const double bound : {parameter.lowest, parameter.highest})
    if (is_bound(value, bound, precision))
      value = bound;
  if (!is_allowed(parameter, value))
    return refused(out_of_range_text(parameter, number_text(given.number)));
  return {Request::Kind::kParameter, index, value};
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

std::string text_of(const Atom& atom) {
  return atom.is_word ? std::string(atom.word) : number_text(atom.number);
}

std::string creation_commands(const Declaration& declaration, std::span<const Atom> given,
                              std::vector<Command>& commands) {
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

Request resolve(const Declaration& declaration, std::string_view name,
                std::span<const Atom> arguments, HostPrecision precision) {
  if (const auto parameter = find_parameter(declaration, name))
    return resolve_parameter(declaration, *parameter, arguments, precision);
  const auto index = find_message(declaration, name);
  if (!index)
    return refused(unknown_name_text(declaration, name));
  const Message& message = declaration.messages[*index];
  if (arguments.size() < message.min_arguments || arguments.size() > message.max_arguments)
    return refused(argument_count(message, arguments.size()));
  return {Request::Kind::kMessage, *index};
}

} // namespace tactus
