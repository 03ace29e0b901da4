#include "net/datagrams.hpp"

#include "net/osc.hpp"

#include <random>

namespace tactus::net {
namespace {

/// Returns nullopt if the datagram is too long or is not a packet of the protocol.
std::optional<Message> decoded(std::span<const std::uint8_t> bytes) noexcept {
  Message message;
  if (bytes.size() > kMaxDatagram || !decode_osc(bytes, message).empty())
    return {};
  return message;
}

Datagram encoded(const Message& message) noexcept {
  Datagram datagram;
  datagram.size = encode_osc(message, datagram.bytes);
  return datagram;
}

} // namespace

std::int32_t make_datagram_key() {
  std::random_device random;
  std::int32_t key = 0;
  while (key == 0)
    key = static_cast<std::int32_t>(random() & 0x7fffffffu);
  return key;
}

void DatagramSender::open(std::int32_t key) noexcept {
  close();
  key_ = key;
}

void DatagramSender::take_probe(std::int32_t sequence, double now_s) noexcept {
  probed_s_ = now_s;
  if (sequence < 0 || newest_ < 0 || is_newer(sequence, newest_))
    return;
  if (confirmed_ >= 0 && !is_newer(sequence, confirmed_))
    return;
  confirmed_ = sequence;
  confirmed_s_ = now_s;
}

void DatagramSender::add(Message message) noexcept {
  newest_ = message.integer_at(0).value_or(newest_);
  const Datagram datagram = encoded(message.integer(key_));
  if (count_ == kMaxQueued) {
    begin_ = (begin_ + 1) % kMaxQueued;
    --count_;
  }
  waiting_[(begin_ + count_) % kMaxQueued] = datagram;
  ++count_;
}

std::optional<Datagram> DatagramSender::take() noexcept {
  if (count_ == 0)
    return {};
  const Datagram& datagram = waiting_[begin_];
  begin_ = (begin_ + 1) % kMaxQueued;
  --count_;
  return datagram;
}

void DatagramReceiver::open(std::int32_t key, int port) noexcept {
  close();
  key_ = key;
  port_ = port;
}

bool DatagramReceiver::take(std::span<const std::uint8_t> bytes, Message& message) noexcept {
  const auto found = port_ != 0 ? decoded(bytes) : std::nullopt;
  const bool sample =
      found && (found->address() == Address::kPosition || found->address() == Address::kVelocity) &&
      found->size() == 6 && found->integer_at(5) == key_;
  const auto sequence = sample ? found->integer_at(0) : std::nullopt;
  const auto time_ms = sample ? found->integer_at(1) : std::nullopt;
  if (!sequence || *sequence < 0 || !time_ms || !found->number_at(2) || !found->number_at(3) ||
      !found->number_at(4)) {
    ++ignored_;
    return false;
  }
  if (newest_ < 0 || is_newer(*sequence, newest_))
    newest_ = *sequence;
  ++received_;
  message = Message(found->address())
                .integer(*sequence)
                .integer(*time_ms)
                .real(*found->number_at(2))
                .real(*found->number_at(3))
                .real(*found->number_at(4));
  return true;
}

std::optional<Datagram> DatagramReceiver::probe(double now_s) noexcept {
  if (port_ == 0 || now_s - probed_s_ < kProbeInterval_s)
    return {};
  probed_s_ = now_s;
  return encoded(Message(Address::kUdp).integer(key_).integer(newest_));
}

std::optional<Probe> read_probe(std::span<const std::uint8_t> bytes) noexcept {
  const auto found = decoded(bytes);
  if (!found || found->address() != Address::kUdp || found->size() != 2)
    return {};
  const auto key = found->integer_at(0), sequence = found->integer_at(1);
  if (!key || *key <= 0 || !sequence || *sequence < -1)
    return {};
  return Probe{*key, *sequence};
}

} // namespace tactus::net
