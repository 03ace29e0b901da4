#pragma once

#include "core/declaration_text.hpp"
#include "core/haptic/signal/signal_player.hpp"
#include "core/rows.hpp"
#include "devices/servo_thread.hpp"
#include "externals/phantom/output/signal_link_name.hpp"

#include <array>
#include <memory>
#include <string>

namespace tactus {

/// [phantom~]: signals as forces into the servo of a [phantom], and its positions as signals out.
/// The two objects find each other by name, whichever is created or deleted first.
class PhantomSignal {
public:
  static const Declaration declaration;
  static constexpr std::size_t timers = 1;

  PhantomSignal() = default;
  ~PhantomSignal() { release_link(); }
  PhantomSignal(const PhantomSignal&) = delete;
  PhantomSignal& operator=(const PhantomSignal&) = delete;

  void prepare(double sample_rate, std::size_t) noexcept { player_.prepare(sample_rate); }
  /// Searches at the first tick, when all objects of the patch exist.
  void created(Host& host) {
    created_ = true;
    created_ms_ = host.created_ms();
    host.wake_in(0, 0);
  }
  void tick(std::size_t, Host& host) { find_device(host); }
  void dump(Host& host) {
    host.info({"name", std::string_view(name_)});
    host.info({"status", link_ ? "attached" : "waiting", std::string_view(name_)});
  }

  template <class S> void process(const Block<S>& block) noexcept {
    const bool velocities = velocities_;
    player_.begin_block(block.frames, 1e-3 * (block.output_ms + created_ms_));
    for (std::size_t i = 0; i < block.frames; ++i) {
      const auto in = [&](std::size_t port) { return static_cast<double>(block.inputs[port][i]); };
      const auto out = player_.process({{in(0), in(1), in(2)}, in(3)});
      for (int axis = 0; axis < 3; ++axis) {
        const auto port = static_cast<std::size_t>(axis);
        block.outputs[port][i] = static_cast<S>(out.position[axis]);
        block.outputs[port + 3][i] = static_cast<S>(velocities ? out.velocity[axis] : 0.0);
      }
      for (std::size_t pickup = 0; pickup < out.network.size(); ++pickup)
        block.outputs[6 + pickup][i] = static_cast<S>(out.network[pickup]);
    }
    player_.end_block(devices::ServoThread::now_s());
  }

private:
  struct Rows;
  [[nodiscard]] double delay_ms() const noexcept { return delay_ms_; }
  void set_delay(double ms) noexcept {
    delay_ms_ = ms;
    player_.set_delay(ms * 1e-3);
  }
  [[nodiscard]] bool gate() const noexcept { return gate_; }
  void set_gate(bool on) noexcept {
    gate_ = on;
    player_.set_gate(on);
  }
  void set_name(const Atom& word, Host& host) {
    name_ = word.is_word ? std::string(word.word) : number_text(word.number);
    searches_ = 0;
    if (created_)
      find_device(host);
  }
  static constexpr double kSearchInterval_ms = 100;
  static constexpr int kSearchesBeforeNotice = 20; // 2 s, in which a patch makes all its objects

  /// Attaches to the [phantom] of that name, and detaches when it is deleted or renamed.
  void find_device(Host& host) {
    const auto found = std::static_pointer_cast<haptic::SignalLink>(
        host.find_published(phantom::signal_link_name(name_)));
    if (found != link_) {
      release_link();
      if (found && found->acquire()) {
        link_ = found;
        refused_ = false;
        searches_ = 0;
      } else if (found && !refused_) {
        refused_ = true;
        host.error("name " + name_ +
                   ": another phantom~ already uses this phantom: expected one phantom~ for each");
      }
      player_.attach(link_.get());
      if (link_ || !waiting_)
        host.info({"status", link_ ? "attached" : "waiting", std::string_view(name_)});
      waiting_ = !link_;
    }
    if (!link_ && !refused_ && ++searches_ == kSearchesBeforeNotice)
      host.log("name " + name_ + ": no phantom of this name found yet: expected " +
               (name_ == "-" ? std::string("[phantom]") : "[phantom -name " + name_ + "]") +
               " in an open patch");
    host.wake_in(0, kSearchInterval_ms);
  }
  void release_link() noexcept {
    if (link_)
      link_->release();
    link_.reset();
    player_.attach(nullptr);
  }

  haptic::SignalPlayer player_;
  bool velocities_ = false, gate_ = true;
  double delay_ms_ = 3;
  std::string name_ = "-";
  std::shared_ptr<haptic::SignalLink> link_;
  bool created_ = false, waiting_ = true, refused_ = false;
  double created_ms_ = 0; // on the clock of all objects
  int searches_ = 0;      // in vain, since the name was set or the phantom was lost
};

struct PhantomSignal::Rows {
  using Self = PhantomSignal;
  static constexpr std::array parameters{
      member<&Self::velocities_>.row("vel",
                                     "switch: 1 sends velocities to the outlets vx, vy and vz", 0),
      property<&Self::delay_ms, &Self::set_delay>.row(
          "delay", "ms", 3, 0, 100,
          "delay of the outlets after the newest position, on the wall clock"),
      property<&Self::gate, &Self::set_gate>.row(
          "gate",
          "switch: 1 lets `vib` act only while the handle touches a body of the scene, along the "
          "body's normal",
          1),
  };
  static constexpr std::array messages{
      action<&Self::set_name>(
          "name", "word", 1, 1,
          "name of the phantom whose servo this uses; -: a phantom without name"),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kSignal, "fx", "N", "force to the right, added to phantom's"},
      Port{Port::Kind::kSignal, "fy", "N", "force up"},
      Port{Port::Kind::kSignal, "fz", "N", "force towards the user"},
      Port{Port::Kind::kSignal, "vib", "N",
           "vibration along the touched body's normal; low-pass at 0.4 times the servo rate"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kSignal, "x", "", "position from left to right, 0..1 over the workspace"},
      Port{Port::Kind::kSignal, "y", "", "position from bottom to top, 0..1"},
      Port{Port::Kind::kSignal, "z", "", "position from far to near, 0..1"},
      Port{Port::Kind::kControl, kInfoOutlet, "",
           "`status attached|waiting name`; answers to `get`"},
      Port{Port::Kind::kSignal, "vx", "m/s", "velocity to the right, with `-vel 1`"},
      Port{Port::Kind::kSignal, "vy", "m/s", "velocity up"},
      Port{Port::Kind::kSignal, "vz", "m/s", "velocity towards the user"},
      Port{Port::Kind::kSignal, "net1", "",
           "first pickup of phantom's mass-spring network, SI units"},
      Port{Port::Kind::kSignal, "net2", "", "second network pickup, SI units"},
  };
  static constexpr std::array arguments{CreationArgument{"name"}};
};

inline constexpr Declaration PhantomSignal::declaration{
    "phantom~",
    "haptic device at audio rate",
    "Adds signals to the force of a phantom object and outputs its position as signals. So you can "
    "feel a sound and hear a motion. In logical time each servo tick falls on its exact sample.",
    "haptic force feedback device audio rate vibration texture",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    Rows::arguments,
    "phantom, modal_impact~, mass_spring.pd",
    "signals of the hand: phantom_signal.md, the device: phantom.md, masses and springs: "
    "network.md",
    "spring/string.wav: a string that a hand plucks"};

} // namespace tactus
