#include "devices/falcon/boot.hpp"

#include "devices/falcon/packet.hpp"

#include <algorithm>
#include <array>
#include <chrono>

namespace tactus::devices::falcon {
namespace {

constexpr std::array<std::uint8_t, 3> kGreeting{0x0a, 0x43, 0x0d};
constexpr std::array<std::uint8_t, 4> kWelcome{0x0a, 0x44, 0x2c, 0x0d};
constexpr std::array<std::uint8_t, 1> kBeginDownload{0x41};
constexpr int kRestarts = 4, kGreetings = 25, kMaxUploads = 10, kMaxProbes = 10;
constexpr double kWelcome_s = 0.05, kDrain_s = 0.005;
constexpr double kEcho_s = 0.5, kProbe_s = 0.05, kClearToSend_s = 0.1;
constexpr std::size_t kChunkBytes = kTransferBytes - kStatusBytes; // its echo fits one IN transfer
constexpr double kMinPause_s = 0.02, kMaxPause_s = 0.5;
constexpr double kMaxBoot_s = 20; // time of all tries together

enum class Step { kDone, kFailed, kGone };

Step gone(const Link& link, std::string& problem) {
  problem = link.cancelled() ? "opening the Falcon was cancelled: open it again"
                             : "the Falcon was disconnected during set-up: plug it in again";
  return Step::kGone;
}

// A search, not a comparison: on some hosts a zero byte precedes the welcome, and a slow loader may
// answer an earlier greeting.
bool welcomes(const std::vector<std::uint8_t>& bytes) {
  return std::search(bytes.begin(), bytes.end(), kWelcome.begin(), kWelcome.end()) != bytes.end();
}

// Sends many greetings after each restart, because the boot loader may need time.
Step greet(Link& link, std::string& problem) {
  for (int restart = 0; restart < kRestarts; ++restart) {
    if (!link.enter_boot_loader())
      return gone(link, problem);
    std::vector<std::uint8_t> bytes;
    for (int greeting = 0; greeting < kGreetings; ++greeting) {
      if (!link.send(kGreeting) ||
          !link.receive(bytes, bytes.size() + kWelcome.size(), kWelcome_s) ||
          (!welcomes(bytes) && !link.receive(bytes, bytes.size() + 1, kDrain_s)))
        return gone(link, problem);
      if (welcomes(bytes))
        return Step::kDone;
    }
  }
  problem = "the Falcon's boot loader did not answer " + std::to_string(kRestarts * kGreetings) +
            " requests: unplug its power and USB for ten seconds, then try another port or a hub "
            "with its own power";
  return Step::kFailed;
}

Step begin_upload(Link& link, std::string& problem) {
  std::vector<std::uint8_t> answer;
  if (!link.enter_upload())
    return gone(link, problem);
  // The device raises "clear to send" when it is ready at the new speed, but the host does not
  // always see the signal.
  const auto begin = std::chrono::steady_clock::now();
  const auto longest = std::chrono::duration<double>(kClearToSend_s);
  while (std::chrono::steady_clock::now() - begin < longest) {
    std::vector<std::uint8_t> nothing;
    if (!link.receive(nothing, 1, 0.02))
      return gone(link, problem);
    if (link.clear_to_send())
      break;
  }
  if (!link.send(kBeginDownload) || !link.receive(answer, kBeginDownload.size(), kEcho_s))
    return gone(link, problem);
  if (answer.size() == 1 && answer[0] == kBeginDownload[0])
    return Step::kDone;
  problem = "the Falcon's boot loader did not accept the upload speed";
  return Step::kFailed;
}

Step send_firmware(Link& link, std::span<const std::uint8_t> firmware, std::string& problem) {
  for (std::size_t at = 0; at < firmware.size(); at += kChunkBytes) {
    const auto piece = firmware.subspan(at, std::min(kChunkBytes, firmware.size() - at));
    std::vector<std::uint8_t> echo;
    if (!link.send(piece) || !link.receive(echo, piece.size(), kEcho_s))
      return gone(link, problem);
    if (!std::equal(echo.begin(), echo.end(), piece.begin(), piece.end())) {
      problem = "the Falcon returned wrong firmware data near byte " + std::to_string(at);
      return Step::kFailed;
    }
  }
  return Step::kDone;
}

} // namespace

bool firmware_runs(Link& link) {
  if (!link.enter_run())
    return false;
  ResponseParser stream;
  for (int attempt = 0; attempt < kMaxProbes; ++attempt) {
    std::vector<std::uint8_t> bytes;
    if (!link.send(encode(kNoForce)) || !link.receive(bytes, kPacketBytes, kProbe_s))
      return false;
    for (const std::uint8_t byte : bytes)
      if (stream.process(byte))
        return true;
  }
  return false;
}

std::string upload(Link& link, std::span<const std::uint8_t> firmware) {
  std::string problem;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kMaxBoot_s);
  double pause_s = kMinPause_s;
  int attempt = 0;
  for (; attempt < kMaxUploads && std::chrono::steady_clock::now() < end; ++attempt) {
    if (attempt > 0) {
      if (!link.pause(pause_s)) {
        gone(link, problem);
        return problem;
      }
      pause_s = std::min(2 * pause_s, kMaxPause_s);
    }
    if (greet(link, problem) != Step::kDone)
      return problem; // greet() has already retried
    Step step = begin_upload(link, problem);
    if (step == Step::kDone)
      step = send_firmware(link, firmware, problem);
    if (step == Step::kGone)
      return problem;
    if (step == Step::kFailed)
      continue;
    if (firmware_runs(link))
      return {};
    if (link.cancelled()) {
      gone(link, problem);
      return problem;
    }
    problem = "the Falcon loaded the firmware but does not run it: check that it is the right file";
  }
  return problem + " (" + std::to_string(attempt) +
         " attempts): unplug its power and USB for ten seconds, then try another port or a hub "
         "with its own power";
}

} // namespace tactus::devices::falcon
