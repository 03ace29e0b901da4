// [stress_haptic] in a host of the test: continuity of the force when the stress is exchanged, the
// solver, the worker's thread.
#include "externals/stress_haptic/stress_haptic.hpp"
#include "tests/core/stress/beam_solver.hpp"
#include "tests/externals/by_name.hpp"
#include "tests/externals/recording_host.hpp"
#include "tests/externals/table_folder.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <vector>

using namespace tactus;
using namespace tactus::stress;
using test::BeamSolver;
using test::Cantilever;

namespace {

namespace fs = std::filesystem;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Rig {
  test::TableFolder folder;
  test::RecordingHost host;
  StressHaptic object;

  explicit Rig(bool real_time = false, StressJob::SolverFactory solvers = {})
      : host(folder.path, real_time), object(std::move(solvers)) {
    object.created(host);
  }
  /// The cantilever is loaded and gamma is its mean stress in MPa.
  static Rig& loaded(Rig& rig) {
    rig.say("range", {"fixed", 0.0, 1e6});
    rig.say("load", {"cantilever.stress.npz"});
    return rig;
  }
  void say(std::string_view name, std::vector<Atom> arguments = {}) {
    for (const Parameter& row : StressHaptic::declaration.parameters)
      if (row.name == name)
        return row.set(&object, arguments.at(0).number);
    test::send(object, name, std::span<const Atom>(arguments), host);
  }
  void handle(const std::vector<Atom>& atoms) { object.list(1, atoms, host); }
  /// The handle at rest at a position.
  void hold(double x_mm, double y_mm, double z_mm) { handle({x_mm, y_mm, z_mm, 0.0, 0.0, 0.0}); }
  /// Advances the logical time.
  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      host.time_ms += 1;
      if (host.due_ms <= host.time_ms) {
        host.due_ms = 1e300;
        object.tick(0, host);
      }
    }
  }
  /// Delivers what the worker's thread posts until the condition holds; false after a minute.
  template <class Condition> bool wait(const Condition& condition) {
    for (int i = 0; i < 60000 && !condition(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      run(1);
      if (host.woken.exchange(0) > 0)
        object.posted(host);
    }
    return condition();
  }
  bool wait_for(const std::string& start) {
    return wait([&] { return !host.said(start).empty(); });
  }
  [[nodiscard]] double gamma() const { return host.sent.at(0).back().at(0); }
  [[nodiscard]] double force() const { return host.sent.at(1).back().at(0); }
  /// The largest step of the force along x from one answer to the next, N.
  [[nodiscard]] double largest_step(std::size_t from) const {
    const auto& forces = host.sent.at(1);
    double largest = 0;
    for (std::size_t i = from + 1; i < forces.size(); ++i)
      largest = std::max(largest, std::abs(forces[i][0] - forces[i - 1][0]));
    return largest;
  }
};

StressJob::SolverFactory beam_solvers(const std::shared_ptr<BeamSolver::Log>& log) {
  return [log](const SolverOptions&) { return std::make_unique<BeamSolver>(log); };
}

/// Of Taylor's series, as a share of 1 MPa.
doctest::Approx series_mean(double d0, double d1) {
  StressModel model(test::shared(Cantilever::table()));
  return doctest::Approx(model.update(std::vector<double>{d0, d1}).mean_pa / 1e6).epsilon(1e-9);
}

} // namespace

TEST_CASE("force is continuous when a re-solved stress takes the place of the series") {
  const auto log = std::make_shared<BeamSolver::Log>();
  Rig rig(false, beam_solvers(log));
  rig.say("gains", {0.0, 600.0, 0.0, 0.0});
  rig.say("range", {"fixed", 100e3, 500e3});
  rig.say("load", {"cantilever.stress.npz"});
  rig.say("anchor", {0.0, 0.0, 0.0});
  rig.hold(50, 0, 0); // 30 N at gamma 1
  rig.run(500);
  CHECK(std::abs(rig.force()) > 0);
  // A large displacement: the series has a large error, so the solution changes gamma by much.
  log->polls_needed = 60;               // one every 2 ms
  rig.say("cp", {0.0, 0.0, 20.0, 0.0}); // 10 mm up
  rig.run(60);                          // the glide of the series has ended
  const double series = rig.gamma();
  const std::size_t from = rig.host.sent.at(1).size();
  rig.run(400);
  REQUIRE(log->started.size() == 1);
  CHECK(rig.gamma() ==
        doctest::Approx((Cantilever::mean_pa(0.01, 0) - 100e3) / 400e3).epsilon(1e-6));
  const double change = std::abs(rig.gamma() - series) * 30;
  CHECK(change > 2); // N
  // Linear over 100 ms: 1 % of the change in a millisecond, and no more.
  CHECK(rig.largest_step(from) < 0.0101 * change + 1e-9);
  CHECK(rig.largest_step(from) > 0.009 * change);
  CHECK(rig.host.errors.empty());
}

TEST_CASE("force is continuous across settings, a grab, another table and a moved anchor") {
  Rig rig;
  StressTable weak = Cantilever::table();
  for (float& s : weak.base.von_mises.stress)
    s *= 2;
  rig.folder.write("weak.stress.npz", weak);
  rig.say("gains", {0.0, 600.0, 0.0, 0.0});
  Rig::loaded(rig).say("anchor", {0.0, 0.0, 0.0});
  rig.hold(50, 0, 0);
  rig.run(300);
  CHECK(rig.force() == doctest::Approx(-600 * 0.05 * 0.5));
  const std::size_t from = rig.host.sent.at(1).size() - 1;
  rig.say("load", {"weak.stress.npz"});
  rig.run(300);
  CHECK(rig.force() == doctest::Approx(-30));
  rig.say("range", {"initial"});
  rig.run(50); // the next change comes in the middle of a fade
  rig.say("grab", {0.0});
  rig.run(30);
  rig.say("mode", {1.0});
  rig.run(20);
  rig.say("sens", {0.0});
  rig.run(200);
  rig.say("anchor", {"here"});
  rig.run(200);
  CHECK(std::abs(rig.force()) < 1e-9);
  CHECK(rig.largest_step(from) <= 0.01 * 30 + 1e-9);
  CHECK(rig.host.errors.empty());
}

TEST_CASE("the handle drags the grabbed control point within its bounds, scaled") {
  Rig rig;
  Rig::loaded(rig);
  const auto settled = [&] {
    rig.run(300);
    return rig.gamma();
  };
  rig.hold(0, 5, 0);
  rig.say("grab", {1.0});
  rig.say("scale", {2.0});
  rig.hold(3, 6, 9); // 1 mm up: d1 = 2 mm; x and z have no parameters
  CHECK(settled() == series_mean(0, 0.002));
  rig.hold(0, 500, 0); // far beyond: the bound of 20 mm
  CHECK(settled() == series_mean(0, 0.02));
  CHECK(!rig.host.said("outside 1").empty());
  rig.say("release");
  rig.hold(0, 0, 0); // moves nothing now
  CHECK(settled() == series_mean(0, 0.02));
  rig.say("reset");
  CHECK(settled() == doctest::Approx(0.5));
  // Grabbed again it is dragged on from where it is.
  rig.say("scale", {1.0});
  rig.say("grab", {1.0});
  rig.hold(0, 2, 0);
  rig.say("release");
  rig.hold(0, 0, 0);
  rig.say("grab", {1.0});
  rig.say("grab", {0.0, 0.0}); // releases another point: no effect
  rig.hold(0, 1, 0);           // 2 mm from before and 1 mm
  CHECK(settled() == series_mean(0, 0.003));
  rig.say("grab", {1.0, 0.0});
  rig.hold(0, 9, 0);
  CHECK(settled() == series_mean(0, 0.003));
  // Another table begins at its own shape, with nothing grabbed.
  rig.say("grab", {1.0});
  rig.say("load", {"cantilever.stress.npz"});
  CHECK(settled() == doctest::Approx(0.5));
  rig.hold(0, 0, 0);
  CHECK(settled() == doctest::Approx(0.5));
  rig.object.dump(rig.host);
  CHECK(!rig.host.said("grabbed -1").empty());
}

TEST_CASE("stiffness and damping never exceed the device's limits") {
  Rig rig;
  rig.say("load", {"cantilever.stress.npz"});
  rig.say("range", {"fixed", 0.0, 1.0}); // gamma 1
  rig.say("anchor", {0.0, 0.0, 0.0});
  rig.say("gains", {0.0, 5000.0, 0.0, 4.0});
  REQUIRE(rig.host.errors.size() == 1);
  CHECK(rig.host.errors[0].find("600") != std::string::npos);
  rig.hold(10, 0, 0);
  rig.run(300);
  CHECK(rig.force() == doctest::Approx(-6));
  rig.say("nominal", {100.0});
  rig.hold(10, 0, 0);
  CHECK(rig.force() == doctest::Approx(-0.6));
  rig.say("gains", {0.0, 10.0, 0.0, 6.0});
  CHECK(rig.host.errors.size() == 2);
}

TEST_CASE("feedback messages come while gamma changes, and at least every 250 ms") {
  Rig rig;
  rig.say("load", {"cantilever.stress.npz"});
  rig.run(1000);
  const auto& feedback = rig.host.sent.at(3);
  const std::size_t count = feedback.size();
  CHECK(count >= 12);
  CHECK(count <= 18);
  for (std::size_t i = 0; i < count; ++i)
    CHECK(feedback[i][0] == static_cast<double>(i + 1)); // sequence
  CHECK(feedback.back()[1] == doctest::Approx(rig.gamma()));
  rig.say("mode", {2.0});
  rig.run(500);
  CHECK(feedback.back().size() == 4); // sequence and three
}

TEST_CASE(
    "points sends a workspace that holds every bound, and the control points where they are") {
  Rig rig;
  rig.say("load", {"cantilever.stress.npz"});
  rig.say("cp", {1.0, 0.0, 13.0, 0.0});
  rig.host.sent[3].clear();
  rig.say("points");
  auto sent = rig.host.sent.at(3);
  REQUIRE(sent.size() == 5);
  CHECK(sent[3][2] == doctest::Approx(13));
  sent[3][2] = 13;
  CHECK(sent == std::vector<std::vector<double>>{
                    {-1, -1, -1, 101, 31, 1}, {2}, {0, 0, 10, 0}, {1, 100, 13, 0}, {}});
}

// What needs no table of its own is a row of tests/patches/test_refusals.py.
TEST_CASE("bad input is one error and changes nothing") {
  Rig rig;
  StressTable held = Cantilever::table();
  held.control_point_m.push_back({0.2, 0, 0});
  rig.folder.write("held.stress.npz", held);
  std::ofstream(rig.folder.path / "bad.stress.npz") << "nonsense";
  const auto one = [&](std::string_view name, const std::vector<Atom>& arguments,
                       const char* word) {
    rig.host.errors.clear();
    rig.say(name, arguments);
    REQUIRE(rig.host.errors.size() == 1);
    INFO(rig.host.errors[0]);
    CHECK(rig.host.errors[0].starts_with(name));
    CHECK(rig.host.errors[0].find(word) != std::string::npos);
  };
  one("cp", {0.0, 1.0, 2.0, 3.0}, "load");
  one("list", {0.0, 1.0}, "load");
  one("points", {}, "load");
  one("reset", {}, "load");
  rig.say("load", {"held.stress.npz"});
  one("grab", {2.0}, "is fixed in this table");
  rig.say("load", {"cantilever.stress.npz"});
  rig.run(300);
  const double gamma = rig.gamma();
  one("cp", {kNan, 1.0, 2.0, 3.0}, "expected");
  one("cp", {0.0, kNan, 2.0, 3.0}, "expected numbers");
  one("list", {1.0, kNan}, "expected numbers");
  one("range", {"fixed", 5.0, 5.0}, "a below b");
  one("anchor", {1.0, 2.0}, "here");
  one("load", {"bad.stress.npz"}, "not an .npz file");
  one("state", {1.0}, "shear0");
  one("weights", {1.0}, "array weights");
  one("resolve", {2.0}, "no mesh");
  rig.host.errors.clear();
  rig.handle({1.0, 2.0, 3.0, 4.0, 5.0});
  rig.handle({1.0, kNan, 3.0});
  CHECK(rig.host.errors.size() == 2);
  rig.run(300);
  CHECK(rig.gamma() == gamma);
}

TEST_CASE("the first position is the anchor, and each is answered by a force, however absurd") {
  Rig rig;
  rig.say("load", {"cantilever.stress.npz"});
  rig.say("range", {"fixed", 0.0, 1.0});
  rig.hold(20, 0, 0);
  rig.run(300);
  CHECK(rig.force() == 0);
  rig.hold(21, 0, 0);
  const std::size_t count = rig.host.sent.at(1).size();
  rig.hold(21, 0, 0);
  rig.hold(21, 0, 0);
  CHECK(rig.host.sent.at(1).size() == count + 2);
  CHECK(rig.force() == doctest::Approx(-0.4));
  rig.say("render", {1.0});
  rig.handle({21.0, 0.0, 0.0, 1e6, 0.0, 0.0});
  CHECK(rig.force() == doctest::Approx(-400)); // 4 N s/m at 100 m/s
}

TEST_CASE("with three numbers the velocity is estimated from the positions") {
  Rig rig;
  rig.say("load", {"cantilever.stress.npz"});
  rig.say("range", {"fixed", 0.0, 1.0});
  rig.say("render", {1.0});
  rig.run(300);
  for (int i = 0; i < 20; ++i) {
    rig.handle({0.1 * i, 0.0, 0.0});
    rig.run(1);
  }
  CHECK(rig.force() == doctest::Approx(-4 * 0.1).epsilon(1e-6));
}

TEST_CASE("in real time a thread evaluates: the newest request counts") {
  const auto log = std::make_shared<BeamSolver::Log>();
  Rig rig(true, beam_solvers(log));
  Rig::loaded(rig);
  REQUIRE(rig.wait_for("loaded"));
  for (int i = 0; i < 2000; ++i) {
    rig.say("list", {0.001 * (i % 1500), 0.0}); // mm
    if (rig.host.woken.exchange(0) > 0)
      rig.object.posted(rig.host);
  }
  rig.say("list", {1.0, 1.0});
  rig.hold(1, 2, 3);
  // First the series, then the solution.
  const double truth = Cantilever::mean_pa(0.001, 0.001) / 1e6;
  REQUIRE(rig.wait(
      [&] { return rig.host.sent.contains(0) && std::abs(rig.gamma() / truth - 1) < 1e-6; }));
  CHECK(!log->started.empty());
  CHECK(rig.host.errors.empty());
}

TEST_CASE("a child that dies or does not answer: one sentence, no jump, and the series goes on") {
  for (const auto& [how, when] : {std::pair("killed", false), std::pair("cut", false),
                                  std::pair("half", true), std::pair("good", true)}) {
    const std::string mode = how; // bindings are captured by no lambda
    const bool real_time = when;
    INFO(mode, ", in real time: ", real_time);
    const bool good = mode == "good";
    std::string program;
    Rig rig(real_time, [&](const SolverOptions& order) {
      return std::make_unique<PartSolver>(
          SolverOptions{order.table, order.path, program, order.wait});
    });
    program = (rig.folder.path / ("fake." + mode)).string();
    fs::create_symlink(TACTUS_FAKE_PART_STRESS, program);
    rig.say("gains", {0.0, 600.0, 0.0, 0.0});
    Rig::loaded(rig).say("anchor", {0.0, 0.0, 0.0});
    rig.hold(50, 0, 0);
    REQUIRE(rig.wait_for("loaded"));
    REQUIRE(rig.wait([&] { return rig.host.sent.contains(1); }));
    rig.run(300);
    const std::size_t from = rig.host.sent.at(1).size() - 1;
    rig.say("list", {1.0, 0.0}); // mm
    REQUIRE(rig.wait(
        [&] { return good ? !rig.host.said("method full").empty() : !rig.host.errors.empty(); }));
    rig.run(300);
    rig.say("list", {0.0, 0.0});
    REQUIRE(rig.wait([&] { return std::abs(rig.gamma() - 0.5) < 1e-3; }));
    rig.run(1000);
    CHECK(rig.host.errors.size() == (good ? 0 : 1));
    if (!good)
      CHECK(rig.host.errors[0].starts_with("resolve: "));
    CHECK(rig.largest_step(from) <= 0.01 * 30 + 1e-9);
  }
}

TEST_CASE("a named solver replaces the one before") {
  Rig rig(false, [](const SolverOptions& order) -> std::unique_ptr<Reanalysis> {
    return order.program.empty() ? nullptr : std::make_unique<PartSolver>(order);
  });
  fs::create_symlink(TACTUS_FAKE_PART_STRESS, rig.folder.path / "fake.good");
  rig.say("load", {"cantilever.stress.npz"});
  rig.say("list", {1.0, 0.0});
  rig.run(500);
  CHECK(rig.host.said("method full").empty());
  for (const char* wrong : {"nothing", "cantilever.stress.npz"}) {
    rig.host.errors.clear();
    rig.say("solver", {wrong});
    REQUIRE(rig.host.errors.size() == 1);
    CHECK(rig.host.errors[0].find("no executable file") != std::string::npos);
  }
  rig.host.errors.clear();
  rig.say("solver", {"fake.good"});
  rig.run(500);
  CHECK(!rig.host.said("method full").empty()); // conjugate gradients, then new sensitivities
  CHECK(rig.host.errors.empty());
}

TEST_CASE("a table that cannot be read leaves the one before, also one that is not taken yet") {
  const test::TableFolder folder;
  StressWorker worker;
  StressJob::Request request;
  for (const char* name : {"cantilever.stress.npz", "none.stress.npz"}) {
    request.path = (folder.path / name).string();
    request.name = name;
    ++request.load;
    worker.request_here(request);
    worker.finish();
  }
  const auto taken = worker.take();
  REQUIRE(taken.answer);
  CHECK(taken.answer->load == 1);
  CHECK(taken.sentences ==
        std::vector<std::string>{"load none.stress.npz: it is not a readable file"});
  request.table = 1; // and it is evaluated
  request.displacement_m = {0, 0};
  worker.request_here(request);
  worker.finish();
  CHECK(worker.take().answer->result.table == 1);
}

TEST_CASE("in real time the thread draws: what is asked while the table is read comes after it") {
  Rig rig(true);
  rig.say("draw");
  REQUIRE(rig.host.errors.size() == 1);
  rig.say("load", {"cantilever.stress.npz"});
  rig.say("draw"); // still being read, or not
  REQUIRE(rig.wait_for("face 1"));
  CHECK(!rig.host.said("picture 2 2 ").empty()); // faces, control points, scale
  CHECK(rig.host.said("point 1") == "point 1 100 10 0");
  // Both faces move: corner 3 by 1 mm; corner 4, of the second alone, by 2 mm.
  const auto draw_until = [&](const std::string& start) {
    rig.host.infos.clear();
    rig.say("draw");
    return rig.wait_for(start);
  };
  rig.say("list", {2.0, 1.0}); // mm
  REQUIRE(draw_until("face 1"));
  CHECK(rig.host.said("point 1") == "point 1 100 11 0");
  CHECK(rig.host.said("face 0 ").ends_with(" 100 11"));
  CHECK(rig.host.said("face 1 ").ends_with(" 100 11 0 12"));
  // Nothing has changed: no face, but the points.
  REQUIRE(draw_until("point 1"));
  CHECK(rig.host.said("face").empty());
  // Another table is drawn whole, and a picture asked of the old one is not taken for its own.
  rig.say("draw");
  rig.host.infos.clear(); // before the load, which may be done when it returns
  rig.say("load", {"cantilever.stress.npz"});
  REQUIRE(rig.wait_for("loaded"));
  REQUIRE(draw_until("face 1"));
  CHECK(rig.host.said("face 1 ").ends_with(" 100 10 0 10"));
  CHECK(rig.host.errors.size() == 1);
}

TEST_CASE("tables loaded one after another: the last one counts, and an end while it reads") {
  StressTable large = test::four_elements();
  large.base.von_mises.stress.assign(2000, 1e6F);
  large.base.von_mises.sensitivity.assign(6000, 0);
  for (int round = 0; round < 8; ++round) {
    Rig rig(true);
    rig.folder.write("large.stress.npz", large);
    rig.say("range", {"fixed", 0.0, 2e6});
    rig.say("load", {"cantilever.stress.npz"});
    rig.say("load", {"large.stress.npz"});
    if (round % 2)
      continue; // destroyed now
    REQUIRE(rig.wait_for("loaded large.stress.npz"));
    REQUIRE(
        rig.wait([&] { return rig.host.sent.contains(0) && std::abs(rig.gamma() - 0.5) < 1e-9; }));
    rig.say("list", {1.0, 2.0, 3.0});
    CHECK(rig.host.errors.empty());
  }
}
