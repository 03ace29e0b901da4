#include "core/command.hpp"

#include "core/declaration_text.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
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

/// The largest number of values that the parameter or message of this name takes.
std::optional<std::size_t> max_arguments(const Declaration& declaration, std::string_view name) {
  if (find_parameter(declaration, name))
    return 1;
  if (const auto message = find_message(declaration, name))
    return declaration.messages[*message].max_arguments;
  return std::nullopt;
}

/// Usage text of the creation arguments: "preset, then -name value".
std::string usage(const Declaration& declaration) {
  std::string words;
  for (const CreationArgument& argument : declaration.arguments)
    words += std::string(argument.parameter) + ", then ";
  return words + "-name value";
}

} // namespace

std::string text_of(const Atom& atom) {
  return atom.is_word ? std::string(atom.word) : number_text(atom.number);
}

std::string creation_commands(const Declaration& declaration, std::span<const Atom> given,
                              std::vector<Command>& commands) {
  std::vector<Command> flags;
  std::size_t position = 0;
  for (std::size_t i = 0; i < given.size();) {
    const bool flag = is_flag(given[i]);
    if (!flag && position == declaration.arguments.size())
      return "creation argument '" + text_of(given[i]) + "': expected " + usage(declaration);
    Command command{flag ? given[i++].word.substr(1) : declaration.arguments[position++].parameter,
                    {}};
    const auto most = max_arguments(declaration, command.name);
    if (!most)
      return "creation flag '" + text_of(given[i - 1]) +
             "': " + unknown_name_text(declaration, command.name);
    for (; i < given.size() && !is_flag(given[i]) && command.arguments.size() < *most; ++i)
      command.arguments.push_back(given[i]);
    (flag ? flags : commands).push_back(std::move(command));
  }
  std::move(flags.begin(), flags.end(), std::back_inserter(commands));
  return {};
}

std::string list_refusal(const Declaration& declaration, std::span<const Atom> numbers) {
  std::string inlets;
  for (const Port& inlet : declaration.inlets) {
    inlets += (inlets.empty() ? "" : ", ") + std::string(inlet.name);
    if (!inlet.unit.empty())
      inlets += " (" + std::string(inlet.unit) + ")";
  }
  for (const Atom& atom : numbers)
    if (atom.is_word)
      return "list: '" + text_of(atom) + "': not a number: expected one for each inlet: " + inlets;
  if (numbers.size() > declaration.inlets.size())
    return "list: " + std::to_string(numbers.size()) + " numbers: expected at most " +
           std::to_string(declaration.inlets.size()) + ", one for each inlet: " + inlets;
  return {};
}

bool names_file(const Message& message, std::span<const Atom> arguments) {
  return std::any_of(arguments.begin(), arguments.end(), [&](const Atom& atom) {
    return atom.is_word && (atom.word.find_first_of("./\\") != std::string_view::npos ||
                            message.name_behind == "*" || message.name_behind == atom.word);
  });
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
