// When the stress is solved anew, by what, and what becomes of the answer.
#include "core/stress/stress_session.hpp"
#include "tests/approx.hpp"
#include "tests/core/stress/beam_solver.hpp"

#include <cmath>
#include <limits>
#include <tuple>

using namespace tactus;
using namespace tactus::stress;
using test::approx;
using test::BeamSolver;
using test::Cantilever;

namespace {

struct Rig {
  std::shared_ptr<BeamSolver::Log> log = std::make_shared<BeamSolver::Log>();
  StressSession session{test::shared(Cantilever::table()), std::make_unique<BeamSolver>(log)};
  SessionRequest request;
  double now_s = 100;
  SessionResult result;

  Rig() { request.displacement_m = {0, 0}; }
  const SessionResult& step(double d0, double d1, double after_s = 0.001) {
    now_s += after_s;
    request.displacement_m = {d0, d1};
    return result = session.step(now_s, request);
  }
  /// Steps of a millisecond at one shape.
  const SessionResult& rest(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * 1000)); ++i)
      step(request.displacement_m[0], request.displacement_m[1]);
    return result;
  }
};

} // namespace

TEST_CASE("while the part is dragged within the trust size there is Taylor's series alone") {
  Rig rig;
  for (int i = 0; i < 1000; ++i)
    rig.step(0.0018 * std::sin(0.02 * i), 0);
  CHECK(rig.log->started.empty());
  CHECK(rig.result.method == Method::kTaylor);
  CHECK(!rig.result.outside_trust);
  CHECK(rig.result.base_changes == 1); // the first selection
}

TEST_CASE("after 150 ms without motion the part is solved anew") {
  Rig rig;
  rig.step(0.001, 0);
  CHECK(rig.session.due_s() - rig.now_s == approx(0.15));
  rig.rest(0.149);
  CHECK(rig.log->started.empty());
  CHECK(rig.session.due_s() - rig.now_s == doctest::Approx(0.001));
  rig.rest(0.002);
  REQUIRE(rig.log->started.size() == 1);
  CHECK(rig.session.due_s() - rig.now_s <= 0.002);
  const double series = rig.result.feedback.mean_pa;
  CHECK(rig.result.error == approx(0.01 * 0.25)); // a rule of thumb before the first solve
  rig.rest(0.01);
  CHECK(rig.log->started.size() == 1); // and not again
  CHECK(rig.result.method == Method::kPcg);
  CHECK(rig.result.iterations == 9);
  CHECK(rig.result.solve_s == 0.02);
  CHECK(rig.result.base_changes == 2);
  CHECK(rig.result.error == 0);
  const double reference = Cantilever::mean_pa(0.001, 0);
  CHECK(rig.result.feedback.mean_pa == approx(reference).epsilon(1e-7));
  CHECK(rig.session.due_s() - rig.now_s > 0.4); // whether the solver still lives
  // From now on the part's own error is known: err = e (d/trust)^2.
  rig.step(0.002, 0);
  CHECK(rig.result.method == Method::kTaylor);
  CHECK(rig.result.error == doctest::Approx(std::abs(series / reference - 1)).epsilon(1e-4));
}

TEST_CASE("leaving the trust size starts a solve at once, and one at a time") {
  Rig rig;
  rig.log->polls_needed = 20;
  rig.step(0.0021, 0);
  CHECK(rig.result.outside_trust);
  REQUIRE(rig.log->started.size() == 1);
  for (int i = 0; i < 19; ++i)
    rig.step(0.0021 + 1e-5 * i, 0);
  CHECK(rig.log->started.size() == 1);
  CHECK(rig.result.solving);
  rig.step(0.0023, 0);
  CHECK(!rig.result.outside_trust); // of the new base
  CHECK(rig.result.feedback.trust_ratio == approx(0.1));
}

TEST_CASE(
    "without a solver, or with resolve taylor, the series goes on and says that it is outside") {
  StressSession alone(test::shared(Cantilever::table()));
  SessionRequest request;
  request.displacement_m = {0.005, 0};
  for (int i = 0; i < 500; ++i)
    static_cast<void>(alone.step(0.001 * i, request));
  const SessionResult& result = alone.step(1, request);
  CHECK(result.method == Method::kTaylor);
  CHECK(result.outside_trust);
  CHECK(result.error == approx(0.01 * 2.5 * 2.5));
  CHECK(result.iterations == 0);
  CHECK(alone.due_s() == std::numeric_limits<double>::infinity());
  CHECK(alone.take_refusal().empty());
  Rig rig;
  rig.request.resolve = Resolve::kTaylor;
  rig.step(0.005, 0);
  rig.rest(0.3);
  CHECK(rig.log->started.empty());
  CHECK(rig.session.due_s() - rig.now_s > 0.4); // whether the solver still lives
}

TEST_CASE("old sensitivities are found anew at rest, but not with resolve pcg") {
  for (const Resolve resolve : {Resolve::kAuto, Resolve::kFull, Resolve::kPcg}) {
    Rig rig;
    rig.log->stale_sensitivities = true;
    rig.request.resolve = resolve;
    rig.step(0.003, 0);
    rig.rest(0.1); // solved at once, as it is beyond the trust size
    REQUIRE(rig.log->started.size() == 1);
    CHECK(rig.result.feedback.trust_ratio == 0);
    CHECK(rig.result.base_changes == 2);
    rig.rest(0.5);
    REQUIRE(rig.log->started.size() == (resolve == Resolve::kPcg ? 1 : 2));
    CHECK(rig.log->started.back() == (resolve == Resolve::kPcg ? Method::kPcg : Method::kFull));
    CHECK(rig.result.base_changes == (resolve == Resolve::kPcg ? 2 : 3));
    CHECK(rig.result.method == rig.log->started.back());
  }
}

TEST_CASE("a lost solver is one error; the series is used until another is attached") {
  Rig rig;
  rig.step(0.001, 0);
  rig.rest(0.2);
  const double solved = rig.result.feedback.mean_pa;
  CHECK(rig.result.solver == Solver::kReady);
  rig.log->lost = true;
  rig.log->result_refusal = "the solver ended";
  rig.step(0.0015, 0);
  rig.rest(0.2);
  const std::string refusal = rig.session.take_refusal();
  CHECK(refusal.find("the solver ended") != std::string::npos);
  CHECK(refusal.find("the Taylor series continues") != std::string::npos);
  CHECK(rig.result.solver == Solver::kNone);
  CHECK(rig.session.due_s() - rig.now_s == std::numeric_limits<double>::infinity());
  rig.step(0.001, 0);
  rig.rest(0.3);
  CHECK(rig.session.take_refusal().empty());
  CHECK(rig.result.feedback.mean_pa == solved); // of the last solution
  rig.log->lost = false;
  rig.log->result_refusal.clear();
  const std::size_t before = rig.log->started.size();
  rig.session.attach(std::make_unique<BeamSolver>(rig.log));
  rig.step(0.0015, 0);
  rig.rest(0.3);
  CHECK(rig.log->started.size() == before + 1);
  CHECK(rig.result.solver == Solver::kReady);
  CHECK(rig.result.feedback.mean_pa == approx(Cantilever::mean_pa(0.0015, 0)).epsilon(1e-7));
}

TEST_CASE("a solver that loads its part is asked when it has") {
  Rig rig;
  rig.log->loaded = false;
  rig.step(0.003, 0);
  rig.rest(0.3);
  CHECK(rig.result.solver == Solver::kStarting);
  CHECK(rig.session.due_s() - rig.now_s <= 0.02);
  CHECK(rig.log->started.empty());
  rig.log->loaded = true;
  rig.rest(0.01);
  CHECK(rig.log->started.size() == 1);
  CHECK(rig.result.solver == Solver::kReady);
}

TEST_CASE("a shape that the mesh cannot take is solved as far as it goes, and not again") {
  Rig rig;
  rig.log->reached = 0.5;
  rig.step(0.003, 0);
  rig.rest(0.5);
  CHECK(rig.log->started.size() == 1);
  CHECK(rig.session.take_refusal().find("1.5 mm short of it") != std::string::npos);
  CHECK(rig.result.method == Method::kTaylor);
  CHECK(rig.result.feedback.trust_ratio == approx(0.75));
}

TEST_CASE("resolve pcg and full take what they say, whatever it costs") {
  using Costs = Reanalysis::Costs;
  for (const auto& [resolve, method, costs] :
       {std::tuple(Resolve::kPcg, Method::kPcg, Costs{1, 1, 1e-9}),
        std::tuple(Resolve::kFull, Method::kFull, Costs{1e-9, 1e-9, 1})}) {
    Rig rig;
    rig.log->costs = costs;
    rig.request.resolve = resolve;
    rig.step(0.003, 0);
    REQUIRE(rig.log->started.size() == 1);
    CHECK(rig.log->started[0] == method);
  }
}

TEST_CASE("the cost model takes the cheaper one, and a new factor beyond 15 iterations") {
  CostModel model;
  model.set({1e-3, 2e-3, 0.05});
  // n = 4.5 + 5 r: pcg 3 ms an iteration, full 52 ms.
  CHECK(model.iterations(0.5) == approx(7));
  CHECK(model.pcg_s(1) == approx(9.5 * 3e-3));
  CHECK(model.full_s() == approx(0.052));
  CHECK(model.cheapest(1) == Method::kPcg);    // 28.5 ms
  CHECK(model.cheapest(2.2) == Method::kFull); // 15.5 iterations
  model.set({1e-3, 2e-3, 0.02});
  CHECK(model.cheapest(1) == Method::kFull); // 28.5 ms against 22
  model.set({1e-3, 2e-3, 10});
  CHECK(model.cheapest(2) == Method::kPcg);
  CHECK(model.cheapest(2.2) == Method::kFull);
  // A part that needs twice as many.
  model.learn({{}, nullptr, Method::kPcg, 19, 0.1}, 1);
  CHECK(model.iterations(0.5) == approx(14));
  CHECK(model.cheapest(1) == Method::kFull);
  model.learn({{}, nullptr, Method::kFull, 1, 0.1}, 1); // says nothing of iterations
  CHECK(model.iterations(0.5) == approx(14));
}

TEST_CASE("iterations count from the last factor, not from the last solution") {
  Rig rig;
  rig.log->costs = {1e-3, 1e-3, 10}; // a factor costs more than iterations ever
  rig.log->polls_needed = 1;
  rig.log->iterations = 0; // nothing is learnt
  for (int i = 1; i <= 8; ++i) {
    rig.step(0.0011 * i, 0);
    rig.rest(0.2);
  }
  // Five steps of 0.55 trust sizes are 2.75 from the factor: more than 15 iterations.
  bool full = false;
  for (const Method m : rig.log->started)
    full = full || m == Method::kFull;
  CHECK(full);
  CHECK(rig.log->started.front() == Method::kPcg);
}

TEST_CASE("a failed solve is one error, is not repeated at rest, and changes no stress") {
  for (int kind = 0; kind < 3; ++kind) {
    Rig rig;
    if (kind == 0)
      rig.log->start_refusal = "the child has ended";
    if (kind == 1)
      rig.log->result_refusal = "an element is inverted";
    if (kind == 2)
      rig.log->damaged = true;
    rig.step(0.003, 0);
    const double before = rig.result.feedback.mean_pa;
    rig.rest(0.01);
    const std::string refusal = rig.session.take_refusal();
    CHECK(refusal.starts_with("resolve: "));
    CHECK(refusal.find("the last stress is kept") != std::string::npos);
    CHECK(rig.session.take_refusal().empty());
    rig.rest(0.5);
    CHECK(rig.session.take_refusal().empty());
    CHECK(rig.result.feedback.mean_pa == before);
    CHECK(rig.result.base_changes == 1);
    CHECK(!rig.result.solving);
    rig.step(0.0031, 0); // a new shape is a new chance
    rig.rest(0.01);
    CHECK(!rig.session.take_refusal().empty());
  }
}

TEST_CASE("settings and the grabbed point count as swaps, displacements do not") {
  Rig rig;
  CHECK(rig.step(0, 0).base_changes == 1);
  CHECK(rig.step(0.001, 0).base_changes == 1);
  rig.request.control_point = 1;
  CHECK(rig.step(0.001, 0).base_changes == 2);
  rig.request.settings.mapping = Mapping::kWeighted;
  CHECK(rig.step(0.001, 0).base_changes == 3);
  CHECK(rig.step(0.001, 0).base_changes == 3);
}
