// A solver that runs as a child process, and every way in which it can fail. A script stands for
// part_stress (fake_part_stress.py); tests/patches/test_stress_solver.py runs the program itself.
#include "externals/stress_haptic/part_solver.hpp"
#include "tests/externals/table_folder.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <sys/wait.h>
#include <thread>

using namespace tactus;
using namespace tactus::stress;
using test::Cantilever;

namespace {

namespace fs = std::filesystem;

std::size_t open_descriptors() {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator("/proc/self/fd"))
    count += entry.path().empty() ? 0 : 1;
  return count;
}

/// A table and a fake program beside it. At its end no child and no descriptor may be left.
struct Rig {
  test::TableFolder folder;
  StressTable table = Cantilever::table();
  std::size_t descriptors = open_descriptors();
  std::unique_ptr<PartSolver> solver;

  explicit Rig(const std::string& mode, bool wait = false, PartSolver::Limits limits = {}) {
    const fs::path program = folder.path / ("fake." + mode);
    fs::create_symlink(fs::path(TACTUS_FAKE_PART_STRESS), program);
    solver = std::make_unique<PartSolver>(
        SolverOptions{table, (folder.path / "cantilever.stress.npz").string(), program.string(),
                      wait},
        limits);
  }
  ~Rig() {
    solver.reset();
    CHECK(waitpid(-1, nullptr, WNOHANG) == -1); // no child, ended or not
    CHECK(open_descriptors() == descriptors);
  }
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  [[nodiscard]] bool prepare() const {
    for (int i = 0; i < 60000; ++i) {
      if (solver->prepare())
        return true; // not asked again: a child that leaves may be gone by then
      if (refused())
        return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  [[nodiscard]] bool refused() const {
    if (auto found = solver->poll()) {
      result = std::move(*found);
      return true;
    }
    return false;
  }
  /// Up to a minute.
  const Reanalysis::Result& solve(std::vector<double> p, Method method = Method::kPcg,
                                  bool sensitivities = false) const {
    result = {};
    REQUIRE(solver->start(p, method, sensitivities).empty());
    for (int i = 0; i < 60000 && !refused(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return result;
  }
  void is_lost(const std::string& words) const {
    CAPTURE(result.refusal);
    CHECK(result.lost);
    CHECK(result.refusal.find(words) != std::string::npos);
    CHECK(result.refusal.find_first_of("\n\r\a") == std::string::npos);
    CHECK(!solver->prepare());
    CHECK(!refused()); // one sentence
  }
  mutable Reanalysis::Result result;
};

} // namespace

TEST_CASE("a child solves the part: stress alone, then its sensitivities") {
  for (const bool wait : {false, true}) {
    Rig rig("good", wait);
    REQUIRE(rig.prepare());
    const Reanalysis::Costs costs = rig.solver->costs();
    CHECK(costs.factor_s == (wait ? 0 : 0.01)); // a caller that waits chooses by iterations
    const auto& own = rig.table.base.von_mises;
    auto result = rig.solve({0.004, 0});
    REQUIRE(result.base);
    CHECK(result.refusal.empty());
    CHECK(result.method == Method::kPcg);
    CHECK(result.iterations == 12);
    CHECK(result.seconds == 0.01);
    CHECK(result.stale_sensitivities);
    CHECK(result.base->displacement_m == std::vector<double>{0.004, 0});
    CHECK(result.base->von_mises.sensitivity == own.sensitivity);
    CHECK(result.base->von_mises.stress[3] == doctest::Approx(1.04 * own.stress[3]).epsilon(1e-6));
    CHECK(check_base(rig.table, *result.base).empty());
    result = rig.solve({0.004, 0}, Method::kPcg, true);
    CHECK(result.method == Method::kFull);
    CHECK(!result.stale_sensitivities);
    CHECK(result.base->von_mises.sensitivity[3] ==
          doctest::Approx(10 * own.stress[3]).epsilon(1e-6));
    const auto kept = result.base->von_mises.sensitivity;
    result = rig.solve({0.001, 0}, Method::kFull);
    CHECK(result.method == Method::kFull);
    CHECK(result.base->von_mises.sensitivity == kept); // the newest that there are
  }
}

TEST_CASE("a program that is not there or cannot run is one sentence") {
  Rig rig("good");
  const std::string text = (rig.folder.path / "text").string();
  std::ofstream(text) << "#!/nowhere/interpreter\n";
  fs::permissions(text, fs::perms::owner_all);
  for (const std::string& program :
       {std::string("/nowhere/part_stress"), std::string("no_such_program_of_this_name"),
        std::string("/etc/passwd"), text}) {
    rig.solver = std::make_unique<PartSolver>(SolverOptions{rig.table, "x", program, false});
    CHECK(!rig.prepare());
    rig.is_lost(program == text ? "cannot start: No such file" : "was not found");
  }
}

TEST_CASE("a child that fails is lost, with its reason, and its parent gets no signal") {
  struct Failure {
    std::string mode, words;
    bool loads = false; // it fails when it solves
    bool wait = false;  // its caller does, as in a render that is not in real time
  };
  const Failure failures[] = {
      {"dies", "the solver ended: part_stress: a  reason"},
      {"dies", "the solver ended: part_stress: a  reason", false, true},
      {"hangs", "did not answer within 0.3 s"},
      {"garbage", "sent an invalid answer"},
      {"huge", "sent an invalid answer"},
      {"sizes", "parameters: expected the table's"},
      {"costs", "expected 0..100000 s"},
      {"another", "stress at the table's own shape differs"},
      {"killed", "the solver ended: signal 9", true},
      {"mute", "did not answer within 0.448 s", true}, // 20 (0.01 + 62 * 0.0002)
      {"mute", "did not answer within 0.448 s", true, true},
      {"nonsense", "impossible numbers", true},
      {"half", "the solver ended: status 0", true},
      {"short", "sent an invalid answer", true},
  };
  for (const Failure& failure : failures) {
    CAPTURE(failure.mode);
    // Only what waits for ever must meet its limit: the others have time on a busy machine.
    Rig rig(failure.mode, failure.wait,
            {failure.mode == "hangs" ? 0.3 : 60, failure.mode == "mute" ? 0.1 : 60});
    if (failure.loads)
      REQUIRE(rig.prepare());
    if (failure.loads || failure.wait)
      static_cast<void>(rig.solve({0.001, 0}));
    else
      CHECK(!rig.prepare());
    rig.is_lost(failure.words);
  }
}

TEST_CASE("a child that has gone is noticed at the next look, and by a request") {
  const auto until_refused = [](const Rig& rig) {
    for (int i = 0; i < 60000 && !rig.refused(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  for (const bool asks : {false, true}) {
    Rig rig("leaves"); // after the comparison with the table
    REQUIRE(rig.prepare());
    siginfo_t ended;
    REQUIRE(waitid(P_ALL, 0, &ended, WEXITED | WNOWAIT) == 0);
    if (asks)
      static_cast<void>(rig.solve({0.001, 0}));
    else
      until_refused(rig);
    rig.is_lost("the solver ended: status 3");
  }
  Rig rig("floods");
  REQUIRE(rig.prepare());
  CHECK(rig.solve({0.001, 0}).base);
  until_refused(rig);
  rig.is_lost("sent an invalid answer");
}

TEST_CASE("a child that refuses a solve, or says much on stderr, solves the next") {
  for (const char* mode : {"refuses", "talks"}) {
    Rig rig(mode);
    REQUIRE(rig.prepare());
    if (std::string(mode) == "refuses") {
      const auto refused = rig.solve({0.001, 0});
      CHECK(!refused.lost);
      CHECK(!refused.base);
      CHECK(refused.refusal == "the part is singular");
    }
    CHECK(rig.solve({0.001, 0}).base);
  }
}

TEST_CASE("a solver is ended in the middle of whatever it does") {
  for (const char* mode : {"good", "hangs", "mute"}) {
    Rig rig(mode);
    CHECK(!rig.solver->prepare()); // a child has been started
    if (std::string(mode) == "mute") {
      REQUIRE(rig.prepare());
      CHECK(rig.solver->start(std::vector<double>{0.001, 0}, Method::kPcg, false).empty());
    }
  }
}
