#include "externals/phantom/device/trouble.hpp"

#include <utility>

namespace tactus::phantom {
namespace {

constexpr double kPollInterval_ms = 50;
constexpr double kDebounce_ms = 100; // a trouble is reported once it has lasted this long
constexpr double kClear_ms = 500;    // its end is reported after this time without trouble
constexpr double kStall_s = 1;       // a servo without a tick for this long is reported

} // namespace

void Trouble::begin(Host& host) {
  flags_.reset();
  faults_ = 0;
  if (!sent_.empty())
    report({}, host);
  latest_.clear();
}

void Trouble::report(std::string_view sentence, Host& host) {
  sent_ = sentence;
  send(sent_, host);
}

void Trouble::send(std::string_view sentence, Host& host) const {
  reports_.send(kError, {"trouble", link_.driver_name(), sentence.empty() ? "-" : sentence}, host);
}

std::optional<haptic::Fault> Trouble::watch(double silence_s, Host& host) {
  if (const haptic::Report* report = session_.report()) {
    watch_flags(report->state.flags, host);
    if (std::exchange(faults_, report->faults) != report->faults)
      return report->fault;
  }
  if (host.now_ms() - polled_ms_ < kPollInterval_ms)
    return {};
  polled_ms_ = host.now_ms();
  watch_sentence(link_.runs() && silence_s > kStall_s
                     ? std::string(link_.driver_name()) +
                           ": the servo has stopped: a call of the driver does not return, or "
                           "the driver no longer calls back; close the device, switch it off and "
                           "on, and open it again"
                     : link_.device().trouble(),
                 host);
  return {};
}

/// Reports changes of the device's state flags. The first report after opening always includes
/// whether the device is homed, since it may have been homed before this thread first read the
/// flags.
void Trouble::watch_flags(std::uint32_t flags, Host& host) {
  using haptic::State;
  const std::uint32_t changed = flags_ ? flags ^ *flags_ : flags | State::kHomed;
  flags_ = flags;
  constexpr std::pair<std::uint32_t, std::string_view> kWatched[] = {
      {State::kHomed, "homed"}, {State::kMotorsHot, "hot"}, {State::kForceLimited, "limited"}};
  for (const auto& [flag, word] : kWatched)
    if (changed & flag)
      reports_.send(kStatus, {"status", word, (flags & flag) ? 1.0 : 0.0}, host);
}

/// Handles the driver's trouble. It is reported once it has lasted, and so is its end.
void Trouble::watch_sentence(std::string sentence, Host& host) {
  const double now_ms = host.now_ms();
  if (sentence != latest_) {
    latest_ = std::move(sentence);
    since_ms_ = now_ms;
  }
  if (latest_ == sent_ || now_ms - since_ms_ < (latest_.empty() ? kClear_ms : kDebounce_ms))
    return;
  report(latest_, host);
  if (!sent_.empty())
    host.log(sent_);
}

} // namespace tactus::phantom
