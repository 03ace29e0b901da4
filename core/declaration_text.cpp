#include "core/declaration_text.hpp"

#include <algorithm>
#include <charconv>
#include <utility>
#include <vector>

namespace tactus {
namespace {

template <class List>
std::optional<std::size_t> find_named(const List& list, std::string_view name) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (list[i].name == name)
      return i;
  return std::nullopt;
}

/// Optimal string alignment distance: letters to insert, delete, replace or swap with their
/// neighbour from one word to the other.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before, above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j)
    row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = std::exchange(above, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

/// The items of a list, as in "closed, open or swing".
template <class List, class Text>
std::string alternatives(const List& list, Text text, std::string_view last = " or ") {
  std::string sentence;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (i > 0)
      sentence += i + 1 == list.size() ? last : ", ";
    sentence += text(list[i]);
  }
  return sentence;
}

/// The candidate that differs from the name by the fewest edits; empty if none is close. At most
/// two edits, or one in words of up to four letters, since two edits turn a short word into nearly
/// any other.
class Nearest {
public:
  explicit Nearest(std::string_view name)
      : name_(name), min_distance_(name.size() > kShort ? 3 : 2) {}
  void consider(std::string_view candidate) {
    const std::size_t distance = edits(name_, candidate);
    if (distance < min_distance_ && distance < candidate.size())
      min_distance_ = distance, nearest_ = candidate;
  }
  [[nodiscard]] std::string_view found() const { return nearest_; }

private:
  static constexpr std::size_t kShort = 4;
  std::string_view name_, nearest_{};
  std::size_t min_distance_; // distance of the nearest candidate so far; initially the smallest
                             // distance that is too large
};

std::string did_you_mean(std::string_view name) {
  return "; did you mean '" + std::string(name) + "'?";
}

/// "; it is inlet 1, a signal in Pa" for the name of an inlet, which takes values without a
/// selector; else empty.
std::string inlet_hint(const Declaration& declaration, std::string_view name) {
  const auto index = find_named(declaration.inlets, name);
  if (!index)
    return {};
  const Port& inlet = declaration.inlets[*index];
  std::string hint = "; it is inlet " + std::to_string(*index + 1);
  if (inlet.kind == Port::Kind::kSignal)
    hint += ", a signal";
  if (!inlet.unit.empty())
    hint += (inlet.kind == Port::Kind::kSignal ? " in " : ", in ") + std::string(inlet.unit);
  return hint;
}

/// Messages that hosts send on their own. They are not taken for misspelt messages of an object.
bool is_of_the_host(std::string_view name) {
  return name == "bang" || name == "float" || name == "list" || name == "symbol";
}

} // namespace

std::string number_text(double value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 7);
  return {text, end.ptr};
}

std::optional<std::size_t> find_parameter(const Declaration& declaration, std::string_view name) {
  return find_named(declaration.parameters, name);
}

std::optional<std::size_t> find_message(const Declaration& declaration, std::string_view name) {
  return find_named(declaration.messages, name);
}

std::optional<std::size_t> find_choice(const Parameter& parameter, std::string_view word) {
  for (std::size_t i = 0; i < parameter.choices.size(); ++i)
    if (parameter.choices[i] == word)
      return i;
  return std::nullopt;
}

bool is_allowed(const Parameter& parameter, double value) {
  return value >= parameter.lowest && value <= parameter.highest &&
         (parameter.values.empty() || std::find(parameter.values.begin(), parameter.values.end(),
                                                value) != parameter.values.end());
}

std::string out_of_range_text(const Parameter& parameter, std::string_view given) {
  std::string sentence = std::string(parameter.name) + " " + std::string(given);
  if (!parameter.choices.empty())
    return sentence + ": expected " +
           alternatives(parameter.choices, [](std::string_view word) { return std::string(word); });
  if (!parameter.unit.empty())
    sentence += " " + std::string(parameter.unit);
  sentence += ": expected ";
  return parameter.values.empty()
             ? sentence + number_text(parameter.lowest) + ".." + number_text(parameter.highest)
             : sentence + alternatives(parameter.values, number_text);
}

std::string unknown_name_text(const Declaration& declaration, std::string_view name) {
  const std::string sentence = "no message '" + std::string(name) + "'";
  const auto with_messages = [&] {
    return sentence + (declaration.messages.size() == 1 ? "; there is " : "; there are ") +
           alternatives(
               declaration.messages, [](const Message& m) { return std::string(m.name); }, " and ");
  };
  if (is_of_the_host(name) && !declaration.messages.empty())
    return with_messages();
  if (const std::string hint = inlet_hint(declaration, name); !hint.empty())
    return sentence + hint;
  Nearest nearest(name);
  for (const Parameter& parameter : declaration.parameters)
    nearest.consider(parameter.name);
  for (const Message& message : declaration.messages)
    nearest.consider(message.name);
  if (!nearest.found().empty())
    return sentence + did_you_mean(nearest.found());
  if (declaration.parameters.empty() && !declaration.messages.empty())
    return with_messages();
  return sentence + "; 'get' lists the parameters, the help patch shows all messages";
}

std::string no_answer_text(const Declaration& declaration, std::string_view name) {
  const std::string sentence = "get " + std::string(name) + ": ";
  if (find_message(declaration, name))
    return sentence + "a message has no value; 'dump' lists all values";
  Nearest nearest(name);
  for (const Parameter& parameter : declaration.parameters)
    nearest.consider(parameter.name);
  return sentence + "unknown name" +
         (nearest.found().empty() ? std::string("; 'dump' lists all values")
                                  : did_you_mean(nearest.found()));
}

} // namespace tactus
