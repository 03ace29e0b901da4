// The audio side: signals, the dsp method, the perform chain.
#include "tests/pd/host/internal.hpp"

#include <algorithm>
#include <cstdarg>

namespace tactus::test {
namespace {

HostObject* building = nullptr; // whose dsp method runs

std::unique_ptr<HostSignal> new_signal(int frames, double rate, int channels) {
  std::unique_ptr<HostSignal> made(
      new HostSignal{frames, nullptr, static_cast<t_float>(rate), 0, {}});
  made->set_channels(channels);
  return made;
}

/// The number in each signal inlet.
std::vector<t_float> inlet_values(const HostObject& o) {
  std::vector<t_float> values;
  if (const int offset = o.type->main_signal_offset)
    values.push_back(
        *reinterpret_cast<const t_float*>(reinterpret_cast<const char*>(o.pd) + offset));
  for (const auto& inlet : o.inlets)
    if (inlet->takes_signal())
      values.push_back(inlet->value);
  return values;
}

} // namespace

void HostSignal::set_channels(int count) {
  channels = count;
  owned.assign(static_cast<std::size_t>(length * channels), 0);
  samples = owned.data();
}

std::size_t HostObject::signal_inlets() const { return inlet_values(*this).size(); }
std::size_t HostObject::signal_outlets() const {
  return static_cast<std::size_t>(std::count_if(
      outlets.begin(), outlets.end(), [](const auto& o) { return o->type == gensym("signal"); }));
}

void Box::dsp(double rate, int frames, const std::vector<int>& channels, bool alias) {
  HostObject& o = *object_;
  o.rate = rate;
  o.frames = frames;
  o.signals.clear();
  o.chain.clear();
  const _class::Method* const method = o.type->method("dsp");
  if (!method)
    return;
  const std::size_t ins = o.signal_inlets(), outs = o.signal_outlets();
  for (std::size_t i = 0; i < ins; ++i)
    o.signals.push_back(new_signal(frames, rate, channels[std::min(i, channels.size() - 1)]));
  for (std::size_t i = 0; i < outs; ++i) {
    o.signals.push_back(new_signal(frames, rate, 1));
    if (alias && channels[0] == 1 && i < ins)
      o.signals.back()->samples = o.signals[i]->samples;
  }
  std::vector<t_signal*> given;
  for (const auto& signal : o.signals)
    given.push_back(reinterpret_cast<t_signal*>(signal.get()));
  building = &o;
  as<void(t_pd*, t_signal**)>(method->function)(o.pd, given.data());
  building = nullptr;
}

Buffers Box::run(const Buffers& inputs, std::size_t samples, bool within_tick) {
  HostObject& o = *object_;
  const auto frames = static_cast<std::size_t>(o.frames);
  const std::size_t ins = o.signals.empty() ? 0 : o.signal_inlets();
  Buffers result(o.signals.size() - ins);
  for (std::size_t begin = 0; begin + frames <= samples; begin += frames) {
    if (!within_tick)
      advance(1000.0 * o.frames / o.rate); // as Pd does, to the block's end
    const std::vector<t_float> values = inlet_values(o);
    for (std::size_t i = 0; i < ins; ++i) {
      const std::size_t size = o.signals[i]->owned.size();
      const double* const from =
          i < inputs.size() && !inputs[i].empty() ? &inputs[i][begin / frames * size] : nullptr;
      for (std::size_t n = 0; n < size; ++n)
        o.signals[i]->samples[n] = from ? static_cast<t_sample>(from[n]) : values[i];
    }
    for (t_int* word = o.chain.data(); word < o.chain.data() + o.chain.size();)
      word = reinterpret_cast<t_perfroutine>(*word)(word);
    for (std::size_t i = 0; i < result.size(); ++i) {
      const HostSignal& signal = *o.signals[ins + i];
      result[i].insert(result[i].end(), signal.samples, signal.samples + signal.owned.size());
    }
    if (!within_tick)
      advance(0); // what the block has to say
  }
  return result;
}

} // namespace tactus::test

void dsp_add(t_perfroutine f, int n, ...) {
  std::vector<t_int>& chain = tactus::test::building->chain;
  chain.push_back(reinterpret_cast<t_int>(f));
  std::va_list words;
  va_start(words, n);
  for (int i = 0; i < n; ++i)
    chain.push_back(va_arg(words, t_int));
  va_end(words);
}
