// A solver of modes that runs as a child process, and every way in which it can fail. A script
// stands for modal_fem (fake_modal_fem.py); tests/patches/test_shape_solver.py runs the program
// itself.
#include "externals/modal_impact~/mode_solver.hpp"
#include "files/tables.hpp"
#include "tests/externals/table_folder.hpp"
#include "tests/files/modal_members.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sys/wait.h>
#include <thread>

using namespace tactus;
using namespace tactus::modal;

namespace {

namespace fs = std::filesystem;

std::vector<test::Member> reshaped_table() {
  auto members = test::small_table();
  members.push_back({"control_points", "<f8", {1, 3}, test::raw(std::vector<double>{.1, 0, 0})});
  members.push_back({"parameters", "<f8", {1, 4}, test::raw(std::vector<double>{0, 1, -.01, .01})});
  members.push_back({"trust", "<f8", {}, test::raw(std::vector<double>{.002})});
  members.push_back({"domega2_dp", "<f8", {1, 2}, test::raw(std::vector<double>{1e6, 2e6})});
  members.push_back({"mesh", "|u1", {3}, "abc"});
  return members;
}

/// A table and a fake program beside it. At its end no child may be left.
struct Rig {
  test::TemporaryFolder folder;
  std::shared_ptr<const LoadedTable> table;
  std::unique_ptr<ModeSolver> solver;
  ModeJob::Request request;

  explicit Rig(const std::string& mode, const ModeJob::Limits& limits = {}) {
    const fs::path body = folder.path / "body.modal.npz", program = folder.path / ("fake." + mode);
    const std::string bytes = test::archive(reshaped_table());
    std::ofstream(body, std::ios::binary) << bytes;
    ModalTable read;
    REQUIRE(files::read_modal_table(std::as_bytes(std::span(bytes)), read) == "");
    REQUIRE(read.has_mesh);
    table = std::make_shared<const LoadedTable>(std::move(read));
    fs::create_symlink(TACTUS_FAKE_MODAL_FEM, program);
    solver = std::make_unique<ModeSolver>(limits);
    request = {1, body.string(), program.string(), table, {.003}};
  }
  ~Rig() {
    solver.reset();
    int tries = 0; // its thread ends the child
    while (waitpid(-1, nullptr, WNOHANG) != -1 && ++tries < 10000)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    CHECK(tries < 10000);
  }
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  /// Up to a minute.
  [[nodiscard]] ModeJob::Answer solve(bool threaded) const {
    std::atomic<bool> ready{false};
    solver->on_ready([&] { ready = true; });
    if (!threaded) {
      solver->request_here(request);
      solver->finish();
      ready = true;
    } else {
      REQUIRE(solver->request(request).empty());
    }
    for (int i = 0; i < 60000 && !ready; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    solver->on_ready({});
    auto answer = solver->take().answer;
    return answer ? std::move(*answer) : ModeJob::Answer{};
  }
};

} // namespace

TEST_CASE("a child solves shape after shape, each from the modes of the one before") {
  for (const bool threaded : {false, true}) {
    CAPTURE(threaded);
    Rig rig("good");
    auto result = rig.solve(threaded);
    REQUIRE(result.refusal == "");
    REQUIRE(result.table);
    CHECK(result.before == rig.table);
    CHECK(result.table->follows(*rig.table));
    CHECK(result.seconds == 0); // the parameters of the modes before, by the fake
    CHECK(result.table->table.frequency_hz[0] == doctest::Approx(440 * 1.03).epsilon(1e-12));
    CHECK(result.table->table.sensitivity.solved_at(0) == .003);
    CHECK(result.table->table.has_mesh);
    rig.request.table = result.table;
    rig.request.displacement_m = {.001};
    const auto next = rig.solve(threaded);
    REQUIRE(next.table);
    CHECK(next.seconds == .003);
    CHECK(next.table->follows(*result.table));
    CHECK(!next.table->follows(*rig.table));
    CHECK(next.table->table.frequency_hz[0] == doctest::Approx(440 * 1.01).epsilon(1e-12));
  }
}

// What every served program may do is tested by part_solver_test.cpp.
TEST_CASE("a child that fails is lost, with its reason") {
  for (const auto& [name, words] :
       {std::pair("dies", "the solver ended: modal_fem: a  reason"),
        std::pair("sizes", "vertices and 1 parameters: expected the table's 4 and 1"),
        std::pair("mute", "did not answer within 0.4 s"), std::pair("shares", "expected -1..1"),
        std::pair("damaged", "the solver sent an invalid answer")}) {
    const std::string mode = name; // a binding cannot be captured
    CAPTURE(mode);
    // Only what waits for ever must meet its limit: the others have time on a busy machine.
    Rig rig(mode, {60, mode == "mute" ? 0.4 : 60});
    const auto result = rig.solve(mode != "dies"); // its caller may wait, too
    CAPTURE(result.refusal);
    CHECK(result.lost);
    CHECK(!result.table);
    CHECK(result.refusal.find(words) != std::string::npos);
    CHECK(result.refusal.find_first_of("\n\r\a") == std::string::npos);
  }
}

TEST_CASE("a solve that is refused is one sentence, and the child goes on") {
  Rig rig("refuses");
  for (int i = 0; i < 2; ++i) {
    const auto result = rig.solve(true);
    CHECK(!result.lost);
    CHECK(result.refusal == "the body is singular");
  }
}

TEST_CASE("a move that the mesh does not bear is solved as far as it does") {
  Rig rig("cut");
  const auto result = rig.solve(false);
  REQUIRE(result.table);
  CHECK(result.fraction == .5);
  CHECK(result.table->table.sensitivity.solved_at(0) == .0015);
}

TEST_CASE("a solver is ended in the middle of whatever it does, and solves another table after") {
  for (const char* mode : {"good", "hangs", "mute"}) {
    Rig rig(mode);
    REQUIRE(rig.solver->request(rig.request).empty());
    while (std::string(mode) == "mute" && !fs::exists(rig.folder.path / "body.modal.npz.asked"))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ModeJob::Request none;
    none.number = 2;
    REQUIRE(rig.solver->request(none).empty());
    if (std::string(mode) == "good") {
      while (rig.solver->take().finished < 2)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      rig.request.number = 2;
      CHECK(rig.solve(true).table);
    }
  }
}
