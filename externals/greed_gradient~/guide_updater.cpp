#include "externals/greed_gradient~/guide_updater.hpp"

#include "core/reed/playability/gradient.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr std::size_t kNodes = ReedGradient::kGrowthNodes;
constexpr std::size_t kPortion = 8;      // nodes; some 0.4 ms
constexpr double kNodesPerSecond = 3000; // in the host's time: some 15 % of a core
constexpr double kNewsEvery_s = 0.05;
constexpr double kPatience_s = 0.1; // a bore that moves for longer is mapped as it is

} // namespace

GuideUpdater::GuideUpdater() { map_.prepare(kNodes, kNodes); }

MapWorker::Portion GuideUpdater::portion() {
  return [this](std::vector<double>& nodes, std::size_t first) {
    if (!map_.advance(kPortion))
      return std::min(first + kPortion, nodes.size() - 1);
    finished_guide_.take(map_);
    mailbox_.write(finished_guide_);
    return nodes.size();
  };
}

void GuideUpdater::begin(const PlaneSettings& wanted, bool in_background) {
  asked_ = wanted;
  has_request_ = true;
  told_ = false;
  nodes_due_ = 0;
  since_report_s_ = kNewsEvery_s;
  map_.begin(wanted.playing, wanted.range);
  if (in_background) {
    refusal_ = worker_.start(kNodes * kNodes, portion());
    without_thread_ = !refusal_.empty();
  } else {
    worker_.start_stepped(kNodes * kNodes, portion());
  }
}

void GuideUpdater::keep(const PlaneSettings& wanted, double elapsed_s, bool in_background) {
  in_background = in_background && !without_thread_;
  since_report_s_ += elapsed_s;
  const bool served = has_request_ && wanted.matches(asked_);
  const bool still = std::abs(wanted.playing.length - length_m_) <= 1e-5 * length_m_;
  length_m_ = wanted.playing.length;
  waiting_s_ = served ? 0 : waiting_s_ + elapsed_s;
  const bool obsolete = wanted.revision != asked_.revision || worker_.is_stepped() == in_background;
  if (!worker_.idle() && obsolete) {
    worker_.request_stop();
    has_request_ = false;
  }
  if (!(has_request_ && served) && worker_.idle() && (still || waiting_s_ > kPatience_s))
    begin(wanted, in_background);
  if (worker_.is_stepped() && !worker_.finished())
    for (nodes_due_ += kNodesPerSecond * elapsed_s; nodes_due_ >= kPortion && !worker_.finished();
         nodes_due_ -= kPortion)
      worker_.step();
}

bool GuideUpdater::progress_changed() noexcept {
  if (told_ || (progress() < 1 && since_report_s_ < kNewsEvery_s))
    return false;
  since_report_s_ = 0;
  told_ = progress() == 1;
  return true;
}

double GuideUpdater::progress() const noexcept {
  return has_request_ ? static_cast<double>(worker_.done()) / static_cast<double>(kNodes * kNodes)
                      : 0;
}

const PlaneGuide* GuideUpdater::newest() noexcept {
  has_guide_ |= mailbox_.read();
  return has_guide_ ? &mailbox_.latest() : nullptr;
}

} // namespace tactus::reed
