#pragma once

#include "core/rows.hpp"

#include <algorithm>
#include <array>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace tactus::test {

/// An object with one of everything the shells offer, for their own tests: multiplies two signals
/// and a gain, counts blocks, echoes messages, wakes itself.
struct Probe {
  static const Declaration declaration;
  struct Rows;
  static constexpr std::size_t timers = 1;
  static constexpr bool multichannel = true;

  void fail_in(std::string_view member) const {
    if (member != failing)
      return;
    if (how == "memory")
      throw std::bad_alloc();
    if (how == "size")
      static_cast<void>(std::string().append(std::string().max_size() + 1, ' '));
    if (how == "range")
      throw std::out_of_range("a reason");
    throw 1;
  }
  void prepare(double, std::size_t) const { fail_in("dsp"); }
  [[nodiscard]] double get_gain() const {
    fail_in("get");
    return gain;
  }
  void set_gain(double value) {
    fail_in("set");
    gain = value;
  }
  void echo(std::span<const Atom> arguments, Host& host) const {
    fail_in("message");
    host.info(arguments);
  }
  void wake(const Atom& ms, Host& host) const {
    fail_in("message");
    host.wake_in(0, ms.number);
  }
  void fail(std::span<const Atom> arguments, Host& host) {
    failing = arguments[0].word;
    how = arguments[1].word;
    host.wake_from_thread();
  }
  void post(const Atom& times, Host& host) {
    fail_in("message");
    for (woken = 0; woken < times.number; ++woken)
      host.wake_from_thread();
  }
  void starts(Host& host) const {
    fail_in("message");
    host.info({"ago", host.now_ms() - starts_ms[0], host.now_ms() - starts_ms[1],
               host.now_ms() - starts_ms[2], host.now_ms() - starts_ms[3]});
  }
  void created(Host&) const {
    if (gain == 3.5)
      throw std::bad_alloc();
  }
  void posted(Host& host) const {
    fail_in("posted");
    if (woken > 0)
      host.info({"posted"});
  }
  void scalar(std::size_t inlet, double value, Host& host) {
    fail_in("scalar");
    host.info({"scalar", static_cast<double>(inlet), value});
  }
  void list(std::size_t inlet, std::span<const Atom> atoms, Host& host) {
    fail_in("list");
    std::vector<Atom> echo{"list", static_cast<double>(inlet)};
    echo.insert(echo.end(), atoms.begin(), atoms.end());
    host.info(echo);
  }
  template <class S> void process(const Block<S>& block) noexcept {
    const double factor = gain * (negative ? -1 : 1);
    for (std::size_t n = 0; n < block.frames; ++n)
      block.outputs[0][n] = static_cast<S>(factor * static_cast<double>(block.inputs[0][n]) *
                                           static_cast<double>(block.inputs[1][n]));
    std::rotate(starts_ms.begin(), starts_ms.begin() + 1, starts_ms.end());
    starts_ms.back() = block.start_ms;
    ++blocks;
  }
  void dump_first(Host& host) {
    fail_in("dump");
    host.info({"kind", "probe"});
  }
  void dump(Host& host) {
    host.info({"block", 1.0, static_cast<double>(blocks)});
    host.info({"block", 2.0, "last"});
    host.send(1, {-1.0}); // of no name: for dump alone
  }
  void report(Host& host) {
    fail_in("report");
    host.send(1, {static_cast<double>(blocks)});
  }
  void tick(std::size_t, Host& host) {
    fail_in("tick");
    host.info({"awake", host.now_ms()});
  }

  double gain = 0;
  bool negative = false;
  std::array<double, 4> starts_ms{};
  std::size_t blocks = 0;
  double woken = 0;
  std::string failing{}, how{};
};

struct Probe::Rows {
  static constexpr std::array<std::string_view, 2> signs{"plus", "minus"};
  static constexpr std::array parameters{
      property<&Probe::get_gain, &Probe::set_gain>.row("gain", "", 1, 0, 4,
                                                       "factor of the product"),
      member<&Probe::negative>.row("sign", signs, "of the product", 0),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kSignal, "a", "", "first factor"},
      Port{Port::Kind::kSignal, "b", "", "second factor"},
      Port{Port::Kind::kControl, "number", "", "echoed with its inlet number"},
      Port{Port::Kind::kList, "list", "", "echoed with its inlet number"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kSignal, "product", "", "gain a b"},
      Port{Port::Kind::kControl, "blocks", "", "blocks processed so far, after each block"},
  };
  static constexpr std::array messages{
      action<&Probe::echo>("echo", "anything", 0, 100, "comes back out of the info outlet"),
      action<&Probe::wake>("wake", "ms", 1, 1, "sends `awake` that much later"),
      action<&Probe::fail>("fail", "member how", 2, 2,
                           "from now on that member throws; how: memory, size, 1"),
      action<&Probe::post>(
          "post", "times", 1, 1,
          "wakes itself that many times, and sends `posted` each time it is woken"),
      action<&Probe::starts>("starts", "", 0, 0,
                             "sends `ago` and how long ago the latest four blocks began, in ms"),
  };
  static constexpr std::array arguments{CreationArgument{"gain"}, CreationArgument{"echo"}};
};

inline constexpr Declaration Probe::declaration{
    "probe~",         "one of everything", "For the tests of the shells.",
    "test",           Rows::inlets,        Rows::outlets,
    Rows::parameters, Rows::messages,      Rows::arguments};

} // namespace tactus::test
