#include "core/declaration_text.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/path_message.hpp"
#include "externals/phantom/phantom.hpp"

/// [phantom]'s messages for the simulated device.
namespace tactus {

using namespace phantom;

void Phantom::on_hand(Words words, Host& host) {
  if (!for_simulation("hand", host))
    return;
  using Hold = haptic::HandSettings::Hold;
  haptic::HandSettings hand = simulation_.hand;
  if (is(words[0], "free"))
    hand.hold = Hold::kFree;
  else if (is(words[0], "rigid"))
    hand.hold = Hold::kRigid;
  else if (is(words[0], "spring"))
    hand.hold = Hold::kSpring;
  else if (is(words[0], "person"))
    hand.hold = Hold::kPerson;
  else
    return host.error(expected("hand", words[0], "free, rigid, spring or person"));

  constexpr Range ranges[] = {{"K", "N/m", 0, 20000},
                              {"B", "N s/m", 0, 1000},
                              {"tremor", "mm", 0, 10},
                              {"wander", "mm", 0, 50},
                              {"yield", "ms", 0, 60000}};
  const std::size_t given = words.size() - 1;
  const bool person = hand.hold == Hold::kPerson, spring = hand.hold == Hold::kSpring;
  if (given != 0 && !(spring && given == 2) && !(person && (given == 2 || given == 5)))
    return host.error("hand " + std::string(words[0].word) + ": " +
                      number_text(static_cast<double>(given)) +
                      (given == 1 ? " number" : " numbers") +
                      (spring   ? ": expected none, or K (N/m) and B (N s/m)"
                       : person ? ": expected none, K (N/m) and B (N s/m), or these and tremor "
                                  "(mm), wander (mm) and yield (ms)"
                                : ": expected none"));
  double values[5] = {};
  const std::string refusal = read_numbers(words.subspan(1), std::span(ranges, given), values);
  if (!refusal.empty())
    return host.error("hand: " + refusal);
  if (given >= 2) {
    hand.stiffness_n_per_m = values[0];
    hand.damping_n_s_per_m = values[1];
  }
  if (given == 5) {
    hand.tremor_m = values[2] * 1e-3;
    hand.wander_m = values[3] * 1e-3;
    hand.yield_s = values[4] * 1e-3;
  }
  simulation_.hand = hand;
  apply_simulation_settings();
}

void Phantom::on_path(Words words, Host& host) {
  if (!for_simulation("path", host))
    return;
  PathChoice choice = choose_path(words, host);
  if (!choice.refusal.empty())
    return host.error(choice.refusal);
  path_name_ = words[0].word;
  with_simulation([this, &choice] { simulated_.set_path(std::move(choice.path)); });
}

void Phantom::on_target(Words words, Host& host) {
  if (!for_simulation("target", host))
    return;
  constexpr Range ranges[] = {millimetres("x"), millimetres("y"), millimetres("z")};
  double mm[3];
  const std::string refusal = read_numbers(words, ranges, mm);
  if (!refusal.empty())
    return host.error("target: " + refusal);
  path_name_ = "target";
  with_simulation([this, &mm] { simulated_.set_target(metres(mm)); });
}

void Phantom::on_seek(Words words, Host& host) {
  if (!for_simulation("seek", host))
    return;
  constexpr Range ranges[] = {{"time", "ms", -1e9, 1e9}};
  double ms = 0;
  const std::string refusal = read_numbers(words, ranges, &ms);
  if (!refusal.empty())
    return host.error("seek: " + refusal);
  with_simulation([this, ms] { simulated_.seek(ms * 1e-3); });
}

void Phantom::on_button(Words words, Host& host) {
  if (!for_simulation("button", host))
    return;
  constexpr Range ranges[] = {{"number", "", 0, 31}, {"state", "", 0, 1}};
  double values[2];
  const std::string refusal = read_numbers(words, ranges, values);
  if (!refusal.empty())
    return host.error("button: " + refusal);
  with_simulation(
      [this, &values] { simulated_.set_button(static_cast<int>(values[0]), values[1] != 0); });
}

void Phantom::dump_hand(Host& host) const {
  using Hold = haptic::HandSettings::Hold;
  host.info({"path", std::string_view(path_name_)});
  const auto& hand = simulation_.hand;
  switch (hand.hold) {
  case Hold::kFree:
    host.info({"hand", "free"});
    break;
  case Hold::kRigid:
    host.info({"hand", "rigid"});
    break;
  case Hold::kSpring:
    host.info({"hand", "spring", hand.stiffness_n_per_m, hand.damping_n_s_per_m});
    break;
  case Hold::kPerson:
    host.info({"hand", "person", hand.stiffness_n_per_m, hand.damping_n_s_per_m,
               hand.tremor_m * 1e3, hand.wander_m * 1e3, hand.yield_s * 1e3});
    break;
  }
}

} // namespace tactus
