#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string_view>

/// Declaration: the name, inlets, outlets, parameters and messages of an object, as constant data.
/// The host shell (pd/), the reference pages, the package's object list and the fuzz ranges are
/// made from this one table.
namespace tactus {

struct Atom;
class Host;

/// Its address identifies a class of objects.
template <class Object> inline constexpr char kOwner{};

/// A number the user can set: creation flag `-name value`, message `name value`, `get name`.
struct Parameter {
  std::string_view name;
  std::string_view unit; ///< SI; empty for pure numbers
  double initial;
  double lowest, highest; ///< inclusive; a value outside is refused, and the old value stays
  std::string_view text;  ///< one line of documentation
  /// If not empty: the parameter takes one of these words, and its value is the word's index.
  std::span<const std::string_view> choices{};
  /// If not empty: the parameter takes one of these numbers, in ascending order from lowest to
  /// highest; other numbers are refused.
  std::span<const double> values{};
  /// False if setting it allocates or hands work to a thread: a host then never sets it in its
  /// audio thread.
  bool realtime = true;
  /// False if setting it must be a deliberate act, such as ending an emergency stop: a host then
  /// saves it neither with the patch nor in presets.
  bool stored = true;
  /// True if it seeds random numbers: a host gives every instance, and every channel of an
  /// instance, its own seed (core/instance_numbers.hpp).
  bool seeds = false;
  /// Functions that set and get it in an object of the class `owner`; see core/rows.hpp. The value
  /// is finite and within the range; neither function throws, allocates nor locks if `realtime`.
  void (*set)(void* object, double value) = nullptr;
  double (*get)(const void* object) = nullptr;
  const char* owner = nullptr;
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

/// A message that does more than set one number, e.g. `reset`, `range 0 8000 80 900`.
struct Message {
  std::string_view name;
  std::string_view arguments;               ///< names as the help shows them: "p_lo p_hi f_lo f_hi"
  std::size_t min_arguments, max_arguments; ///< number of arguments accepted
  std::string_view text;
  /// True if it allocates nothing, locks nothing and makes no system call, whatever its arguments:
  /// a host may carry it out in its audio thread, at the start of a block.
  bool realtime = false;
  /// True if its first argument may be the name of a file, so that a host can send it a file that
  /// is dropped onto the object's box.
  bool file = false;
  /// The argument word that precedes the name of a file or array of the host; "*": any word may be
  /// such a name. Read by names_file() (core/command.hpp) for hosts that look names up in one
  /// thread only.
  std::string_view name_behind{};
  /// Function that carries it out in an object of the class `owner`. The number of arguments is
  /// within the accepted range; `row` is this message.
  void (*run)(void* object, const Message& row, std::span<const Atom> arguments,
              Host& host) = nullptr;
  const char* owner = nullptr;

  [[nodiscard]] constexpr Message with_name_behind(std::string_view behind) const {
    Message message = *this;
    message.name_behind = behind;
    return message;
  }
};

/// Marks the message as one whose first argument may be the name of a file.
[[nodiscard]] constexpr Message takes_file(Message message) {
  message.file = true;
  return message;
}
/// Marks the message as one that a host may carry out in its audio thread.
[[nodiscard]] constexpr Message realtime(Message message) {
  message.realtime = true;
  return message;
}
/// Marks the parameter as one that a host never sets in its audio thread.
[[nodiscard]] constexpr Parameter not_realtime(Parameter parameter) {
  parameter.realtime = false;
  return parameter;
}
/// Marks the parameter as one that a host saves neither with the patch nor in presets.
[[nodiscard]] constexpr Parameter not_stored(Parameter parameter) {
  parameter.stored = false;
  return parameter;
}

/// A string literal as a template argument.
template <std::size_t size> struct Literal {
  std::array<char, size> text{};
  constexpr Literal(const char (&literal)[size]) { std::copy_n(literal, size, text.begin()); }
};

/// The text, followed by the rule for the seeds of further instances.
template <Literal text>
inline constexpr auto kSeedText = [] {
  constexpr std::string_view rule = "; further instances start with 2, 3, ...";
  std::array<char, text.text.size() - 1 + rule.size()> both{};
  std::copy_n(rule.begin(), rule.size(),
              std::copy_n(text.text.begin(), text.text.size() - 1, both.begin()));
  return both;
}();

/// The parameter `seed`; the text names what it seeds.
template <Literal text> [[nodiscard]] constexpr Parameter seed_parameter() {
  Parameter parameter{
      "seed", "", 1, 0, 16777215, std::string_view(kSeedText<text>.data(), kSeedText<text>.size())};
  parameter.seeds = true;
  return parameter;
}

/// A positional creation argument; it sets the parameter of that name.
struct CreationArgument {
  std::string_view parameter;
};

/// Name of the outlet for answers. The shell adds it at the right unless the object declares it.
inline constexpr std::string_view kInfoOutlet = "info";

struct Declaration {
  std::string_view name;        ///< name as typed in a box: "greed~"
  std::string_view title;       ///< half a line: "generalised pressure-controlled valve on a bore"
  std::string_view description; ///< one paragraph
  std::string_view keywords;
  std::span<const Port> inlets;
  std::span<const Port> outlets; ///< the shell adds the info outlet at the right if it is not
                                 ///< listed
  std::span<const Parameter> parameters;
  std::span<const Message> messages{};
  std::span<const CreationArgument> arguments{};
  std::string_view related{}; ///< objects and patches to look at next: "greed~, reed_haptic.pd"
  /// Pages of docs/ that explain it: "the model: theory/greed.md, guidance: guidance.md"
  std::string_view pages{};
  std::string_view sound{}; ///< a recording made by ./play: "fanfare/fanfare.wav: two trumpets"
};

} // namespace tactus
