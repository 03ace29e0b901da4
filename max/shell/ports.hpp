#pragma once

#include "core/declaration.hpp"
#include "max/abi/max_abi.h"

#include <cstddef>
#include <string>
#include <vector>

/// An object's inlets and outlets in Max.
namespace tactus::max {

/// Number of inlets to which signals can be connected: all up to the last declared signal inlet.
[[nodiscard]] std::size_t count_signal_inlets(const Declaration&);

class Ports {
public:
  /// Makes the ports from right to left, because Max adds each new port at the left.
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

/// The text that Max shows while the mouse is over a port, such as "(signal/float) p_m, Pa: mouth
/// pressure".
[[nodiscard]] std::string assistance(const Declaration&, bool is_inlet, std::size_t index);

} // namespace tactus::max
