#include "max/stub/script.hpp"

#include <array>
#include <charconv>
#include <limits>

namespace tactus::stub {

Line split_line(const std::string& text) {
  Line line;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == ' ' || text[i] == '\t' || text[i] == '\r') {
      ++i;
      continue;
    }
    if (text[i] == '#' && (i + 1 == text.size() || text[i + 1] == ' '))
      break;
    Token token;
    if (text[i] == '"') {
      token.quoted = true;
      for (++i; i < text.size() && text[i] != '"'; ++i) {
        if (text[i] == '\\' && i + 1 < text.size())
          ++i;
        token.text += text[i];
      }
      ++i;
    } else
      while (i < text.size() && text[i] != ' ' && text[i] != '\t' && text[i] != '\r')
        token.text += text[i++];
    line.push_back(std::move(token));
  }
  return line;
}

t_atom to_atom(const Token& token) {
  const std::string& text = token.text;
  if (token.quoted || text.empty())
    return symbol_atom(text);
  if (text == "#nan")
    return float_atom(std::numeric_limits<double>::quiet_NaN());
  if (text == "#inf" || text == "#-inf")
    return float_atom(text == "#inf" ? std::numeric_limits<double>::infinity()
                                     : -std::numeric_limits<double>::infinity());
  if (text.find_first_not_of("+-.0123456789eE") != std::string::npos)
    return symbol_atom(text);
  const char* end = text.data() + text.size();
  long long whole = 0;
  if (const auto [rest, error] = std::from_chars(text.data(), end, whole);
      error == std::errc() && rest == end)
    return long_atom(static_cast<t_atom_long>(whole));
  double value = 0;
  if (const auto [rest, error] = std::from_chars(text.data(), end, value);
      error == std::errc() && rest == end)
    return float_atom(value);
  return symbol_atom(text);
}

std::span<const Script::Command> Script::commands() {
  static constexpr std::array kCommands{
      Command{"load", 1, "FILE", &Script::load},
      Command{"class", 1, "NAME", &Script::describe_class},
      Command{"new", 2, "ID CLASS [ATOM...] [@ATTRIBUTE ATOM...]", &Script::make},
      Command{"free", 1, "ID", &Script::free},
      Command{"send", 3, "ID INLET SELECTOR [ATOM...]", &Script::send},
      Command{"drop", 3, "ID locked|unlocked FILE", &Script::drop},
      Command{"set", 2, "ID ATTRIBUTE [ATOM...]", &Script::set},
      Command{"get", 2, "ID ATTRIBUTE", &Script::get},
      Command{"describe", 1, "ID", &Script::describe},
      Command{"expect", 3, "ID inlets|outlets TYPE...", &Script::expect},
      Command{"loadbang", 1, "ID", &Script::loadbang},
      Command{"cord", 4, "ID OUTLET ID INLET", &Script::cord},
      Command{"save", 1, "FILE [all]", &Script::save},
      Command{"restore", 1, "FILE", &Script::restore},
      Command{"value", 1, "ID [ATOM...]", &Script::value},
      Command{"preset", 1, "ID", &Script::preset},
      Command{"signal", 3, "ID INLET constant|sine|noise|impulse|nan|inf|file|wav|box|none ...",
              &Script::signal},
      Command{"rate", 1, "HZ", &Script::rate},
      Command{"vector", 1, "SAMPLES [MAX]", &Script::vector},
      Command{"inplace", 1, "off|same|crossed", &Script::inplace},
      Command{"unconnected", 1, "guard|zeros", &Script::unconnected},
      Command{"dsp", 1, "on|off", &Script::dsp},
      Command{"mute", 2, "ID 0|1", &Script::mute},
      Command{"run", 1, "VECTORS", &Script::run_vectors},
      Command{"record", 2, "ID FILE", &Script::record},
      Command{"levels", 1, "ID", &Script::levels},
      Command{"advance", 1, "MS", &Script::advance},
      Command{"service", 0, "", &Script::service},
      Command{"lowpriority", 1, "auto|manual", &Script::low_priority},
      Command{"overdrive", 1, "on|off", &Script::overdrive},
      Command{"thread", 1, "main|scheduler", &Script::thread},
      Command{"searchpath", 1, "FOLDER", &Script::search_path},
      Command{"patcher", 1, "FILE [subpatcher]", &Script::patcher_path},
      Command{"buffer", 3, "NAME CHANNELS FRAMES [SIGNAL...]", &Script::buffer},
      Command{"echo", 0, "TEXT...", &Script::echo},
  };
  return kCommands;
}

void Script::execute(const Line& line) {
  const std::string& name = line.front().text;
  for (const Command& command : commands()) {
    if (command.name != name)
      continue;
    const Arguments arguments = Arguments(line).subspan(1);
    if (arguments.size() < command.arguments)
      throw ScriptError("usage: " + name + " " + std::string(command.usage));
    (this->*command.run)(arguments);
    if (!low_priority_by_hand_)
      run_low_priority();
    return;
  }
  throw ScriptError("no command: " + name);
}

void Script::run_block(std::span<const Line> lines) {
  const Line& head = lines.front();
  if (head.size() < 2)
    throw ScriptError("usage: " + head.front().text + " COUNT");
  const auto count = static_cast<std::uint64_t>(std::stoull(head[1].text));
  const auto body = lines.subspan(1);
  if (head.front().text == "threads")
    run_threads(*this, count, body);
  else
    for (std::uint64_t i = 0; i < count; ++i)
      for (const Line& line : body)
        execute(line);
}

void Script::run(std::istream& stream) {
  std::vector<Line> block;
  std::string text;
  try {
    while (std::getline(stream, text)) {
      ++line_;
      Line line = split_line(text);
      if (line.empty())
        continue;
      const std::string& name = line.front().text;
      if (block.empty() && name != "threads" && name != "repeat")
        execute(line);
      else if (name == "end" && !block.empty()) {
        run_block(block);
        block.clear();
      } else
        block.push_back(std::move(line));
    }
    if (!block.empty())
      throw ScriptError(block.front().front().text + " without end");
  } catch (const std::exception& error) {
    throw ScriptError("line " + std::to_string(line_) + ": " + error.what());
  }
}

void Script::finish() {
  stop_dsp();
  while (!boxes_.empty()) {
    free_object(*boxes_.begin()->second);
    boxes_.erase(boxes_.begin());
  }
  run_low_priority();
  write_recordings();
  report_leaks(nullptr);
}

Object& Script::box(const Token& id) const {
  const auto found = boxes_.find(id.text);
  if (found == boxes_.end())
    throw ScriptError("no box: " + id.text);
  return *found->second;
}

} // namespace tactus::stub
