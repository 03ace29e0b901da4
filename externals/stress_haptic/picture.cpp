#include "externals/stress_haptic/stress_haptic.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::stress {

namespace {

// A face is sent again when it differs by this much from its last sent state.
constexpr double kStressStep = 1.0 / 128;    // relative to the scale
constexpr double kPositionStep = 1.0 / 2000; // relative to the part's width

bool differs(const PictureFace& a, const PictureFace& b, const Picture& picture) {
  if (!(std::abs(a.stress_pa - b.stress_pa) <= kStressStep * picture.stress_scale_pa))
    return true;
  for (std::size_t k = 0; k < a.corner_m.size(); ++k)
    if (!(std::abs(a.corner_m[k] - b.corner_m[k]) <= kPositionStep * picture.width_m))
      return true;
  return false;
}

} // namespace

void StressHaptic::draw(std::span<const Atom> arguments, Host& host) {
  if (!arguments.empty() && !(arguments[0].is_word && arguments[0].word == "all"))
    return host.error(sentence_of("draw", arguments) + ": expected nothing or all");
  if (!table_ && request_.load > 0) {
    draw_when_loaded_ = true; // the worker is still reading the table
    return;
  }
  if (!has_table("draw", host))
    return;
  if (table_->surface_triangle.empty())
    return host.error("draw: the table has no surface: expected the arrays surface_nodes, "
                      "surface_triangles and surface_node_element");
  if (!arguments.empty())
    sent_faces_.clear();
  request_.picture = ++pictures_;
  submit(host);
}

/// Sends `picture F H scale`, then `face i Pa x1 y1 x2 y2 x3 y3` for each face that has changed,
/// then `point id x y z`.
void StressHaptic::send_picture(Host& host) {
  sent_picture_ = result_.picture_number;
  const Picture& picture = *result_.picture;
  const bool all = sent_faces_.size() != picture.faces.size();
  if (all)
    sent_faces_ = picture.faces;
  std::vector<std::size_t> movable;
  for (std::size_t c = 0; c < table_->control_point_m.size(); ++c)
    if (design::control_point_refusal(table_->parameters, table_->control_point_m.size(),
                                      static_cast<double>(c))
            .empty())
      movable.push_back(c);
  host.info({"picture", static_cast<double>(picture.faces.size()),
             static_cast<double>(movable.size()), picture.stress_scale_pa});
  for (std::size_t f = 0; f < picture.faces.size(); ++f) {
    const PictureFace& face = picture.faces[f];
    if (!all && !differs(face, sent_faces_[f], picture))
      continue;
    sent_faces_[f] = face;
    const auto mm = [&](std::size_t k) { return kMm_per_m * face.corner_m[k]; };
    host.info({"face", static_cast<double>(f), std::clamp(face.stress_pa, -1e38, 1e38), mm(0),
               mm(1), mm(2), mm(3), mm(4), mm(5)});
  }
  for (const std::size_t c : movable) {
    const Vec3 position_mm = (table_->control_point_m[c] + displacement_of(c)) * kMm_per_m;
    host.info({"point", static_cast<double>(c), position_mm.x, position_mm.y, position_mm.z});
  }
}

} // namespace tactus::stress
