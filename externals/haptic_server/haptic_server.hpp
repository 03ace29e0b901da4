#pragma once

#include "core/rows.hpp"
#include "externals/haptic_server/patch_device.hpp"
#include "net/servo_link.hpp"
#include "net/tcp_server.hpp"

#include <array>
#include <memory>
#include <optional>
#include <string>

namespace tactus::haptic_server {

/// [haptic_server]: the haptic protocol's server in a patch. docs/haptic_network.md.
class HapticServerObject {
public:
  static const Declaration declaration;
  static constexpr std::size_t timers = 1;

  HapticServerObject();
  ~HapticServerObject();
  void tick(std::size_t timer, Host& host);
  void dump(Host& host);

private:
  /// The server, its sockets and its link to the servo, which exist while the object listens.
  struct Service;
  struct Rows;
  /// Settings that take effect at the next `open`.
  struct Limits {
    double port = net::kPort, force_n = 3, stiffness_n_per_m = 500, damping_n_s_per_m = 5,
           grab_mm = 10;
  };

  void open(Host& host);
  void close(Host& host);
  void send_again(Host& host) { host.send(0, {sent_n_.x, sent_n_.y, sent_n_.z}); }
  void set_position(std::span<const Atom> arguments, Host& host);
  void set_address(const Atom& address, Host& host);
  void set_token(const Atom& file, Host& host);
  void set_workspace(std::span<const Atom> arguments, Host& host);
  void set_button(std::span<const Atom> arguments, Host& host);
  void stop(Host& host);
  void enable(std::span<const Atom> arguments, Host& host);
  [[nodiscard]] bool stopped() noexcept;
  void send_force(Host& host);
  void send_notices(Host& host);

  Limits limits_;
  haptic::Workspace workspace_{};
  std::string listen_{}, token_{};
  PatchDevice device_{};
  net::RenderModel model_{};
  haptic::Servo servo_{};
  std::unique_ptr<Service> service_;
  std::uint64_t ticks_ = 0;
  double stepped_s_ = 0;
  Vec3 sent_n_{};
};

struct HapticServerObject::Rows {
  using Self = HapticServerObject;
  template <auto limit> static constexpr auto limits = member<&Self::limits_, limit>;
  static constexpr std::array parameters{
      limits<&Limits::port>.row("port", "", 0, 65535,
                                "TCP port from the next `open` on; 0: any free port"),
      limits<&Limits::force_n>.row("forcemax", "N", 0.01, 40,
                                   "maximum force for clients, from the next `open` on"),
      limits<&Limits::stiffness_n_per_m>.row(
          "stiffness", "N/m", 0, 20000,
          "maximum stiffness of a client's spring, from the next `open` on"),
      limits<&Limits::damping_n_s_per_m>.row(
          "damping", "N s/m", 0, 1000,
          "maximum damping of a client's damper, from the next `open` on"),
      limits<&Limits::grab_mm>.row(
          "grab", "mm", 0, 1000,
          "distance at which the handle grabs control points, from the next `open` on"),
  };
  static constexpr std::array messages{
      action<&Self::set_position>("list", "x y z", 3, 3, "position of the handle, mm"),
      action<&Self::open>("open", "", 0, 0,
                          "open the port on this machine, or at the address of `listen`"),
      action<&Self::close>("close", "", 0, 0, "close all connections; the force becomes zero"),
      action<&Self::set_address>("listen", "address|loopback", 1, 1,
                                 "numeric address of the port; all but loopback need a token"),
      action<&Self::set_token>("token", "file", 1, 1,
                               "file of 16 to 1024 bytes that every client must send"),
      action<&Self::set_workspace>("workspace", "xmin ymin zmin xmax ymax zmax", 6, 6,
                                   "workspace of the handle, mm, that clients receive"),
      action<&Self::set_button>("button", "n 0|1", 2, 2,
                                "state of a button of the handle; button 0 drags control points"),
      action<&Self::stop>("estop", "", 0, 0,
                          "emergency stop: no force until `motors 1` and a client's start"),
      action<&Self::enable>("motors", "1", 1, 1, "end the emergency stop"),
      action<&Self::send_again>("bang", "", 0, 0, "send the force to its outlet"),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kControl, "position", "mm",
           "list x y z: position of the handle; all messages"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kControl, "force", "N",
           "list fx fy fz for [phantom] at each change of the force"},
  };
  static constexpr std::array arguments{CreationArgument{"port"}};
};

inline constexpr Declaration HapticServerObject::declaration{
    "haptic_server",
    "lets other computers control a haptic device",
    "Accepts clients of the haptic protocol and outputs the force that the client in control "
    "requests: a force, or a spring or damper set by its feedback, within limits that no client "
    "can raise. A stop, a lost connection or 500 ms of silence ends the force.",
    "haptic network server OSC TCP force feedback remote",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    Rows::arguments,
    "phantom, stress_haptic",
    "a device on another computer: haptic_network.md, the protocol: formats/haptic_protocol.md"};

} // namespace tactus::haptic_server
