#pragma once

#include <cstddef>

/// Time that this thread has had the processor for, s: what others take of it does not count.
double thread_cpu_seconds();

/// The dearest block of 64 samples of plates with thousands of modes and a surface of 2501 vertices
/// with 1, 2 and 4 listeners: struck by 1 or 8 balls at one sample, pushed at a point
/// that moves at 1 kHz, and touched by a dragged hand; against the 1.33 ms that a block lasts.
/// `only` for plates of so many modes; 0: 1024, 4096 and 20000.
void large_bodies(std::size_t only);

/// Two bodies that rest on each other at several points and ring: cost of a sample beside the same
/// two apart.
void resting_bodies();
