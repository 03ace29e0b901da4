#include "core/declaration_text.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/phantom.hpp"

/// [phantom]'s message `network`.
namespace tactus {

using namespace phantom;
using haptic::NetworkModel;

void Phantom::on_network(Words words, Host& host) {
  if (!is(words[0], "pluck") && !is(words[0], "reset")) {
    const double before_hz = network_.stepping(period_s()).rate_hz;
    if (const std::string refusal = network_.handle(words, host, period_s()); !refusal.empty())
      return host.error(refusal);
    rig_->network.publish(network_.snapshot());
    const auto stepping = network_.stepping(period_s());
    if (!stepping.reason.empty() && stepping.rate_hz != before_hz)
      host.log("network: stepped at " + number_text(stepping.rate_hz) + " Hz: " + stepping.reason);
    const haptic::Network& network = network_.network();
    constexpr double kLate = 0.5; // the mean over a tick's steps adds half a tick of delay
    if (is(words[0], "touch")) {
      warn_of_stiffness("network touch", network.touch.stiffness_n_per_m, host, kLate);
      warn_of_damping("network touch", network.touch.damping_n_s_per_m, host);
    }
    if (!is(words[0], "grab"))
      return;
    warn_of_stiffness("network grab", network.grab.stiffness_n_per_m, host, kLate);
    warn_of_damping("network grab", network.grab.damping_n_s_per_m, host);
  }
  NetworkModel::Action action;
  if (is(words[0], "pluck")) {
    constexpr Range ranges[] = {{"fx", "N", -100, 100},
                                {"fy", "N", -100, 100},
                                {"fz", "N", -100, 100},
                                {"time", "ms", 0, 10000}};
    double v[4] = {};
    if (words.size() != 6)
      return host.error("network pluck: expected a mass, fx fy fz in N and ms");
    const NamedNetwork::Found found = network_.movable(words[1]);
    std::string refusal = found.refusal;
    if (refusal.empty())
      refusal = read_numbers(words.subspan(2), ranges, v);
    if (!refusal.empty())
      return host.error("network pluck: " + refusal);
    action = NetworkModel::Pluck{found.key, {v[0], v[1], v[2]}, v[3] * 1e-3};
  } else if (is(words[0], "grab")) {
    if (is(words[1], "off"))
      action = NetworkModel::Release{};
    else if (is(words[1], "nearest"))
      action = NetworkModel::GrabNearest{};
    else
      action = NetworkModel::Grab{network_.movable(words[1]).key};
  }
  if (!rig_->network.queue_action(action))
    host.error("network " + std::string(words[0].word) +
               ": 64 actions are queued and the servo does not run: expected an open device");
}

/// A new period of the ticks may need more steps than a tick can have.
void Phantom::check_network(Host& host) {
  const auto stepping = network_.stepping(period_s());
  if (!(stepping.rate_hz > 0))
    host.error("network: stopped: at " + number_text(1 / period_s()) + " ticks a second, " +
               stepping.reason);
}

} // namespace tactus
