#pragma once

#include "core/haptic/servo/mailbox.hpp"
#include "core/reed/playability/plane_guide.hpp"
#include "externals/playability_map/map_worker.hpp"

#include <cstddef>
#include <string>
#include <utility>

namespace tactus::reed {

/// Keeps a PlaneGuide up to date with an instrument: in a thread of its own, or in portions of the
/// host's time. The audio path takes the newest without waiting; the old one goes on until then.
class GuideUpdater {
public:
  GuideUpdater();

  /// Host time, after a block: `elapsed_s` seconds of sound further, this is what is wanted. Begins
  /// a map when there is none for it; does a portion when `in_background` is false. Never waits.
  void update(const PlaneSettings& target, double elapsed_s, bool in_background);
  /// True twenty times a second of sound while a map is made, and once when it is finished.
  [[nodiscard]] bool progress_changed() noexcept;
  /// Once, why the map is computed in the host's time though it was wanted in the background.
  [[nodiscard]] std::string take_error() { return std::exchange(thread_error_, {}); }
  /// 0..1, of the map at work or the last one.
  [[nodiscard]] double progress() const noexcept;

  /// Audio path. Null until the first map is finished; valid until the next call.
  [[nodiscard]] const PlaneGuide* latest() noexcept;

private:
  void begin(const PlaneSettings& target, bool in_background);
  [[nodiscard]] MapWorker::Portion portion();

  GrowthMap map_;             // the worker's
  PlaneGuide finished_guide_; // the worker's
  haptic::Mailbox<PlaneGuide> mailbox_;
  PlaneSettings requested_{};
  std::string thread_error_{};
  bool without_thread_ = false; // the system gave none
  bool has_request_ = false, has_guide_ = false, reported_ = true;
  double length_m_ = 0, waiting_s_ = 0, nodes_due_ = 0, since_report_s_ = 0;
  MapWorker worker_; // last: ends before what it works on
};

} // namespace tactus::reed
