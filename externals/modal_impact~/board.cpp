#include "core/declaration_text.hpp"
#include "core/refusal.hpp"
#include "externals/modal_impact~/modal_impact~.hpp"

#include <cmath>
#include <utility>
#include <vector>

/// The board on which the body lies: the messages `board` and `rest`.
namespace tactus::modal {

using namespace modal_impact;

namespace {

constexpr double kGapWarningRatio = 0.1; // relative to the diagonal of the box around both

bool is_position(const Atom& atom) { return !atom.is_word && std::abs(atom.number) <= kFarthest; }

} // namespace

void ModalImpact::set_board(std::span<const Atom> arguments, Host& host) {
  const bool displaced = arguments.size() == 4;
  if (!arguments[0].is_word || (arguments.size() != 1 && !displaced))
    return host.error(
        refusal("board", arguments, "the name of a file, optionally dx dy dz, or none"));
  TableFile board{{}, std::string(arguments[0].word), wanted_.board.number + 1};
  Vec3 displacement_m{};
  if (displaced) {
    for (std::size_t i = 1; i < 4; ++i)
      if (!is_position(arguments[i]))
        return host.error(refusal("board", arguments, "dx dy dz in -1e+06..1e+06 mm"));
    displacement_m =
        kMillimetre * Vec3{arguments[1].number, arguments[2].number, arguments[3].number};
  }
  if (board.name != "none" || displaced) {
    board.path = find_table("board", board.name, host);
    if (board.path.empty())
      return;
  } else if (table_ && table_->parts.empty() && answered_ == worker_.requested()) {
    return;
  }
  wanted_.board = std::move(board);
  wanted_.board_displacement_m = displacement_m;
  request(at_once(), host);
  body_change_ = worker_.requested();
}

void ModalImpact::set_rest(Numbers n, Host& host) {
  if (n.size() % 3 != 0)
    return host.error("rest: " + number_text(static_cast<double>(n.size())) +
                      " numbers: expected x y z for each point, or nothing");
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < n.size(); i += 3) {
    for (std::size_t axis = i; axis < i + 3; ++axis)
      if (!(std::abs(n[axis]) <= kFarthest))
        return host.error("rest: " + number_text(n[axis]) + " mm: expected -1e+06..1e+06");
    points.push_back(kMillimetre * Vec3{n[i], n[i + 1], n[i + 2]});
  }
  change(settings_.rest.point_m, points);
}

bool ModalImpact::accept_support(const BodyModel& model, bool same_table, Host* host) {
  const RestSettings& rest = model.settings.rest;
  if (model.resting_refusal.empty()) {
    last_valid_.rest = rest;
    const double far = kGapWarningRatio * model.settings.size * model.loaded->surface.diagonal();
    if (host && !model.resting_contacts.empty() && model.largest_gap_m > far)
      host->log("the points of rest are up to " + number_text(1000 * model.largest_gap_m) +
                " mm from the board: the layer between them is assumed to have that thickness");
    return true;
  }
  if (host)
    host->error("rest: " + model.resting_refusal);
  // Restores the last valid points if they differ and belong to the same table; else removes all
  // points.
  const bool another = same_table && !(last_valid_.rest == rest);
  if (another)
    settings_.rest = last_valid_.rest;
  else
    settings_.rest.point_m.clear();
  last_valid_.rest = {};
  return !another;
}

} // namespace tactus::modal
