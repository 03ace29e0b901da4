// [modal_impact~] in real time: what waits for its worker, whose answers the test hands on when it
// wants to.
#include "externals/modal_impact~/modal_impact~.hpp"
#include "tests/externals/by_name.hpp"
#include "tests/externals/recording_host.hpp"
#include "tests/externals/table_folder.hpp"
#include "tests/files/modal_members.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>
#include <vector>

using namespace tactus;
using namespace tactus::modal;
using namespace tactus::modal_impact;

namespace {

constexpr double kSilent = 1e-6; // the recoil in its slow suspension is below it

struct Rig {
  test::TemporaryFolder folder;
  test::RecordingHost host{folder.path, true};
  ModalImpact object;
  int answers = 0;

  Rig() {
    std::vector<test::Member> members = test::small_table();
    std::ofstream(folder.path / "mute.modal.npz", std::ios::binary) << test::archive(members);
    using test::raw;
    members.insert(members.end(), {{"mp_lmax", "<i4", {2}, raw(std::vector<std::int32_t>{0, 0})},
                                   {"mp_off", "<i4", {3}, raw(std::vector<std::int32_t>{0, 1, 2})},
                                   {"mp_coef", "<c8", {2}, raw(std::vector<float>{1, 0, 1, 0})},
                                   {"mp_center", "<f8", {3}, raw(std::vector<double>{0, 0, 0})},
                                   {"mp_rref", "<f8", {}, raw(std::vector<double>{.2})}});
    std::ofstream(folder.path / "small.modal.npz", std::ios::binary) << test::archive(members);
    std::string& meta = members[0].data;
    meta.replace(meta.find("free"), 4, "held");
    meta.replace(meta.find("four corners"), 12, "held corners");
    std::ofstream(folder.path / "held.modal.npz", std::ios::binary) << test::archive(members);
    object.prepare(48000, 64);
    test::set(object, "radiation", 2); // of the body: models are built by the worker, however small
    test::set(object, "sync", 2);
    test::set(object, "choke", 0.001); // 60 dB in a millisecond after a reset
    say("load", {"small.modal.npz"});
    object.created(host);
    take_answer();
  }
  void say(std::string_view message, const std::vector<Atom>& atoms) {
    test::send(object, message, std::span<const Atom>(atoms), host);
  }
  void take_answer() {
    while (host.woken == answers)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    answers = host.woken;
    object.posted(host);
  }
  /// The largest sample of ten blocks.
  double peak() {
    std::array<std::vector<double>, 10> signal;
    signal.fill(std::vector<double>(64, 0.0));
    std::array<const double*, 4> in{}; // every signal inlet and outlet
    std::array<double*, 6> out{};
    for (std::size_t i = 0; i < in.size(); ++i)
      in[i] = signal[i].data();
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = signal[in.size() + i].data();
    double largest = 0;
    for (int block = 0; block < 10; ++block) {
      object.process(Block<double>{in, out, 64, host.time_ms});
      host.time_ms += 64 / 48.0;
      for (const double sample : signal[in.size()])
        largest = std::max(largest, std::abs(sample));
    }
    return largest;
  }
  /// What dump says last that begins so, when every change is answered.
  std::string settled(const std::string& start) {
    while (width() == 0)
      take_answer();
    host.infos.clear();
    object.dump(host);
    return host.said(start);
  }
  double width() {
    host.infos.clear();
    say("info", {});
    const std::string box = host.said("box ");
    return box.empty() ? 0 : std::stod(box.substr(box.rfind(' ')));
  }
};

} // namespace

TEST_CASE(
    "with sync 2 strikes and info wait for a size that came before them, not for a listener") {
  Rig rig;
  const double width = rig.width();
  REQUIRE(width > 0);
  CHECK(rig.peak() == 0);
  rig.say("listener", {1.0, 0.0, 0.0, 200.0});
  rig.say("hit", {1.0});
  CHECK(rig.peak() > kSilent);
  rig.take_answer();
  rig.say("reset", {});
  rig.peak();
  REQUIRE(rig.peak() < kSilent);

  test::set(rig.object, "size", 2);
  rig.say("hit", {1.0});
  CHECK(rig.width() == 0); // waits behind the strike
  CHECK(rig.peak() < kSilent);
  rig.take_answer();
  CHECK(rig.peak() > kSilent);
  CHECK(rig.host.said("box ") != "");
  CHECK(rig.width() == doctest::Approx(2 * width));
  CHECK(rig.host.errors.empty());

  test::set(rig.object, "size", 1);
  for (std::size_t i = 0; i < 65; ++i)
    rig.say("hit", {1.0});
  REQUIRE(rig.host.errors.size() == 1);
  CHECK(rig.host.errors[0].find("64 messages are already queued") != std::string::npos);
  rig.take_answer();

  test::set(rig.object, "size", 3); // a reset silences what waits, too
  rig.say("hit", {1.0});
  rig.say("reset", {});
  rig.take_answer();
  rig.peak();
  CHECK(rig.peak() < kSilent);
}

TEST_CASE("a radiation for which the table has no arrays is refused, and get tells what is used") {
  Rig rig;
  REQUIRE(test::get(rig.object, "radiation") == 2);
  test::set(rig.object, "radiation", 1);
  REQUIRE(rig.host.errors.size() == 1);
  CHECK(rig.host.errors[0].find("radiation raw: the table has no arrays raw_v") == 0);
  CHECK(rig.host.errors[0].ends_with("using body"));
  CHECK(test::get(rig.object, "radiation") == 2);
  rig.say("load", {"mute.modal.npz"});
  rig.take_answer();
  REQUIRE(rig.host.errors.size() == 2);
  CHECK(rig.host.errors[1].find("radiation body: the table has no arrays mp_coef") == 0);
  CHECK(rig.host.errors[1].ends_with("using modal"));
  CHECK(test::get(rig.object, "radiation") == 0);
  rig.say("hit", {1.0});
  CHECK(rig.peak() > kSilent);
  CHECK(rig.host.errors.size() == 2);
}

TEST_CASE(
    "a solution takes the place of the body that it was made of, on its board, and of no other") {
  const Rig rig;
  TableWorker worker;
  TableJob::Request request;
  const auto file = [&rig](const char* name, std::uint64_t number) {
    return TableFile{(rig.folder.path / name).string(), name, number};
  };
  const auto answer_to = [&worker](const TableJob::Request& asked) {
    worker.request_here(asked);
    worker.finish();
    return worker.take();
  };
  request.body = file("small.modal.npz", 1);
  request.board = file("held.modal.npz", 1);
  request.board_displacement_m = {0, 0, -.3};
  const auto first = answer_to(request).answer;
  REQUIRE(first);
  REQUIRE(first->table->parts.size() == 2);
  ModalTable shifted = first->table->body().table;
  shifted.shape.assign(2 * 4 * 3, 1);
  request.solved = std::make_shared<const LoadedTable>(
      std::move(shifted), first->table->body(), std::vector<ModeShare>{{0, 0, 1}, {1, 1, 1}});
  request.solved_body = request.solved_number = 1;
  const auto second = answer_to(request).answer;
  REQUIRE(second);
  CHECK(second->in_use.solved == 1);
  CHECK(second->table->parts[0].loaded == request.solved);
  CHECK(second->table->parts[1].loaded == first->table->parts[1].loaded);
  CHECK(second->table->follows(*first->table));

  request.body = file("mute.modal.npz", 2);
  request.solved_number = 2; // still of the first
  const auto third = answer_to(request).answer;
  REQUIRE(third);
  CHECK(third->in_use.body.number == 2);
  CHECK(third->in_use.solved == 0);
  CHECK(third->table->parts[0].loaded != request.solved);
  request.body = file("no.modal.npz", 3);
  const auto fourth = answer_to(request);
  CHECK(fourth.sentences ==
        std::vector<std::string>{"load no.modal.npz: it is not a readable file"});
  CHECK(fourth.answer->in_use.body.number == 2);
  CHECK(answer_to(request).sentences.empty()); // once
}

TEST_CASE("a board that waits is kept when the table before it cannot be read") {
  Rig rig;
  const auto path = rig.folder.path / "long.modal.npz";
  std::ofstream(path).put('x');
  std::filesystem::resize_file(path, std::uint64_t{1} << 26); // read in tenths of a second
  rig.say("load", {"long.modal.npz"});                        // the worker is busy
  rig.say("load", {"long.modal.npz"});
  rig.say("board", {"held.modal.npz", 0.0, 0.0, -300.0});
  test::set(rig.object, "size", 2);
  CHECK(rig.settled("board ") == "board held.modal.npz 0 0 -300");
  CHECK(rig.settled("body ") == "body four corners");
  REQUIRE(!rig.host.errors.empty());
  for (const std::string& error : rig.host.errors)
    CHECK(error.starts_with("load long.modal.npz: "));
}

TEST_CASE("what is set while a table is read holds for it, too") {
  Rig rig;
  const double width = rig.width();
  test::set(rig.object, "radiation", 0); // built at once
  rig.say("load", {"held.modal.npz"});
  test::set(rig.object, "size", 2);
  CHECK(rig.settled("body ") == "body held corners");
  CHECK(rig.width() == doctest::Approx(2 * width));
}

TEST_CASE("a table that is read at once is not replaced by one that was asked for before") {
  Rig rig;
  rig.say("load", {"held.modal.npz"});
  rig.say("load", {"mute.modal.npz", "-sync"});
  REQUIRE(rig.host.said("loaded ") == "loaded four corners 2");
  test::set(rig.object, "radiation", 3);
  test::set(rig.object, "modes", 1); // whatever the worker has done since comes before this
  CHECK(rig.settled("body ") == "body four corners");
}

TEST_CASE("a board that waits to be read is not lost by the changes that come after it") {
  Rig rig;
  const auto board_after = [&rig](auto change) {
    change();
    return rig.settled("board ");
  };
  for (int round = 0; round < 4; ++round) {
    REQUIRE(board_after([&] { rig.say("board", {"none"}); }) == "board none");
    const std::string board = board_after([&] {
      test::set(rig.object, "size", 2); // the worker is busy
      rig.say("board", {"held.modal.npz", 0.0, 0.0, -300.0});
      test::set(rig.object, "size", 1);
      test::set(rig.object, "size", 1.5);
    });
    CHECK(board == "board held.modal.npz 0 0 -300");
  }
  CHECK(rig.host.errors == std::vector<std::string>{});
}
