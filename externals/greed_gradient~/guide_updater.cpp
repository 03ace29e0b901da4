#include "externals/greed_gradient~/guide_updater.hpp"

#include "core/reed/playability/gradient.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactus::reed {
namespace {

constexpr std::size_t kNodes = ReedGradient::kGrowthNodes;
constexpr std::size_t kNodesPerStep = 8; // a step takes about 0.4 ms
constexpr double kNodesPerSecond = 3000; // second of sound, in the host's time; about 15 % of a
                                         // core
constexpr double kReportInterval_s = 0.05;
constexpr double kMaxWait_s = 0.1; // after that, a bore that has not settled is mapped as it is

} // namespace

GuideUpdater::GuideUpdater() { maps_->map.prepare(kNodes, kNodes); }

MapWorker::Portion GuideUpdater::portion() {
  return [maps = maps_, target = target_](std::vector<double>& nodes, std::size_t first) {
    if (first == 0)
      maps->map.begin(target.playing, target.range);
    if (!maps->map.advance(kNodesPerStep))
      return std::min(first + kNodesPerStep, nodes.size() - 1);
    maps->finished_guide.build(maps->map);
    maps->mailbox.write(maps->finished_guide);
    return nodes.size();
  };
}

void GuideUpdater::begin() {
  requested_ = target_;
  has_request_ = true;
  reported_ = false;
  nodes_due_ = 0;
  since_report_s_ = kReportInterval_s;
  if (in_background_) {
    thread_error_ = worker_.start(kNodes * kNodes, portion());
    without_thread_ = !thread_error_.empty();
  } else {
    worker_.start_stepped(kNodes * kNodes, portion());
  }
}

bool GuideUpdater::obsolete() const noexcept {
  return target_.revision != requested_.revision || worker_.is_stepped() == in_background_;
}

bool GuideUpdater::needs_work(const PlaneSettings& target, double elapsed_s,
                              bool in_background) noexcept {
  target_ = target;
  in_background_ = in_background && !without_thread_;
  elapsed_s_ += elapsed_s;
  since_report_s_ += elapsed_s;
  up_to_date_ = has_request_ && target.matches(requested_);
  length_settled_ = std::abs(target.playing.length - length_m_) <= 1e-5 * length_m_;
  length_m_ = target.playing.length;
  waiting_s_ = up_to_date_ ? 0 : waiting_s_ + elapsed_s;
  const bool in_thread = computing() && !worker_.is_stepped();
  const bool needed = in_thread && !obsolete() ? !reported_ && since_report_s_ >= kReportInterval_s
                                               : !up_to_date_ || in_thread || !worker_.finished() ||
                                                     !reported_ || !thread_error_.empty();
  if (!needed)
    elapsed_s_ = 0; // only time with work to do counts towards portions
  return needed;
}

void GuideUpdater::work() {
  if (thread_error_.empty())
    thread_error_ = worker_.take_error();
  if (computing() && obsolete()) {
    worker_.cancel();
    has_request_ = false;
  }
  if (!computing() && !(has_request_ && up_to_date_) &&
      (length_settled_ || waiting_s_ > kMaxWait_s))
    begin();
  const double elapsed_s = std::exchange(elapsed_s_, 0);
  if (computing() && worker_.is_stepped())
    for (nodes_due_ += kNodesPerSecond * elapsed_s;
         nodes_due_ >= kNodesPerStep && !worker_.finished(); nodes_due_ -= kNodesPerStep)
      worker_.step();
}

bool GuideUpdater::progress_changed() noexcept {
  if (reported_ || (progress() < 1 && since_report_s_ < kReportInterval_s))
    return false;
  since_report_s_ = 0;
  reported_ = progress() == 1;
  return true;
}

double GuideUpdater::progress() const noexcept {
  return has_request_ ? static_cast<double>(worker_.done()) / static_cast<double>(kNodes * kNodes)
                      : 0;
}

const PlaneGuide* GuideUpdater::latest() noexcept {
  has_guide_ |= maps_->mailbox.read();
  return has_guide_ ? &maps_->mailbox.latest() : nullptr;
}

} // namespace tactus::reed
