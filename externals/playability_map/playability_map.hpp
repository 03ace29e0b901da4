#pragma once

#include "core/object.hpp"
#include "core/reed/instrument/parameters.hpp"
#include "core/reed/playability/gradient_field.hpp"
#include "core/reed/playability/gradient_plane.hpp"
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
  static constexpr std::array<std::string_view, 2> kQuantities{"f_p", "growth"};
  static constexpr auto kParameters = greed::with_own(std::array{
      Parameter{"quantity", "", 0, 0, 1,
                "playability by playing every node, or growth rate by theory", kQuantities},
      Parameter{"columns", "", 41, 2, 101, "nodes along y, mouth pressure"},
      Parameter{"rows", "", 41, 2, 101, "nodes along z, reed frequency"},
      Parameter{"f_b", "Hz", 0, 0, 4000, "bore frequency; 0: the parameter own_length"},
      Parameter{"settle", "ms", 500, 0, 2000, "time a node is given to speak"},
      Parameter{"listen", "ms", 200, 1, 1000, "time over which its f_p is averaged"},
      Parameter{"rate", "Hz", 48000, 8000, 96000, "sample rate at which nodes are played"},
      Parameter{"background", "", 1, 0, 1,
                "0: eight nodes every 5 ms of the host's time; repeatable"},
  });
  static constexpr std::array kInlets{
      Port{Port::Kind::kControl, "y", "", "look up at this y, and all messages"},
      Port{Port::Kind::kControl, "z", "", "z of the next look-up"},
  };
  static constexpr std::array kOutlets{
      Port{Port::Kind::kControl, "value", "", "f_p, or growth rate in 1/s, at (y, z)"},
      Port{Port::Kind::kControl, "gradient", "", "list: its slope for one unit of y and of z"},
      Port{Port::Kind::kControl, "cells", "",
           "cell i k value r g b: node i along y, k along z, colour 0..255; at the start of each "
           "drawing: cells columns rows"},
      Port{Port::Kind::kControl, "progress", "", "0..1"},
  };
  static constexpr std::array kMessages{
      Message{"preset", "clarinet|sax|oboe|trumpet|trombone|voice|syrinx", 1, 1,
              "all of valve and bore at once, and a range in which it plays"},
      Message{"range", "p_lo p_hi f_lo f_hi", 4, 4, "what 0 and 1 of y (Pa) and z (Hz) stand for"},
      Message{"compute", "", 0, 0, "make the map of the present settings, or find it again"},
      Message{"bang", "", 0, 0, "the same"},
      Message{"cancel", "", 0, 0, "stop computing and drawing"},
      Message{"draw", "", 0, 0, "send all cells of the finished map again"},
      Message{"write", "file", 1, 1, "keep all maps made so far in a file"},
      takes_file(Message{"read", "file", 1, 1, "find maps of a file again"}),
  };
  static constexpr std::array kArguments{CreationArgument{"preset"}};
  static constexpr Declaration declaration{
      "playability_map",
      "where a reed plays, over mouth pressure and reed frequency",
      "Plays an instrument at every node of a grid, or asks linear theory, in a thread of its own; "
      "reports progress and coloured cells twenty times a second, and afterwards value and slope "
      "at any place in the plane. Maps are found again by their settings, in memory or in a file.",
      "reed playability map growth guidance heat map",
      kInlets,
      kOutlets,
      kParameters,
      kMessages,
      kArguments,
      "playability~, greed_gradient~, reed_haptic.pd",
      "guidance: guidance.md"};
  static constexpr std::size_t timers = 1;

  PlayabilityMapObject();
  void set(std::size_t parameter, double value) noexcept;
  [[nodiscard]] double get(std::size_t parameter) const noexcept;
  void message(std::size_t index, std::span<const Atom> arguments, Host& host);
  void scalar(std::size_t inlet, double value, Host& host);
  void tick(std::size_t timer, Host& host);
  void dump_first(Host& host);
  void dump(Host& host);

private:
  enum OwnParameter : std::size_t {
    kQuantity,
    kColumns,
    kRows,
    kBoreFrequency,
    kSettle,
    kListen,
    kRate,
    kBackground,
    kOwnCount
  };
  static constexpr std::size_t kFirstOwn = greed::kParameters.size();

  [[nodiscard]] std::size_t count(OwnParameter p) const noexcept {
    return static_cast<std::size_t>(own_[p]);
  }
  void compute(Host& host);
  void finish(std::span<const double> nodes);
  void draw(Host& host);
  void send_cells(Host& host, std::size_t to);
  /// All settings that the map depends on, as text.
  [[nodiscard]] std::string key() const;
  [[nodiscard]] MapWorker::Portion portion() const;

  Parameters parameters_{};
  ControlRange range_{};
  std::array<double, kOwnCount> own_{};
  double z_ = 0;
  MapStore store_;
  MapWorker worker_;
  std::string working_key_;
  // The map being computed or drawn; field_ is the finished one for look-ups.
  std::size_t columns_ = 0, rows_ = 0, sent_ = 0, total_ = 0;
  unsigned step_ = 0;
  bool growth_ = false, computing_ = false, drawing_ = false;
  GradientField field_;
};

} // namespace tactus::reed
