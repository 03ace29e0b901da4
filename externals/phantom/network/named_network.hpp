#pragma once

#include "core/haptic/network/network.hpp"
#include "core/haptic/network/shapes.hpp"
#include "core/object.hpp"
#include "externals/phantom/words.hpp"

#include <memory>
#include <string>
#include <vector>

namespace tactus::phantom {

/// Damping in a message of the network.
inline constexpr Range kNetworkDamping{"b", "N s/m", 0, 100};

/// The mass-spring network of a patch, whose masses have names, and its messages: docs/network.md.
class NamedNetwork {
public:
  NamedNetwork() { network_.drag_per_s = kDrag_per_s; }
  /// Handles a message that changes the network: mass, anchor, link, string, membrane, load, del,
  /// touch, grab, listen, drag, gravity or rate. Returns a sentence if the message is refused,
  /// which includes a network that cannot be stepped in ticks of period_s. Nothing has changed
  /// then.
  [[nodiscard]] std::string handle(Words words, const Host& host, double period_s);
  /// A copy for the servo.
  [[nodiscard]] std::unique_ptr<const haptic::Network> snapshot() const {
    return std::make_unique<const haptic::Network>(network_);
  }
  [[nodiscard]] const haptic::Network& network() const noexcept { return network_; }
  /// The key of a movable mass; 0 and a sentence if no mass has that name.
  struct Found {
    std::uint64_t key = 0;
    std::string refusal{};
  };
  [[nodiscard]] Found movable(const Atom& name) const;
  /// Steps per second in ticks of that length, 0 if a tick would have too many steps, and the
  /// reason if this is not the set rate.
  struct Stepping {
    double rate_hz = 0;
    std::string reason{};
  };
  [[nodiscard]] Stepping stepping(double period_s) const;
  void dump(Host& host, double period_s) const;

private:
  struct Name {
    std::string name;
    std::string group; ///< the string or membrane that the mass belongs to
  };
  static constexpr double kDrag_per_s = 1; // without a damper, a sound decays by 60 dB in 14 s
  static constexpr std::size_t kNone = haptic::NetworkPickup::kNone;

  [[nodiscard]] std::string change(Words words, const Host& host);
  [[nodiscard]] std::string add_mass(Words words);
  [[nodiscard]] std::string add_anchor(Words words);
  [[nodiscard]] std::string add_link(Words words);
  [[nodiscard]] std::string add_string(Words words);
  [[nodiscard]] std::string add_membrane(Words words);
  [[nodiscard]] std::string load(Words words, const Host& host);
  [[nodiscard]] std::string remove(Words words);
  [[nodiscard]] std::string set_motion(Words words);
  [[nodiscard]] std::string set_touch(Words words);
  [[nodiscard]] std::string set_grab(Words words);
  [[nodiscard]] std::string set_pickup(Words words);
  [[nodiscard]] std::size_t find(const std::string& name) const noexcept;
  void add(haptic::NetworkMass mass, std::string name, std::string group);
  void add(const haptic::NetworkPart& part, const std::string& group,
           const std::vector<std::string>& names);
  bool remove_named(const std::string& name);
  bool remove_mass(const std::string& name);
  template <class Predicate> bool remove_if(const Predicate& predicate);
  [[nodiscard]] std::string too_large() const;

  haptic::Network network_{};
  std::vector<Name> names_; // names of network_.masses
  std::uint64_t keys_ = 0;
};

} // namespace tactus::phantom
