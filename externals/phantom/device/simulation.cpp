#include "externals/phantom/device/simulation.hpp"

#include "core/declaration_text.hpp"
#include "externals/phantom/device/path_message.hpp"

namespace tactus::phantom {

using Device = haptic::SimulatedDevice;
using Hold = haptic::HandSettings::Hold;

/// Makes a change while the device is not being stepped.
template <class Change> void Simulation::between_ticks(const Change& change) {
  if (link_.is_real())
    change(link_.simulated);
  else
    session_.between_ticks([&] { change(link_.simulated); });
}

std::string Simulation::only_simulated(std::string_view message) const {
  return std::string(message) + ": only for the simulated device, not for " +
         std::string(link_.driver_name()) + "; send backend sim first";
}

void Simulation::apply() {
  Device::Settings settings;
  settings.mass_kg = given.mass_kg;
  settings.viscous_n_s_per_m = given.viscous_n_s_per_m;
  settings.stops = given.stops;
  settings.resolution_m = given.resolution_mm * 1e-3;
  settings.noise_m = given.noise_mm * 1e-3;
  settings.latency_ticks = static_cast<int>(given.latency_ticks);
  settings.hand = hand_;
  settings.seed = settings.hand.seed = given.seed;
  between_ticks([&](Device& simulated) {
    const haptic::Caps before = simulated.caps();
    simulated.set(settings);
    const haptic::Caps now = simulated.caps();
    const bool same = now.position_noise_m == before.position_noise_m &&
                      now.damping_limit_n_s_per_m == before.damping_limit_n_s_per_m &&
                      now.latency_ticks == before.latency_ticks;
    if (!same && !link_.is_real())
      session_.rig().servo.refresh_caps();
  });
  if (!link_.is_real())
    session_.rig().set_limits(link_.simulated.caps());
}

std::string Simulation::set_hand(Words words, const Host&) {
  haptic::HandSettings hand = hand_;
  if (is(words[0], "free"))
    hand.hold = Hold::kFree;
  else if (is(words[0], "rigid"))
    hand.hold = Hold::kRigid;
  else if (is(words[0], "spring"))
    hand.hold = Hold::kSpring;
  else if (is(words[0], "person"))
    hand.hold = Hold::kPerson;
  else
    return expected("hand", words[0], "free, rigid, spring or person");

  constexpr Range ranges[] = {{"K", "N/m", 0, 20000},
                              {"B", "N s/m", 0, 1000},
                              {"tremor", "mm", 0, 10},
                              {"wander", "mm", 0, 50},
                              {"yield", "ms", 0, 60000}};
  const std::size_t count = words.size() - 1;
  const bool person = hand.hold == Hold::kPerson, spring = hand.hold == Hold::kSpring;
  if (count != 0 && !(spring && count == 2) && !(person && (count == 2 || count == 5)))
    return "hand " + std::string(words[0].word) + ": " + number_text(static_cast<double>(count)) +
           (count == 1 ? " number" : " numbers") +
           (spring   ? ": expected none, or K (N/m) and B (N s/m)"
            : person ? ": expected none, K (N/m) and B (N s/m), or these and tremor (mm), wander "
                       "(mm) and yield (ms)"
                     : ": expected none");
  double values[5] = {};
  const std::string refusal = read_numbers(words.subspan(1), std::span(ranges, count), values);
  if (!refusal.empty())
    return "hand: " + refusal;
  if (count >= 2) {
    hand.stiffness_n_per_m = values[0];
    hand.damping_n_s_per_m = values[1];
  }
  if (count == 5) {
    hand.tremor_m = values[2] * 1e-3;
    hand.wander_m = values[3] * 1e-3;
    hand.yield_s = values[4] * 1e-3;
  }
  hand_ = hand;
  apply();
  return {};
}

std::string Simulation::set_path(Words words, const Host& host) {
  PathChoice choice = choose_path(words, host);
  if (!choice.refusal.empty())
    return choice.refusal;
  path_name_ = words[0].word;
  between_ticks([&](Device& simulated) { simulated.set_path(std::move(choice.path)); });
  return {};
}

std::string Simulation::set_target(Words words, const Host&) {
  constexpr Range ranges[] = {millimetres("x"), millimetres("y"), millimetres("z")};
  double mm[3];
  if (const std::string refusal = read_numbers(words, ranges, mm); !refusal.empty())
    return "target: " + refusal;
  path_name_ = "target";
  between_ticks([&](Device& simulated) { simulated.set_target(metres(mm)); });
  return {};
}

std::string Simulation::seek(Words words, const Host&) {
  constexpr Range ranges[] = {{"time", "ms", -1e9, 1e9}};
  double ms = 0;
  if (const std::string refusal = read_numbers(words, ranges, &ms); !refusal.empty())
    return "seek: " + refusal;
  between_ticks([ms](Device& simulated) { simulated.seek(ms * 1e-3); });
  return {};
}

std::string Simulation::press(Words words, const Host&) {
  constexpr Range ranges[] = {{"number", "", 0, 31}, {"state", "", 0, 1}};
  double values[2];
  if (const std::string refusal = read_numbers(words, ranges, values); !refusal.empty())
    return "button: " + refusal;
  between_ticks([&](Device& simulated) {
    simulated.set_button(static_cast<int>(values[0]), values[1] != 0);
  });
  return {};
}

void Simulation::dump(Host& host) const {
  host.info({"path", std::string_view(path_name_)});
  switch (hand_.hold) {
  case Hold::kFree:
    return host.info({"hand", "free"});
  case Hold::kRigid:
    return host.info({"hand", "rigid"});
  case Hold::kSpring:
    return host.info({"hand", "spring", hand_.stiffness_n_per_m, hand_.damping_n_s_per_m});
  case Hold::kPerson:
    return host.info({"hand", "person", hand_.stiffness_n_per_m, hand_.damping_n_s_per_m,
                      hand_.tremor_m * 1e3, hand_.wander_m * 1e3, hand_.yield_s * 1e3});
  }
}

} // namespace tactus::phantom
