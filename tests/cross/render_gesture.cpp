// Renders one gesture by a module in the stub host of tests/pd.
//   render_gesture STAGE STEM INPUTS OBJECT ATOM... < MESSAGES
// MESSAGES: lines "SAMPLE MESSAGE ATOM...". STEM.f64 gets the signal outlets one after another as
// doubles, STEM.txt what left the control outlets and what was refused. Into a signal inlet goes
// the file of doubles INPUTS/UNIT.f64, or INPUTS/other.f64 where there is none of its unit.
#include "tests/pd/host.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <span>
#include <sstream>

namespace {

using namespace tactus;
using namespace tactus::test;

constexpr double kRate = 48000;
constexpr std::size_t kFrames = 64, kSamples = 96000;

struct Message {
  std::size_t sample = 0;
  std::string selector;
  MessageAtoms atoms;
};

MessageAtom atom_of(const std::string& word) {
  char* end = nullptr;
  const double number = std::strtod(word.c_str(), &end);
  return *end ? MessageAtom(word) : MessageAtom(number);
}

std::vector<Message> read_messages(std::istream& lines) {
  std::vector<Message> messages;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    Message& message = messages.emplace_back();
    words >> message.sample >> message.selector;
    for (std::string word; words >> word;)
      message.atoms.push_back(atom_of(word));
  }
  return messages;
}

/// Times from the gesture's begin, to a microsecond.
void write_messages(std::ostream& out, double begin_ms) {
  out << std::setprecision(17);
  const Heard all = heard();
  for (const std::string& error : all.errors)
    out << "error: " << error << '\n';
  for (const Sent& message : all.sent) {
    out << std::round(1e3 * (message.ms - begin_ms)) / 1e3 << ' ' << message.outlet << ' '
        << message.selector;
    for (const MessageAtom& atom : message.atoms)
      atom.is_word ? out << ' ' << atom.text : out << ' ' << atom.number;
    out << '\n';
  }
}

Buffers read_inputs(const Declaration& declaration, const std::string& folder) {
  Buffers inputs;
  for (const Port& port : declaration.inlets) {
    if (port.kind != Port::Kind::kSignal)
      continue;
    std::string path = folder + "/" + std::string(port.unit) + ".f64";
    if (!std::filesystem::exists(path))
      path = folder + "/other.f64";
    std::vector<double>& samples = inputs.emplace_back(kSamples);
    std::ifstream(path, std::ios::binary)
        .read(reinterpret_cast<char*>(samples.data()),
              static_cast<std::streamsize>(kSamples * sizeof(double)));
  }
  return inputs;
}

/// False if the box is not made or a file is not written.
bool render(const Declaration& declaration, const MessageAtoms& arguments, const Buffers& inputs,
            const std::string& stem) {
  Box box(declaration.name, arguments);
  if (!box.made())
    return false;
  box.dsp(kRate, kFrames);
  const double begin_ms = now_ms();
  Buffers outputs;
  const std::vector<Message> messages = read_messages(std::cin);
  auto next = messages.begin();
  for (std::size_t begin = 0; begin < kSamples; begin += kFrames) {
    for (; next != messages.end() && next->sample <= begin; ++next)
      box.send(next->selector, next->atoms);
    append(outputs, box.run(part_of(inputs, begin, kFrames), kFrames));
  }
  std::ofstream text(stem + ".txt", std::ios::binary), sound(stem + ".f64", std::ios::binary);
  write_messages(text, begin_ms);
  for (const std::vector<double>& signal : outputs)
    sound.write(reinterpret_cast<const char*>(signal.data()),
                static_cast<std::streamsize>(signal.size() * sizeof(double)));
  return text.good() && sound.good();
}

} // namespace

int main(int count, char** words) {
  if (count < 5) {
    std::fprintf(stderr, "usage: render_gesture STAGE STEM INPUTS OBJECT ATOM... < MESSAGES\n");
    return 2;
  }
  set_folder(words[1]);
  MessageAtoms arguments;
  for (const char* word : std::span(words, static_cast<std::size_t>(count)).subspan(5))
    arguments.push_back(atom_of(word));
  for (const ObjectDescription& described : objects()) // those that this system has
    if (described.declaration->name == words[4])
      return render(*described.declaration, arguments,
                    read_inputs(*described.declaration, words[3]), words[2])
                 ? 0
                 : 1;
  return 0;
}
