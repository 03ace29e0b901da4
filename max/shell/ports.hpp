#pragma once

#include "core/declaration.hpp"
#include "max/abi/max_abi.h"

#include <cstddef>
#include <string>
#include <vector>

/// An object's inlets and outlets in Max.
namespace tactus::max {

/// Inlets that signals can be connected to: all up to the last that is declared as one.
[[nodiscard]] std::size_t count_signal_inlets(const Declaration&);

class Ports {
public:
  /// Makes them from right to left, as Max adds each at the left of those that are there.
  Ports(t_pxobject& object, const Declaration&, bool processes);
  ~Ports();
  Ports(const Ports&) = delete;
  Ports& operator=(const Ports&) = delete;

  [[nodiscard]] void* outlet(std::size_t i) const {
    return i < outlets_.size() ? outlets_[i] : nullptr;
  }
  /// The declared info outlet, or one at the right of all others.
  [[nodiscard]] void* info() const { return info_; }

private:
  std::vector<void*> outlets_; // Max frees them
  void* info_ = nullptr;
  std::vector<void*> proxies_;
};

/// What Max shows while the mouse is over a port: "(signal/float) p_m, Pa: mouth pressure".
[[nodiscard]] std::string assistance(const Declaration&, bool is_inlet, std::size_t index);

} // namespace tactus::max
