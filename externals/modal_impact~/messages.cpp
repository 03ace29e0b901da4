#include "core/contact/friction_rows.hpp"
#include "core/contact/strike_scatter.hpp"
#include "core/declaration_text.hpp"
#include "core/dsp/elementary.hpp"
#include "core/modal/table/materials.hpp"
#include "core/refusal.hpp"
#include "core/sentence.hpp"
#include "externals/modal_impact~/modal_impact~.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace tactus::modal {

using namespace modal_impact;

namespace {

constexpr double kFastest = 50;               // m/s
constexpr double kDistanceWarningRatio = 0.1; // relative to the body's diagonal

/// The range of a number of a message.
struct Range {
  std::string_view name, unit;
  double lowest, highest;
};

/// True if all numbers are in their ranges; else reports the first that is not.
bool within(std::string_view message, std::span<const double> numbers,
            std::initializer_list<Range> ranges, Host& host) {
  std::size_t i = 0;
  for (const Range& range : ranges) {
    if (i >= numbers.size())
      break;
    const double x = numbers[i++];
    if (x >= range.lowest && x <= range.highest)
      continue;
    Sentence sentence(message);
    for (const std::string_view part : {std::string_view(": "), range.name, std::string_view(" ")})
      sentence += part;
    sentence += number_text(x);
    if (!range.unit.empty()) {
      sentence += " ";
      sentence += range.unit;
    }
    sentence += ": expected ";
    sentence += number_text(range.lowest);
    sentence += "..";
    sentence += number_text(range.highest);
    host.error(sentence);
    return false;
  }
  return true;
}

void refuse_words(const Message& message, std::span<const Atom> given, Host& host) {
  Sentence expected("numbers (");
  expected += message.arguments;
  expected += ")";
  host.error(refusal(message.name, given, expected));
}

/// A vector of two components at right angles to a direction of length 1.
Vec3 across(const Vec3& direction, const std::array<double, 2>& component) noexcept {
  const Vec3 axis = std::abs(direction.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 normal = cross(direction, axis), first = normal * (1 / norm(normal));
  return component[0] * first + component[1] * cross(direction, first);
}

constexpr Range kX{"x", "mm", -kFarthest, kFarthest}, kY{"y", "mm", -kFarthest, kFarthest},
    kZ{"z", "mm", -kFarthest, kFarthest}, kSpeed{"v", "m/s", 1e-6, kFastest};

} // namespace

void ModalImpact::carry_out(const Message& row, std::span<const Atom> arguments,
                            void (ModalImpact::*handler)(Numbers, Host&), Waits waits, Host& host) {
  host_ = &host;
  for (const Atom& atom : arguments)
    if (atom.is_word || !std::isfinite(atom.number))
      return refuse_words(row, arguments, host);
  // Realtime messages have few numbers, and allocate nothing.
  std::array<double, kFewNumbers> few{};
  std::vector<double> many;
  if (arguments.size() > few.size())
    many.resize(arguments.size());
  const std::span<double> numbers =
      (many.empty() ? std::span<double>(few) : std::span<double>(many)).first(arguments.size());
  std::transform(arguments.begin(), arguments.end(), numbers.begin(),
                 [](const Atom& atom) { return atom.number; });
  if (!must_wait(row, numbers, handler, waits, host))
    (this->*handler)(numbers, host);
}

void ModalImpact::warn_if_far(const SurfacePoint& point, Host& host) {
  const BodyModel* model = body_.model();
  const double diagonal =
      model->loaded->surface.empty() ? 0 : model->loaded->surface.diagonal() * model->settings.size;
  if (warned_ || point.distance <= kDistanceWarningRatio * diagonal || diagonal == 0)
    return;
  warned_ = true;
  Sentence sentence("the point is ");
  sentence += number_text(point.distance * 1000);
  sentence += " mm off the body: using the nearest point of its surface (reported once)";
  host.log(sentence);
}

void ModalImpact::warn_if_still(std::string_view message, const SurfacePoint& point,
                                const Vec3& direction, Host& host) {
  if (warned_still_ || body_.model()->loaded->surface.empty() ||
      body_.model()->moves_along(point, direction))
    return;
  warned_still_ = true;
  Sentence sentence(message);
  sentence += ": no mode of this table moves the surface along this direction, so it gives "
              "no sound (reported once)";
  host.log(sentence);
}

void ModalImpact::strike(const SurfacePoint& point, double speed, Host& host, bool falls) {
  warn_if_far(point, host);
  warn_if_still("hit", point, normal_.value_or(point.normal), host);
  last_point_ = point;
  last_speed_ = speed;
  last_was_drop_ = falls;
  body_.schedule(varied({point, normal_.value_or(point.normal), speed, falls}), sample_now(host));
}

Hit ModalImpact::varied(Hit hit) noexcept {
  if (variation_ <= 0)
    return hit;
  const BodyModel& model = *body_.model();
  const Surface& surface = model.loaded->surface;
  const double size = model.settings.size;
  const auto scatter = contact::StrikeScatter::draw(
      variation_, surface.empty() ? 0 : size * surface.diagonal(), random_);
  hit.speed_m_per_s *= scatter.speed_factor;
  if (surface.empty())
    return hit;
  hit.point = model.nearest(size * hit.point.position + across(hit.point.normal, scatter.offset_m));
  hit.direction = hit.direction + across(hit.direction, {math::tan(scatter.tilt_rad[0]),
                                                         math::tan(scatter.tilt_rad[1])});
  hit.direction = hit.direction * (1 / norm(hit.direction));
  return hit;
}

void ModalImpact::hit(Numbers n, Host& host) {
  if (n.size() != 1 && n.size() != 4)
    return host.error("hit: expected v, or x y z v");
  if (n.size() == 4 ? !within("hit", n, {kX, kY, kZ, kSpeed}, host)
                    : !within("hit", n, {kSpeed}, host))
    return;
  const BodyModel* model = body(host);
  if (!model)
    return;
  if (n.size() == 4)
    return strike(model->nearest(kMillimetre * Vec3{n[0], n[1], n[2]}), n[3], host);
  strike(last_point_.value_or(body_.point()), n[0], host);
}

void ModalImpact::drop(Numbers n, Host& host) {
  if (n.size() != 1 && n.size() != 4)
    return host.error("drop: expected h, or x y z h");
  constexpr Range kHeight{"h", "mm", 1e-3, 100000};
  if (n.size() == 4 ? !within("drop", n, {kX, kY, kZ, kHeight}, host)
                    : !within("drop", n, {kHeight}, host))
    return;
  const BodyModel* model = body(host);
  if (!model)
    return;
  const double speed = std::sqrt(2 * kGravity * kMillimetre * n.back());
  strike(n.size() == 4 ? model->nearest(kMillimetre * Vec3{n[0], n[1], n[2]})
                       : last_point_.value_or(body_.point()),
         speed, host, true);
}

void ModalImpact::repeat_last(Numbers, Host& host) {
  if (body(host))
    strike(last_point_.value_or(body_.point()), last_speed_, host, last_was_drop_);
}

SurfacePoint ModalImpact::at_vertex(std::size_t vertex) const noexcept {
  const LoadedTable& loaded = *body_.model()->loaded;
  if (loaded.surface.empty())
    return {};
  return loaded.surface.nearest(loaded.table.vertex_m[vertex]);
}

void ModalImpact::hit_vertex(Numbers n, Host& host) {
  const BodyModel* model = body(host);
  if (!model)
    return;
  const double last = std::max<double>(static_cast<double>(model->loaded->table.vertices()), 1) - 1;
  if (within("hitv", n, {{"vertex", "", 0, last}, kSpeed}, host))
    strike(at_vertex(static_cast<std::size_t>(n[0])), n[1], host);
}

void ModalImpact::hit_face(Numbers n, Host& host) {
  const BodyModel* model = body(host);
  if (!model)
    return;
  const Surface& surface = model->loaded->surface;
  const double last = std::max<double>(static_cast<double>(surface.triangles()), 1) - 1;
  if (!within("hitf", n,
              {{"face", "", 0, last},
               {"u", "", 0, 1},
               {"v", "", 0, 1 - n[1]},
               {"speed", "m/s", 1e-6, kFastest}},
              host))
    return;
  strike(surface.empty() ? SurfacePoint{} : surface.on(static_cast<std::size_t>(n[0]), n[1], n[2]),
         n[3], host);
}

void ModalImpact::set_normal(Numbers n, Host& host) {
  if (n.empty()) {
    normal_.reset();
    return;
  }
  if (n.size() != 3)
    return host.error("normal: expected x y z, or nothing for the surface normal");
  const Vec3 direction{n[0], n[1], n[2]};
  const double size = norm(direction);
  if (!(size > 0))
    return host.error("normal 0 0 0: expected a direction");
  normal_ = direction * (1 / size);
}

void ModalImpact::set_striker(Numbers n, Host& host) {
  if (!within("striker", n,
              {{"mass", "kg", 1e-9, 1e4},
               {"radius", "m", 1e-6, 10},
               {"E", "Pa", 1e3, 1e13},
               {"nu", "", -0.99, 0.499}},
              host))
    return;
  Striker striker = body_.striker();
  striker.mass_kg = n[0];
  striker.radius_m = n[1];
  striker.youngs_modulus_pa = n[2];
  striker.poisson = n[3];
  striker.stiffness = 0;
  body_.set_striker(striker);
}

void ModalImpact::set_hardness(Numbers n, Host& host) {
  if (!within("hardness", n,
              {{"k", "N/m^a", 0, 1e15}, {"exponent", "", 1, 5}, {"loss", "s/m", 0, 100}}, host))
    return;
  Striker striker = body_.striker();
  striker.stiffness = n[0];
  striker.exponent = n.size() > 1 ? n[1] : 1.5;
  striker.loss_s_per_m = n.size() > 2 ? n[2] : 0;
  body_.set_striker(striker);
}

void ModalImpact::set_point(Numbers n, Host& host) {
  if (n.size() == 2)
    return host.error("point: expected x y z, or a vertex");
  const BodyModel* model = body(host);
  if (!model)
    return;
  SurfacePoint point;
  if (n.size() == 3) {
    if (!within("point", n, {kX, kY, kZ}, host))
      return;
    point = model->nearest(kMillimetre * Vec3{n[0], n[1], n[2]});
  } else {
    const double last =
        std::max<double>(static_cast<double>(model->loaded->table.vertices()), 1) - 1;
    if (!within("point", n, {{"vertex", "", 0, last}}, host))
      return;
    point = at_vertex(static_cast<std::size_t>(n[0]));
  }
  warn_if_far(point, host);
  body_.schedule(ForcePoint{point, normal_.value_or(point.normal)}, sample_now(host));
}

void ModalImpact::set_rub(Numbers n, Host& host) {
  if (!n.empty() && n.size() != 3 && n.size() != 6)
    return host.error("rub: expected x y z, x y z dx dy dz, or nothing for the point");
  const BodyModel* model = body(host);
  if (model && n.empty()) {
    Rub rub = body_.rub();
    rub.placed = false;
    rub.direction = Rub().direction;
    return body_.schedule(rub, sample_now(host));
  }
  if (!model || !within("rub", n, {kX, kY, kZ}, host))
    return;
  Rub rub = body_.rub();
  rub.point = model->nearest(kMillimetre * Vec3{n[0], n[1], n[2]});
  Vec3 wanted = rub.direction;
  if (n.size() == 6) {
    wanted = {n[3], n[4], n[5]};
    const double length = norm(wanted);
    constexpr double kMinTangentialSine = 0.1; // sine of the angle to the normal
    const Vec3& normal = rub.point.normal;
    if (!(length > 0))
      return host.error("rub: direction 0 0 0: expected one along the surface");
    wanted = wanted * (1 / length);
    if (norm(wanted - dot(wanted, normal) * normal) < kMinTangentialSine)
      return host.error("rub: direction " + number_text(n[3]) + " " + number_text(n[4]) + " " +
                        number_text(n[5]) + ": expected one along the surface, whose normal is " +
                        number_text(normal.x) + " " + number_text(normal.y) + " " +
                        number_text(normal.z));
  }
  rub.direction = along_surface(rub.point.normal, wanted);
  rub.placed = true;
  warn_if_far(rub.point, host);
  warn_if_still("rub", rub.point, rub.direction, host);
  body_.schedule(rub, sample_now(host));
}

void ModalImpact::set_friction(Numbers n, Host& host) {
  contact::FrictionLaw law;
  for (std::size_t i = 0; i < n.size(); ++i) {
    const Parameter& row = contact::kFrictionRows[i];
    if (!within("friction", n.subspan(i, 1), {{row.name, row.unit, row.lowest, row.highest}}, host))
      return;
    row.set(&law, n[i]);
  }
  Rub rub = body_.rub();
  rub.law = law;
  body_.schedule(rub, sample_now(host));
}

void ModalImpact::set_listener(Numbers n, Host& host) {
  auto listener = settings_.listener;
  if (n.size() == 4) {
    if (!within("listener", n, {{"i", "", 1, static_cast<double>(kMaxListeners)}, kX, kY, kZ},
                host))
      return;
    listener[static_cast<std::size_t>(n[0]) - 1] = kMillimetre * Vec3{n[1], n[2], n[3]};
  } else if (n.size() % 3 == 0) {
    for (std::size_t i = 0; i < n.size() / 3; ++i) {
      if (!within("listener", n.subspan(3 * i, 3), {kX, kY, kZ}, host))
        return;
      listener[i] = kMillimetre * Vec3{n[3 * i], n[3 * i + 1], n[3 * i + 2]};
    }
  } else {
    return host.error("listener: expected i x y z, or x y z of listeners 1, 2, ...");
  }
  change(settings_.listener, listener, false);
}

void ModalImpact::set_material(Numbers n, Host& host) {
  for (std::size_t i = 0; i < 2; ++i)
    if (n[i] != 0 &&
        !within("material", n.subspan(i, 1),
                {i == 0 ? Range{"E", "Pa", 1e3, 1e13} : Range{"rho", "kg/m^3", 1, 1e5}}, host))
      return;
  if (settings_.youngs_modulus_pa == n[0] && settings_.density_kg_per_m3 == n[1])
    return;
  settings_.youngs_modulus_pa = n[0];
  settings_.density_kg_per_m3 = n[1];
  rebuild_model();
}

void ModalImpact::set_preset(const Atom& name, Host& host) {
  const std::string word = name.is_word ? std::string(name.word) : number_text(name.number);
  if (word == "table") {
    settings_.youngs_modulus_pa = settings_.density_kg_per_m3 = 0;
    settings_.damping = Damping::kTable;
    preset_ = "table";
    return rebuild_model();
  }
  const auto preset = find_material(word);
  if (!preset) {
    std::string sentence = "preset " + word + ": expected ";
    for (const MaterialPreset& known : kMaterialPresets)
      sentence += std::string(known.name) + ", ";
    return host.error(sentence + "or table");
  }
  preset_ = preset->name;
  settings_.youngs_modulus_pa = preset->youngs_modulus_pa;
  settings_.density_kg_per_m3 = preset->density_kg_per_m3;
  settings_.damping = preset->loss_factor > 0 ? Damping::kLoss : Damping::kRayleigh;
  settings_.loss_factor = preset->loss_factor;
  settings_.rayleigh_a_per_s = preset->rayleigh_a_per_s;
  settings_.rayleigh_b_s = preset->rayleigh_b_s;
  rebuild_model();
}

void ModalImpact::choose_damping(const Message& row, std::span<const Atom> arguments, Host& host) {
  const std::string_view law = arguments[0].is_word ? arguments[0].word : std::string_view();
  const auto numbers = arguments.subspan(1);
  if (law == "table" && numbers.empty())
    return change(settings_.damping, Damping::kTable);
  for (const Message& m : Rows::messages)
    if ((m.name == "rayleigh" || m.name == "loss" || m.name == "losscurve") && law == m.name &&
        numbers.size() >= m.min_arguments && numbers.size() <= m.max_arguments)
      return m.run(this, m, numbers, host);
  host.error(refusal("damping", arguments, row.arguments));
}

void ModalImpact::set_rayleigh(Numbers n, Host& host) {
  if (!within("rayleigh", n, {{"a", "1/s", 0, 1e6}, {"b", "s", 0, 1}}, host))
    return;
  settings_.damping = Damping::kRayleigh;
  settings_.rayleigh_a_per_s = n[0];
  settings_.rayleigh_b_s = n[1];
  rebuild_model();
}

void ModalImpact::set_loss(Numbers n, Host& host) {
  if (!within("loss", n, {{"eta", "", 0, 2}}, host))
    return;
  settings_.damping = Damping::kLoss;
  settings_.loss_factor = n[0];
  rebuild_model();
}

void ModalImpact::set_loss_curve(Numbers n, Host& host) {
  if (n.size() % 2 != 0)
    return host.error("losscurve: expected pairs of frequency and loss factor");
  std::vector<std::array<double, 2>> curve;
  for (std::size_t i = 0; i < n.size(); i += 2) {
    const double minimum = curve.empty() ? 1e-3 : curve.back()[0] * (1 + 1e-9);
    if (!within("losscurve", n.subspan(i, 2), {{"f", "Hz", minimum, 1e6}, {"eta", "", 0, 2}}, host))
      return;
    curve.push_back({n[i], n[i + 1]});
  }
  settings_.damping = Damping::kCurve;
  settings_.loss_curve = std::move(curve);
  rebuild_model();
}

} // namespace tactus::modal
