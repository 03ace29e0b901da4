#pragma once
#include "fem/mesh/mesh.hpp"

#include <cstdint>
#include <functional>

namespace tactus::fem {

/// Limits of a child process.
struct ChildLimits {
  std::uint64_t memory_bytes = 0;   ///< 0: half of the machine's free memory
  double progress_timeout_s = 1200; ///< wall-clock seconds between two signs of progress
};

/// Progress callbacks: sentences, and stages with their completed fraction.
struct ChildProgress {
  std::function<void(const std::string& sentence)> notify{};
  std::function<void(const std::string& stage, double share)> report{};
};

/// Runs `work` in a child process and returns its mesh. A crash, an endless loop or a forbidden
/// system call there (sandbox.hpp) does not affect this process. `work` gets a ChildProgress whose
/// calls reach `progress` in this process. An exception of `work` is rethrown here as an
/// InputError. If a signal, the memory limit or the progress timeout ends the child, this throws an
/// InputError of one sentence that begins with `file`, names the limit and says how to raise it.
/// The child ends when this process ends, for whatever reason. Only one child may run at a time.
[[nodiscard]] Mesh run_isolated(const std::string& file, const ChildLimits&,
                                const ChildProgress& progress,
                                const std::function<Mesh(const ChildProgress&)>& work);

/// Ends the running child, if there is one, and waits for it. Signal handlers may call it.
void end_isolated_child() noexcept;

} // namespace tactus::fem
