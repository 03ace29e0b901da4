#include "externals/phantom/trouble.hpp"

#include <utility>

namespace tactus::phantom {
namespace {

constexpr double kPollInterval_ms = 50;
constexpr double kDebounce_ms = 100; // a trouble is reported after this time
constexpr double kClear_ms = 500;    // its end is reported after this time without trouble

} // namespace

/// An empty sentence reports the end of a trouble.
void send_trouble(std::string_view sentence, std::string_view driver, const Reports& reports,
                  Host& host) {
  reports.send(kError, {"trouble", driver, sentence.empty() ? "-" : sentence}, host);
}

void Trouble::begin(std::string_view driver, const Reports& reports, Host& host) {
  flags_.reset();
  if (!sent_.empty())
    report({}, driver, reports, host);
  latest_.clear();
}

void Trouble::report(std::string_view sentence, std::string_view driver, const Reports& reports,
                     Host& host) {
  sent_ = sentence;
  send_trouble(sent_, driver, reports, host);
}

void Trouble::watch_flags(std::uint32_t flags, const Reports& reports, Host& host) {
  using haptic::State;
  const std::uint32_t changed = flags_ ? flags ^ *flags_ : flags | State::kHomed;
  flags_ = flags;
  constexpr std::pair<std::uint32_t, std::string_view> kWatched[] = {
      {State::kHomed, "homed"}, {State::kMotorsHot, "hot"}, {State::kForceLimited, "limited"}};
  for (const auto& [flag, word] : kWatched)
    if (changed & flag)
      reports.send(kStatus, {"status", word, (flags & flag) ? 1.0 : 0.0}, host);
}

bool Trouble::due(double now_ms) noexcept {
  if (now_ms - polled_ms_ < kPollInterval_ms)
    return false;
  polled_ms_ = now_ms;
  return true;
}

void Trouble::watch(std::string problem, std::string_view driver, const Reports& reports,
                    Host& host) {
  const double now_ms = host.now_ms();
  if (problem != latest_) {
    latest_ = std::move(problem);
    since_ms_ = now_ms;
  }
  if (latest_ == sent_ || now_ms - since_ms_ < (latest_.empty() ? kClear_ms : kDebounce_ms))
    return;
  report(latest_, driver, reports, host);
  if (!sent_.empty())
    host.log(sent_);
}

} // namespace tactus::phantom
