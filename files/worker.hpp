#pragma once

#include "files/background_thread.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tactus {

/// Special due times of a job's next piece: at once, or never.
inline constexpr double kDueNow = -std::numeric_limits<double>::infinity();
inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// One piece of a job, as its work() receives it.
template <class Answer> class Turn {
public:
  /// Whether this is the first piece of its request.
  [[nodiscard]] bool is_new() const noexcept { return is_new_; }
  [[nodiscard]] double now_s() const noexcept { return now_s_; }
  /// True if a newer request waits or the owner has gone. A job that waits for something then stops
  /// waiting. Its results so far are handed over in any case.
  [[nodiscard]] bool is_superseded() const noexcept { return state_.stop || state_.superseded; }
  /// Replaces an answer that has not been taken yet.
  void hand_over(Answer answer) {
    std::optional<Answer> fresh(std::move(answer));
    const std::lock_guard lock(state_.mutex);
    fresh.swap(state_.answer); // frees the old answer, perhaps large, after unlocking
    state_.has_output = true;
  }
  /// Passes a sentence to the user. No sentence is dropped.
  void say(std::string sentence) {
    const std::lock_guard lock(state_.mutex);
    state_.sentences.push_back(std::move(sentence));
    state_.has_output = true;
  }

private:
  template <class, class> friend class Worker;
  struct State : BackgroundState {
    std::atomic<bool> superseded{false};
    std::optional<Answer> answer;
    std::vector<std::string> sentences;
    bool has_output = false;
  };
  Turn(State& state, bool is_new, double now_s) : state_(state), is_new_(is_new), now_s_(now_s) {}
  State& state_;
  bool is_new_;
  double now_s_;
};

/// Computes answers to an object's requests in a thread of normal priority. In a render, or if the
/// system starts no thread, the object's own thread computes them by the same calls.
///
/// A request is a complete state ("this body on this board with these settings"), never a change of
/// one, so that a newer request can replace a waiting one. Answers to older requests are handed
/// over as well, so that answers arrive even if requests are frequent.
///
/// A Job defines the types Request and Answer, and kOutOfMemory, the sentence for lack of memory.
///   double work(const Request&, Turn<Answer>&)
/// computes a piece of a request and returns the time, on the turn's clock, at which the next piece
/// is due. Newer requests are noticed between pieces. The job must own all that work() uses,
/// because its last piece may end after the owner. A Job may have a function end(), which is the
/// last call in the thread. No function but finish() waits for a piece in the thread.
template <class Job, class Thread = BackgroundThread> class Worker {
public:
  using Request = typename Job::Request;
  using Answer = typename Job::Answer;

  template <class... Arguments>
  explicit Worker(Arguments&&... of_the_job)
      : state_(std::make_shared<State>(std::forward<Arguments>(of_the_job)...)) {}

  /// `ready` is called in the thread when there is something to take, until the end of this object.
  void on_ready(std::function<void()> ready) {
    const std::lock_guard lock(state_->mutex);
    state_->ready = std::move(ready);
  }
  /// Starts work in the thread. Returns an empty string, or the reason why the system starts no
  /// thread; the request is then treated as one of request_here().
  [[nodiscard]] std::string request(const Request& request) {
    put(request, false);
    if (thread_.running()) {
      state_->changed.notify_all();
      return {};
    }
    std::string reason = thread_.start(state_);
    if (!reason.empty())
      state_->in_caller = true;
    return reason;
  }
  /// Makes a request that the owner computes by step() or finish().
  void request_here(const Request& request) { put(request, true); }
  [[nodiscard]] bool is_here() const noexcept { return state_->in_caller; }
  /// Computes the piece that is due in the calling thread, if there is one.
  void step(double now_s) {
    std::unique_lock lock(state_->mutex);
    if (state_->in_caller && !state_->busy && state_->due_s <= now_s)
      state_->work_on(lock, now_s);
  }
  /// Waits until the thread has ended a piece in progress, then computes in the calling thread all
  /// pieces that are due at once.
  void finish() {
    std::unique_lock lock(state_->mutex);
    state_->changed.wait(lock, [&] { return !state_->busy; });
    while (state_->in_caller && state_->due_s == kDueNow)
      state_->work_on(lock, 0);
  }
  /// Time until the next step() that computes a piece.
  [[nodiscard]] double due_in_s(double now_s) const {
    const std::lock_guard lock(state_->mutex);
    return state_->in_caller ? std::max(0.0, state_->due_s - now_s) : kNever;
  }
  /// True if a request is in progress or a piece is due at once.
  [[nodiscard]] bool busy() const {
    const std::lock_guard lock(state_->mutex);
    return state_->finished != requested_;
  }
  /// The number of the newest request; 0: none.
  [[nodiscard]] std::uint64_t requested() const noexcept { return requested_; }

  struct Taken {
    std::optional<Answer> answer; ///< the newest, if not yet taken
    std::vector<std::string> sentences;
    std::uint64_t finished = 0; ///< newest request without another piece due at once
  };
  [[nodiscard]] Taken take() {
    const std::lock_guard lock(state_->mutex);
    state_->has_output = false;
    return {std::exchange(state_->answer, {}), std::exchange(state_->sentences, {}),
            state_->finished};
  }

private:
  struct State final : Turn<Answer>::State {
    template <class... Arguments>
    explicit State(Arguments&&... of_the_job) : job(std::forward<Arguments>(of_the_job)...) {}

    void work() override {
      std::unique_lock lock(this->mutex);
      while (!this->stop) {
        const double wait_s = in_caller || busy ? kNever : due_s - now_s();
        if (wait_s <= 0) {
          work_on(lock, now_s());
          if (std::exchange(this->has_output, false) && this->ready)
            this->ready();
        } else if (wait_s == kNever) {
          this->changed.wait(lock);
        } else {
          this->changed.wait_for(lock, std::chrono::duration<double>(std::min(wait_s, kLong_s)));
        }
      }
      lock.unlock();
      if constexpr (requires { job.end(); })
        job.end();
    }
    /// Computes one piece without holding the lock.
    void work_on(std::unique_lock<std::mutex>& lock, double now_s) {
      busy = true;
      const bool is_new = std::exchange(has_waiting, false);
      Request fresh{};
      if (is_new) {
        std::swap(fresh, waiting);
        at_work = requested;
        this->superseded = false;
      }
      lock.unlock();
      if (is_new)
        current = std::move(fresh); // frees the old request's data without the lock
      double next_s = kNever;
      Turn<Answer> turn(*this, is_new, now_s);
      try {
        next_s = job.work(current, turn);
      } catch (const std::exception&) { // bad_alloc, or the length_error of a container
        turn.say(Job::kOutOfMemory);
      }
      lock.lock();
      busy = false;
      if (!has_waiting)
        due_s = next_s;
      if (next_s > now_s) {
        finished = at_work;
        this->has_output = true;
      }
      this->changed.notify_all(); // wakes finish()
    }
    static double now_s() {
      return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
          .count();
    }
    static constexpr double kLong_s = 3600;

    Job job;
    Request current{}; ///< used by the job only, like `job` itself
    // Guarded by the lock, except that the owner reads in_caller without it.
    Request waiting{};
    std::uint64_t requested = 0, at_work = 0, finished = 0;
    double due_s = kNever;
    bool has_waiting = false, busy = false;
    std::atomic<bool> in_caller{true};
  };
  void put(const Request& request, bool in_caller) {
    const std::lock_guard lock(state_->mutex);
    state_->waiting = request;
    state_->requested = ++requested_;
    state_->has_waiting = state_->superseded = true;
    state_->due_s = kDueNow;
    state_->in_caller = in_caller;
  }

  std::shared_ptr<State> state_;
  std::uint64_t requested_ = 0;
  Thread thread_;
};

} // namespace tactus
