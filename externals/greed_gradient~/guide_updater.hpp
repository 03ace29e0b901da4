#pragma once

#include "core/dsp/mailbox.hpp"
#include "core/reed/playability/plane_guide.hpp"
#include "externals/playability_map/map_worker.hpp"

#include <cstddef>
#include <memory>
#include <string>
#include <utility>

namespace tactus::reed {

/// Recomputes a PlaneGuide when its instrument changes, in a thread or in portions of the host's
/// time. The audio path gets the newest finished guide through a mailbox, without waiting.
class GuideUpdater {
public:
  GuideUpdater();

  /// Call it after a block of elapsed_s seconds of sound. Returns whether work() has something to
  /// do for this target. Allocates nothing, so that the audio thread may call it.
  [[nodiscard]] bool needs_work(const PlaneSettings& target, double elapsed_s,
                                bool in_background) noexcept;
  /// The host's thread calls it after needs_work(). Starts a map for the target if there is none;
  /// computes a portion of the map if in_background was false. Never waits.
  void work();
  /// True twenty times per second of sound while a map is computed, and once when it is finished.
  [[nodiscard]] bool progress_changed() noexcept;
  /// Returns, once, the reason why the map is computed in the host's time although in_background
  /// was true.
  [[nodiscard]] std::string take_error() { return std::exchange(thread_error_, {}); }
  /// Computed fraction of the current or the last map, 0..1.
  [[nodiscard]] double progress() const noexcept;

  /// For the audio thread. Null until the first map is finished; valid until the next call.
  [[nodiscard]] const PlaneGuide* latest() noexcept;

private:
  void begin();
  [[nodiscard]] bool computing() const noexcept { return has_request_ && !worker_.finished(); }
  [[nodiscard]] bool obsolete() const noexcept;
  [[nodiscard]] MapWorker::Portion portion();

  /// The data that the worker uses. They may outlive this object until a portion in progress ends.
  struct Maps {
    GrowthMap map;
    PlaneGuide finished_guide;
    Mailbox<PlaneGuide> mailbox;
  };
  std::shared_ptr<Maps> maps_ = std::make_shared<Maps>();
  PlaneSettings target_{}, requested_{};
  bool in_background_ = true, up_to_date_ = false, length_settled_ = false;
  std::string thread_error_{};
  bool without_thread_ = false; // the system could not start a thread
  bool has_request_ = false, has_guide_ = false, reported_ = true;
  double length_m_ = 0, waiting_s_ = 0, nodes_due_ = 0, since_report_s_ = 0, elapsed_s_ = 0;
  MapWorker worker_;
};

} // namespace tactus::reed
