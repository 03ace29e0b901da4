#pragma once

#include "core/object.hpp"
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
  static constexpr std::array kParameters{
      Parameter{"port", "", net::kPort, 0, 65535, "from the next open on; 0: any that is free"},
      Parameter{"forcemax", "N", 3, 0.01, 40, "no client can raise it; from the next open on"},
      Parameter{"stiffness", "N/m", 500, 0, 20000,
                "limit of a client's spring; from the next open on"},
      Parameter{"damping", "N s/m", 5, 0, 1000,
                "limit of a client's damper; from the next open on"},
      Parameter{"grab", "mm", 10, 0, 1000,
                "reach of the handle for control points; from the next open on"},
  };
  static constexpr std::array kInlets{
      Port{Port::Kind::kControl, "position", "mm", "list x y z of the handle, and all messages"},
  };
  static constexpr std::array kOutlets{
      Port{Port::Kind::kControl, "force", "N", "list fx fy fz for [phantom], whenever it changes"},
  };
  static constexpr std::array kMessages{
      Message{"list", "x y z", 3, 3, "where the handle is, mm"},
      Message{"open", "", 0, 0, "listen on this machine, or where listen said"},
      Message{"close", "", 0, 0, "tell all clients, and no force"},
      Message{"listen", "address|loopback", 1, 1,
              "a numeric address; another than loopback needs a token"},
      Message{"token", "file", 1, 1, "16 to 1024 bytes that every client must bring"},
      Message{"workspace", "xmin ymin zmin xmax ymax zmax", 6, 6,
              "of the handle, mm, as clients are told"},
      Message{"button", "n 0|1", 2, 2, "a button of the handle; 0 drags control points"},
      Message{"estop", "", 0, 0, "no force until motors 1 and a client's start"},
      Message{"motors", "1", 1, 1, "releases estop"},
      Message{"bang", "", 0, 0, "send the force now"},
  };
  static constexpr std::array kArguments{CreationArgument{"port"}};
  static constexpr Declaration declaration{
      "haptic_server",
      "lets other computers move a haptic device",
      "Listens for clients of the haptic protocol and gives the force that the one in control asks "
      "for: forces, or a spring or damper set by its feedback, within limits that no client can "
      "raise. Stop, a lost connection and 500 ms of silence end the force.",
      "haptic network server OSC TCP force feedback remote",
      kInlets,
      kOutlets,
      kParameters,
      kMessages,
      kArguments,
      "phantom, stress_haptic",
      "the protocol: haptic_network.md"};
  static constexpr std::size_t timers = 1;

  HapticServerObject();
  ~HapticServerObject();
  void set(std::size_t parameter, double value) noexcept { values_[parameter] = value; }
  [[nodiscard]] double get(std::size_t parameter) const noexcept { return values_[parameter]; }
  void message(std::size_t index, std::span<const Atom> arguments, Host& host);
  void tick(std::size_t timer, Host& host);
  void dump(Host& host);

private:
  /// The server, its sockets and its link to the servo, which exist while the object listens.
  struct Service;
  enum Value : std::size_t { kPortValue, kForceMax, kStiffness, kDamping, kGrab, kValueCount };

  void open(Host& host);
  void close(Host& host);
  [[nodiscard]] bool stopped() noexcept;
  void send_force(Host& host);
  void send_notices(Host& host);

  std::array<double, kValueCount> values_{};
  haptic::Workspace workspace_{};
  std::string listen_{}, token_{};
  PatchDevice device_{};
  net::RenderModel model_{};
  haptic::Servo servo_{};
  std::unique_ptr<Service> service_;
  std::uint64_t ticks_ = 0;
  double stepped_s_ = 0;
  haptic::Vec3 sent_n_{};
};

} // namespace tactus::haptic_server
