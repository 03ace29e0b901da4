#include "tests/pd/host.hpp"

#include "tests/pd/probe/probe~.hpp"

#include <cstdio>
#include <cstdlib>
#include <numbers>

namespace tactus::test {
namespace {

std::vector<host_atom> to_host_atoms(const MessageAtoms& words) {
  std::vector<host_atom> atoms;
  for (const MessageAtom& w : words)
    atoms.push_back({w.is_word ? w.text.c_str() : nullptr, w.number});
  return atoms;
}

void load(const std::string& folder, std::string_view name) {
  std::string setup(name);
  if (setup.back() == '~')
    setup.replace(setup.size() - 1, 1, "_tilde");
  const std::string file = folder + "/" + std::string(name) + TACTUS_MODULE_SUFFIX;
  if (const char* why = host_load(file.c_str(), (setup + "_setup").c_str())) {
    std::fprintf(stderr, "cannot load %s: %s\n", file.c_str(), why);
    std::exit(1);
  }
}

} // namespace

const std::vector<ObjectDescription>& objects() {
  static const std::vector<ObjectDescription> all = [] {
    std::vector<ObjectDescription> found = described_objects();
    for (const ObjectDescription& described : found)
      load(TACTUS_STAGE, described.declaration->name);
    load(TACTUS_TEST_OBJECTS, Probe::declaration.name);
    found.push_back({&Probe::declaration, traits_of<Probe>()});
    return found;
  }();
  return all;
}

Box::Box(std::string_view name, const MessageAtoms& arguments) {
  static_cast<void>(objects());
  const std::vector<host_atom> atoms = to_host_atoms(arguments);
  object_.reset(host_make(std::string(name).c_str(), static_cast<int>(atoms.size()), atoms.data()));
}

void Box::send(int inlet, std::string_view selector, const MessageAtoms& atoms) {
  const std::vector<host_atom> given = to_host_atoms(atoms);
  host_message(object_.get(), inlet, std::string(selector).c_str(), static_cast<int>(given.size()),
               given.data());
}

void Box::dsp(double rate, int frames, int channels, bool alias) {
  rate_ = rate;
  frames_ = static_cast<std::size_t>(frames);
  channels_ = static_cast<std::size_t>(channels);
  has_dsp_ = host_dsp(object_.get(), rate, frames, channels, alias) != 0;
}

Buffers Box::run(const Buffers& inputs, std::size_t samples) {
  const auto outlets = has_dsp_ ? static_cast<std::size_t>(signal_outlets()) : 0;
  const auto inlets = has_dsp_ ? static_cast<std::size_t>(signal_inlets()) : 0;
  Buffers result(outlets);
  for (std::size_t i = 0; i < outlets; ++i)
    result[i].resize(samples *
                     static_cast<std::size_t>(host_channels(object_.get(), static_cast<int>(i))));
  std::vector<const double*> in(inlets);
  std::vector<double*> out(outlets);
  for (std::size_t begin = 0; begin + frames_ <= samples; begin += frames_) {
    for (std::size_t i = 0; i < inlets; ++i)
      in[i] =
          i < inputs.size() && !inputs[i].empty() ? inputs[i].data() + begin * channels_ : nullptr;
    for (std::size_t i = 0; i < outlets; ++i)
      out[i] = result[i].data() + begin * (result[i].size() / samples);
    host_advance(1000.0 * static_cast<double>(frames_) / rate_); // as Pd does, to the block's end
    if (has_dsp_)
      host_run(object_.get(), in.data(), out.data());
    host_advance(0); // what the block has to say
  }
  return result;
}

Buffers part_of(const Buffers& whole, std::size_t begin, std::size_t frames) {
  Buffers part;
  for (const std::vector<double>& signal : whole)
    part.emplace_back(signal.begin() + static_cast<std::ptrdiff_t>(begin),
                      signal.begin() + static_cast<std::ptrdiff_t>(begin + frames));
  return part;
}

void append(Buffers& whole, const Buffers& part) {
  whole.resize(part.size());
  for (std::size_t i = 0; i < part.size(); ++i)
    whole[i].insert(whole[i].end(), part[i].begin(), part[i].end());
}

std::vector<std::string> errors() {
  std::vector<std::string> result;
  for (int i = 0; i < host_error_count(); ++i)
    result.emplace_back(host_error(i));
  host_clear_events();
  return result;
}

std::vector<Sent> sent() {
  std::vector<Sent> result;
  for (int i = 0; i < host_event_count(); ++i) {
    const host_event event = host_get_event(i);
    Sent one{event.outlet, event.ms, event.selector, {}};
    for (int a = 0; a < event.count; ++a) {
      if (event.atoms[a].word)
        one.atoms.emplace_back(event.atoms[a].word);
      else
        one.atoms.emplace_back(event.atoms[a].number);
    }
    result.push_back(std::move(one));
  }
  host_clear_events();
  return result;
}

Buffers plausible_inputs(const Declaration& declaration, double rate, std::size_t samples) {
  constexpr double kTwoPi = 2 * std::numbers::pi;
  Buffers result;
  for (const Port& port : declaration.inlets) {
    if (port.kind != Port::Kind::kSignal)
      continue;
    std::vector<double> signal(samples);
    for (std::size_t n = 0; n < samples; ++n) {
      const double t = static_cast<double>(n) / rate;
      if (port.unit == "Pa")
        signal[n] = 4000 * std::abs(std::sin(kTwoPi * 2 * t));
      else if (port.unit == "Hz")
        signal[n] = 300 + 60 * std::sin(kTwoPi * 3 * t);
      else
        signal[n] = 0.5 + 0.4 * std::sin(kTwoPi * 220 * t) * std::sin(kTwoPi * 2.5 * t);
      signal[n] = static_cast<double>(static_cast<float>(signal[n]));
    }
    result.push_back(std::move(signal));
  }
  return result;
}

} // namespace tactus::test
