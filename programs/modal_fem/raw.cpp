#include "programs/modal_fem/raw.hpp"

#include "core/dsp/complex.hpp"
#include "fem/io/text.hpp"
#include "fem/radiation/acoustic_skin.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

namespace tactus::fem {
namespace {

using modal::BodyModel;
using modal::LoadedTable;
using modal::SurfacePoint;

struct Grid {
  std::vector<SurfacePoint> point;
  std::vector<double> area_m2;
};

Vec3 unit(const Vec3& v) { return v * (1 / norm(v)); }
Vec3 area_of(const std::array<Vec3, 3>& c) {
  const Vec3 a = c[1] - c[0], b = c[2] - c[0];
  return 0.5 * Vec3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// For a plate, excludes the rim, which faces sideways. For other bodies, selects the half that
/// faces the side.
bool faces_toward(const Vec3& area, const Vec3& side, bool flat) {
  return dot(area, side) > (flat ? .5 : 0) * norm(area);
}

Grid every_triangle(const modal::Surface& surface, const Vec3& side, bool flat) {
  Grid grid;
  for (std::size_t t = 0; t < surface.triangles(); ++t) {
    const Vec3 area = area_of(surface.corners(t));
    if (!faces_toward(area, side, flat))
      continue;
    grid.point.push_back(surface.on(t, 1. / 3, 1. / 3));
    grid.area_m2.push_back(norm(area));
  }
  return grid;
}

/// Centres of a coarser skin's triangles, projected onto the body; the sum of their areas is the
/// body's area.
Grid coarse_grid(const modal::ModalTable& table, const modal::Surface& surface, const Vec3& side,
                 bool flat, std::size_t points, const Grid& whole) {
  AcousticSkin skin;
  for (const Vec3& v : table.vertex_m)
    skin.vertex.push_back({v.x, v.y, v.z});
  skin.triangle.assign(table.triangle.begin(), table.triangle.end());
  const auto share =
      static_cast<double>(whole.point.size()) / static_cast<double>(surface.triangles());
  skin = with_triangles(skin, static_cast<std::size_t>(static_cast<double>(points) / share));
  Grid grid;
  double sum = 0, all = 0;
  for (const double a : whole.area_m2)
    all += a;
  for (const auto& t : skin.triangle) {
    std::array<Vec3, 3> corner;
    for (std::size_t j = 0; j < 3; ++j) {
      const Vec3& v = skin.vertex[static_cast<std::size_t>(t[j])];
      corner[j] = {v.x, v.y, v.z};
    }
    const Vec3 area = area_of(corner);
    if (!faces_toward(area, side, flat))
      continue;
    grid.point.push_back(surface.nearest((corner[0] + corner[1] + corner[2]) * (1. / 3)));
    grid.area_m2.push_back(norm(area));
    sum += norm(area);
  }
  for (double& a : grid.area_m2)
    a *= all / sum;
  return grid;
}

/// Centres of `points` rings along one radius; each has the area of its whole ring.
Grid rings(const modal::Surface& surface, const RawSettings& settings, const Grid& whole) {
  Vec3 middle{};
  double all = 0, top = -1e300;
  for (std::size_t i = 0; i < whole.point.size(); ++i) {
    middle += whole.area_m2[i] * whole.point[i].position;
    all += whole.area_m2[i];
    top = std::max(top, dot(whole.point[i].position, settings.side));
  }
  middle = middle * (1 / all);
  const double radius = std::sqrt(all / std::numbers::pi);
  const Vec3 z = settings.side;
  const Vec3 x = unit(std::abs(z.x) < .9 ? Vec3{1, 0, 0} - z.x * z : Vec3{0, 1, 0} - z.y * z);
  const Vec3 y{z.y * x.z - z.z * x.y, z.z * x.x - z.x * x.z, z.x * x.y - z.y * x.x};
  const Vec3 along = std::cos(settings.ring_angle_rad) * x + std::sin(settings.ring_angle_rad) * y;
  Grid grid;
  const double step = radius / static_cast<double>(settings.points);
  for (std::size_t i = 0; i < settings.points; ++i) {
    const double r = step * static_cast<double>(i);
    const Vec3 at = middle + (r + step / 2) * along;
    grid.point.push_back(surface.nearest(at + (top - dot(at, z)) * z));
    grid.area_m2.push_back(std::numbers::pi * ((r + step) * (r + step) - r * r));
  }
  return grid;
}

/// Force of a striker at 1 m/s in N, as its mean over each short step.
std::vector<double> contact_force(const std::shared_ptr<const LoadedTable>& loaded,
                                  const RawSettings& settings, const Vec3& strike_position,
                                  double rate) {
  modal::BodySettings body;
  body.sample_rate = rate;
  body.radiation = modal::Radiation::kNone;
  auto struck_body = std::make_unique<modal::StruckBody>();
  struck_body->prepare(rate);
  struck_body->publish(std::make_unique<BodyModel>(loaded, body), false);
  struck_body->adopt();
  struck_body->set_striker(settings.striker);
  const SurfacePoint at = struck_body->model()->nearest(strike_position);
  if (!struck_body->hit({at, at.normal, 1}))
    throw InputError("the strike could not start");
  constexpr std::size_t kBlock = 64;
  std::array<float, kBlock> silence{}, left{}, right{}, contact{};
  std::vector<double> force;
  const auto longest = static_cast<std::size_t>(std::min(settings.seconds, .1) * rate);
  while (struck_body->contacts() > 0 && force.size() < longest) {
    const std::array<std::span<float>, 2> out{left, right};
    struck_body->process<float>(silence, silence, out, contact);
    force.insert(force.end(), contact.begin(), contact.end());
  }
  return force;
}

/// True for a plate: most of the skin faces `side` or its opposite.
bool is_flat(const modal::Surface& surface, const Vec3& side) {
  double seen = 0, flat_area = 0, all = 0;
  for (std::size_t t = 0; t < surface.triangles(); ++t) {
    const Vec3 area = area_of(surface.corners(t));
    all += norm(area);
    seen += std::abs(dot(area, side));
    flat_area += std::abs(dot(area, side)) > .9 * norm(area) ? norm(area) : 0;
  }
  return seen > .6 * all && flat_area > .6 * all;
}

/// The surface elements whose velocities are computed. `settings.side` has length 1.
Grid grid_of(const modal::ModalTable& table, const modal::Surface& surface,
             const RawSettings& settings) {
  const bool flat = is_flat(surface, settings.side);
  Grid whole = every_triangle(surface, settings.side, flat);
  if (whole.point.empty())
    throw InputError("no face of the body points towards --side");
  if (settings.ring)
    return rings(surface, settings, whole);
  if (settings.points == 0)
    return whole;
  return coarse_grid(table, surface, settings.side, flat, settings.points, whole);
}

/// A table of the right size without velocities. Refuses a table of more than 3 GB.
modal::RawTable empty_table(const Grid& grid, const RawSettings& settings) {
  modal::RawTable out;
  out.hits = settings.hit_m.size();
  out.points = grid.point.size();
  out.samples = static_cast<std::size_t>(std::ceil(settings.seconds * settings.sample_rate));
  const double bytes = 4.0 * static_cast<double>(out.hits) * static_cast<double>(out.points) *
                       static_cast<double>(out.samples);
  if (bytes > 3e9)
    throw InputError(
        format("the velocities would take %.1f GB: use fewer --points, --hit positions or "
               "--seconds",
               bytes / 1e9));
  out.sample_rate_hz = settings.sample_rate;
  out.area_m2 = grid.area_m2;
  for (const SurfacePoint& p : grid.point)
    out.position_m.push_back(p.position);
  out.velocity_m_per_s.resize(out.hits * out.points * out.samples);
  return out;
}

/// phi . n of every mode at every point, [point][mode].
std::vector<float> normal_gains(const BodyModel& model, const Grid& grid) {
  const std::size_t modes = model.audible_modes;
  std::vector<float> normal(grid.point.size() * modes);
  std::vector<double> gain(model.mode.size());
  for (std::size_t p = 0; p < grid.point.size(); ++p) {
    model.gains(grid.point[p], grid.point[p].normal, gain);
    for (std::size_t k = 0; k < modes; ++k)
      normal[p * modes + k] = static_cast<float>(-gain[k]);
  }
  return normal;
}

/// Modal velocities after a strike at a point, [sample][mode]. `force` has `finer` steps per
/// sample.
std::vector<float> modal_velocities(const BodyModel& model, const SurfacePoint& at,
                                    std::span<const double> force, std::size_t finer,
                                    const RawSettings& settings, std::size_t samples) {
  const double step = 1 / (settings.sample_rate * static_cast<double>(finer));
  const std::size_t modes = model.audible_modes;
  std::vector<float> velocity(samples * modes);
  std::vector<double> gain(model.mode.size());
  model.gains(at, at.normal, gain);
  for (std::size_t k = 0; k < modes; ++k) {
    const Complex s = model.rate[k], turn = math::exp(s * step);
    // z = q' + alpha q + j omega q; a force that is constant over a step adds b F (exp(sT) - 1)/s.
    const Complex push = gain[k] * (turn - 1.0) / s;
    Complex z = gain[k] * settings.impulse_n_s;
    for (std::size_t n = 0, fine = 0; n < samples; ++n) {
      velocity[n * modes + k] = static_cast<float>(z.real() + s.real() / s.imag() * z.imag());
      for (std::size_t i = 0; i < finer; ++i, ++fine)
        z = turn * z + (fine < force.size() ? push * force[fine] : 0.0);
    }
  }
  return velocity;
}

} // namespace

modal::RawTable make_raw(const modal::ModalTable& table, const RawSettings& given) {
  if (table.shape.empty())
    throw InputError("the table has no mode shapes: expected one with phi");
  if (given.hit_m.empty())
    throw InputError("no strike position: expected --hit X,Y,Z");
  RawSettings settings = given;
  settings.side = unit(given.side);
  const auto loaded = std::make_shared<const LoadedTable>(table);
  const modal::Surface& surface = loaded->surface;
  const Grid grid = grid_of(table, surface, settings);
  modal::BodySettings body;
  body.sample_rate = settings.sample_rate;
  body.radiation = modal::Radiation::kNone;
  const BodyModel model(loaded, body);
  modal::RawTable out = empty_table(grid, settings);
  const std::size_t modes = model.audible_modes;
  const std::vector<float> normal = normal_gains(model, grid);
  const auto finer =
      static_cast<std::size_t>(std::clamp(std::floor(1e6 / settings.sample_rate), 1.0, 16.0));
  const double step = 1 / (settings.sample_rate * static_cast<double>(finer));
  for (std::size_t h = 0; h < out.hits; ++h) {
    const SurfacePoint at = model.nearest(settings.hit_m[h]);
    if (at.distance > .1 * surface.diagonal())
      throw InputError(format("--hit %zu lies %.3g mm off the body", h + 1, 1e3 * at.distance));
    out.hit_m.push_back(at.position);
    const std::vector<double> force = settings.impulse_n_s > 0
                                          ? std::vector<double>{}
                                          : contact_force(loaded, settings, at.position, 1 / step);
    const std::vector<float> velocity =
        modal_velocities(model, at, force, finer, settings, out.samples);
    for (std::size_t p = 0; p < out.points; ++p)
      for (std::size_t n = 0; n < out.samples; ++n) {
        float sum = 0;
        for (std::size_t k = 0; k < modes; ++k)
          sum += normal[p * modes + k] * velocity[n * modes + k];
        out.velocity_m_per_s[(h * out.points + p) * out.samples + n] = sum;
      }
  }
  return out;
}

} // namespace tactus::fem
