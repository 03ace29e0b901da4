#pragma once
#include "fem/mesh/mesh.hpp"

#include <cstdint>
#include <functional>

namespace tactus::fem {

/// Limits of a child process.
struct ChildLimits {
  std::uint64_t memory_bytes = 0; ///< 0: half of the machine's free memory
  double progress_timeout_s =
      1200; ///< seconds by the wall clock from one sign of progress to the next
};

/// Progress callbacks: sentences, and stages with their completed fraction.
struct ChildProgress {
  std::function<void(const std::string& sentence)> notify{};
  std::function<void(const std::string& stage, double share)> report{};
};

/// Runs `work` in a child process and returns its mesh. A crash, an endless loop or a forbidden
/// system call there (sandbox.hpp) does not affect this process. `work` gets a ChildProgress that
/// reaches `progress` here; what it throws is thrown here as an InputError. A child that ends by a
/// signal, the memory limit or the progress timeout is an InputError of one sentence that begins
/// with `file` and names the limit and how to raise it. The child ends when this process ends, for
/// whatever reason. One child at a time.
[[nodiscard]] Mesh run_isolated(const std::string& file, const ChildLimits&,
                                const ChildProgress& progress,
                                const std::function<Mesh(const ChildProgress&)>& work);

/// Ends the child that runs now, if any, and waits for it. For signal handlers.
void end_isolated_child() noexcept;

} // namespace tactus::fem
