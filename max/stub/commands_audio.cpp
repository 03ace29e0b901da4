// Commands on the host: audio, time, threads, files.
#include "max/stub/script.hpp"
#include "max/stub/sources.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus::stub {
namespace {
std::size_t to_size(const Token& token) {
  return static_cast<std::size_t>(std::stoull(token.text));
}
double vector_ms() {
  const AudioSettings& s = audio_settings();
  return 1000.0 * static_cast<double>(s.vector) / s.sample_rate;
}
std::size_t choice(const Token& token, std::span<const std::string_view> words) {
  for (std::size_t i = 0; i < words.size(); ++i)
    if (words[i] == token.text)
      return i;
  throw ScriptError("not expected: " + token.text);
}
bool is_on(const Token& token) {
  return choice(token, std::array<std::string_view, 2>{"off", "on"}) == 1;
}
} // namespace

void Script::recompile() {
  if (dsp_runs())
    start_dsp();
}

void Script::signal(Arguments a) {
  Object& object = box(a[0]);
  const std::size_t inlet = to_size(a[1]);
  if (static_cast<long>(inlet) >= object.signal_inlets)
    throw ScriptError(a[0].text + " has no signal inlet " + a[1].text);
  Input input;
  if (a[2].text == "box") {
    if (a.size() < 5)
      throw ScriptError("usage: signal ID INLET box ID OUTLET");
    input.box = &box(a[3]);
    input.outlet = to_size(a[4]);
  } else if (a[2].text != "none") {
    std::vector<std::string> words;
    for (const Token& token : a.subspan(2))
      words.push_back(token.text);
    input.source = make_source(words);
  }
  connect_input(object, inlet, std::move(input));
  recompile();
}

void Script::rate(Arguments a) {
  audio_settings().sample_rate = std::stod(a[0].text);
  recompile();
}
void Script::vector(Arguments a) {
  const long n = std::stol(a[0].text), max = a.size() > 1 ? std::stol(a[1].text) : n;
  if (n < 1 || max < n || max > 8192)
    throw ScriptError("a vector of 1 to 8192 samples");
  const bool on = dsp_runs();
  stop_dsp();
  audio_settings().vector = n;
  audio_settings().max_vector = max;
  if (on)
    start_dsp();
}
void Script::inplace(Arguments a) {
  audio_settings().inplace =
      static_cast<Inplace>(choice(a[0], std::array<std::string_view, 3>{"off", "same", "crossed"}));
}
void Script::unconnected(Arguments a) {
  audio_settings().zeros_unconnected =
      choice(a[0], std::array<std::string_view, 2>{"guard", "zeros"}) == 1;
  recompile();
}
void Script::dsp(Arguments a) {
  if (is_on(a[0]))
    start_dsp();
  else
    stop_dsp();
}
void Script::mute(Arguments a) {
  Object& object = box(a[0]);
  if (!object.type->dsp)
    throw ScriptError(a[0].text + " has no signals");
  reinterpret_cast<t_pxobject*>(object.header())->z_disabled = std::stol(a[1].text);
}

void Script::run_vectors(Arguments a) {
  const std::uint64_t count = std::stoull(a[0].text);
  const double begin = now_ms();
  for (std::uint64_t i = 0; i < count; ++i) {
    advance_clocks(begin + static_cast<double>(i) * vector_ms());
    perform_vector();
    if (!low_priority_by_hand_)
      run_low_priority();
  }
  advance_clocks(begin + static_cast<double>(count) * vector_ms());
  if (!low_priority_by_hand_)
    run_low_priority();
}

void Script::record(Arguments a) {
  Object& object = box(a[0]);
  auto& recording = recordings_[a[0].text];
  recording = std::make_unique<Recording>(Recording{a[1].text, {}});
  performer_of(object).recorded = &recording->samples;
}
void Script::write_recordings() {
  for (const auto& [id, recording] : recordings_)
    write_samples(recording->file, recording->samples);
  recordings_.clear();
}

void Script::levels(Arguments a) {
  const Object& object = box(a[0]);
  if (!object.performer)
    return;
  for (std::size_t i = 0; i < object.performer->levels.size(); ++i) {
    Performer::Level& level = object.performer->levels[i];
    const double samples = static_cast<double>(std::max<std::uint64_t>(level.samples, 1));
    const std::array numbers{float_atom(level.peak),
                             float_atom(std::sqrt(level.square_sum / samples)),
                             long_atom(static_cast<t_atom_long>(level.not_finite))};
    print_line("level: " + object.id + " " + std::to_string(i) + " " + to_text(numbers));
    level = {};
  }
}

void Script::advance(Arguments a) { advance_clocks(now_ms() + std::stod(a[0].text)); }
void Script::service(Arguments) { run_low_priority(); }
void Script::low_priority(Arguments a) {
  low_priority_by_hand_ = choice(a[0], std::array<std::string_view, 2>{"auto", "manual"}) == 1;
}
void Script::overdrive(Arguments a) { set_overdrive(is_on(a[0])); }
void Script::thread(Arguments a) {
  set_role(choice(a[0], std::array<std::string_view, 2>{"main", "scheduler"}) == 0
               ? Role::kMain
               : Role::kScheduler);
}
void Script::search_path(Arguments a) { add_search_path(a[0].text); }
void Script::patcher_path(Arguments a) {
  if (a.size() > 1 && a[1].text != "subpatcher")
    throw ScriptError("patcher: a file, and perhaps the word subpatcher");
  set_patcher_path(a[0].text, a.size() > 1);
}

void Script::buffer(Arguments a) {
  const std::size_t channels = to_size(a[1]), frames = to_size(a[2]);
  if (channels == 0)
    throw ScriptError("a buffer~ has at least one channel");
  std::vector<double> signal(frames);
  if (a.size() > 3) {
    std::vector<std::string> words;
    for (const Token& token : a.subspan(3))
      words.push_back(token.text);
    make_source(words)(signal, 0);
  }
  std::vector<float> samples;
  for (double v : signal)
    samples.insert(samples.end(), channels, static_cast<float>(v));
  make_buffer(a[0].text, static_cast<long>(channels), samples);
}

} // namespace tactus::stub
