#include "net/remote_device.hpp"

#include "core/text.hpp"
#include "net/backoff.hpp"
#include "net/client.hpp"
#include "net/clock.hpp"
#include "net/remote_wire.hpp"
#include "net/token_file.hpp"

#include <chrono>
#include <cmath>
#include <exception>
#include <random>
#include <system_error>
#include <utility>

namespace tactus::net {
namespace {

using haptic::State;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr double kConnect_s = 2, kWelcomeTimeout_s = 4;
constexpr double kStale_s = 0.1; ///< older positions get no force
/// Longer than the servo needs to detect a failure.
constexpr double kFailureHold_s = 0.1;
/// While positions are late by less than this, as after a lost packet of TCP, the last velocity is
/// kept, so that a hit keeps its speed when the delayed positions arrive together. Later the
/// velocity counts as zero, because dampers would act on an old velocity.
constexpr double kHeldVelocity_s = 0.05;
constexpr double kRepeat_s = 0.1;    ///< repeat interval of an unchanged force
constexpr double kMeasure_s = 0.6;   ///< time to measure the round trip when opening
constexpr double kRounding_m = 5e-9; ///< rounding error of 100 mm in 32 bits
constexpr auto kPollInterval = std::chrono::milliseconds(5);

/// A whole number from 1 to 65535; 0 for any other text.
int port_of(std::string_view text) noexcept { return to_number(text, 1, 65535).value_or(0); }

} // namespace

RemoteDevice::RemoteDevice() = default;
RemoteDevice::~RemoteDevice() { close(); }

std::string RemoteDevice::configure(std::span<const std::string> words) {
  const std::lock_guard lock(mutex_);
  if (words.size() >= 2 && words[words.size() - 2] == "udp") {
    const std::string& on = words.back();
    if (on != "0" && on != "1")
      return "net: udp " + on + ": expected 0 or 1";
    const bool before = std::exchange(settings_.udp, on == "1");
    if (words.size() == 2)
      return {};
    std::string refusal = configure_locked(words.first(words.size() - 2));
    if (!refusal.empty())
      settings_.udp = before;
    return refusal;
  }
  return configure_locked(words);
}

std::string RemoteDevice::configure_locked(std::span<const std::string> words) {
  const auto refused_port = [](const std::string& port) {
    return "net: port " + port + ": expected 1..65535";
  };
  if (words.size() == 2 && words[0] == "token") {
    TokenFile file = read_token_file(words[1]);
    if (file.error.empty())
      settings_.token = std::move(file.token);
    return file.error.empty() ? std::string() : "net: " + file.error;
  }
  if (words.size() == 2 && words[0] == "rate") {
    const auto rate_hz = to_number(words[1], 50., 4000.);
    if (!rate_hz)
      return "net: rate " + words[1] + ": expected 50..4000 Hz";
    settings_.rate_hz = *rate_hz;
    return {};
  }
  if (words.size() == 2 && words[0] == "device") {
    if (words[1] == "0") // index of the configured server in the list of `devices`
      return {};
    if (words[1].find_first_not_of("0123456789") == std::string::npos)
      return "net: device " + words[1] + ": expected 0, HOST or HOST:PORT";
    const auto colon = words[1].rfind(':');
    const bool has_port = colon != std::string::npos && words[1].find(':') == colon;
    const int port = has_port ? port_of(words[1].substr(colon + 1)) : kPort;
    if (port == 0)
      return refused_port(words[1].substr(colon + 1));
    settings_.host = has_port ? words[1].substr(0, colon) : words[1];
    settings_.port = port;
    return {};
  }
  if (words.size() == 3 && (words[0] == "host" || words[0] == "device")) {
    if (port_of(words[2]) == 0)
      return refused_port(words[2]);
    settings_.host = words[1];
    settings_.port = port_of(words[2]);
    return {};
  }
  return "net: setting " + (words.empty() ? "nothing" : words[0]) +
         ": expected host HOST PORT, token FILE, rate HZ (50..4000) or udp 0|1";
}

std::string RemoteDevice::open() {
  close();
  {
    const std::lock_guard lock(mutex_);
    active_settings_ = settings_;
    trouble_.clear();
    welcome_.reset();
  }
  sample_ = {};
  samples_.write({});
  forces_.reset();
  down_until_s_ = failed_until_s_ = 0;
  failures_ = 0;
  failures_seen_ = 0;
  stop_ = cancelled_ = false;
  try {
    thread_ = std::thread([this] { serve(); });
  } catch (const std::system_error&) {
    return "net: cannot start a thread for the connection: close other programs";
  }
  std::string sentence;
  {
    std::unique_lock lock(mutex_);
    const auto until =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(kWelcomeTimeout_s));
    while (!welcome_ && !cancelled_ && Clock::now() < until)
      changed_.wait_for(lock, kPollInterval);
    if (welcome_) {
      update_caps(*welcome_, round_trip_s_, active_settings_.rate_hz);
      return {};
    }
    sentence = cancelled_         ? "net: opening was cancelled: open the device again"
               : trouble_.empty() ? "net: the haptic server on " + active_settings_.host + ":" +
                                        std::to_string(active_settings_.port) + " does not answer"
                                  : "net: " + trouble_;
  }
  close();
  return sentence;
}

void RemoteDevice::update_caps(const Welcome& welcome, double round_trip_s,
                               double rate_hz) noexcept {
  const double period_s = 1 / rate_hz;
  caps_ = {};
  caps_.axes_in = caps_.axes_out = welcome.axes;
  caps_.peak_force_n = welcome.force_limit_n;
  // A sampled wall is stable up to 2 b / T (Colgate & Schenkel 1997), and the round trip adds to T.
  caps_.stiffness_limit_n_per_m =
      welcome.stiffness_limit_n_per_m * period_s / (period_s + round_trip_s);
  caps_.damping_limit_n_s_per_m =
      welcome.damping_limit_n_s_per_m * period_s / (period_s + round_trip_s);
  caps_.workspace_min = welcome.workspace.min;
  caps_.workspace_max = welcome.workspace.max;
  caps_.rate_hz = rate_hz;
  caps_.position_noise_m = kRounding_m;
  caps_.latency_ticks = 1 + static_cast<int>(std::ceil(round_trip_s / period_s));
  caps_.has_buttons = caps_.has_velocity = true;
  identity_ = {"tactus", welcome.device,
               active_settings_.host + ":" + std::to_string(active_settings_.port)};
  last_position_ = (welcome.workspace.min + welcome.workspace.max) * 0.5;
}

void RemoteDevice::close() noexcept {
  if (!thread_.joinable())
    return;
  stop_ = true;
  thread_.join();
}

std::string RemoteDevice::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_.empty() ? std::string() : "net: " + trouble_;
}

void RemoteDevice::set_trouble(const std::string& trouble) {
  const std::lock_guard lock(mutex_);
  trouble_ = trouble;
  changed_.notify_all();
}

bool RemoteDevice::read(const haptic::Tick& /*tick*/, State& state) noexcept {
  samples_.read();
  const Sample& sample = samples_.latest();
  state = sample.state;
  const double age_s = now_s() - sample.time_s;
  if (!sample.connected || age_s >= net::kSilence_s)
    return false;
  if (age_s >= kHeldVelocity_s)
    state.velocity = {};
  haptic::reject_unreachable(caps_, state, last_position_);
  if (age_s >= kStale_s)
    state.flags |= State::kUnreachable;
  if (sample.failed)
    state.flags |= State::kFault;
  failures_seen_ = sample.failures;
  return true;
}

bool RemoteDevice::write(const Vec3& force_n) noexcept {
  forces_.write(limited(force_n, caps_.peak_force_n));
  return true;
}

void RemoteDevice::serve() noexcept {
  try {
    run_connection();
  } catch (const std::exception& error) {
    set_trouble(std::string("the connection ended: ") + error.what() + "; open the device again");
  }
  sample_.connected = false;
  samples_.write(sample_);
}

void RemoteDevice::run_connection() {
  Backoff backoff{std::random_device{}()};
  const std::string server = active_settings_.host + ":" + std::to_string(active_settings_.port);
  while (!stop_) {
    const auto wire = std::make_unique<Wire>(stop_);
    std::string failure = wire->connect(active_settings_.host, active_settings_.port, kConnect_s);
    if (failure.empty()) {
      const double began_s = now_s();
      failure = run_session(*wire);
      if (now_s() - began_s > 1)
        backoff.reset();
    } else {
      failure =
          "no haptic server answers on " + server + " (" + failure + "): start haptic_server there";
    }
    // Lasts long enough for the servo to detect the missing device and to stop its motors.
    sample_.connected = false;
    samples_.write(sample_);
    down_until_s_ = now_s() + kFailureHold_s;
    if (stop_)
      return;
    set_trouble(failure);
    const auto until =
        Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(backoff.next()));
    while (!stop_ && Clock::now() < until)
      std::this_thread::sleep_for(kPollInterval);
  }
}

std::string RemoteDevice::run_session(Wire& wire) {
  const auto client = std::make_unique<Client>(
      ClientSettings{"tactus-" + std::to_string(name_), active_settings_.token,
                     active_settings_.rate_hz, active_settings_.udp});
  may_start_ = false;
  refusals_ = 0;
  sent_force_ = {};
  const double began_s = now_s();
  client->connect(began_s);
  wire.receive(
      [&client](std::span<const std::uint8_t> bytes) { return client->receive(bytes, now_s()); });
  const std::string server = active_settings_.host + ":" + std::to_string(active_settings_.port);
  bool reported = false, late = false;
  notice_.clear();
  while (!stop_ && wire.open && !wire.refused && client->advance(now_s())) {
    wire.exchange_datagrams(*client);
    exchange(*client, now_s());
    wire.send(client->out());
    wire.run();
    const bool measured = client->round_trip_s() && now_s() - began_s > kMeasure_s;
    if (!reported && client->ready() && measured) {
      reported = true;
      const std::lock_guard lock(mutex_);
      welcome_ = client->welcome();
      round_trip_s_ = *client->round_trip_s();
      if (client->udp_refused())
        notice_ = "the haptic server on " + server +
                  " sends no datagrams; positions arrive over TCP: start haptic_server with --udp";
      trouble_ = notice_;
      changed_.notify_all();
    }
    if (const bool now_late = reported && now_s() - client->position_s() >= kStale_s;
        now_late != late) {
      late = now_late;
      set_trouble(late ? "no position has arrived from the haptic server on " + server +
                             " for 100 ms: no force until positions arrive again"
                       : notice_);
    }
  }
  if (stop_) {
    client->stop();
    wire.send(client->out());
    return {};
  }
  const std::string reason = client->trouble().empty() ? wire.failure : client->trouble();
  if (const std::lock_guard lock(mutex_); !welcome_)
    return "the haptic server on " + server + " refused the connection (" + reason + ")";
  return "the connection to the haptic server on " + server + " was lost (" + reason +
         "): trying to reconnect; afterwards send motors 1";
}

/// Exchanges the newest states and forces with the servo.
void RemoteDevice::exchange(Client& client, double now) {
  const Vec3 newest = forces_.read();
  const Vec3 force_n = newest * forces_.gain();
  if (newest == Vec3{}) // commanded as zero, not by the timeout: the servo has seen the failure
    may_start_ = true;
  if (client.ready() && may_start_ && !client.in_control() && !(force_n == Vec3{})) {
    client.start(RenderMode::kForce);
    may_start_ = false;
    sent_force_ = {};
    set_trouble(notice_);
  }
  const bool stays = force_n == sent_force_;
  if (client.in_control() && (!stays || (!(force_n == Vec3{}) && now - sent_s_ >= kRepeat_s))) {
    client.send_force(force_n);
    sent_force_ = force_n;
    sent_s_ = now;
  }
  if (client.refusals() != refusals_) {
    refusals_ = client.refusals();
    failed_until_s_ = now + kFailureHold_s;
    ++failures_;
    may_start_ = false;
    set_trouble(client.trouble());
  }
  sample_.connected = client.ready() && now >= down_until_s_;
  sample_.failures = failures_;
  sample_.failed = now < failed_until_s_ || failures_seen_ != failures_;
  sample_.time_s = client.position_s();
  sample_.state.position = client.position();
  sample_.state.velocity = client.velocity();
  sample_.state.buttons = client.buttons();
  sample_.state.flags = State::kHomed;
  samples_.write(sample_);
}

} // namespace tactus::net
