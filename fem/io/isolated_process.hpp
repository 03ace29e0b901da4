#pragma once
#include "fem/mesh/mesh.hpp"

#include <cstdint>
#include <functional>

namespace tactus::fem {

/// What a child process may use.
struct ChildLimits {
  std::uint64_t memory_bytes = 0; ///< 0: half of what the machine has free
  double progress_timeout_s =
      1200; ///< seconds by the wall clock from one sign of progress to the next
};

/// Signs of progress: sentences, and stages with the share that is done.
struct ChildProgress {
  std::function<void(const std::string& sentence)> notify{};
  std::function<void(const std::string& stage, double share)> report{};
};

/// Runs `work` in a child process and returns its mesh. What happens there (a crash, a run-away, a
/// system call it may not make; see sandbox.hpp) leaves this process as it is. `work` gets a
/// ChildProgress that reaches `progress` here; what it throws is thrown here as a Refusal. Death by
/// signal, memory or silence is a Refusal of one sentence that begins with `file` and names the
/// limit and how to raise it. The child ends with this process, whatever ends it. One child at a
/// time.
[[nodiscard]] Mesh run_isolated(const std::string& file, const ChildLimits&,
                                const ChildProgress& progress,
                                const std::function<Mesh(const ChildProgress&)>& work);

/// Ends the child that runs now, if any, and waits for it. For signal handlers.
void end_isolated_child() noexcept;

} // namespace tactus::fem
