// tactus_describe: prints what every object says of itself as one JSON array.
// Each entry: name, title, description, keywords, inlets, outlets, arguments, parameters, messages
// and traits, as in core/declaration.hpp.
#include "programs/describe/describe.hpp"

#include <cstdio>
#include <string>
#include <string_view>

namespace {

using namespace tactus;

std::string quoted(std::string_view text) {
  std::string result = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\')
      result += '\\';
    if (letter == '\n')
      result += "\\n";
    else
      result += letter;
  }
  return result + '"';
}

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string field(std::string_view name, const std::string& json) {
  return quoted(name) + ": " + json;
}

template <class List, class Write> std::string array(const List& list, Write write) {
  std::string result = "[";
  for (std::size_t i = 0; i < list.size(); ++i)
    result += (i ? ",\n    " : "\n    ") + write(list[i]);
  return result + "]";
}

std::string port(const Port& p) {
  return "{" + field("kind", quoted(p.kind == Port::Kind::kSignal ? "signal" : "control")) + ", " +
         field("name", quoted(p.name)) + ", " + field("unit", quoted(p.unit)) + ", " +
         field("text", quoted(p.text)) + "}";
}

std::string parameter(const Parameter& p) {
  return "{" + field("name", quoted(p.name)) + ", " + field("unit", quoted(p.unit)) + ", " +
         field("initial", number(p.initial)) + ", " + field("lowest", number(p.lowest)) + ", " +
         field("highest", number(p.highest)) + ", " + field("text", quoted(p.text)) + ", " +
         field("choices", array(p.choices, quoted)) + ", " +
         field("values", array(p.values, number)) + "}";
}

std::string message(const Message& m) {
  return "{" + field("name", quoted(m.name)) + ", " + field("arguments", quoted(m.arguments)) +
         ", " + field("fewest", std::to_string(m.min_arguments)) + ", " +
         field("most", std::to_string(m.max_arguments)) + ", " + field("text", quoted(m.text)) +
         "}";
}

std::string object(const ObjectDescription& described) {
  const Declaration& d = *described.declaration;
  const auto flag = [](bool value) { return std::string(value ? "true" : "false"); };
  return "{" + field("name", quoted(d.name)) + ",\n  " + field("title", quoted(d.title)) + ",\n  " +
         field("description", quoted(d.description)) + ",\n  " +
         field("keywords", quoted(d.keywords)) + ",\n  " + field("inlets", array(d.inlets, port)) +
         ",\n  " + field("outlets", array(d.outlets, port)) + ",\n  " +
         field("arguments",
               array(d.arguments, [](const CreationArgument& a) { return quoted(a.parameter); })) +
         ",\n  " + field("parameters", array(d.parameters, parameter)) + ",\n  " +
         field("messages", array(d.messages, message)) + ",\n  " +
         field("signal", flag(described.traits.processes)) + ",\n  " +
         field("multichannel", flag(described.traits.multichannel)) + "}";
}

} // namespace

int main() {
  std::printf("%s\n", array(described_objects(), object).c_str());
  return 0;
}
