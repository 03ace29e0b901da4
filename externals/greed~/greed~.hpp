#pragma once

#include "core/declaration_text.hpp"
#include "core/reed/instrument/instrument.hpp"
#include "core/rows.hpp"
#include "externals/greed~/settings.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string>

namespace tactus {

/// [greed~]: a pressure-controlled valve on a bore (core/reed/instrument/instrument.hpp) in a
/// patch.
class Greed {
public:
  static const Declaration declaration;
  static constexpr bool multichannel = true;

  void prepare(double sample_rate, std::size_t max_block) {
    instrument_.prepare(sample_rate, max_block);
  }
  template <class S> void process(const Block<S>& block) noexcept {
    instrument_.process<S>({block.in(0), block.in(1), block.in(2)},
                           {block.out(0), block.out(1), block.out(2), block.out(3)});
  }

  /// After each block: sends the last refused note with the limits of the compass, once.
  void report(Host& host) {
    const reed::Refusal& refusal = instrument_.refusal();
    if (refusal.count == reported_refusals_)
      return;
    reported_refusals_ = refusal.count;
    const reed::Parameters& now = instrument_.parameters();
    host.info({"range", refusal.note, now.lowest_note, now.highest_note});
  }

  void dump_first(Host& host) { greed::dump_preset(instrument_.parameters(), host); }
  void dump(Host& host) {
    const reed::Parameters& now = instrument_.parameters();
    host.info({"P_M", reed::closing_pressure(now)});
    host.info({"zeta", reed::strength(now)});
    host.info({"L", instrument_.length()});
    std::array<Atom, 4> valves{"valves", "auto", 0.0, 0.0};
    std::size_t count = now.valves < 0 ? 2 : 1;
    for (int valve = 0; valve < 3 && now.valves >= 0; ++valve)
      if ((now.valves >> valve & 1) != 0)
        valves[count++] = valve + 1;
    host.info(std::span<const Atom>(valves).first(count));
  }

private:
  struct Rows;

  [[nodiscard]] const reed::Parameters& parameters() const noexcept {
    return instrument_.parameters();
  }
  void take(const reed::Parameters& changed) noexcept { instrument_.set(changed); }
  void restart() noexcept { instrument_.restart(); }
  [[nodiscard]] double fingering() const noexcept { return parameters().fingering; }
  void set_fingering(double note) noexcept {
    reed::Parameters changed = parameters();
    changed.fingering = note;
    instrument_.release_holes();
    instrument_.set(changed);
  }
  void articulate() noexcept { instrument_.articulate(); }
  void bang(Host& host) {
    if (!parameters().tune)
      return host.error("bang: expected tune 1, with which the player tongues the note; without it "
                        "the mouth pressure p_m alone makes the sound");
    instrument_.articulate();
  }
  void take_preset(const Atom& name, Host& host) {
    if (const auto preset = greed::preset_of(name, parameters(), host))
      instrument_.set(*preset);
  }
  void set_valves(std::span<const Atom> arguments, Host& host) {
    reed::Parameters changed = instrument_.parameters();
    if (changed.end != reed::BoreEnd::kTrumpet)
      return host.error("valves: expected end trumpet, which has valves");
    changed.valves = 0;
    if (arguments.size() == 1 && arguments[0].is_word && arguments[0].word == "auto")
      changed.valves = -1;
    else
      for (const Atom& valve : arguments) {
        const bool usable =
            !valve.is_word && (valve.number == 1 || valve.number == 2 || valve.number == 3);
        const int bit = usable ? 1 << (static_cast<int>(valve.number) - 1) : 0;
        if (!usable || (changed.valves & bit) != 0)
          return host.error("valves " +
                            (valve.is_word ? std::string(valve.word) : number_text(valve.number)) +
                            ": expected valves of 1, 2 and 3, each once, none, or auto");
        changed.valves |= bit;
      }
    instrument_.set(changed);
  }

  void finger(std::span<const Atom> arguments, Host& host) {
    const reed::Woodwind* const wind = reed::woodwind(instrument_.parameters().end);
    if (wind == nullptr)
      return host.error("holes: expected end clarinet, saxophone or oboe, which have tone holes");
    std::array<double, reed::Woodwind::kMaxToneHoles + 1> closed{};
    const std::size_t count = wind->tone_holes() + 1;
    bool usable = arguments.size() == count;
    std::string given = std::to_string(arguments.size()) + " numbers";
    for (std::size_t i = 0; i < count && usable; ++i) {
      usable = !arguments[i].is_word && arguments[i].number >= 0 && arguments[i].number <= 1;
      closed[i] = arguments[i].number;
      if (!usable)
        given = arguments[i].is_word ? std::string(arguments[i].word)
                                     : number_text(arguments[i].number);
    }
    if (!usable)
      return host.error("holes: " + given + ": expected " + std::to_string(count) +
                        " numbers in 0..1, the register vent, then the holes from the reed down: "
                        "1 closed, 0 open");
    if (!instrument_.finger_holes(std::span(closed).first(count)))
      host.error("holes: no filter found for this fingering: expected another one");
  }

  reed::Instrument instrument_;
  unsigned reported_refusals_ = 0; // Refusal::count at the last report
};

struct Greed::Rows {
  /// The core's parameters. Setting `fingering` also ends the message `holes`.
  static constexpr auto parameters = [] {
    auto all = rows_of_field<&Greed::parameters, &Greed::take, reed::kRows>();
    for (Parameter& row : all)
      if (row.name == "fingering")
        row.set = property<&Greed::fingering, &Greed::set_fingering>.row("", "", 0, 0, 0, "").set;
    return all;
  }();
  static constexpr std::array messages{
      action<&Greed::take_preset>(greed::kPresetMessage),
      realtime(action<&Greed::restart>("reset", "", 0, 0, "stop all motion of valve and air")),
      realtime(
          action<&Greed::articulate>("tongue", "", 0, 0, "tongue the note again, with `tune 1`")),
      action<&Greed::finger>(
          "holes", "CLOSED...", 1, 33,
          "states of register vent and tone holes from the reed down, with `tune 1`: 1: closed, 0: "
          "open, between: partly covered; `fingering` replaces them"),
      action<&Greed::set_valves>("valves", "[VALVE...|auto]", 0, 3,
                                 "pressed valves, any of 1 2 3, with `tune 1` and `end trumpet`; "
                                 "auto: the player chooses"),
      realtime(action<&Greed::bang>("bang", "", 0, 0, "tongue the note again, with `tune 1`")),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kSignal, "p_m", "Pa", "mouth pressure"},
      Port{Port::Kind::kSignal, "f_r", "Hz",
           "natural frequency of the valve; 0: the parameter `f_r`"},
      Port{Port::Kind::kSignal, "f_b", "Hz", "bore frequency; 0: from `own_length`"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kSignal, "sound", "", "radiated pressure times `gain`, within +-1"},
      Port{Port::Kind::kSignal, "theta", "rad", "angle of the valve"},
      Port{Port::Kind::kSignal, "p_b", "Pa", "pressure in the bore at the valve"},
      Port{Port::Kind::kSignal, "U", "m^3/s", "volume flow through the valve"},
  };
};

inline constexpr Declaration Greed::declaration{
    "greed~",
    "generalised pressure-controlled valve on a bore",
    "Mouth pressure drives a reed, lips, vocal folds or a syrinx on a cylindrical or conical bore. "
    "The sign of the rest angle and a stop make the valve blown closed, blown open or a swinging "
    "door. All parameters have SI units and can change while it sounds.",
    "physical model reed lips wind instrument waveguide synthesis",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    greed::kArguments,
    "playability~, greed_gradient~, wind_controller.pd",
    "how to use it: greed.md, the model: theory/greed.md, "
    "wind controllers: wind_controller.md",
    "fanfare/fanfare.wav: two trumpets and two trombones"};

} // namespace tactus
