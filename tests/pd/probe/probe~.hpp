#pragma once

#include "core/object.hpp"

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
  static constexpr std::array<std::string_view, 2> kSigns{"plus", "minus"};
  static constexpr std::array kParameters{
      Parameter{"gain", "", 1, 0, 4, "factor of the product"},
      Parameter{"sign", "", 0, 0, 1, "of the product", kSigns},
  };
  static constexpr std::array kInlets{
      Port{Port::Kind::kSignal, "a", "", "first factor"},
      Port{Port::Kind::kSignal, "b", "", "second factor"},
      Port{Port::Kind::kControl, "number", "", "echoed with its inlet number"},
      Port{Port::Kind::kList, "list", "", "echoed with its inlet number"},
  };
  static constexpr std::array kOutlets{
      Port{Port::Kind::kSignal, "product", "", "gain a b"},
      Port{Port::Kind::kControl, "blocks", "", "blocks processed so far, after each block"},
  };
  static constexpr std::array kMessages{
      Message{"echo", "anything", 0, 100, "comes back out of the info outlet"},
      Message{"wake", "ms", 1, 1, "sends `awake` that much later"},
      Message{"fail", "member how", 2, 2, "from now on that member throws; how: memory, size, 1"},
      Message{"post", "times", 1, 1,
              "wakes itself that many times, and sends `posted` each time it is woken"},
      Message{"starts", "", 0, 0,
              "sends `ago` and how long ago the latest four blocks began, in ms"},
  };
  static constexpr std::array kArguments{CreationArgument{"gain"}, CreationArgument{"echo"}};
  static constexpr Declaration declaration{"probe~",
                                           "one of everything",
                                           "For the tests of the shells.",
                                           "test",
                                           kInlets,
                                           kOutlets,
                                           kParameters,
                                           kMessages,
                                           kArguments};
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
  void set(std::size_t parameter, double value) {
    fail_in("set");
    values[parameter] = value;
  }
  [[nodiscard]] double get(std::size_t parameter) const {
    fail_in("get");
    return values[parameter];
  }
  void message(std::size_t index, std::span<const Atom> arguments, Host& host) {
    if (index == 2) {
      failing = arguments[0].word;
      how = arguments[1].word;
      return host.wake_from_thread();
    }
    fail_in("message");
    if (index == 3) {
      for (woken = 0; woken < arguments[0].number; ++woken)
        host.wake_from_thread();
      return;
    }
    if (index == 4)
      return host.info({"ago", host.now_ms() - starts_ms[0], host.now_ms() - starts_ms[1],
                        host.now_ms() - starts_ms[2], host.now_ms() - starts_ms[3]});
    if (index == 0)
      host.info(arguments);
    else
      host.wake_in(0, arguments[0].number);
  }
  void created(Host&) const {
    if (values[0] == 3.5)
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
    const double factor = values[0] * (values[1] > 0 ? -1 : 1);
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

  std::array<double, 2> values{};
  std::array<double, 4> starts_ms{};
  std::size_t blocks = 0;
  double woken = 0;
  std::string failing{}, how{};
};

} // namespace tactus::test
