// tactus_describe: prints what every object says of itself as one JSON array.
// Each entry: name, title, description, keywords, inlets, outlets, arguments, parameters, messages
// and traits, as in core/declaration.hpp.
#include "programs/describe/describe.hpp"

#include "files/json.hpp"

#include <cstdio>
#include <string>
#include <string_view>

namespace {

using namespace tactus;

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string field(std::string_view name, const std::string& json) {
  return files::quoted_json(name) + ": " + json;
}

std::string flag(bool value) { return value ? "true" : "false"; }

template <class List, class Write> std::string array(const List& list, Write write) {
  std::string result = "[";
  for (std::size_t i = 0; i < list.size(); ++i)
    result += (i ? ",\n    " : "\n    ") + write(list[i]);
  return result + "]";
}

std::string port(const Port& p) {
  return "{" +
         field("kind", files::quoted_json(p.kind == Port::Kind::kSignal ? "signal" : "control")) +
         ", " + field("name", files::quoted_json(p.name)) + ", " +
         field("unit", files::quoted_json(p.unit)) + ", " +
         field("text", files::quoted_json(p.text)) + "}";
}

std::string parameter(const Parameter& p) {
  return "{" + field("name", files::quoted_json(p.name)) + ", " +
         field("unit", files::quoted_json(p.unit)) + ", " + field("initial", number(p.initial)) +
         ", " + field("lowest", number(p.lowest)) + ", " + field("highest", number(p.highest)) +
         ", " + field("text", files::quoted_json(p.text)) + ", " +
         field("choices", array(p.choices, files::quoted_json)) + ", " +
         field("values", array(p.values, number)) + ", " + field("realtime", flag(p.realtime)) +
         "}";
}

std::string message(const Message& m) {
  return "{" + field("name", files::quoted_json(m.name)) + ", " +
         field("arguments", files::quoted_json(m.arguments)) + ", " +
         field("fewest", std::to_string(m.min_arguments)) + ", " +
         field("most", std::to_string(m.max_arguments)) + ", " +
         field("text", files::quoted_json(m.text)) + ", " + field("realtime", flag(m.realtime)) +
         "}";
}

std::string object(const ObjectDescription& described) {
  const Declaration& d = *described.declaration;
  return "{" + field("name", files::quoted_json(d.name)) + ",\n  " +
         field("title", files::quoted_json(d.title)) + ",\n  " +
         field("description", files::quoted_json(d.description)) + ",\n  " +
         field("keywords", files::quoted_json(d.keywords)) + ",\n  " +
         field("inlets", array(d.inlets, port)) + ",\n  " +
         field("outlets", array(d.outlets, port)) + ",\n  " +
         field("arguments",
               array(d.arguments,
                     [](const CreationArgument& a) { return files::quoted_json(a.parameter); })) +
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
