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
  double bus_ahead_ms_ = 0; ///< bus time minus the object's
  double reported_ms_ = 0;  ///< when late messages were last reported
  std::uint64_t late_ = 0, late_reported_ = 0;
};

struct IoaLink::Rows {
  using Self = IoaLink;
  static constexpr std::array messages{
      action<&Self::send>(
          "send", "topic fields...", 1, 1 + net::kMaxTopicFields,
          "send a topic to all peers; on a slow connection samples of raw, hand, contact, force "
          "and listener may be dropped, all else arrives while the connection lasts"),
      action<&Self::listen>("listen", "port [address]", 1, 2,
                            "accept connections on 127.0.0.1 and ::1, or on a numeric address, "
                            "which needs a token; port 0: any that is free"),
      action<&Self::connect>("connect", "[host] port", 1, 2,
                             "connect to a link that listens, and again after each loss until "
                             "`disconnect`; without host on this machine"),
      action<&Self::disconnect>("disconnect", "", 0, 0,
                                "close all connections and stop to listen or to connect"),
      action<&Self::set_token>("token", "file", 1, 1,
                               "file with the 16 to 1024 bytes that both sides share, from the "
                               "next `listen` or `connect` on"),
      action<&Self::set_playout>("playout", "auto|ms", 1, 1,
                                 "playout delay after a message was sent, 0 to 400 ms; auto: as "
                                 "the connection needs; 0: at once"),
      action<&Self::set_time>(
          "time", "ms", 1, 1,
          "present time of this side's bus, ms; without it bus time begins with the object. Times "
          "begin again at 0 after 65536 ms; the one nearest to now is meant"),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kControl, "messages", "", "all messages"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kControl, "topics", "",
           "TOPIC fields... from the other side, at its playout time; times among the fields are "
           "on this side's clock, ms, from 0 to 65536 and again from 0"},
  };
  static constexpr std::array arguments{CreationArgument{"listen"}};
};

inline constexpr Declaration IoaLink::declaration{
    "ioa_link",
    "mirrors a bus of modules over TCP",
    "Sends messages of the AudioHaptics bus to links on other computers and lets theirs out "
    "evenly, "
    "in order, with times translated to this side's clock. Events are never lost while a "
    "connection stands; a lost connection is taken up again by itself.",
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
