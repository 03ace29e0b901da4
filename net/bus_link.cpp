#include "net/bus_link.hpp"

#include "core/haptic/device/force_timeout.hpp"
#include "core/retired_threads.hpp"
#include "net/backoff.hpp"
#include "net/bus_topic.hpp"
#include "net/clock.hpp"
#include "net/osc.hpp"
#include "net/remote_wire.hpp"
#include "net/tcp_server.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <random>
#include <system_error>
#include <thread>

namespace tactus::net {
namespace {

using Notice = BusExchange::Notice;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr double kLinkConnect_s = 2, kCloseTimeout_s = 0.2;
constexpr int kSilentAttempts = 2;   ///< attempts to connect before a failure is reported
constexpr double kPortInUse_s = 0.5; ///< time for an ended link to release its port
constexpr auto kLinkPollInterval = std::chrono::milliseconds(5);

} // namespace

/// The sockets of a link, in a thread that may outlive the link by a moment.
class BusLink::Worker {
public:
  Worker(BusSession::Side side, BusSettings settings)
      : node_(side, std::move(settings), exchange) {}
  virtual ~Worker() = default;
  virtual void run() = 0;
  virtual void stop() noexcept { stop_ = true; }

  BusExchange exchange{};
  std::thread thread{};
  std::shared_ptr<std::atomic<bool>> ended = std::make_shared<std::atomic<bool>>(false);

protected:
  /// Returns false if the thread is to end.
  bool pause(double seconds) {
    const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(seconds));
    while (!stop_ && Clock::now() < until) {
      node_.advance(now_s()); // discards messages, as there is no receiver
      std::this_thread::sleep_for(kLinkPollInterval);
    }
    return !stop_;
  }
  BusNode node_;
  std::atomic<bool> stop_{false};
};

void BusLink::start(std::shared_ptr<Worker> worker) {
  worker->exchange.playout_s = playout_s_;
  worker_ = worker;
  try {
    worker_->thread = std::thread([worker = std::move(worker)] {
      try {
        worker->run();
      } catch (const std::exception& error) {
        worker->exchange.post(
            {Notice::What::kFailed, std::string("the connection failed: ") + error.what()});
      }
      *worker->ended = true;
    });
  } catch (const std::system_error&) {
    worker_->exchange.post({Notice::What::kFailed, "cannot start a thread: close other programs"});
  }
}

void BusLink::disconnect() noexcept {
  if (!worker_)
    return;
  worker_->stop();
  if (worker_->thread.joinable())
    RetiredThreads::add(std::move(worker_->thread), worker_->ended);
  worker_.reset();
}

void BusLink::listen(int port, const std::string& address) {
  class Listener final : public Worker {
  public:
    Listener(BusSettings settings, int port, const std::string& address)
        : Worker(BusSession::Side::kListener, std::move(settings)), requested_{port, address},
          refusal_(server_.open(requested_)) {}
    void run() override {
      for (double waited_s = 0; !refusal_.empty() && waited_s < kPortInUse_s; waited_s += 0.05) {
        if (!pause(0.05))
          return;
        refusal_ = server_.open(requested_);
      }
      if (!refusal_.empty())
        return exchange.post({Notice::What::kFailed, refusal_});
      exchange.post({Notice::What::kListening, server_.addresses(), server_.port()});
      server_.run();
    }
    void stop() noexcept override {
      Worker::stop();
      server_.stop();
    }

  private:
    TcpServer::Settings requested_;
    TcpServer server_{node_, {[this](double time_s) { node_.advance(time_s); }, {}}};
    std::string refusal_;
  };
  disconnect();
  start(std::make_shared<Listener>(settings(), port, address));
}

// Long, because it contains the worker's class, which nothing else uses.
void BusLink::connect(const std::string& host, int port) {
  class Caller final : public Worker {
  public:
    Caller(BusSettings settings, std::string host, int port)
        : Worker(BusSession::Side::kCaller, std::move(settings)), host_(std::move(host)),
          port_(port) {}
    void run() override {
      Backoff backoff{std::random_device{}()};
      int failures = 0;
      do {
        const std::string failure = run_session();
        if (stop_)
          return;
        if (ready_once_) {
          backoff.reset();
          failures = 0;
        } else if (++failures == kSilentAttempts + 1) {
          exchange.post({Notice::What::kFailed, "cannot connect to " + host_ + " port " +
                                                    std::to_string(port_) + " (" + failure +
                                                    "): trying again until disconnect"});
        }
      } while (pause(backoff.next()));
    }

  private:
    /// Runs one connection until it ends. Returns the reason of the end.
    std::string run_session() {
      ready_once_ = false;
      Wire wire(stop_);
      if (std::string failure = wire.connect(host_, port_, kLinkConnect_s); !failure.empty())
        return failure;
      const auto id = node_.connect(host_, now_s());
      wire.receive([this, id](std::span<const std::uint8_t> bytes) {
        node_.receive(id, bytes, now_s());
        return !node_.closing(id);
      });
      while (wire.open && !wire.refused && !stop_ && !node_.closing(id)) {
        node_.advance(now_s());
        ready_once_ = ready_once_ || node_.session(id).ready();
        wire.send(node_.out(id));
        wire.run();
      }
      if (stop_)
        node_.close("closing");
      for (const double until_s = now_s() + kCloseTimeout_s;
           wire.open && node_.out(id).size() > 0 && now_s() < until_s;) {
        wire.send(node_.out(id));
        if (node_.out(id).size() > 0)
          wire.run();
      }
      node_.disconnect(id);
      return node_.last_reason();
    }

    std::string host_;
    int port_;
    bool ready_once_ = false;
  };
  disconnect();
  start(std::make_shared<Caller>(settings(), host, port));
}

BusSettings BusLink::settings() const { return {"tactus", token_}; }

void BusLink::set_playout(std::optional<double> delay_s) noexcept {
  playout_s_ = delay_s.value_or(-1);
  if (worker_)
    worker_->exchange.playout_s = playout_s_;
}

void BusLink::observe(double logical_s) noexcept {
  const double time_s = now_s();
  ahead_.add(time_s - logical_s, time_s);
  clock_.update(*ahead_.value(time_s), time_s);
}

bool BusLink::send(const Message& topic, double logical_s) noexcept {
  if (!worker_ || worker_->exchange.ready == 0)
    return true;
  observe(logical_s);
  std::array<std::uint8_t, kMaxSent> packet;
  const std::size_t size = encode_osc(topic, packet);
  if (size == 0)
    return false;
  BusExchange& exchange = worker_->exchange;
  const bool event = bus_topic(topic.name()).is_event;
  const bool taken = exchange.outgoing.push(logical_s + clock_.value(), {packet.data(), size},
                                            false, event ? 0 : BusExchange::kReserve);
  if (!taken && event)
    exchange.overflowed = true;
  return true;
}

double BusLink::poll(double logical_s, const Receiver& receiver) {
  observe(logical_s);
  double next_s = logical_s + kPoll_s;
  const std::shared_ptr<Worker> worker = worker_; // the receiver may close or replace the link
  if (!worker)
    return next_s;
  const bool at_once = worker->exchange.playout_s == 0;
  for (BusExchange::Incoming& incoming : worker->exchange.incoming)
    while (const auto packet = incoming.ring.front()) {
      const bool late = packet->late;
      const double sent_s = packet->time_s - clock_.value();
      const double due_s = sent_s + incoming.delay_s;
      constexpr double kRounding_s = 1e-7;
      if (!at_once && !late && due_s > logical_s + kRounding_s) {
        next_s = std::min(next_s, due_s);
        break;
      }
      std::array<std::uint8_t, kMaxSent> bytes;
      const std::size_t size = packet->bytes.size();
      std::copy(packet->bytes.begin(), packet->bytes.end(), bytes.begin());
      incoming.ring.pop();
      Message topic;
      if (!decode_osc(std::span(bytes).first(size), topic).empty())
        continue;
      receiver({topic, sent_s, !at_once && (late || logical_s - due_s > kTolerance_s)});
      if (worker_ != worker)
        return next_s;
    }
  return next_s;
}

std::vector<Notice> BusLink::take_notices() {
  std::vector<Notice> notices;
  if (worker_ && !worker_->exchange.try_take(notices))
    return {};
  return notices;
}

int BusLink::peers() const noexcept { return worker_ ? worker_->exchange.ready.load() : 0; }

double BusLink::max_s(std::atomic<double> BusExchange::Incoming::*time) const noexcept {
  double max_s = 0;
  if (worker_)
    for (const auto& incoming : worker_->exchange.incoming)
      max_s = std::max(max_s, (incoming.*time).load());
  return max_s;
}

double BusLink::delay_s() const noexcept { return max_s(&BusExchange::Incoming::delay_s); }
double BusLink::transit_s() const noexcept { return max_s(&BusExchange::Incoming::transit_s); }

} // namespace tactus::net
