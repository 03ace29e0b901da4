#pragma once

#include "bench/modal_bank/peer.hpp"

#include <cstddef>
#include <memory>

/// Null where the peer is not installed.
std::unique_ptr<Peer> make_loop(std::size_t modes);
std::unique_ptr<Peer> make_stk(std::size_t modes);
std::unique_ptr<Peer> make_csound(std::size_t modes);
