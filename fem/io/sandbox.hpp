#pragma once
#include <cstdint>

namespace tactus::fem {

/// Drops inherited state that a parser does not need: the controlling terminal, by starting a new
/// session; the environment; signal handlers, ignored and blocked signals.
void leave_terminal_and_environment() noexcept;

/// Denies this process, for the rest of its life, what a parser of untrusted files does not need:
/// address space beyond the present size plus `memory_bytes` (not under the address sanitizer),
/// processor time beyond `cpu_seconds`, core files, written files, new privileges. On Linux (x86-64
/// and ARM64) a system-call filter also refuses other programs, other processes, sockets, signals
/// to others, terminals, locks, keyrings, shared memory, and opening a file for writing, or making,
/// renaming or removing one. Restrictions that the kernel does not support are skipped.
void enter_sandbox(std::uint64_t memory_bytes, std::uint64_t cpu_seconds) noexcept;

/// Whether this program was built with the address sanitizer, whose shadow memory takes 20 TB of
/// address space.
[[nodiscard]] bool under_address_sanitizer() noexcept;

} // namespace tactus::fem
