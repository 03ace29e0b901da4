#pragma once

#include "net/bus_session.hpp"
#include "net/packet_ring.hpp"
#include "net/service.hpp"

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

namespace tactus::net {

/// Data exchanged between the socket thread of a bus link and the patch's thread. Messages pass
/// through wait-free rings; notices are guarded by a lock, which the patch's thread only tries to
/// take.
class BusExchange {
public:
  static constexpr std::size_t kOutgoing = 1u << 20, kIncoming = 1u << 20;
  /// Free bytes that streams leave to events.
  static constexpr std::size_t kReserve = 1u << 19;

  /// Messages from one peer.
  struct Incoming {
    PacketRing ring{kIncoming};     ///< topics as OSC packets; their times by this side's clock, s
    std::atomic<double> delay_s{0}; ///< playout delay after a packet's time
    std::atomic<double> transit_s{0}; ///< half the shortest round trip
  };
  /// An event for the info outlet: a word, then its data.
  struct Notice {
    enum class What { kListening, kConnected, kLate, kBack, kEnded, kWarning, kFailed };
    What what;
    std::string text{};
    int number = 0; ///< port (kListening) or number of peers (kConnected, kEnded)
  };

  PacketRing outgoing{kOutgoing};
  std::array<Incoming, kMaxConnections> incoming{};
  std::atomic<int> ready{0};           ///< peers that receive messages
  std::atomic<double> playout_s{-1};   ///< fixed delay; automatic if below 0
  std::atomic<bool> overflowed{false}; ///< an event did not fit, so the connections end

  void post(Notice notices);
  /// False if the lock is taken: call again later.
  [[nodiscard]] bool try_take(std::vector<Notice>& notices);

private:
  std::mutex mutex_{};
  std::vector<Notice> notices_{};
};

/// All connections of a bus link, without sockets, threads and clocks.
class BusNode final : public Service {
public:
  BusNode(BusSession::Side side, BusSettings settings, BusExchange& exchange)
      : side_(side), settings_(std::move(settings)), exchange_(exchange),
        admission_(settings_.token) {}

  [[nodiscard]] ClientId connect(std::string_view peer, double now_s, int udp_port = 0) override;
  void receive(ClientId client, std::span<const std::uint8_t> bytes, double now_s) override;
  void disconnect(ClientId client) override;
  void close(std::string_view reason) override;
  [[nodiscard]] OutQueue& out(ClientId client) noexcept override { return sessions_[client]->out; }
  [[nodiscard]] bool closing(ClientId client) const noexcept override {
    return sessions_[client]->closing;
  }
  [[nodiscard]] bool guarded() const noexcept override { return admission_.guarded(); }

  /// Call it once a millisecond. Sends the patch's messages and those that are due by time.
  void advance(double now_s);

  [[nodiscard]] bool connected(ClientId client) const noexcept {
    return sessions_[client] != nullptr;
  }
  [[nodiscard]] const BusSession& session(ClientId client) const { return *sessions_[client]; }
  /// The reason for which the last connection ended.
  [[nodiscard]] const std::string& last_reason() const noexcept { return last_reason_; }

private:
  void send_all(double now_s);
  void watch(ClientId client, double now_s);

  BusSession::Side side_;
  BusSettings settings_;
  BusExchange& exchange_;
  Admission admission_;
  std::array<std::unique_ptr<BusSession>, kMaxConnections> sessions_{};
  std::array<bool, kMaxConnections> reported_ready_{}, reported_late_{};
  std::string last_reason_{};
};

} // namespace tactus::net
