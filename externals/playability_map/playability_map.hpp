#pragma once

#include "core/reed/instrument/parameters.hpp"
#include "core/reed/playability/gradient_field.hpp"
#include "core/reed/playability/gradient_plane.hpp"
#include "core/rows.hpp"
#include "externals/greed~/settings.hpp"
#include "externals/playability_map/map_store.hpp"
#include "externals/playability_map/map_worker.hpp"

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace tactus::reed {

/// [playability_map]: a map of playability or growth rate over mouth pressure and reed frequency,
/// computed in the background and looked up at the hand's position. docs/guidance.md.
class PlayabilityMapObject {
public:
  static const Declaration declaration;
  static constexpr std::size_t timers = 1;

  PlayabilityMapObject();
  void scalar(std::size_t inlet, double value, Host& host);
  void tick(std::size_t timer, Host& host);
  void dump_first(Host& host);
  void dump(Host& host);

private:
  struct Rows;
  struct Settings {
    bool growth = false;
    double columns = 41, rows = 41; ///< as given; the fraction is ignored
    double bore_frequency_hz = 0, settle_ms = 500, listen_ms = 200, rate_hz = 48000;
    bool background = true;
  };

  [[nodiscard]] const Parameters& parameters() const noexcept { return parameters_; }
  void take(const Parameters& changed) noexcept { parameters_ = changed; }
  void take_preset(const Atom& name, Host& host);
  void take_range(std::span<const Atom> words, Host& host);
  void cancel(Host& host);
  void write(std::span<const Atom> words, Host& host);
  void read(std::span<const Atom> words, Host& host);
  void compute(Host& host);
  void finish(std::span<const double> nodes);
  void draw(Host& host);
  void send_cells(Host& host, std::size_t to);
  /// All settings that the map depends on, as text.
  [[nodiscard]] std::string key() const;
  [[nodiscard]] MapWorker::Portion portion() const;

  Parameters parameters_{};
  ControlRange range_{};
  Settings settings_{};
  double z_ = 0;
  MapStore store_;
  MapWorker worker_;
  std::string working_key_;
  // Size and progress of the map being computed or drawn; field_ is the finished map for look-ups.
  std::size_t columns_ = 0, rows_ = 0, sent_ = 0, total_ = 0;
  unsigned step_ = 0;
  bool growth_ = false, computing_ = false, drawing_ = false;
  GradientField field_;
};

struct PlayabilityMapObject::Rows {
  using Self = PlayabilityMapObject;
  static constexpr std::array<std::string_view, 2> quantities{"f_p", "growth"};
  static constexpr std::array own{
      member<&Self::settings_, &Settings::growth>.row(
          "quantity", quantities,
          "quantity of the map: playability, from playing each node, or growth rate by linear "
          "theory"),
      member<&Self::settings_, &Settings::columns>.row("columns", "", 2, 101,
                                                       "number of nodes along y (mouth pressure)"),
      member<&Self::settings_, &Settings::rows>.row("rows", "", 2, 101,
                                                    "number of nodes along z (reed frequency)"),
      member<&Self::settings_, &Settings::bore_frequency_hz>.row(
          "f_b", "Hz", 0, 4000, "bore frequency; 0: from `own_length`"),
      member<&Self::settings_, &Settings::settle_ms>.row(
          "settle", "ms", 0, 2000, "time for which each node plays before evaluation"),
      member<&Self::settings_, &Settings::listen_ms>.row(
          "listen", "ms", 1, 1000, "time over which a node's f_p is averaged"),
      member<&Self::settings_, &Settings::rate_hz>.row("rate", "Hz", 8000, 96000,
                                                       "sample rate at which nodes are played"),
  };
  static constexpr auto parameters =
      joined(joined(rows_of_field<&Self::parameters, &Self::take, kRows>(), own),
             std::array{member<&Self::settings_, &Settings::background>.row(
                 "background", "switch: 1 computes in a thread; 0 computes eight nodes every 5 ms "
                               "of host time, repeatably")});
  static constexpr std::array messages{
      action<&Self::take_preset>(greed::kPresetMessage),
      action<&Self::take_range>(greed::kRangeMessage),
      action<&Self::compute>("compute", "", 0, 0,
                             "compute the map for the present settings, or load it from memory"),
      action<&Self::compute>("bang", "", 0, 0, "same as `compute`"),
      action<&Self::cancel>("cancel", "", 0, 0, "stop computing and drawing"),
      action<&Self::draw>("draw", "", 0, 0, "send all cells of the finished map again"),
      action<&Self::write>("write", "file", 1, 1, "write all computed maps to a file"),
      takes_file(action<&Self::read>("read", "file", 1, 1, "read maps from a file")),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kControl, "y", "", "y of a look-up (mouth pressure, 0..1); all messages"},
      Port{Port::Kind::kControl, "z", "", "z of the next look-up (reed frequency, 0..1)"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kControl, "value", "", "playability f_p, or growth rate in 1/s, at (y, z)"},
      Port{Port::Kind::kControl, "gradient", "", "list: slope of the value per unit of y and of z"},
      Port{Port::Kind::kControl, "cells", "",
           "cell i k value r g b: node i along y, k along z, colour 0..255; before each drawing: "
           "cells columns rows"},
      Port{Port::Kind::kControl, "progress", "", "computed share of the map, 0..1"},
  };
};

inline constexpr Declaration PlayabilityMapObject::declaration{
    "playability_map",
    "where a reed plays, over mouth pressure and reed frequency",
    "Plays an instrument at every node of a grid, or uses linear theory, in a thread of its own. "
    "Reports progress and coloured cells twenty times a second, then value and slope at any point "
    "of the plane. Maps stay in memory, and a file can store them; the same settings find the same "
    "map.",
    "reed playability map growth guidance heat map",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    greed::kArguments,
    "playability~, greed_gradient~, reed_haptic.pd",
    "how to use it: guidance.md, the model: theory/guidance.md"};

} // namespace tactus::reed
