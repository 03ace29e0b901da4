// A body that lies on a board, in one table and one object.
#include "tests/core/modal/rig.hpp"
#include "tests/sanitized.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <vector>

using namespace tactus::modal;
using tactus::test::Output;
using tactus::test::plate;
using tactus::test::Rig;

namespace {

constexpr double kPi = std::numbers::pi;

/// A free bar along x, 0.2 m by 0.03 m by 0.01 m, its bending modes by Euler and Bernoulli.
ModalTable bar(double first_hz = 400, int modes = 4) {
  ModalTable table = plate(0.2, 0.03, 0.01, 1, 40, 3); // its upper face
  const auto vertices = static_cast<std::int32_t>(table.vertices());
  const std::size_t triangles = table.triangle.size();
  for (std::int32_t v = 0; v < vertices; ++v) {
    const Vec3 above = table.vertex_m[static_cast<std::size_t>(v)];
    table.vertex_m.push_back({above.x, above.y, -above.z});
  }
  for (std::size_t t = 0; t < triangles; ++t) {
    const auto above = table.triangle[t];
    table.triangle.push_back({above[0] + vertices, above[2] + vertices, above[1] + vertices});
  }
  const double mass = 0.06, length = 0.2;
  constexpr std::array<double, 4> kRoot{4.730040745, 7.853204624, 10.99560784, 14.13716549};
  table.frequency_hz.clear();
  table.shape.clear();
  table.loss_factor.clear();
  table.decay_rate.clear();
  for (int k = 0; k < modes; ++k) {
    const double beta = kRoot[static_cast<std::size_t>(k)];
    table.frequency_hz.push_back(first_hz * std::pow(beta / kRoot[0], 2));
    table.loss_factor.push_back(1e-3);
    const double sigma = (std::cosh(beta) - std::cos(beta)) / (std::sinh(beta) - std::sin(beta));
    for (const Vec3& v : table.vertex_m) {
      const double x = beta * (v.x / length + 0.5);
      const double w = std::cosh(x) + std::cos(x) - sigma * (std::sinh(x) + std::sin(x));
      for (const double part : {0.0, 0.0, w / std::sqrt(mass)})
        table.shape.push_back(static_cast<float>(part));
    }
  }
  table.free = true;
  table.mass_kg = mass;
  table.centre_of_mass_m = {};
  const double i = mass * length * length / 12;
  table.inertia_kg_m2 = {Vec3{i / 40, 0, 0}, Vec3{0, i, 0}, Vec3{0, 0, i}};
  table.multipoles = {};
  table.body_name = "bar";
  return table;
}

ModalTable board() {
  ModalTable table = plate(0.4, 0.3, 0.012);
  table.body_name = "board";
  return table;
}

std::shared_ptr<const LoadedTable> on_board(ModalTable body = bar()) {
  return std::make_shared<const LoadedTable>(std::make_shared<const LoadedTable>(std::move(body)),
                                             std::make_shared<const LoadedTable>(board()),
                                             Vec3{0.01, 0.02, -0.03});
}

struct BarOnSupports : Rig {
  explicit BarOnSupports(std::vector<Vec3> points = {{-0.0552, 0, -0.01}, {0.0552, 0, -0.01}})
      : Rig(48000, bar()) {
    loaded = on_board();
    settings.rest.point_m = std::move(points);
    settings.listener = {Vec3{0, 0, 0.1}, Vec3{0.05, 0.05, -0.2}};
    rebuild(false);
  }
  [[nodiscard]] double energy() { return body.model()->solver.energy(); }
};

/// Amplitude of a tone in a part of a sound.
double tone(const std::vector<float>& sound, std::size_t from, std::size_t to, double hz,
            double rate = 48000) {
  std::complex<double> sum = 0;
  const auto count = static_cast<double>(to - from);
  for (std::size_t n = from; n < to; ++n) {
    const double window = 1 - std::cos(2 * kPi * static_cast<double>(n - from) / count);
    sum += window * static_cast<double>(sound[n]) *
           std::polar(1.0, -2 * kPi * hz * static_cast<double>(n) / rate);
  }
  return 2 * std::abs(sum) / count;
}

} // namespace

TEST_CASE("two tables are one, each mode with its shape on its own body alone") {
  const auto both = on_board();
  const LoadedTable &one = *both->parts[0].loaded, &other = *both->parts[1].loaded;
  CHECK(both->table.modes() == one.table.modes() + other.table.modes());
  CHECK(std::is_sorted(both->table.frequency_hz.begin(), both->table.frequency_hz.end()));
  BodySettings settings;
  settings.radiation = Radiation::kNone;
  const BodyModel joined(both, settings);
  for (std::size_t p = 0; p < 2; ++p) {
    const auto& part = both->parts[p];
    const BodyModel alone(part.loaded, settings);
    const Vec3 at{0.03, 0.01, 0.02};
    const SurfacePoint point = both->nearest_on(p, at + part.displacement_m),
                       own = part.loaded->surface.nearest(at);
    CHECK(point.distance == doctest::Approx(own.distance));
    CHECK(norm(point.position - own.position - part.displacement_m) < 1e-9);
    CHECK(both->part_of_triangle(point.triangle) == p);
    std::vector<double> gain(joined.mode.size()), wanted(alone.mode.size());
    const Vec3 along{0.3, -0.2, 0.9};
    joined.gains(point, along, gain);
    alone.gains(own, along, wanted);
    double sum = 0;
    for (std::size_t k = 0; k < part.mode.size(); ++k) {
      CHECK(both->table.frequency_hz[part.mode[k]] == part.loaded->table.frequency_hz[k]);
      if (alone.index_of[k] == alone.mode.size())
        continue; // too high
      const std::size_t here = joined.index_of[part.mode[k]];
      CHECK(gain[here] == wanted[alone.index_of[k]]);
      CHECK(std::abs(joined.rate[here] - alone.rate[alone.index_of[k]]) <
            1e-9 * std::abs(joined.rate[here]));
      sum += std::abs(gain[here]);
    }
    for (const double g : gain)
      sum -= std::abs(g);
    CHECK(std::abs(sum) < 1e-12); // nothing on the other's modes
  }
}

TEST_CASE("only a body that is held can be a board") {
  const LoadedTable held(board()), free(bar());
  CHECK(LoadedTable::refusal(free, held).empty());
  CHECK(LoadedTable::refusal(held, held).empty());
  CHECK(LoadedTable::refusal(held, free).find("nothing holds") != std::string::npos);
  ModalTable bare = board();
  bare.shape.clear();
  bare.vertex_m.clear();
  bare.triangle.clear();
  CHECK(LoadedTable::refusal(free, LoadedTable(std::move(bare))).find("no shapes") !=
        std::string::npos);
}

TEST_CASE("points carry the weight and what presses, or the body is told to tip over") {
  const auto loaded = on_board();
  BodySettings settings;
  settings.radiation = Radiation::kNone;
  const auto model = [&](std::vector<Vec3> points, double pressing = 0) {
    settings.rest.point_m = std::move(points);
    settings.rest.pressing_n = pressing;
    return std::make_unique<BodyModel>(loaded, settings);
  };
  const double weight = 0.06 * 9.80665;
  // By the levers; only what lies along the bar is resisted by two points.
  const auto two = model({{-0.05, 0, -0.01}, {0.08, 0, -0.01}}, 2);
  REQUIRE(two->resting_contacts.size() == 2);
  CHECK(two->resting_contacts[0].preload_n ==
        doctest::Approx(weight * 0.08 / 0.13 + 1).epsilon(1e-6));
  CHECK(two->resting_contacts[1].preload_n ==
        doctest::Approx(weight * 0.05 / 0.13 + 1).epsilon(1e-6));
  const SurfacePoint middle = loaded->nearest_on(0, {0, 0, 0.1});
  for (const double b : two->rigid_gains(middle, {0, 1, 0}))
    CHECK(std::abs(b) < 1e-9); // the points hold it sideways
  double upwards = 0;
  for (const double b : two->rigid_gains(middle, {0, 0, 1}))
    upwards += b * b;
  CHECK(upwards == doctest::Approx(1 / 0.06)); // and let it bounce
  // Four corners: a quarter each.
  const auto four = model(
      {{-0.08, -0.01, -0.01}, {0.08, -0.01, -0.01}, {-0.08, 0.01, -0.01}, {0.08, 0.01, -0.01}});
  REQUIRE(four->resting_contacts.size() == 4);
  for (const auto& rest : four->resting_contacts)
    CHECK(rest.preload_n == doctest::Approx(weight / 4).epsilon(1e-6));
  // Both on one side.
  const auto tips = model({{0.02, 0, -0.01}, {0.08, 0, -0.01}});
  CHECK(tips->resting_contacts.empty());
  CHECK(tips->resting_refusal.find("tips over") != std::string::npos);
  CHECK(model({{0.02, 0, -0.01}, {0.08, 0, -0.01}}, 3)->resting_contacts.size() == 2); // screwed on
}

TEST_CASE("a point pushes the body away from the board, and the board from the body") {
  ModalTable upper = bar(), lower = board();
  upper.residual_compliance.assign(upper.vertices(), 1e-7F);
  lower.residual_compliance.assign(lower.vertices(), 2e-7F);
  const auto both = std::make_shared<const LoadedTable>(
      std::make_shared<const LoadedTable>(std::move(upper)),
      std::make_shared<const LoadedTable>(std::move(lower)), Vec3{0.01, 0.02, -0.03});
  BodySettings settings;
  settings.radiation = Radiation::kNone;
  settings.rest.point_m = {{-0.1, 0, -0.005}, {0.1, 0, -0.005}};
  const BodyModel model(both, settings);
  REQUIRE(model.resting_contacts.size() == 2);
  for (const BodyModel::RestingContact& rest : model.resting_contacts) {
    CHECK(rest.direction.z == doctest::Approx(1));
    CHECK(1e7 * rest.law.compliance_m_per_n == doctest::Approx(3).epsilon(1e-5));
    // The lowest modes of both are bulges upwards here.
    CHECK(rest.gain[model.index_of[both->parts[0].mode[0]]] ==
          doctest::Approx(2 / std::sqrt(0.06)).epsilon(1e-3));
    CHECK(rest.gain[model.index_of[both->parts[1].mode[0]]] < -0.5);
  }
}

TEST_CASE("a body at rest on its board is silent, and costs nothing") {
  BarOnSupports rig;
  const Output output = rig.run(4800);
  for (const auto* x : {&output.left, &output.right, &output.contact})
    CHECK(*std::max_element(x->begin(), x->end()) == 0);
  CHECK(rig.body.model()->solver.active() == 0);
}

TEST_CASE("a bar struck on its board never holds more energy than the strike gave, and settles") {
  for (const double stiffness : {1e5, 4e8, 1e12}) {
    if (kSanitized && stiffness != 4e8)
      continue;
    CAPTURE(stiffness);
    BarOnSupports rig;
    rig.settings.rest.law = {stiffness, 1.5, 1};
    rig.settings.damping = Damping::kLoss;
    rig.settings.loss_factor = 0.05;
    rig.rebuild(false);
    rig.hit({0.02, 0, 0.02}, 1);
    const double given = 0.5 * 0.0071 * 1;
    rig.run(1);
    const ContactSolver& solver = rig.body.model()->solver;
    double rest = 0;
    for (std::size_t i = 0; i < 2; ++i)
      rest += solver.contact(rig.body.model()->resting_slot() + i)
                  .exciter.impact.law()
                  .work(solver.contact(rig.body.model()->resting_slot() + i).exciter.position_m);
    double before = given + rest;
    for (int n = 0; n < 3000; ++n) {
      rig.run(8, 8);
      if (rig.body.contacts() > 0)
        continue; // the ball's own energy counts until it has left
      CHECK(rig.energy() < before + 1e-9 * given);
      before = rig.energy();
    }
    rig.run(20 * 48000);
    const Output output = rig.run(48000);
    CHECK(*std::max_element(output.left.begin(), output.left.end()) == 0);
    CHECK(rig.body.model()->solver.active() == 0);
  }
}

TEST_CASE("a bar on a board is heard with the board's modes, through felt less of them") {
  const auto level = [](double stiffness, double exponent) {
    BarOnSupports rig;
    rig.settings.rest.law = {stiffness, exponent, 0};
    rig.settings.rest.pressing_n = stiffness > 1 ? 20 : 0;
    rig.settings.listeners = 1;
    rig.settings.listener[0] = {0.05, 0.05, -0.2}; // the velocity of the board's far side
    rig.rebuild(false);
    rig.hit({0.02, 0, 0.02}, 1);
    const Output output = rig.run(24000);
    double sum = 0;
    for (std::size_t n = 2400; n < 24000; ++n)
      sum += std::pow(static_cast<double>(output.left[n]), 2);
    return std::sqrt(sum / 21600);
  };
  const double nothing = level(1, 1), felt = level(3e3, 1), hard = level(1e6, 1);
  CHECK(nothing < 1e-4 * hard);
  CHECK(felt < 0.3 * hard);
  CHECK(felt > 10 * nothing);
}

TEST_CASE("without stiffness a bar on its board sounds as the bar alone") {
  Rig alone(48000, bar());
  BarOnSupports on_supports;
  on_supports.settings.rest.law = {1, 1, 0};
  for (Rig* rig : {&alone, static_cast<Rig*>(&on_supports)}) {
    rig->settings.listener = {Vec3{0.02, 0, 0.02}, Vec3{-0.06, 0, 0.02}};
    rig->rebuild(false);
    rig->hit({0.02, 0, 0.02}, 1);
  }
  const Output one = alone.run(4800), two = on_supports.run(4800);
  double difference = 0, size = 0;
  for (std::size_t n = 0; n < one.left.size(); ++n) {
    difference += std::pow(static_cast<double>(one.left[n] - two.left[n]), 2);
    size += std::pow(static_cast<double>(one.left[n]), 2);
  }
  CHECK(std::sqrt(difference / size) < 1e-3); // the bank that the one rings in: -65 dB
}

TEST_CASE("a body on a board sounds alike however its stream is cut") {
  const auto render = [](std::size_t block) {
    BarOnSupports rig;
    rig.hit({0.02, 0, 0.02}, 1);
    return rig.run(9600, block);
  };
  const Output whole = render(64);
  for (const std::size_t block : {std::size_t{1}, std::size_t{7}, std::size_t{480}}) {
    const Output cut = render(block);
    CHECK(cut.left == whole.left);
    CHECK(cut.contact == whole.contact);
  }
}

TEST_CASE("settings of a body that rings on its board change without a jump") {
  BarOnSupports rig;
  rig.hit({0.02, 0, 0.02}, 1);
  Output before = rig.run(4800);
  rig.settings.rest.pressing_n = 0.001;
  rig.rebuild(true);
  Output after = rig.run(64);
  const auto change = [](float a, float b) { return std::abs(static_cast<double>(a - b)); };
  double usual = 0;
  for (std::size_t n = 4000; n < 4800; ++n)
    usual = std::max(usual, change(before.left[n], before.left[n - 1]));
  CHECK(change(after.left[0], before.left.back()) < 1.5 * usual);
  // The points are taken away, and given back: it rings on.
  const auto points = rig.settings.rest.point_m;
  for (const auto& present : {std::vector<Vec3>{}, points}) {
    before = rig.run(640);
    rig.settings.rest.point_m = present;
    rig.rebuild(true);
    after = rig.run(640);
    CHECK(change(after.left[0], before.left.back()) < 1.5 * usual);
    CHECK(tone(after.left, 0, 640, 400) > 0.3 * tone(before.left, 0, 640, 400));
    CHECK((rig.body.model()->solver.active() == 2) == !present.empty());
  }
}

TEST_CASE("a reset brings a body on its board back to rest") {
  BarOnSupports rig;
  rig.hit({0.02, 0, 0.02}, 1);
  rig.run(480);
  rig.body.reset();
  rig.run(2048);
  const Output output = rig.run(480);
  CHECK(*std::max_element(output.left.begin(), output.left.end()) == 0);
  rig.hit({0.02, 0, 0.02}, 1);
  rig.run(480);
  CHECK(rig.body.model()->solver.active() >= 2);
}

TEST_CASE("a force, a hand and a surface that rubs move both bodies") {
  for (const int how : {0, 1, 2}) {
    CAPTURE(how);
    BarOnSupports rig;
    rig.settings.rest.pressing_n = 20;
    rig.rebuild(false);
    rig.body.set_point(rig.loaded->nearest_on(0, {0.02, 0, 0.02}), {0, 0, 1});
    std::vector<float> force(4800, how == 0 ? 5.0F : 0), height(4800, how == 1 ? -1e-5F : 0);
    std::vector<float> normal(4800, how == 2 ? 5.0F : 0), velocity(4800, 0.1F), friction(4800);
    if (how == 1)
      rig.options.driven = true;
    rig.body.set_options(rig.options);
    Output output{std::vector<float>(4800), std::vector<float>(4800), std::vector<float>(4800)};
    const std::array<std::span<float>, 2> out{output.left, output.right};
    if (how == 2) {
      Rub rub;
      rub.placed = true;
      rub.point = rig.loaded->nearest_on(0, {0.1, 0, 0});
      rub.direction = {0, 0, 1};
      rig.body.set_rub(rub);
    }
    rig.body.process<float>(force, height, out, output.contact, {normal, velocity, friction});
    const BodyModel& model = *rig.body.model();
    double on_board = 0;
    for (std::size_t k = 0; k < model.mode.size(); ++k)
      if (rig.loaded->is_board_mode(model.mode[k]))
        on_board += std::abs(model.solver.state(k));
    CHECK(on_board > 1e-8);
    // A lasting push is carried by the points, and no body runs away from it.
    CHECK(std::abs(model.solver.rigid_energy()) < 1e-3);
    if (how == 0) {
      double carried = 0;
      for (std::size_t i = 0; i < 2; ++i)
        carried += model.solver.net_contact_force(model.resting_slot() + i);
      CHECK(carried == doctest::Approx(5).epsilon(0.6));
    }
  }
}

TEST_CASE("a body and its board are heard as each is alone, together") {
  const auto both = on_board();
  for (const Vec3 listener :
       {Vec3{0.1, 0.2, 0.5}, Vec3{0.02, 0.01, 0.05}, Vec3{0, 0, 0.8}, Vec3{0, 0.1, -0.4}})
    for (std::size_t p = 0; p < 2; ++p) {
      BodySettings settings;
      settings.listener[0] = listener;
      settings.listeners = 1;
      const BodyModel joined(both, settings);
      const auto& part = both->parts[p];
      settings.listener[0] = listener - part.displacement_m;
      const BodyModel alone(part.loaded, settings);
      const double late = alone.delay_s[0] - joined.delay_s[0];
      bool seen = false; // the plate has one face
      for (std::size_t k = 0; k < part.mode.size(); ++k) {
        const std::size_t own = alone.index_of[k];
        if (own >= alone.audible_modes)
          continue;
        const auto there = alone.weight[0][own] * std::exp(-alone.rate[own] * late);
        const auto here = joined.weight[0][joined.index_of[part.mode[k]]];
        CHECK(std::abs(here - there) <= 2e-3 * std::abs(there));
        seen |= there != 0.0;
      }
      CHECK((seen || listener.z < 0));
      CHECK((!seen || late > -1.0 / 48000));
    }
}
