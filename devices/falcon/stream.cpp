#include "devices/falcon/stream.hpp"

#include "devices/real_time.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <system_error>

namespace tactus::devices::falcon {
namespace {

using Clock = std::chrono::steady_clock;
const char* const kNoMemory = "not enough memory for the Falcon's transfers: close other programs";
constexpr unsigned kOut_ms = 200;
constexpr int kMaxFailures = 50; // consecutive failures after which the connection counts as lost
constexpr int kMaxUnanswered = 2;
constexpr double kResponseTimeout_s = 0.010;
constexpr double kRepeat_s = 0.020; // interval of zero-force commands while the servo stalls
constexpr auto kStopTimeout = std::chrono::milliseconds(200);
constexpr auto kCancel = std::chrono::milliseconds(250);

double now_s() noexcept { return haptic::ForceTimeout::now_s(); }

Command scaled(Command command, double gain) noexcept {
  for (std::int16_t& motor : command.motors)
    motor = static_cast<std::int16_t>(std::lround(gain * motor));
  return command;
}

} // namespace

std::string Stream::start() {
  UsbLibrary& usb = link_.usb();
  for (Transfer& transfer : in_) {
    transfer.stream = this;
    transfer.usb = usb.alloc_transfer(0);
    if (!transfer.usb)
      return kNoMemory;
    libusb_fill_bulk_transfer(transfer.usb, link_.handle(), kInEndpoint, transfer.bytes.data(),
                              static_cast<int>(transfer.bytes.size()), on_in, &transfer, 0);
  }
  for (Transfer& transfer : out_) {
    transfer.stream = this;
    transfer.usb = usb.alloc_transfer(0);
    if (!transfer.usb)
      return kNoMemory;
    libusb_fill_bulk_transfer(transfer.usb, link_.handle(), kOutEndpoint, transfer.bytes.data(),
                              static_cast<int>(kPacketBytes), on_out, &transfer, kOut_ms);
  }
  for (Transfer& transfer : in_)
    if (!submit(transfer))
      break; // lost() is then true
  try {
    handler_ = std::thread([this] { handle_events(); });
    sender_ = std::thread([this] { send_commands(); });
  } catch (const std::system_error&) {
    return "cannot start a thread for the Falcon: close other programs";
  }
  return {};
}

void Stream::stop() noexcept {
  if (sender_.joinable()) {
    send(kNoForce);
    const auto end = Clock::now() + kStopTimeout;
    while (!lost() && delivered_.load() < commands_written_ && Clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      wake(); // the sender checks its timeouts when it is woken
    }
    stopping_ = true;
    wake();
    sender_.join();
  }
  if (handler_.joinable()) {
    stopping_ = ended_ = true;
    handler_.join();
  }
  for (auto* transfers : {&in_, &out_})
    for (Transfer& transfer : *transfers) {
      if (transfer.usb && !transfer.under_way)
        link_.usb().free_transfer(transfer.usb);
      transfer.usb = nullptr;
    }
}

void Stream::send(const Command& command) noexcept {
  const double written_s = now_s();
  written_s_.store(written_s, std::memory_order_relaxed);
  commands_.write({command, ++commands_written_, written_s});
  wake();
}

Stream::Counts Stream::counts() const noexcept {
  return {sent_.load(), answered_.load(), broken_.load(), skipped_.load(), failed_.load()};
}

void Stream::wake() noexcept { wakes_.wake(); }

bool Stream::idle() const noexcept {
  return std::none_of(in_.begin(), in_.end(),
                      [](const Transfer& t) { return t.under_way.load(); }) &&
         std::none_of(out_.begin(), out_.end(),
                      [](const Transfer& t) { return t.under_way.load(); });
}

bool Stream::submit(Transfer& transfer) noexcept {
  transfer.under_way = true;
  if (link_.usb().submit_transfer(transfer.usb) == 0)
    return true;
  transfer.under_way = false;
  lost_ = true;
  return false;
}

void Stream::failed() noexcept {
  failed_.fetch_add(1, std::memory_order_relaxed);
  if (++failures_ >= kMaxFailures)
    lost_ = true;
}

// All callbacks run in the handler's thread.
void LIBUSB_CALL Stream::on_in(libusb_transfer* transfer) {
  auto& self = *static_cast<Transfer*>(transfer->user_data);
  Stream& stream = *self.stream;
  if (transfer->status == LIBUSB_TRANSFER_COMPLETED)
    stream.process(self);
  else if (transfer->status == LIBUSB_TRANSFER_NO_DEVICE)
    stream.lost_ = true;
  else if (transfer->status != LIBUSB_TRANSFER_CANCELLED)
    stream.failed();
  self.under_way = false;
  if (!stream.stopping_ && !stream.lost_)
    stream.submit(self);
}

void LIBUSB_CALL Stream::on_out(libusb_transfer* transfer) {
  auto& self = *static_cast<Transfer*>(transfer->user_data);
  Stream& stream = *self.stream;
  if (transfer->status == LIBUSB_TRANSFER_COMPLETED) {
    stream.failures_ = 0;
    stream.delivered_ = std::max(stream.delivered_.load(), self.number);
  } else if (transfer->status == LIBUSB_TRANSFER_NO_DEVICE) {
    stream.lost_ = true;
  } else if (transfer->status != LIBUSB_TRANSFER_CANCELLED) {
    stream.failed();
  }
  self.under_way = false;
  if (stream.waiting_.exchange(false))
    stream.wake();
}

void Stream::process(const Transfer& transfer) noexcept {
  failures_ = 0;
  const auto length = static_cast<std::size_t>(std::max(transfer.usb->actual_length, 0));
  for (std::size_t i = kStatusBytes; i < std::min(length, transfer.bytes.size()); ++i)
    if (parser_.process(transfer.bytes[i])) {
      frames_.write({parser_.response(), ++frame_, now_s()});
      answered_.store(frame_, std::memory_order_relaxed);
      int unanswered = unanswered_.load();
      while (unanswered > 0 && !unanswered_.compare_exchange_weak(unanswered, unanswered - 1)) {
      }
      if (waiting_.exchange(false))
        wake();
    }
  broken_.store(parser_.errors(), std::memory_order_relaxed);
}

// Null while two commands are in transfer or unanswered.
Stream::Transfer* Stream::free_out(double since_s) noexcept {
  if (unanswered_ >= kMaxUnanswered) {
    if (now_s() - since_s < kResponseTimeout_s)
      return nullptr;
    unanswered_ = 0;
  }
  for (Transfer& transfer : out_)
    if (!transfer.under_way)
      return &transfer;
  return nullptr;
}

void Stream::send_commands() noexcept {
  raise_thread_priority(kDeviceThreadPriority);
  haptic::ForceTimeout timeout;
  Numbered newest;
  bool unsent = false;
  double sent_s = 0;
  int seen = 0;
  while (!stopping_ && !lost()) {
    seen = wakes_.wait(seen);
    if (commands_.read()) {
      if (unsent)
        skipped_.fetch_add(1, std::memory_order_relaxed);
      newest = commands_.latest();
      unsent = true;
    }
    const double gain = timeout.gain(newest.written_s, now_s());
    if (timeout.expired() && newest.number > 0 && now_s() - sent_s >= kRepeat_s)
      unsent = true;
    if (!unsent)
      continue;
    Transfer* free = free_out(sent_s);
    if (!free) {
      waiting_ = true; // set before the second check, so that no wake-up is missed
      free = free_out(sent_s);
    }
    if (!free)
      continue;
    const Packet packet = encode(scaled(newest.command, gain));
    std::copy(packet.begin(), packet.end(), free->bytes.begin());
    free->number = newest.number;
    unsent = false;
    sent_s = now_s();
    ++unanswered_;
    if (submit(*free))
      sent_.fetch_add(1, std::memory_order_relaxed);
  }
}

void Stream::handle_events() noexcept {
  raise_thread_priority(kDeviceThreadPriority);
  Clock::time_point end{};
  for (;;) {
    if (ended_) {
      if (end == Clock::time_point{}) {
        end = Clock::now() + kCancel;
        for (auto* transfers : {&in_, &out_}) // cancelled in this thread, so no callback can submit
                                              // meanwhile
          for (Transfer& transfer : *transfers)
            if (transfer.under_way)
              link_.usb().cancel_transfer(transfer.usb);
      }
      if (idle() || Clock::now() > end)
        return;
    }
    if (now_s() - written_s_.load(std::memory_order_relaxed) >= haptic::ForceTimeout::kTimeout_s)
      wake(); // the sender ends the force of a servo that stalls
    timeval most{0, 20000};
    link_.usb().handle_events_timeout_completed(link_.context(), &most, nullptr);
  }
}

} // namespace tactus::devices::falcon
