#include "programs/body/progress.hpp"

#include "fem/io/text.hpp"
#include "programs/body/budget.hpp"

#include <algorithm>
#include <cstdio>
#include <unistd.h>

namespace tactus::fem {
namespace {

constexpr std::chrono::milliseconds kRewrite{500}, kLog{4500};

} // namespace

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {
  if (!quiet_)
    watcher_ = std::thread([this] { watch(); });
}

ProgressLine::~ProgressLine() {
  if (!watcher_.joinable())
    return;
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    if (rewriting_)
      std::fputc('\n', stderr);
  }
  change_.notify_one();
  watcher_.join();
}

double ProgressLine::seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

void ProgressLine::watch() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    change_.wait_for(lock, kRewrite);
    if (!stop_ && !name_.empty() && Clock::now() - last_print_ >= (terminal_ ? kRewrite : kLog))
      print(false);
  }
}

std::string ProgressLine::line() const {
  const double spent = seconds_since(stage_start_);
  std::string text = format("%7.1f s  ", seconds_since(start_)) + name_;
  if (share_ > 0)
    text += format(" %.0f %%", 100 * share_);
  if (share_ >= 1 || spent < 1)
    return text;
  // Uses the rate so far once a fiftieth is done, and the predicted time before that.
  const bool measured = share_ > .02;
  const double left = measured ? spent * (1 - share_) / share_ : predicted_s_ - spent;
  if (left > 0)
    text += ", about " + format_seconds(left) + " left";
  else if (predicted_s_ > 0)
    text += ", for " + format_seconds(spent) + " so far, expected " + format_seconds(predicted_s_);
  else
    text += ", for " + format_seconds(spent) + " so far";
  return text;
}

void ProgressLine::print(bool ended) {
  last_print_ = Clock::now();
  std::fprintf(stderr, "%s%s%s", terminal_ ? "\r" : "", line().c_str(), terminal_ ? "\033[K" : "");
  rewriting_ = terminal_ && !ended;
  if (!rewriting_)
    std::fputc('\n', stderr);
  std::fflush(stderr);
}

void ProgressLine::stage(const std::string& name, double share, double predicted_s) {
  if (quiet_)
    return;
  const std::lock_guard lock(mutex_);
  const bool new_stage = name != name_;
  const bool ended = share >= 1 && (share_ < 1 || new_stage);
  if (new_stage) {
    if (rewriting_)
      std::fputc('\n', stderr);
    rewriting_ = false;
    name_ = name;
    stage_start_ = Clock::now();
    share_ = predicted_s_ = 0;
  }
  share_ = std::clamp(std::max(share, share_), 0.0, 1.0);
  predicted_s_ = std::max(predicted_s, predicted_s_);
  if (new_stage || ended)
    print(ended);
}

void ProgressLine::notify(const std::string& sentence) {
  if (quiet_ && !sentence.starts_with("warning: "))
    return;
  const std::lock_guard lock(mutex_);
  std::fprintf(stderr, "%s           %s\n", rewriting_ ? "\r\033[K" : "", sentence.c_str());
  rewriting_ = false;
}

} // namespace tactus::fem
