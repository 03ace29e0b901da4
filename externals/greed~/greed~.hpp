#pragma once

#include "core/object.hpp"
#include "core/reed/instrument.hpp"
#include "core/words.hpp"
#include "externals/greed~/declaration.hpp"
#include "externals/greed~/settings.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <string>

namespace tactus {

/// [greed~]: a pressure-controlled valve on a bore (core/reed/instrument.hpp) in a patch.
class Greed {
public:
  static constexpr Declaration declaration{
      "greed~",
      "generalised pressure-controlled valve on a bore",
      "A reed, a pair of lips, vocal folds or a syrinx, blown by a mouth pressure on a cylindrical "
      "or conical bore: blown closed, blown open or swinging door, by the sign of its rest angle "
      "and a stop. Everything is in SI units and can be changed while it sounds.",
      "physical model reed lips wind instrument waveguide synthesis",
      greed::kInlets,
      greed::kOutlets,
      greed::kParameters,
      greed::kMessages};
  static constexpr bool multichannel = true;

  void prepare(double sample_rate, std::size_t max_block) {
    instrument_.prepare(sample_rate, max_block);
  }
  void set(std::size_t parameter, double value) noexcept {
    reed::Parameters changed = instrument_.parameters();
    greed::kMembers[parameter].set(changed, value);
    if (greed::kParameters[parameter].name == "fingering") instrument_.release_holes();
    instrument_.set(changed);
  }
  [[nodiscard]] double get(std::size_t parameter) const noexcept {
    return greed::kMembers[parameter].get(instrument_.parameters());
  }

  void message(std::size_t index, std::span<const Atom> arguments, Host& host) {
    if (index == greed::kReset) return instrument_.restart();
    if (index == greed::kTongue) return instrument_.articulate();
    if (index == greed::kHoles) return finger(arguments, host);
    if (const auto preset = greed::preset_of(arguments[0], instrument_.parameters(), host))
      instrument_.set(*preset);
  }

  template <class S> void process(const Block<S>& block) noexcept {
    instrument_.process<S>(block.in(0), block.in(1), block.in(2), block.out(0), block.out(1),
                           block.out(2), block.out(3));
  }

  /// Notes that were refused since: one message each, with the limits.
  void report(Host& host) {
    const reed::Refusal& refusal = instrument_.refusal();
    if (refusal.count == told_) return;
    told_ = refusal.count;
    const reed::Parameters& now = instrument_.parameters();
    host.info({"range", refusal.note, now.lowest_note, now.highest_note});
  }

  void dump(Host& host) {
    const reed::Parameters& now = instrument_.parameters();
    host.info({"P_M", reed::closing_pressure(now)});
    host.info({"zeta", reed::strength(now)});
    host.info({"L", instrument_.length()});
  }

private:
  void finger(std::span<const Atom> arguments, Host& host) {
    const reed::Woodwind* const wind = reed::woodwind(instrument_.parameters().end);
    if (wind == nullptr)
      return host.error("holes: expected end clarinet, saxophone or oboe, which have tone holes");
    std::array<double, reed::Woodwind::kMaxToneHoles + 1> closed{};
    const std::size_t count = wind->tone_holes() + 1;
    bool usable = arguments.size() == count;
    std::string given = std::to_string(arguments.size()) + " of them";
    for (std::size_t i = 0; i < count && usable; ++i) {
      usable = !arguments[i].is_word && arguments[i].number >= 0 && arguments[i].number <= 1;
      closed[i] = arguments[i].number;
      if (!usable) given = arguments[i].is_word ? std::string(arguments[i].word) : number_text(arguments[i].number);
    }
    if (!usable)
      return host.error("holes: " + given + ", expected " + std::to_string(count) +
                        " numbers in 0..1, the register vent and then the holes from the reed down: "
                        "1 closed, 0 open");
    if (!instrument_.finger_holes(std::span(closed).first(count)))
      host.error("holes: found no filter for these, expected another fingering");
  }

  reed::Instrument instrument_;
  unsigned told_ = 0; // of the notes refused
};

}  // namespace tactus
