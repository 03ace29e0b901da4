#pragma once

#include "bench/modal_bank/peer.hpp"
#include "core/modal/bank/bank_kernel.hpp"

#include <cstddef>
#include <memory>

/// The recursion with nothing around it, as a measure of what the machine can do sample by sample:
/// v <- r^2 v - kappa y + b x, y <- y + v, the output is the sum of all y; kappa = 1 + r^2 - 2 r
/// cos w. Accurate in pitch. Modes in lanes, as many registers of them in flight as there are. Null
/// where the processor has not got the instructions.
std::unique_ptr<Peer> make_bare_recursion(tactus::modal::VectorSet set, std::size_t modes);

/// Single-precision multiply-adds a nanosecond of this core at its best, lane by lane; 0 where the
/// processor has not got the instructions.
double multiply_adds_per_ns(tactus::modal::VectorSet set);
