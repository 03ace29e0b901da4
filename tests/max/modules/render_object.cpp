// Renders a gesture by an object's core itself, with no host: what its modules are compared with.
//   render_object OBJECT.module FOLDER OUTPUT INPUT...  < GESTURE
// GESTURE: lines "SAMPLE MESSAGE ATOM..."; INPUT: a file of doubles for each signal inlet, OUTPUT
// the signal outlets' one after another. Files are sought in FOLDER. Blocks of 64 samples at 48
// kHz.
#include "core/command.hpp"
#include "core/module_object.hpp"
#include "devices/shared_library.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

using namespace tactus;

constexpr double kRate = 48000;
constexpr std::size_t kFrames = 64;

/// A host in which nothing happens but time.
class PlainHost final : public Host {
public:
  explicit PlainHost(std::string folder) : folder_(std::move(folder)) {}
  void send(std::size_t, std::span<const Atom>) override {}
  void info(std::span<const Atom>) override {}
  void error(std::string_view sentence) override { std::cerr << sentence << '\n'; }
  void log(std::string_view) override {}
  void wake_in(std::size_t, double) override {}
  double now_ms() const override { return now; }
  std::string find_file(std::string_view name) const override {
    const std::string path = folder_ + "/" + std::string(name);
    return std::ifstream(path).good() ? path : std::string();
  }
  std::string new_file(std::string_view) const override { return {}; }
  bool read_array(std::string_view, std::vector<double>&) const override { return false; }
  bool real_time() const override { return false; }
  void wake_from_thread() noexcept override {}

  double now = 0;

private:
  std::string folder_;
};

struct Line {
  std::size_t sample = 0;
  std::string name;
  std::vector<std::string> words{};
};

std::vector<Line> read_gesture(std::istream& stream) {
  std::vector<Line> lines;
  for (std::string text; std::getline(stream, text);) {
    std::istringstream words(text);
    Line line;
    if (words >> line.sample >> line.name) {
      line.words.assign(std::istream_iterator<std::string>(words), {});
      lines.push_back(line);
    }
  }
  return lines;
}

void carry_out(const Line& line, const Declaration& declaration, AnyObject<double>& object,
               Host& host) {
  std::vector<Atom> atoms;
  for (const std::string& word : line.words) {
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (*end)
      atoms.emplace_back(std::string_view(word));
    else
      atoms.emplace_back(number);
  }
  const Request request = resolve(declaration, line.name, atoms, HostPrecision::kDouble);
  if (request.kind == Request::Kind::kParameter)
    object.set(request.index, request.value);
  else if (request.kind == Request::Kind::kMessage)
    object.message(request.index, atoms, host);
}

std::vector<double> read_samples(const char* path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::vector<double> samples(bytes.size() / sizeof(double));
  std::memcpy(samples.data(), bytes.data(), samples.size() * sizeof(double));
  return samples;
}

void render(AnyObject<double>& object, const Declaration& declaration, PlainHost& host,
            const std::vector<std::vector<double>>& in, std::vector<std::vector<double>>& out) {
  for (std::size_t i = 0; i < declaration.parameters.size(); ++i)
    object.set(i, declaration.parameters[i].initial);
  const std::vector<Line> lines = read_gesture(std::cin);
  auto next = lines.begin();
  const auto send_until = [&](std::size_t sample) {
    for (; next != lines.end() && next->sample <= sample; ++next)
      carry_out(*next, declaration, object, host);
  };
  object.created(host);
  object.prepare(kRate, kFrames);
  std::vector<const double*> inputs(in.size());
  std::vector<double*> outputs(out.size());
  for (std::size_t begin = 0; begin < out[0].size(); begin += kFrames) {
    host.now = 1e3 * static_cast<double>(begin) / kRate;
    send_until(begin);
    for (std::size_t i = 0; i < in.size(); ++i)
      inputs[i] = in[i].data() + begin;
    for (std::size_t i = 0; i < out.size(); ++i)
      outputs[i] = out[i].data() + begin;
    object.process({inputs, outputs, kFrames, host.now});
    object.report(host);
  }
}

} // namespace

int main(int count, char** words) {
  if (count < 4)
    return 2;
  const std::string path = std::filesystem::absolute(words[1]).string();
  const char* const names[] = {path.c_str()};
  devices::SharedLibrary module;
  const ModuleObject<double>* (*get)() = nullptr;
  if (!module.load(names) || !module.symbol("tactus_test_object", get)) {
    std::cerr << path << ": " << module.error() << '\n';
    return 1;
  }
  const ModuleObject<double>& found = *get();
  const Declaration& declaration = *found.traits.declaration;
  std::vector<std::vector<double>> in;
  for (int i = 4; i < count; ++i)
    in.push_back(read_samples(words[i]));
  std::vector<std::vector<double>> out;
  for (const Port& port : declaration.outlets)
    if (port.kind == Port::Kind::kSignal)
      out.emplace_back(in.at(0).size());
  PlainHost host(words[2]);
  const std::unique_ptr<AnyObject<double>> object(found.make());
  render(*object, declaration, host, in, out);
  std::ofstream file(words[3], std::ios::binary);
  for (const auto& signal : out)
    file.write(reinterpret_cast<const char*>(signal.data()),
               static_cast<std::streamsize>(signal.size() * sizeof(double)));
  return file.good() ? 0 : 1;
}
