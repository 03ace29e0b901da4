#include "externals/ioa_link/ioa_link.hpp"

#include "core/message_time.hpp"
#include "core/refusal.hpp"
#include "net/bus_topic.hpp"
#include "net/host_messages.hpp"

#include <cmath>

namespace tactus::ioa_link {
namespace {

using net::BusExchange;
using net::text_of;

constexpr double kPerSecond = 1e3, kReportInterval_ms = 500;

/// A whole number from min_port to 65535; -1 if the atom is not one.
int port_of(const Atom& atom, int min_port) noexcept {
  const bool whole = !atom.is_word && atom.number == std::floor(atom.number);
  return whole && atom.number >= min_port && atom.number <= 65535 ? static_cast<int>(atom.number)
                                                                  : -1;
}

} // namespace

void IoaLink::send(std::span<const Atom> arguments, Host& host) {
  if (!arguments[0].is_word || !net::is_topic_name(arguments[0].word))
    return host.error("send " + text_of(arguments[0]) +
                      ": expected a topic of 1 to 32 letters, digits, _ and -");
  net::Message topic(net::Address::kTopic, arguments[0].word);
  for (const Atom& atom : arguments.subspan(1)) {
    const double number = atom.is_word ? 0 : static_cast<double>(static_cast<float>(atom.number));
    if (!std::isfinite(number))
      return host.error("send " + text_of(arguments[0]) + ": not a finite number");
    atom.is_word ? topic.string(atom.word) : topic.real(number);
  }
  const double now_ms = host.now_ms();
  if (net::bus_topic(topic.name()).has_time) {
    if (arguments.size() < 2 || arguments[1].is_word)
      return host.error("send " + text_of(arguments[0]) +
                        ": expected the event's time in ms as first field");
    net::Message timed(net::Address::kTopic, topic.name());
    timed.real(message_time_since(arguments[1].number, now_ms + bus_ahead_ms_));
    for (std::size_t i = 1; i < topic.size(); ++i)
      timed.add(topic[i]);
    if (!std::isfinite(timed.number_at(0).value_or(0)))
      return host.error("send " + text_of(arguments[0]) + ": the event's time is out of range");
    topic = timed;
  }
  if (!link_.send(topic, now_ms / kPerSecond))
    host.error("send " + text_of(arguments[0]) + ": expected at most " +
               std::to_string(net::kMaxSent) + " bytes");
}

void IoaLink::deliver(const net::BusLink::Delivered& delivered, Host& host) {
  late_ += delivered.late ? 1 : 0;
  const net::Message& topic = delivered.topic;
  std::array<Atom, net::Message::kMaxArguments + 1> atoms{
      topic.name(), 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0.};
  for (std::size_t i = 0; i < topic.size(); ++i)
    atoms[i + 1] = std::visit([](auto value) { return Atom(value); }, topic[i]);
  if (net::bus_topic(topic.name()).has_time && topic.size() > 0)
    atoms[1] = message_time(topic.number_at(0).value_or(0) + kPerSecond * delivered.sent_s +
                            bus_ahead_ms_);
  host.send(0, std::span(atoms).first(topic.size() + 1));
}

void IoaLink::listen(std::span<const Atom> arguments, Host& host) {
  const int port = port_of(arguments[0], 0);
  if (port < 0)
    return host.error("listen " + text_of(arguments[0]) + ": expected a port in 0..65535");
  std::string address = arguments.size() > 1 ? text_of(arguments[1]) : std::string();
  disconnect(host);
  link_.listen(port, address == "loopback" ? std::string() : address);
  host.wake_in(0, 0);
}

void IoaLink::connect(std::span<const Atom> arguments, Host& host) {
  const int port = port_of(arguments.back(), 1);
  if (port < 0)
    return host.error("connect " + text_of(arguments.back()) +
                      ": expected [host] port, with a port in 1..65535");
  disconnect(host);
  link_.connect(arguments.size() > 1 ? text_of(arguments[0]) : "127.0.0.1", port);
  host.wake_in(0, 0);
}

void IoaLink::disconnect(Host& host) {
  const bool was_connected = link_.peers() > 0;
  link_.disconnect();
  host.wake_in(0, -1);
  if (was_connected)
    host.info({"connected", 0.});
}

void IoaLink::set_playout(const Atom& delay, Host& host) {
  constexpr double kMax_ms = net::PlayoutDelay::kMax_s * kPerSecond;
  if (delay.is_word && delay.word == "auto")
    return link_.set_playout({});
  if (delay.is_word || !(delay.number >= 0 && delay.number <= kMax_ms))
    return host.error("playout " + text_of(delay) + ": expected auto or 0..400 ms");
  link_.set_playout(delay.number / kPerSecond);
}

void IoaLink::set_token(const Atom& file, Host& host) {
  if (std::optional<std::string> token = net::read_token(file, host))
    link_.set_token(*std::move(token));
}

void IoaLink::tick(std::size_t, Host& host) {
  if (!link_.open())
    return;
  tell(host);
  const double now_s = host.now_ms() / kPerSecond;
  const double next_s =
      link_.poll(now_s, [&](const net::BusLink::Delivered& one) { deliver(one, host); });
  if (link_.open()) // a receiver of the messages may have closed the link
    host.wake_in(0, std::max(0.0, kPerSecond * (next_s - now_s)));
}

void IoaLink::tell(Host& host) {
  using What = BusExchange::Notice::What;
  for (const BusExchange::Notice& notices : link_.take_notices()) {
    switch (notices.what) {
    case What::kListening:
      host.info({"status", "listening", static_cast<double>(notices.number)});
      break;
    case What::kConnected:
      host.info({"status", "connected", std::string_view(notices.text)});
      host.info({"connected", static_cast<double>(notices.number)});
      break;
    case What::kEnded:
      host.log("a connection ended: " + notices.text);
      host.info({"status", "ended"});
      host.info({"connected", static_cast<double>(notices.number)});
      break;
    case What::kLate:
      host.info({"status", "late", std::string_view(notices.text)});
      break;
    case What::kBack:
      host.info({"status", "back", std::string_view(notices.text)});
      break;
    case What::kWarning:
      host.error("the peer reports " + notices.text);
      break;
    case What::kFailed:
      host.error(notices.text);
      break;
    }
  }
  if (late_ != late_reported_ && host.now_ms() - reported_ms_ >= kReportInterval_ms) {
    reported_ms_ = host.now_ms();
    host.info({"late", static_cast<double>(late_ - late_reported_)});
    late_reported_ = late_;
  }
}

void IoaLink::dump(Host& host) {
  host.info({"status", link_.open() ? "open" : "closed"});
  host.info({"connected", static_cast<double>(link_.peers())});
  host.info({"delay", kPerSecond * link_.delay_s()});
  host.info({"transit", kPerSecond * link_.transit_s()});
}

void IoaLink::set_time(std::span<const Atom> arguments, Host& host) {
  if (arguments[0].is_word || !std::isfinite(arguments[0].number))
    return host.error(refusal("time", arguments, "a number of ms"));
  bus_ahead_ms_ = arguments[0].number - host.now_ms();
}

} // namespace tactus::ioa_link
