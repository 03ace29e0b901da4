// A body that lies on a board, in one table and one object.
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

/// A free bar along x, 0.2 m by 0.03 m by 0.01 m, of 60 g: four modes from 400 Hz on.
ModalTable bar() { return free_bar(0.2, 0.03, 0.01, 3600, 2.415e9, 1000); }

ModalTable board() { return plate(0.4, 0.3, 0.012); }

std::shared_ptr<const LoadedTable> on_board(ModalTable body = bar(), ModalTable below = board()) {
  return std::make_shared<const LoadedTable>(std::make_shared<const LoadedTable>(std::move(body)),
                                             std::make_shared<const LoadedTable>(std::move(below)),
                                             Vec3{0.01, 0.02, -0.03});
}

struct BarOnSupports : Rig {
  BarOnSupports() : Rig(kRate, bar()) {
    loaded = on_board();
    settings.rest.point_m = {{-0.0552, 0, -0.01}, {0.0552, 0, -0.01}};
    settings.listener = {Vec3{0, 0, 0.1}, Vec3{0.05, 0.05, -0.2}};
    rebuild(false);
  }
};

} // namespace

TEST_CASE("two tables are one, each mode with its shape on its own body alone") {
  const auto both = on_board();
  const LoadedTable &one = *both->parts[0].loaded, &other = *both->parts[1].loaded;
  CHECK(both->table.modes() == one.table.modes() + other.table.modes());
  CHECK(std::is_sorted(both->table.frequency_hz.begin(), both->table.frequency_hz.end()));
  BodySettings settings = no_radiation();
  const BodyModel joined(both, settings);
  for (std::size_t p = 0; p < 2; ++p) {
    const auto& part = both->parts[p];
    const BodyModel alone(part.loaded, settings);
    const Vec3 at{0.03, 0.01, 0.02};
    const SurfacePoint point = both->nearest_on(p, at + part.displacement_m),
                       own = part.loaded->surface.nearest(at);
    CHECK(point.distance == approx(own.distance));
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
      CHECK(abs(joined.rate[here] - alone.rate[alone.index_of[k]]) < 1e-9 * abs(joined.rate[here]));
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
  CHECK(LoadedTable::refusal(held, free).find("no supports") != std::string::npos);
  ModalTable bare = board();
  bare.shape.clear();
  bare.vertex_m.clear();
  bare.triangle.clear();
  CHECK(LoadedTable::refusal(free, LoadedTable(std::move(bare))).find("no mode shapes") !=
        std::string::npos);
}

TEST_CASE("points carry the weight and what presses, or the body is told to tip over") {
  const auto loaded = on_board();
  BodySettings settings = no_radiation();
  const auto model = [&](std::vector<Vec3> points, double pressing = 0) {
    settings.rest.point_m = std::move(points);
    settings.rest.pressing_n = pressing;
    return std::make_unique<BodyModel>(loaded, settings);
  };
  const double weight = 0.06 * 9.80665;
  // By the levers; only what lies along the bar is resisted by two points.
  const auto two = model({{-0.05, 0, -0.01}, {0.08, 0, -0.01}}, 2);
  REQUIRE(two->resting_contacts.size() == 2);
  CHECK(two->resting_contacts[0].preload_n == approx(weight * 0.08 / 0.13 + 1).epsilon(1e-6));
  CHECK(two->resting_contacts[1].preload_n == approx(weight * 0.05 / 0.13 + 1).epsilon(1e-6));
  const SurfacePoint middle = loaded->nearest_on(0, {0, 0, 0.1});
  for (const double b : two->rigid_gains(middle, {0, 1, 0}))
    CHECK(std::abs(b) < 1e-9); // the points hold it sideways
  double upwards = 0;
  for (const double b : two->rigid_gains(middle, {0, 0, 1}))
    upwards += b * b;
  CHECK(upwards == approx(1 / 0.06)); // and let it bounce
  // Four corners: a quarter each.
  const auto four = model(
      {{-0.08, -0.01, -0.01}, {0.08, -0.01, -0.01}, {-0.08, 0.01, -0.01}, {0.08, 0.01, -0.01}});
  REQUIRE(four->resting_contacts.size() == 4);
  for (const auto& rest : four->resting_contacts)
    CHECK(rest.preload_n == approx(weight / 4).epsilon(1e-6));
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
  const auto both = on_board(std::move(upper), std::move(lower));
  BodySettings settings = no_radiation();
  settings.rest.point_m = {{-0.1, 0, -0.005}, {0.1, 0, -0.005}};
  const BodyModel model(both, settings);
  REQUIRE(model.resting_contacts.size() == 2);
  for (const BodyModel::RestingContact& rest : model.resting_contacts) {
    CHECK(rest.direction.z == approx(1));
    CHECK(1e7 * rest.law.compliance_m_per_n == approx(3).epsilon(1e-5));
    // The lowest modes of both are bulges upwards here.
    CHECK(rest.gain[model.index_of[both->parts[0].mode[0]]] ==
          approx(2 / std::sqrt(0.06)).epsilon(1e-3));
    CHECK(rest.gain[model.index_of[both->parts[1].mode[0]]] < -0.5);
  }
}

TEST_CASE("a body at rest on its board is silent, and costs nothing") {
  BarOnSupports rig;
  const Output output = rig.run(4800);
  for (const auto* x : {&output.left, &output.right, &output.contact})
    CHECK(loudest(*x) == 0);
  CHECK(rig.body.model()->solver.active() == 0);
}

TEST_CASE("a bar struck on its board settles") {
  BarOnSupports rig;
  rig.settings.rest.law = {1e5, 1.5, 1};
  rig.settings.damping = Damping::kLoss;
  rig.settings.loss_factor = 0.05;
  rig.rebuild(false);
  rig.hit({0.02, 0, 0.02}, 1);
  static_cast<void>(rig.run(480));
  CHECK(rig.body.model()->solver.active() == 2);
  static_cast<void>(rig.run(20 * 48000));
  CHECK(loudest(rig.run(480).left) == 0);
  CHECK(rig.body.model()->solver.active() == 0);
}

TEST_CASE("without stiffness a bar on its board sounds as the bar alone") {
  Rig alone(kRate, bar());
  BarOnSupports on_supports;
  on_supports.settings.rest.law = {1, 1, 0};
  for (Rig* rig : {&alone, static_cast<Rig*>(&on_supports)}) {
    rig->settings.listener = {Vec3{0.02, 0, 0.02}, Vec3{-0.06, 0, 0.02}};
    rig->rebuild(false);
    rig->hit({0.02, 0, 0.02}, 1);
  }
  const Output one = alone.run(4800), two = on_supports.run(4800);
  CHECK(difference_db(one.left, two.left) < -60); // the bank that the one rings in: -65 dB
}

TEST_CASE("a body on a board sounds alike however its stream is cut") {
  check_same_bits(
      [](std::size_t block) {
        BarOnSupports rig;
        rig.hit({0.02, 0, 0.02}, 1);
        Output output = rig.run(4800, block);
        append(output.left, output.contact);
        return output.left;
      },
      {1, 7, 480});
}

TEST_CASE("settings of a body that rings on its board change without a jump") {
  BarOnSupports rig;
  rig.hit({0.02, 0, 0.02}, 1);
  std::vector<float> before = rig.run(4800).left, after;
  const double usual = largest_step(std::span(before).subspan(4000));
  const auto jump = [&] {
    return std::abs(static_cast<double>(after[0]) - static_cast<double>(before.back()));
  };
  rig.settings.rest.pressing_n = 0.001;
  rig.rebuild();
  after = rig.run(64).left;
  CHECK(jump() < 1.5 * usual);
  // The points are taken away, and given back: it rings on.
  const Complex first(0, 2 * kPi * 400);
  const auto points = rig.settings.rest.point_m;
  for (const auto& present : {std::vector<Vec3>{}, points}) {
    before = rig.run(640).left;
    rig.settings.rest.point_m = present;
    rig.rebuild();
    after = rig.run(640).left;
    CHECK(jump() < 1.5 * usual);
    CHECK(abs(amplitude(after, first)) > 0.3 * abs(amplitude(before, first)));
    CHECK((rig.body.model()->solver.active() == 2) == !present.empty());
  }
}

TEST_CASE("a reset brings a body on its board back to rest") {
  BarOnSupports rig;
  rig.hit({0.02, 0, 0.02}, 1);
  rig.run(480);
  rig.body.apply(Reset{});
  rig.run(2048);
  CHECK(loudest(rig.run(480).left) == 0);
  rig.hit({0.02, 0, 0.02}, 1);
  rig.run(480);
  CHECK(rig.body.model()->solver.active() >= 2);
}

TEST_CASE("a force, a hand and a surface that rubs move both bodies") {
  enum How { kForce, kHand, kRub };
  for (const How how : {kForce, kHand, kRub}) {
    CAPTURE(static_cast<int>(how));
    BarOnSupports rig;
    rig.settings.rest.pressing_n = 20;
    rig.options.driven = how == kHand;
    rig.rebuild(false);
    rig.body.apply(ForcePoint{rig.loaded->nearest_on(0, {0.02, 0, 0.02}), {0, 0, 1}});
    Rub rub;
    rub.placed = true;
    rub.point = rig.loaded->nearest_on(0, {0.1, 0, 0});
    rub.direction = {0, 0, 1};
    rig.body.apply(rub);
    if (how == kRub)
      static_cast<void>(rig.rub(5, 0.1F, 4800));
    else
      static_cast<void>(rig.run(4800, 4800, std::vector<float>(4800, how == kForce ? 5.0F : 0),
                                std::vector<float>(4800, how == kHand ? -1e-5F : 0)));
    const BodyModel& model = *rig.body.model();
    double on_board = 0;
    for (std::size_t k = 0; k < model.mode.size(); ++k)
      if (rig.loaded->is_board_mode(model.mode[k]))
        on_board += abs(model.solver.state(k));
    CHECK(on_board > 1e-8);
    // A lasting push is carried by the points, and no body runs away from it.
    CHECK(std::abs(model.solver.rigid_energy()) < 1e-3);
    if (how == kForce) {
      double carried = 0;
      for (std::size_t i = 0; i < 2; ++i)
        carried += model.solver.net_contact_force(model.resting_slot() + i);
      CHECK(carried == approx(5).epsilon(0.6));
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
        const auto there = alone.weight[0][own] * exp(-alone.rate[own] * late);
        const auto here = joined.weight[0][joined.index_of[part.mode[k]]];
        CHECK(abs(here - there) <= 2e-3 * abs(there));
        seen |= there != 0.0;
      }
      CHECK((seen || listener.z < 0));
      CHECK((!seen || late > -1.0 / 48000));
    }
}
