#pragma once

#include "core/declaration_text.hpp"
#include "core/haptic/signal/signal_player.hpp"
#include "core/object.hpp"
#include "devices/servo_thread.hpp"
#include "externals/phantom/signal_link_name.hpp"
#include "externals/phantom~/declaration.hpp"

#include <array>
#include <memory>
#include <string>

namespace tactus {

/// [phantom~]: signals as forces into the servo of a [phantom], its positions as signals out. The
/// two find each other by name, in any order of creation and deletion.
class PhantomSignal {
public:
  static constexpr Declaration declaration{
      "phantom~",
      "haptic device at audio rate",
      "Adds signals to the force of a phantom object and sends its position as signals, so that "
      "what sounds can be felt and what moves can sound. In logical time each servo tick falls on "
      "its exact sample.",
      "haptic force feedback device audio rate vibration texture",
      phantom_signal::kInlets,
      phantom_signal::kOutlets,
      phantom_signal::kParameters,
      phantom_signal::kMessages,
      phantom_signal::kArguments,
      "phantom, modal_impact~, mass_spring.pd",
      "the servo: phantom.md, masses and springs: network.md",
      "spring/string.wav: a string that a hand plucks"};
  static constexpr std::size_t timers = 1;

  PhantomSignal() = default;
  ~PhantomSignal() { release_link(); }
  PhantomSignal(const PhantomSignal&) = delete;
  PhantomSignal& operator=(const PhantomSignal&) = delete;

  void prepare(double sample_rate, std::size_t) noexcept { player_.prepare(sample_rate); }
  void set(std::size_t parameter, double value) noexcept {
    values_[parameter] = value;
    player_.set_delay(values_[phantom_signal::kDelay] * 1e-3);
    player_.set_gate(values_[phantom_signal::kGate] >= 0.5);
  }
  [[nodiscard]] double get(std::size_t parameter) const noexcept { return values_[parameter]; }

  void message(std::size_t, std::span<const Atom> words, Host& host) {
    name_ = words[0].is_word ? std::string(words[0].word) : number_text(words[0].number);
    searches_ = 0;
    if (created_)
      find_device(host);
  }
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
    const bool velocities = values_[phantom_signal::kVel] >= 0.5;
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
        host.error("name " + name_ + ": another phantom~ has this device; one is enough");
      }
      player_.attach(link_.get());
      if (link_ || !waiting_)
        host.info({"status", link_ ? "attached" : "waiting", std::string_view(name_)});
      waiting_ = !link_;
    }
    if (!link_ && !refused_ && ++searches_ == kSearchesBeforeNotice)
      host.log("name " + name_ + ": still waiting for a phantom of this name: expected " +
               (name_ == "-" ? std::string("[phantom]") : "[phantom -name " + name_ + "]") +
               " in some patch");
    host.wake_in(0, kSearchInterval_ms);
  }
  void release_link() noexcept {
    if (link_)
      link_->release();
    link_.reset();
    player_.attach(nullptr);
  }

  haptic::SignalPlayer player_;
  std::array<double, 3> values_{};
  std::string name_ = "-";
  std::shared_ptr<haptic::SignalLink> link_;
  bool created_ = false, waiting_ = true, refused_ = false;
  double created_ms_ = 0; // on the clock of all objects
  int searches_ = 0;      // in vain, since the name was set or the phantom was lost
};

} // namespace tactus
