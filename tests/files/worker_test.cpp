// One worker for what objects compute in the background. Its threads are awaited by what they say,
// never by the clock.
#include "files/worker.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#ifdef __linux__
#include <sys/wait.h>
#include <unistd.h>
#endif

using namespace tactus;

namespace {

/// What a test and a job share.
struct Log {
  std::atomic<int> begun{0}; ///< pieces
  std::atomic<bool> held{false};
  std::atomic<int> last_acts{0}, ended{0};

  void await_begun(int pieces) const {
    while (begun < pieces)
      std::this_thread::yield();
  }
};

/// Counts up to the number asked for, one a piece; holds in a piece while the test wants it.
struct Counter {
  struct Request {
    int to = 0;
    std::string sentence{};
    double pause_s = kDueNow; ///< between two pieces
  };
  struct Answer {
    int asked = 0, counted = 0;
  };
  static constexpr const char* kOutOfMemory = "not enough memory";

  explicit Counter(std::shared_ptr<Log> with) : log(std::move(with)) {}
  Counter(const Counter&) = delete;
  Counter& operator=(const Counter&) = delete;
  ~Counter() { ++log->ended; }
  double work(const Request& request, Turn<Answer>& turn) {
    ++log->begun;
    while (log->held && !(request.to < 0 && turn.is_superseded()))
      std::this_thread::yield();
    if (turn.is_new())
      counted = 0;
    if (request.sentence == "throw")
      throw std::bad_alloc();
    if (!request.sentence.empty())
      turn.say(request.sentence);
    turn.hand_over({request.to, ++counted});
    return counted >= request.to        ? kNever
           : request.pause_s == kDueNow ? kDueNow
                                        : turn.now_s() + request.pause_s;
  }
  void end() { ++log->last_acts; }
  std::shared_ptr<Log> log;
  int counted = 0;
};

struct Rig {
  std::shared_ptr<Log> log = std::make_shared<Log>();
  Worker<Counter> worker{log};
  std::vector<std::string> sentences;

  void request(const Counter::Request& request) { REQUIRE(worker.request(request) == ""); }
  /// All that is handed over until the newest request is finished.
  std::vector<Counter::Answer> await() {
    std::vector<Counter::Answer> answers;
    for (bool finished = false; !finished; std::this_thread::yield()) {
      auto taken = worker.take();
      if (taken.answer)
        answers.push_back(*taken.answer);
      sentences.insert(sentences.end(), taken.sentences.begin(), taken.sentences.end());
      finished = taken.finished == worker.requested();
    }
    return answers;
  }
};

} // namespace

TEST_CASE(
    "of the requests that wait the newest counts; what one before had computed is handed over") {
  Rig rig;
  rig.log->held = true;
  rig.request({1});
  rig.log->await_begun(1);
  rig.request({2});
  rig.request({3});
  CHECK(rig.worker.take().finished == 0);
  CHECK(rig.worker.busy());
  rig.log->held = false;
  rig.log->await_begun(2); // the first is handed over
  const auto answers = rig.await();
  REQUIRE(!answers.empty());
  for (const auto& answer : answers)
    CHECK((answer.asked == 1 || answer.asked == 3));
  CHECK(answers.back().asked == 3);
  CHECK(answers.back().counted == 3);
  CHECK(!rig.worker.busy());
  CHECK(rig.log->begun == 4);
}

TEST_CASE("every sentence is taken, also those of answers that newer ones have replaced") {
  Rig rig;
  for (const char* sentence : {"one", "two", "three"}) {
    rig.request({1, sentence});
    while (rig.log->begun < static_cast<int>(rig.worker.requested()))
      std::this_thread::yield();
  }
  rig.await();
  CHECK(rig.sentences == std::vector<std::string>{"one", "two", "three"});
}

TEST_CASE("a job that memory fails says one sentence, and the next request is worked on") {
  Rig rig;
  rig.request({1, "throw"});
  CHECK(rig.await().empty());
  CHECK(rig.sentences == std::vector<std::string>{"not enough memory"});
  rig.request({1});
  CHECK(rig.await().size() == 1);
}

TEST_CASE("requests that never stop coming keep no answer from coming") {
  Rig rig;
  int answers = 0;
  while (answers < 100) {
    rig.request({1});
    if (rig.worker.take().answer)
      ++answers;
  }
}

TEST_CASE("a piece is due again when the job says so, in the thread and in the caller") {
  Rig rig;
  rig.request({3, "", 1e-4});
  for (int counted = 0; counted < 3; std::this_thread::yield())
    if (const auto answer = rig.worker.take().answer)
      counted = answer->counted;
  CHECK(rig.worker.due_in_s(0) == kNever); // not the caller's
  rig.worker.request_here({3, "", 0.5});
  CHECK(rig.worker.due_in_s(7) == 0);
  rig.worker.step(7);
  CHECK(rig.worker.due_in_s(7) == 0.5);
  CHECK(rig.worker.due_in_s(9) == 0);
  rig.worker.step(7.25);
  rig.worker.finish(); // nothing is due at once
  CHECK(rig.worker.take().answer->counted == 1);
  rig.worker.step(7.5);
  rig.worker.step(8);
  const auto taken = rig.worker.take();
  CHECK(taken.answer->counted == 3);
  CHECK(taken.finished == rig.worker.requested());
  CHECK(rig.worker.due_in_s(8) == kNever);
}

TEST_CASE("without a thread the same calls do the same in the caller") {
  Rig rig;
  int ready = 0;
  rig.worker.on_ready([&ready] { ++ready; });
  rig.worker.request_here({1, "one"});
  rig.worker.request_here({4});
  CHECK(rig.worker.is_here());
  rig.worker.finish();
  const auto taken = rig.worker.take();
  CHECK(taken.answer->asked == 4);
  CHECK(taken.answer->counted == 4);
  CHECK(taken.sentences.empty()); // the first was never begun
  CHECK(ready == 0);
  CHECK(rig.log->begun == 4);
}

TEST_CASE("the caller waits for the thread's piece where it must have the answer, and only there") {
  Rig rig;
  rig.log->held = true;
  rig.request({5});
  rig.log->await_begun(1);
  rig.worker.request_here({2});
  rig.worker.step(0); // the thread is at work: not now
  CHECK(rig.log->begun == 1);
  CHECK(!rig.worker.take().answer);
  std::thread other([&] { rig.log->held = false; });
  rig.worker.finish();
  other.join();
  const auto answer = rig.worker.take().answer;
  CHECK(answer->asked == 2);
  CHECK(answer->counted == 2);
  CHECK(rig.log->begun == 3);
  rig.request({1}); // and back
  CHECK(rig.await().back().asked == 1);
}

TEST_CASE("a job that waits for something is told when nobody waits for it any more") {
  const auto log = std::make_shared<Log>();
  log->held = true;
  {
    Worker<Counter> worker(log);
    REQUIRE(worker.request({-1}) == "");
    log->await_begun(1);
    REQUIRE(worker.request({-2}) == "");
    log->await_begun(2);
  }
  while (log->ended == 0)
    std::this_thread::yield();
}

TEST_CASE("a worker that goes waits for nothing, and its thread tells nobody and holds nothing") {
  const auto log = std::make_shared<Log>();
  std::atomic<int> ready{0};
  log->held = true;
  {
    Worker<Counter> worker(log);
    worker.on_ready([&ready] { ++ready; });
    REQUIRE(worker.request({5}) == "");
    log->await_begun(1);
  }
  CHECK(log->ended == 0);
  log->held = false;
  while (log->ended == 0)
    std::this_thread::yield();
  CHECK(ready == 0);
  CHECK(log->begun == 1); // the piece in progress was the last
  CHECK(log->last_acts == 1);
}

TEST_CASE("what waits to be taken is announced, as often as there is something new") {
  Rig rig;
  std::atomic<int> ready{0};
  rig.worker.on_ready([&ready] { ++ready; });
  for (int i = 1; i <= 3; ++i) {
    rig.request({1});
    while (ready < i)
      std::this_thread::yield();
    CHECK(rig.worker.take().answer);
  }
}

TEST_CASE("(for the next) a job never ends" * doctest::skip()) {
  const auto log = std::make_shared<Log>();
  log->held = true;
  Worker<Counter> worker(log);
  REQUIRE(worker.request({1}) == "");
  log->await_begun(1);
}

#ifdef __linux__
TEST_CASE("a job that never ends does not keep the program from ending") {
  const pid_t child = fork();
  if (child == 0) {
    execl("/proc/self/exe", "files_test", "--no-skip", "--test-case=(for the next)*", nullptr);
    _exit(127);
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}
#endif
