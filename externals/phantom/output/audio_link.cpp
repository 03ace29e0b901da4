#include "externals/phantom/output/audio_link.hpp"

#include "externals/phantom/output/signal_link_name.hpp"

namespace tactus::phantom {
namespace {

// If audio has not run for this long plus two blocks, it no longer steps the servo.
constexpr double kAudioTimeout_ms = 20;
constexpr std::uint64_t kPublishInterval_ticks = 64;

} // namespace

bool AudioLink::publish(Host& host) {
  published_ = host.publish(signal_link_name(name_), session_.rig().signals);
  return published_;
}

void AudioLink::withdraw(Host& host) {
  if (published_)
    host.publish(signal_link_name(name_), nullptr);
  published_ = false;
}

void AudioLink::publish_again(Host& host) {
  if (!published_ && ++ticks_ % kPublishInterval_ticks == 0)
    publish(host);
}

void AudioLink::replace(Host& host) {
  blocks_ = 0;
  if (!published_)
    return;
  withdraw(host);
  publish(host);
}

bool AudioLink::steps(const Host& host) noexcept {
  const std::uint64_t blocks = session_.rig().signals->blocks();
  if (blocks != blocks_) {
    blocks_ = blocks;
    seen_ms_ = host.now_ms();
  }
  return host.now_ms() - seen_ms_ <= kAudioTimeout_ms + 2e3 * session_.rig().signals->max_block_s();
}

} // namespace tactus::phantom
