#include "externals/greed_gradient~/guide_keeper.hpp"

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

GuideKeeper::GuideKeeper() { map_.prepare(kNodes, kNodes); }

MapWorker::Portion GuideKeeper::portion() {
  return [this](std::vector<double>& nodes, std::size_t first) {
    if (!map_.advance(kPortion))
      return std::min(first + kPortion, nodes.size() - 1);
    made_.take(map_);
    mailbox_.write(made_);
    return nodes.size();
  };
}

void GuideKeeper::begin(const PlaneSettings& wanted, bool in_background) {
  asked_ = wanted;
  has_asked_ = true;
  told_ = false;
  owed_ = 0;
  silent_s_ = kNewsEvery_s;
  map_.begin(wanted.playing, wanted.range);
  if (in_background) {
    refusal_ = worker_.start(kNodes * kNodes, portion());
    without_thread_ = !refusal_.empty();
  } else {
    worker_.start_by_steps(kNodes * kNodes, portion());
  }
}

void GuideKeeper::keep(const PlaneSettings& wanted, double elapsed_s, bool in_background) {
  in_background = in_background && !without_thread_;
  silent_s_ += elapsed_s;
  const bool served = has_asked_ && wanted.served_by(asked_);
  const bool still = std::abs(wanted.playing.length - length_m_) <= 1e-5 * length_m_;
  length_m_ = wanted.playing.length;
  waited_s_ = served ? 0 : waited_s_ + elapsed_s;
  const bool obsolete = wanted.revision != asked_.revision || worker_.by_steps() == in_background;
  if (!worker_.idle() && obsolete) {
    worker_.ask_to_stop();
    has_asked_ = false;
  }
  if (!(has_asked_ && served) && worker_.idle() && (still || waited_s_ > kPatience_s))
    begin(wanted, in_background);
  if (worker_.by_steps() && !worker_.finished())
    for (owed_ += kNodesPerSecond * elapsed_s; owed_ >= kPortion && !worker_.finished();
         owed_ -= kPortion)
      worker_.step();
}

bool GuideKeeper::has_news() noexcept {
  if (told_ || (progress() < 1 && silent_s_ < kNewsEvery_s))
    return false;
  silent_s_ = 0;
  told_ = progress() == 1;
  return true;
}

double GuideKeeper::progress() const noexcept {
  return has_asked_ ? static_cast<double>(worker_.done()) / static_cast<double>(kNodes * kNodes)
                    : 0;
}

const PlaneGuide* GuideKeeper::newest() noexcept {
  has_guide_ |= mailbox_.read();
  return has_guide_ ? &mailbox_.latest() : nullptr;
}

} // namespace tactus::reed
