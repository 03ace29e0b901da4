#include "externals/greed_gradient~/guide_updater.hpp"

#include "core/reed/playability/gradient.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr std::size_t kNodes = ReedGradient::kGrowthNodes;
constexpr std::size_t kNodesPerStep = 8; // some 0.4 ms
constexpr double kNodesPerSecond = 3000; // of sound, in the host's time; some 15 % of a core
constexpr double kReportInterval_s = 0.05;
constexpr double kMaxWait_s = 0.1; // for the bore to settle, before it is mapped as it is

} // namespace

GuideUpdater::GuideUpdater() { map_.prepare(kNodes, kNodes); }

MapWorker::Portion GuideUpdater::portion() {
  return [this](std::vector<double>& nodes, std::size_t first) {
    if (!map_.advance(kNodesPerStep))
      return std::min(first + kNodesPerStep, nodes.size() - 1);
    finished_guide_.build(map_);
    mailbox_.write(finished_guide_);
    return nodes.size();
  };
}

void GuideUpdater::begin(const PlaneSettings& target, bool in_background) {
  requested_ = target;
  has_request_ = true;
  reported_ = false;
  nodes_due_ = 0;
  since_report_s_ = kReportInterval_s;
  map_.begin(target.playing, target.range);
  if (in_background) {
    thread_error_ = worker_.start(kNodes * kNodes, portion());
    without_thread_ = !thread_error_.empty();
  } else {
    worker_.start_stepped(kNodes * kNodes, portion());
  }
}

void GuideUpdater::update(const PlaneSettings& target, double elapsed_s, bool in_background) {
  in_background = in_background && !without_thread_;
  since_report_s_ += elapsed_s;
  const bool up_to_date = has_request_ && target.matches(requested_);
  const bool length_settled = std::abs(target.playing.length - length_m_) <= 1e-5 * length_m_;
  length_m_ = target.playing.length;
  waiting_s_ = up_to_date ? 0 : waiting_s_ + elapsed_s;
  const bool obsolete =
      target.revision != requested_.revision || worker_.is_stepped() == in_background;
  if (!worker_.idle() && obsolete) {
    worker_.request_stop();
    has_request_ = false;
  }
  if (!(has_request_ && up_to_date) && worker_.idle() &&
      (length_settled || waiting_s_ > kMaxWait_s))
    begin(target, in_background);
  if (worker_.is_stepped() && !worker_.finished())
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
  has_guide_ |= mailbox_.read();
  return has_guide_ ? &mailbox_.latest() : nullptr;
}

} // namespace tactus::reed
