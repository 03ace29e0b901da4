#include "externals/phantom/network/named_network.hpp"

#include "core/declaration_text.hpp"
#include "core/haptic/network/stability.hpp"

#include <algorithm>

/// NamedNetwork's masses and links. The messages are in network_message.cpp and
/// network_settings.cpp.
namespace tactus::phantom {

using haptic::Network;

std::size_t NamedNetwork::find(const std::string& name) const noexcept {
  const auto found =
      std::find_if(names_.begin(), names_.end(), [&](const Name& n) { return n.name == name; });
  return found == names_.end() ? kNone : static_cast<std::size_t>(found - names_.begin());
}

NamedNetwork::Found NamedNetwork::movable(const Atom& name) const {
  const std::size_t index = find(text_of(name));
  if (index == kNone)
    return {0, text_of(name) + ": no such mass"};
  if (network_.masses[index].fixed)
    return {0, text_of(name) + ": an anchor does not move"};
  return {network_.masses[index].key, {}};
}

void NamedNetwork::add(haptic::NetworkMass mass, std::string name, std::string group) {
  mass.key = ++keys_;
  network_.masses.push_back(mass);
  names_.push_back({std::move(name), std::move(group)});
}

void NamedNetwork::add(const haptic::NetworkPart& part, const std::string& group,
                       const std::vector<std::string>& names) {
  remove_named(group);
  for (const std::string& name : names)
    remove_mass(name);
  const auto first = static_cast<std::uint16_t>(network_.masses.size());
  for (std::size_t i = 0; i < part.masses.size(); ++i)
    add(part.masses[i], names[i], group);
  for (haptic::NetworkLink link : part.links) {
    link.a = static_cast<std::uint16_t>(link.a + first);
    link.b = static_cast<std::uint16_t>(link.b + first);
    network_.links.push_back(link);
  }
}

/// Removes a mass, or the masses of a string or membrane.
bool NamedNetwork::remove_named(const std::string& name) {
  return remove_if(
      [&](const Name& n) { return n.name == name || (!n.group.empty() && n.group == name); });
}

bool NamedNetwork::remove_mass(const std::string& name) {
  return remove_if([&](const Name& n) { return n.name == name; });
}

/// Removes masses with their links and pickups. Returns false if there were none.
template <class Predicate> bool NamedNetwork::remove_if(const Predicate& predicate) {
  std::vector<std::size_t> index(names_.size(), kNone); // new index of each mass, or kNone
  std::size_t kept = 0;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (predicate(names_[i]))
      continue;
    index[i] = kept;
    network_.masses[kept] = network_.masses[i];
    if (kept != i)
      names_[kept] = std::move(names_[i]);
    ++kept;
  }
  if (kept == index.size())
    return false;
  network_.masses.resize(kept);
  names_.resize(kept);
  auto& links = network_.links;
  links.erase(std::remove_if(links.begin(), links.end(),
                             [&](const auto& link) {
                               return index[link.a] == kNone || index[link.b] == kNone;
                             }),
              links.end());
  for (haptic::NetworkLink& link : links) {
    link.a = static_cast<std::uint16_t>(index[link.a]);
    link.b = static_cast<std::uint16_t>(index[link.b]);
  }
  for (haptic::NetworkPickup& pickup : network_.pickups)
    if (pickup.mass != kNone)
      pickup.mass = index[pickup.mass];
  return true;
}

std::string NamedNetwork::too_large() const {
  const auto anchors = static_cast<std::size_t>(std::count_if(
      network_.masses.begin(), network_.masses.end(), [](const auto& m) { return m.fixed; }));
  const std::size_t masses = network_.masses.size() - anchors;
  if (masses > Network::kMaxMasses)
    return std::to_string(masses) + " movable masses: expected at most " +
           std::to_string(Network::kMaxMasses);
  if (anchors > Network::kMaxAnchors)
    return std::to_string(anchors) + " anchors: expected at most " +
           std::to_string(Network::kMaxAnchors);
  if (network_.links.size() > Network::kMaxLinks)
    return std::to_string(network_.links.size()) + " links: expected at most " +
           std::to_string(Network::kMaxLinks);
  return {};
}

NamedNetwork::Stepping NamedNetwork::stepping(double period_s) const {
  const haptic::StepBound bound = haptic::max_stable_step(network_);
  const auto steps = haptic::steps_per_tick(network_, bound.step_s, period_s).steps;
  const double needed_hz = 1 / (haptic::kStepMargin * bound.step_s), got_hz = steps / period_s;
  std::string reason;
  if (steps == 0 || needed_hz > network_.rate_hz)
    reason = "mass " + names_[bound.mass].name + " (" +
             number_text(network_.masses[bound.mass].mass_kg) +
             " kg) with its springs and the hand needs " + number_text(std::ceil(needed_hz)) +
             " steps a second";
  else if (got_hz < 0.9 * network_.rate_hz)
    reason = std::to_string(network_.links.size()) + " links: a tick has no time for more steps";
  if (steps == 0)
    reason += ", too many for " + std::to_string(network_.links.size()) +
              " links: expected fewer links, softer springs, weaker dampers or heavier masses";
  return {got_hz, std::move(reason)};
}

std::string NamedNetwork::handle(Words words, const Host& host, double period_s) {
  NamedNetwork changed = *this;
  std::string refusal = changed.change(words, host);
  if (refusal.empty())
    refusal = changed.too_large();
  if (refusal.empty())
    if (const Stepping stepping = changed.stepping(period_s); !(stepping.rate_hz > 0))
      refusal = stepping.reason;
  if (!refusal.empty())
    return "network " + text_of(words[0]) + ": " + refusal;
  *this = std::move(changed);
  return {};
}

std::string NamedNetwork::load(Words words, const Host& host) {
  return handle_file(words, "network", host, [&](Words line) {
    std::string refusal = change(line, host);
    if (refusal.empty() && network_.masses.size() > 2 * Network::kMaxPoints)
      refusal = too_large();
    return refusal.empty() ? refusal : text_of(line[0]) + ": " + refusal;
  });
}

void NamedNetwork::dump(Host& host, double period_s) const {
  host.info({"network", static_cast<double>(network_.masses.size()),
             static_cast<double>(network_.links.size()), stepping(period_s).rate_hz});
}

} // namespace tactus::phantom
