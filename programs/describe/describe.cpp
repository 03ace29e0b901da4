// tactus_describe: prints the declarations of all objects as one JSON array. Each entry: name,
// title, description, keywords, related, pages, sound, inlets, outlets, arguments, parameters,
// messages and traits, as in core/declaration.hpp. `tactus_describe surface_keys` prints the keys
// of a surface's text (docs/formats/surface.md) instead: section, name, unit, range, initial value,
// text.
#include "programs/describe/describe.hpp"

#include "core/footstep/recipe.hpp"
#include "files/json.hpp"
#include "files/recipe.hpp"

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
         ", " + field("stored", flag(p.stored)) + "}";
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
         field("related", files::quoted_json(d.related)) + ",\n  " +
         field("pages", files::quoted_json(d.pages)) + ",\n  " +
         field("sound", files::quoted_json(d.sound)) + ",\n  " +
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

/// The initial value applies to a text in which the section lacks this key.
std::string surface_key(const footstep::RecipeKey& key) {
  const std::string section(key.section);
  footstep::Recipe recipe;
  const std::string mistake =
      files::read_recipe((section.empty() ? "" : "[" + section + "]\n") + "[solid]\n", recipe);
  if (!mistake.empty())
    std::fprintf(stderr, "tactus_describe: [%s]: %s\n", section.c_str(), mistake.c_str());
  return "{" + field("section", files::quoted_json(section)) + ", " +
         field("name", files::quoted_json(key.name)) + ", " +
         field("unit", files::quoted_json(key.unit)) + ", " + field("lowest", number(key.lowest)) +
         ", " + field("highest", number(key.highest)) + ", " +
         field("initial", number(key.member(recipe))) + ", " +
         field("text", files::quoted_json(key.text)) + "}";
}

} // namespace

int main(int count, char** arguments) {
  const bool keys = count == 2 && std::string_view(arguments[1]) == "surface_keys";
  std::printf("%s\n", keys ? array(footstep::recipe_keys(), surface_key).c_str()
                           : array(described_objects(), object).c_str());
  return 0;
}
