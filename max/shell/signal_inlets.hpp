#pragma once

#include "core/declaration.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

/// The samples of an object's signal inlets: Max's samples if a signal is connected, otherwise the
/// last number that was sent to the inlet, as in Pd.
namespace tactus::max {

class SignalInlets {
public:
  /// The longest block, equal to Max's longest vector.
  static constexpr std::size_t kMaxFrames = 2048;

  explicit SignalInlets(const Declaration& declaration) {
    for (std::size_t i = 0; i < declaration.inlets.size(); ++i)
      if (declaration.inlets[i].kind == Port::Kind::kSignal)
        inlets_.push_back(std::make_unique<Inlet>(i));
    samples_.resize(inlets_.size());
  }

  /// For any thread. Returns false if `port` is not a signal inlet.
  bool set(std::size_t port, double number) noexcept {
    for (auto& inlet : inlets_)
      if (inlet->port == port)
        return inlet->number.store(number, std::memory_order_relaxed), true;
    return false;
  }
  /// Called when the signal graph changes, with Max's counts for all its signal inlets.
  void connect(std::span<const short> counts) noexcept {
    for (auto& inlet : inlets_)
      inlet->connected.store(inlet->port < counts.size() && counts[inlet->port] != 0,
                             std::memory_order_relaxed);
  }
  /// For the audio thread: for each inlet a pointer to at most kMaxFrames samples.
  [[nodiscard]] std::span<const double* const> samples(std::span<double* const> from_max,
                                                       std::size_t first) noexcept {
    for (std::size_t k = 0; k < inlets_.size(); ++k) {
      Inlet& inlet = *inlets_[k];
      if (inlet.connected.load(std::memory_order_relaxed) && inlet.port < from_max.size())
        samples_[k] = from_max[inlet.port] + first;
      else
        samples_[k] = inlet.constant();
    }
    return samples_;
  }

private:
  struct Inlet {
    explicit Inlet(std::size_t declared) : port(declared), held(kMaxFrames) {}
    [[nodiscard]] const double* constant() noexcept {
      const double now = number.load(std::memory_order_relaxed);
      if (!(now == held[0]))
        std::fill(held.begin(), held.end(), now);
      return held.data();
    }
    std::size_t port;
    std::atomic<double> number{0};
    std::atomic<bool> connected{false};
    std::vector<double> held;
  };
  std::vector<std::unique_ptr<Inlet>> inlets_;
  std::vector<const double*> samples_;
};

} // namespace tactus::max
