#pragma once

#include "core/rows.hpp"
#include "net/bus_link.hpp"
#include "net/bus_topic.hpp"

#include <array>
#include <string>

namespace tactus::ioa_link {

/// [ioa_link]: a bus of modules mirrored over TCP. docs/audiohaptics_network.md.
class IoaLink {
public:
  static const Declaration declaration;
  static constexpr std::size_t timers = 1;

  void tick(std::size_t timer, Host& host);
  void dump(Host& host);

private:
  struct Rows;
  void send(std::span<const Atom> arguments, Host& host);
  void listen(std::span<const Atom> arguments, Host& host);
  void connect(std::span<const Atom> arguments, Host& host);
  void disconnect(Host& host);
  void set_playout(const Atom& delay, Host& host);
  void set_token(const Atom& file, Host& host);
  void set_time(std::span<const Atom> arguments, Host& host);
  void deliver(const net::BusLink::Delivered& delivered, Host& host);
  void tell(Host& host);

  net::BusLink link_{};
  double bus_ahead_ms_ = 0; ///< bus time minus the object's time
  double reported_ms_ = 0;  ///< time of the last report of late messages
  std::uint64_t late_ = 0, late_reported_ = 0;
};

struct IoaLink::Rows {
  using Self = IoaLink;
  static constexpr std::array messages{
      action<&Self::send>(
          "send", "topic fields...", 1, 1 + net::kMaxTopicFields,
          "send a topic to all peers; a slow connection may drop samples of raw, hand, contact, "
          "force and listener; all others arrive while the connection lasts"),
      action<&Self::listen>("listen", "port [address]", 1, 2,
                            "accept connections on 127.0.0.1 and ::1, or on a numeric address, "
                            "which needs a token; port 0: any free port"),
      action<&Self::connect>("connect", "[host] port", 1, 2,
                             "connect to a listening link, and again after each loss until "
                             "`disconnect`; without host: on this machine"),
      action<&Self::disconnect>("disconnect", "", 0, 0,
                                "close all connections, stop listening and connecting"),
      action<&Self::set_token>(
          "token", "file", 1, 1,
          "file of 16 to 1024 bytes that both sides share, from the next `listen` or `connect` on"),
      action<&Self::set_playout>("playout", "auto|ms", 1, 1,
                                 "playout delay from sending to output, 0 to 400 ms; auto: adapts "
                                 "to the connection; 0: none"),
      action<&Self::set_time>(
          "time", "ms", 1, 1,
          "present time of this side's bus, ms; by default bus time begins with the object. Times "
          "wrap to 0 after 65536 ms; the time nearest to now is meant"),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kControl, "messages", "", "all messages"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kControl, "topics", "",
           "TOPIC fields... from the other side, at the playout time; times in the fields are in "
           "ms of this side's clock, which wraps after 65536"},
  };
  static constexpr std::array arguments{CreationArgument{"listen"}};
};

inline constexpr Declaration IoaLink::declaration{
    "ioa_link",
    "mirrors a bus of modules over TCP",
    "Sends messages of the AudioHaptics bus to links on other computers. Outputs their messages at "
    "a constant delay, in order, with times translated to this side's clock. An open connection "
    "loses no events; a lost connection reconnects by itself.",
    "network bus IOA OSC TCP playout jitter buffer clock",
    Rows::inlets,
    Rows::outlets,
    {},
    Rows::messages,
    Rows::arguments,
    "ioa_net, audiohaptics.pd",
    "AudioHaptics: audiohaptics.md, over a network: audiohaptics_network.md, "
    "four computers: four_computers.md"};

} // namespace tactus::ioa_link
