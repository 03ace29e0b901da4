#pragma once

#include <memory>

/// Something that filters blocks of 64 samples through a bank of modes.
class Peer {
public:
  virtual ~Peer() = default;
  virtual void block(const float* in, float* out) = 0;
};
