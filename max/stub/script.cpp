// The commands of a script; README.md lists them.
#include "max/stub/stub.hpp"

#include "files/utf8_path.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <thread>

namespace tactus::stub {
namespace {
std::map<std::string, Object*> boxes;

Object& box(const std::string& id) {
  const auto found = boxes.find(id);
  if (found == boxes.end())
    throw std::runtime_error("no box: " + id);
  return *found->second;
}
std::size_t to_size(const std::string& word) { return static_cast<std::size_t>(std::stoull(word)); }
bool is_first(const std::string& word, const std::string& first, const std::string& second) {
  if (word != first && word != second)
    throw std::runtime_error("expected " + first + " or " + second + ", got " + word);
  return word == first;
}
std::vector<t_atom> to_atoms(Words words) {
  std::vector<t_atom> atoms;
  std::transform(words.begin(), words.end(), std::back_inserter(atoms), to_atom);
  return atoms;
}

/// Reads "constant V", "sine HZ AMPLITUDE", "file FLOAT64" or "none".
Source make_source(Words words) {
  const std::string& kind = words[0];
  if (kind == "none")
    return {};
  if (kind == "constant")
    return [value = std::stod(words[1])](std::uint64_t) { return value; };
  if (kind == "sine")
    return [step = 2 * std::numbers::pi * std::stod(words[1]) / audio().sample_rate,
            amplitude = std::stod(words[2])](std::uint64_t n) {
      return amplitude * std::sin(step * static_cast<double>(n));
    };
  std::ifstream stream(utf8_path(words[1]), std::ios::binary);
  if (kind != "file" || !stream)
    throw std::runtime_error("no signal: " + kind + " " + words[1]);
  const auto samples = std::make_shared<std::vector<double>>();
  for (double v = 0; stream.read(reinterpret_cast<char*>(&v), sizeof v);)
    samples->push_back(v);
  return [samples](std::uint64_t n) { return n < samples->size() ? (*samples)[n] : 0.0; };
}

void advance(double ms) {
  advance_clocks(now_ms() + ms);
  run_low_priority();
}
void recompile() {
  if (audio().runs)
    start_dsp();
}
void free_box(const std::string& id) {
  Object& freed = box(id);
  write_recording(freed);
  boxes.erase(id);
  free_object(freed);
}

void describe_class(Words w) {
  const t_class* c = find_class(w[0]);
  for (const auto& [name, m] : c->methods)
    print_line("method: " + c->name + " " + name);
  for (const Attribute* attribute : c->attributes) {
    std::string line = "attribute: " + c->name + " " + attribute->name + " " + attribute->type;
    for (const auto& [name, value] : attribute->properties)
      line += " " + name + "=" + to_text(std::array{symbol_atom(value)});
    print_line(line);
  }
}
void describe_box(Words w) {
  Object& object = box(w[0]);
  for (long i = 0; i < object.inlets(); ++i)
    print_line("inlet: " + object.id + " " + std::to_string(i) +
               (i < object.signal_inlets ? " signal " : " message ") +
               assist_text(object, ASSIST_INLET, i));
  for (std::size_t i = 0; i < object.outlets.size(); ++i)
    print_line("outlet: " + object.id + " " + std::to_string(i) +
               (object.outlets[i]->signal ? " signal " : " message ") +
               assist_text(object, ASSIST_OUTLET, static_cast<long>(i)));
}

/// Waits until a line that contains the word is printed, because an object's worker threads take
/// their time.
void wait_for(Words w) {
  std::vector<std::string> lines;
  bool found = false;
  for (int tries = 0; !found && tries < 20000; ++tries) {
    lines.clear();
    collect_lines(&lines);
    advance(1);
    collect_lines(nullptr);
    for (const std::string& line : lines) {
      print_line(line);
      found = found || line.find(w[0]) != line.npos;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (!found)
    throw std::runtime_error("no line with " + w[0]);
}

void run_vectors(Words w) {
  advance(0);
  for (std::size_t left = to_size(w[0]); left > 0; --left) {
    perform_vector();
    advance(1e3 * static_cast<double>(audio().vector) / audio().sample_rate);
  }
}

struct Command {
  std::string_view name;
  std::size_t words; ///< minimum number of words
  void (*run)(Words);
};
constexpr std::array kCommands{
    Command{"load", 1,
            [](Words w) {
              if (const std::string reason = load_external(w[0]); !reason.empty())
                throw std::runtime_error("cannot load " + w[0] + ": " + reason);
            }},
    Command{"class", 1, describe_class},
    Command{"new", 2,
            [](Words w) {
              std::vector<t_atom> atoms = to_atoms(w.subspan(2));
              if (Object* object = make_object(w[0], w[1], atoms))
                boxes[w[0]] = object;
            }},
    Command{"free", 1, [](Words w) { free_box(w[0]); }},
    Command{"send", 3, [](Words w) { prepare("send", w)(); }},
    Command{"get", 2, [](Words w) { prepare("get", w)(); }},
    Command{"value", 1, [](Words w) { prepare("value", w)(); }},
    Command{"drop", 3,
            [](Words w) {
              if (!drop_file(box(w[0]), w[1], w[2]))
                print_line("refused: " + w[0] + " " + w[2]);
            }},
    Command{"describe", 1, describe_box},
    Command{"signal", 3,
            [](Words w) {
              box(w[0]).sources.at(to_size(w[1])) = make_source(w.subspan(2));
              recompile();
            }},
    Command{"rate", 1,
            [](Words w) {
              audio().sample_rate = std::stod(w[0]);
              recompile();
            }},
    Command{"vector", 1,
            [](Words w) {
              audio().vector = std::stol(w[0]);
              recompile();
            }},
    Command{"inplace", 1,
            [](Words w) {
              audio().inplace = w[0] == "off"                       ? Inplace::kOff
                                : is_first(w[0], "same", "crossed") ? Inplace::kSame
                                                                    : Inplace::kCrossed;
            }},
    Command{"dsp", 1, [](Words w) { is_first(w[0], "on", "off") ? start_dsp() : stop_dsp(); }},
    Command{"mute", 2, [](Words w) { box(w[0]).header()->z_disabled = std::stol(w[1]); }},
    Command{"run", 1, run_vectors},
    Command{"record", 2, [](Words w) { box(w[0]).recording = w[1]; }},
    Command{"advance", 1, [](Words w) { advance(std::stod(w[0])); }},
    Command{"wait", 1, wait_for},
    Command{"thread", 1,
            [](Words w) { set_role(is_first(w[0], "main", "scheduler") ? kMain : kScheduler); }},
    Command{"searchpath", 1, [](Words w) { add_search_path(w[0]); }},
    Command{"patcher", 1, [](Words w) { set_patcher(w[0], w.size() > 1); }},
    Command{"buffer", 4,
            [](Words w) {
              const Source source = make_source(w.subspan(3));
              std::vector<float> samples;
              for (std::size_t k = 0, channels = to_size(w[1]); k < channels * to_size(w[2]); ++k)
                samples.push_back(k % channels == 0 ? static_cast<float>(source(k / channels)) : 0);
              make_buffer(w[0], std::stol(w[1]), samples);
            }},
    Command{"echo", 1, [](Words w) { print_line(w[0]); }},
};
} // namespace

std::function<void()> prepare(const std::string& command, Words w) {
  Object& object = box(w[0]);
  if (command == "send")
    return [&object, inlet = std::stol(w[1]), name = w[2], atoms = to_atoms(w.subspan(3))] {
      std::vector<t_atom> own = atoms;
      send_message(object, inlet, name, own);
    };
  if (command == "value")
    return [&object, atoms = to_atoms(w.subspan(1))] {
      std::vector<t_atom> own = atoms;
      if (own.empty())
        print_line("whole: " + object.id + " " + to_text(get_value(object)));
      else
        set_value(object, own);
    };
  const Attribute* attribute = object.type->attribute(w[1]);
  if (command != "get" || !attribute)
    throw std::runtime_error("no attribute, or no such command: " + command + " " + w[1]);
  return [&object, attribute] {
    print_line("value: " + object.id + " " + attribute->name + " " +
               to_text(get_attribute(object, *attribute)));
  };
}

std::vector<std::string> split_line(const std::string& text) {
  std::vector<std::string> words;
  for (std::size_t at = 0; (at = text.find_first_not_of(" \r", at)) != text.npos;) {
    const bool quoted = text[at] == '"';
    const std::size_t begin = at + (quoted ? 1 : 0);
    at = std::min(text.find(quoted ? '"' : ' ', begin), text.size());
    words.push_back(text.substr(begin, at - begin));
    at += quoted ? 1 : 0;
  }
  return words;
}

void execute(Words line) {
  const auto command = std::find_if(kCommands.begin(), kCommands.end(),
                                    [&](const Command& c) { return c.name == line[0]; });
  if (command == kCommands.end() || line.size() <= command->words)
    throw std::runtime_error("no command, or with too few words: " + line[0]);
  command->run(line.subspan(1));
}

void finish() {
  stop_dsp();
  while (!boxes.empty())
    free_box(boxes.begin()->first);
  run_low_priority();
}

} // namespace tactus::stub
