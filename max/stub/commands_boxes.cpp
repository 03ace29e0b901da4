// Commands on boxes: making, messages, attributes.
#include "files/utf8_path.hpp"
#include "max/stub/module.hpp"
#include "max/stub/script.hpp"

#include <fstream>

namespace tactus::stub {
namespace {
std::vector<t_atom> to_atoms(Script::Arguments tokens) {
  std::vector<t_atom> atoms;
  for (const Token& token : tokens)
    atoms.push_back(to_atom(token));
  return atoms;
}
long to_long(const Token& token) { return std::stol(token.text); }

std::string types_text(const std::vector<short>& types) {
  static constexpr const char* kNames[]{"",      "int",     "float",    "symbol", "object",
                                        "[int]", "[float]", "[symbol]", "gimme",  "cant"};
  std::string text;
  for (short type : types)
    text.append(" ").append(kNames[type]);
  return text;
}
} // namespace

void Script::load(Arguments a) {
  if (const std::string reason = load_external(a[0].text); !reason.empty())
    throw ScriptError("cannot load " + a[0].text + ": " + reason);
}

void Script::describe_class(Arguments a) {
  const t_class* c = find_class(a[0].text);
  if (!c)
    throw ScriptError("no class: " + a[0].text);
  for (const auto& [name, m] : c->methods)
    print_line("method: " + c->name + " " + name + types_text(m.types));
  for (const Attribute* attribute : c->attributes) {
    std::string line = "attribute: " + c->name + " " + attribute->name + " " + attribute->type;
    for (const auto& [name, value] : attribute->properties)
      line += " " + name + "=" + to_text(std::vector{symbol_atom(value)});
    print_line(line);
  }
}

void Script::make(Arguments a) {
  if (boxes_.count(a[0].text))
    throw ScriptError("there is a box " + a[0].text);
  std::vector<t_atom> atoms = to_atoms(a.subspan(2));
  if (Object* object = make_object(a[0].text, a[1].text, atoms))
    boxes_[a[0].text] = object;
}

void Script::free(Arguments a) {
  Object& object = box(a[0]);
  if (const auto recording = recordings_.find(a[0].text);
      recording != recordings_.end() && object.performer)
    object.performer->recorded = nullptr;
  boxes_.erase(a[0].text);
  free_object(object);
}

void Script::send(Arguments a) {
  std::vector<t_atom> atoms = to_atoms(a.subspan(3));
  send_message(box(a[0]), to_long(a[1]), a[2].text, atoms);
}

void Script::drop(Arguments a) {
  if (a[1].text != "locked" && a[1].text != "unlocked")
    throw ScriptError("drop: a patcher is locked or unlocked");
  if (!drop_file(box(a[0]), a[1].text, a[2].text))
    print_line("refused: " + a[0].text + " " + a[2].text);
}

void Script::set(Arguments a) {
  std::vector<t_atom> atoms = to_atoms(a.subspan(2));
  set_attribute(box(a[0]), a[1].text, atoms);
}

void Script::get(Arguments a) {
  Object& object = box(a[0]);
  const Attribute* attribute = object.type->attribute(a[1].text);
  if (!attribute)
    throw ScriptError(a[0].text + " has no attribute " + a[1].text);
  print_line("value: " + object.id + " " + attribute->name + " " +
             to_text(get_attribute(object, *attribute)));
}

void Script::describe(Arguments a) {
  Object& object = box(a[0]);
  for (long i = 0; i < object.inlets(); ++i)
    print_line("inlet: " + object.id + " " + std::to_string(i) +
               (i < object.signal_inlets ? " signal " : " message ") +
               assist_text(object, ASSIST_INLET, i));
  for (std::size_t i = 0; i < object.outlets.size(); ++i) {
    const std::string& type = object.outlets[i]->type;
    print_line("outlet: " + object.id + " " + std::to_string(i) + " " +
               (type.empty() ? "message" : type) + " " +
               assist_text(object, ASSIST_OUTLET, static_cast<long>(i)));
  }
}

void Script::expect(Arguments a) {
  Object& object = box(a[0]);
  const std::string& what = a[1].text;
  std::string is, wanted;
  for (const Token& token : a.subspan(2))
    wanted += " " + token.text;
  if (what == "inlets")
    for (long i = 0; i < object.inlets(); ++i)
      is += i < object.signal_inlets ? " signal" : " message";
  else if (what == "outlets")
    for (const Outlet* outlet : object.outlets)
      is += " " + (outlet->type.empty() ? "message" : outlet->type);
  else
    throw ScriptError("expect inlets or outlets");
  if (is != wanted && !(is.empty() && wanted == " none"))
    violation(object.text() + ": " + what + " are" + (is.empty() ? " none" : is) + ", expected" +
              wanted);
}

void Script::loadbang(Arguments a) {
  Object& object = box(a[0]);
  const Method* m = object.type->find("loadbang");
  if (!m)
    return;
  Call call{.where = Where::kMessage, .object = &object, .name = "loadbang"};
  run_external(call, [&] { as<void (*)(void*)>(m->function)(object.header()); });
}

void Script::cord(Arguments a) {
  Object& from = box(a[0]);
  const auto outlet = static_cast<std::size_t>(to_long(a[1]));
  if (outlet >= from.outlets.size())
    throw ScriptError(a[0].text + " has no outlet " + a[1].text);
  from.outlets[outlet]->cords.push_back({&box(a[2]), to_long(a[3])});
}

void Script::save(Arguments a) {
  const bool all = a.size() > 1 && a[1].text == "all";
  std::ofstream file(utf8_path(a[0].text));
  for (const auto& [id, object] : boxes_)
    for (const Attribute* attribute : object->type->attributes)
      if (attribute->setter && (all || attribute->saved()))
        file << "set " << id << " " << attribute->name << " "
             << to_text(get_attribute(*object, *attribute)) << "\n";
  if (!file.flush())
    throw ScriptError("cannot write " + a[0].text);
}

void Script::restore(Arguments a) {
  std::ifstream file(utf8_path(a[0].text));
  if (!file)
    throw ScriptError("cannot read " + a[0].text);
  std::string text;
  while (std::getline(file, text)) {
    const Line line = split_line(text);
    if (!line.empty() && line.front().text == "set")
      execute(line);
  }
}

void Script::value(Arguments a) {
  Object& object = box(a[0]);
  if (a.size() == 1) {
    print_line("whole: " + object.id + " " + to_text(get_value(object)));
    return;
  }
  std::vector<t_atom> atoms = to_atoms(a.subspan(1));
  if (!set_value(object, atoms))
    throw ScriptError(a[0].text + " has no value");
}

void Script::preset(Arguments a) {
  if (!ask_for_preset(box(a[0])))
    print_line("not asked: " + a[0].text);
}

void Script::echo(Arguments a) {
  std::string text;
  for (const Token& token : a)
    text += (text.empty() ? "" : " ") + token.text;
  print_line(text);
}

} // namespace tactus::stub
