// Renders gestures by modules in the stub host, to be compared with another system's renders.
//   render_gestures GESTURES STAGE FOLDER [INPUTS]
// For each gesture FOLDER/NAME.f64, the signal outlets one after another as doubles, and
// FOLDER/NAME.txt, what left the control outlets and what was refused; FOLDER/NAME.I.in, what went
// into signal inlet I: the same files of the folder INPUTS, or else plausible signals, whose sines
// are this C library's.
#include "tests/pd/host.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <sstream>

namespace {

using namespace tactus;
using namespace tactus::test;

constexpr double kRate = 48000;
constexpr std::size_t kFrames = 64, kSamples = 96000;

struct Gesture {
  struct Message {
    double ms;
    std::string selector;
    MessageAtoms atoms;
  };
  std::string name, object;
  MessageAtoms arguments;
  std::vector<Message> messages;
};

MessageAtoms atoms_of(std::istream& words) {
  MessageAtoms atoms;
  for (std::string word; words >> word;) {
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    atoms.push_back(*end ? MessageAtom(word) : MessageAtom(number));
  }
  return atoms;
}

std::vector<Gesture> read_gestures(const char* path) {
  std::vector<Gesture> gestures;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string first;
    if (!(words >> first) || first[0] == '#')
      continue;
    if (first == "gesture") {
      Gesture& made = gestures.emplace_back();
      words >> made.name >> made.object;
      made.name.pop_back(); // the colon
      made.arguments = atoms_of(words);
    } else {
      Gesture::Message message{std::strtod(first.c_str(), nullptr), {}, {}};
      words >> message.selector;
      message.atoms = atoms_of(words);
      gestures.back().messages.push_back(std::move(message));
    }
  }
  return gestures;
}

const Declaration* declaration_of(const std::string& object) {
  for (const ObjectDescription& described : objects())
    if (described.declaration->name == object)
      return described.declaration;
  return nullptr;
}

/// Times from the gesture's begin, to a microsecond: the host's clock runs on.
void write_messages(std::ostream& out, double begin_ms) {
  for (int i = 0; i < host_error_count(); ++i)
    out << "error: " << host_error(i) << '\n';
  for (const Sent& message : sent()) { // forgets the errors, too
    out << std::round(1e3 * (message.ms - begin_ms)) / 1e3 << ' ' << message.outlet << ' '
        << message.selector;
    for (const MessageAtom& atom : message.atoms)
      atom.is_word ? out << ' ' << atom.text : out << ' ' << atom.number;
    out << '\n';
  }
}

Buffers part_of(const Buffers& whole, std::size_t begin) {
  Buffers part;
  for (const auto& signal : whole)
    part.emplace_back(signal.begin() + static_cast<std::ptrdiff_t>(begin),
                      signal.begin() + static_cast<std::ptrdiff_t>(begin + kFrames));
  return part;
}

bool write_samples(const std::string& path, const Buffers& signals) {
  std::ofstream file(path, std::ios::binary);
  for (const auto& signal : signals)
    file.write(reinterpret_cast<const char*>(signal.data()),
               static_cast<std::streamsize>(signal.size() * sizeof(double)));
  return file.good();
}

std::string input_file(const std::string& stem, std::size_t inlet) {
  return stem + "." + std::to_string(inlet) + ".in";
}

/// A signal inlet's samples; an empty vector if the file has another length.
std::vector<double> read_samples(const std::string& path) {
  std::vector<double> samples(kSamples);
  const auto size = static_cast<std::streamsize>(kSamples * sizeof(double));
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(samples.data()), size) || file.peek() != EOF)
    samples.clear();
  return samples;
}

/// False if the box cannot be made, or an input is missing; given_stem is empty when none is given.
bool render(const Gesture& gesture, const std::string& stem, const std::string& given_stem) {
  const Declaration* declaration = declaration_of(gesture.object);
  if (!declaration) // not built for this system
    return true;
  std::ofstream text(stem + ".txt", std::ios::binary);
  text << std::setprecision(17);
  Box box(gesture.object, gesture.arguments);
  if (!box.made())
    return false;
  box.dsp(kRate, kFrames);
  Buffers inputs = plausible_inputs(*declaration, kRate, kSamples);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (!given_stem.empty())
      inputs[i] = read_samples(input_file(given_stem, i));
    if (inputs[i].empty() || !write_samples(input_file(stem, i), {inputs[i]}))
      return false;
  }
  const double begin_ms = host_now();
  Buffers outputs;
  std::size_t next = 0;
  for (std::size_t begin = 0; begin < kSamples; begin += kFrames) {
    for (; next < gesture.messages.size() &&
           gesture.messages[next].ms * kRate <= 1e3 * static_cast<double>(begin);
         ++next)
      box.send(gesture.messages[next].selector, gesture.messages[next].atoms);
    const Buffers block = box.run(part_of(inputs, begin), kFrames);
    outputs.resize(block.size());
    for (std::size_t i = 0; i < block.size(); ++i)
      outputs[i].insert(outputs[i].end(), block[i].begin(), block[i].end());
  }
  write_messages(text, begin_ms);
  return write_samples(stem + ".f64", outputs) && text.good();
}

} // namespace

int main(int count, char** words) {
  if (count != 4 && count != 5) {
    std::fprintf(stderr, "usage: render_gestures GESTURES STAGE FOLDER [INPUTS]\n");
    return 2;
  }
  const std::string given = count == 5 ? std::string(words[4]) + "/" : std::string();
  host_set_folder(words[2]);
  for (const Gesture& gesture : read_gestures(words[1]))
    if (!render(gesture, std::string(words[3]) + "/" + gesture.name,
                given.empty() ? given : given + gesture.name)) {
      std::fprintf(stderr, "%s: %s is not made, or a file is not read or written\n",
                   gesture.name.c_str(), gesture.object.c_str());
      return 1;
    }
  return 0;
}
