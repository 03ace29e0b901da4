#pragma once

#include "core/object.hpp"
#include "max/shell/command_queue.hpp"
#include "max/shell/output.hpp"
#include "max/shell/parameter_view.hpp"

#include <atomic>
#include <cstddef>
#include <memory>

namespace tactus::max {

/// The right to use an object, held by one thread at a time. The audio thread never waits for it.
class Token {
public:
  enum class Holder { kNobody, kMessage, kAudio };

  /// One attempt; false while the token is held. Writes of the last holder are visible afterwards.
  [[nodiscard]] bool take(Holder by) noexcept {
    Holder expected = Holder::kNobody;
    return holder_.compare_exchange_strong(expected, by);
  }
  void release() noexcept { holder_.store(Holder::kNobody); }
  [[nodiscard]] Holder holder() const noexcept { return holder_.load(); }

private:
  // Sequentially consistent with the queue's atomics: see Executor::carry_out_all().
  std::atomic<Holder> holder_{Holder::kNobody};
};

/// Lets messages of several threads and the audio thread use one object, whose members must never
/// overlap, without a lock in the audio thread.
///
/// Every command goes into one queue, so that the commands of a thread stay in order. The audio
/// thread carries out commands that allocate nothing (parameters, messages declared realtime) at
/// the start of its next block. The message thread that gets the object's token carries out all
/// others: it empties the queue, including other threads' commands, releases the token and then
/// sends the object's output. If a message thread has the token when a block begins, it releases it
/// after the current command; the audio thread retries a bounded number of times, for about 30
/// microseconds. A longer command, such as one that loads a file, costs the block: run_block()
/// returns false and the caller outputs silence.
class Executor {
public:
  /// Functions that the shell provides.
  class Shell {
  public:
    virtual ~Shell() = default;
    [[nodiscard]] virtual bool audio_runs() const = 0;
    /// Commands wait for the audio thread, which may have stopped: call carry_out_all() then.
    virtual void expect_audio() = 0;
    /// Sends the object's output to its outlets and the console.
    virtual void deliver(const Outbox& outbox) = 0;
    /// A command was dropped as the queue stayed full.
    virtual void lost() noexcept = 0;
    /// A command has changed parameters; take_change() returns which. Called in any thread,
    /// including audio's.
    virtual void changed() noexcept = 0;
  };

  /// `number`: of the instance; it makes the seeds of instances differ.
  Executor(AnyObject<double>* object, const Traits& traits, Shell& shell, Host& host,
           std::size_t number = 0);

  /// Carries the command out, or leaves it to whoever holds the object. Any thread but audio's.
  void post(QueuedCommand command);
  /// Empties the queue if nobody else does. Any thread but audio's.
  void carry_out_all();
  /// The queue's realtime commands, then a block; false if a message thread held the object.
  [[nodiscard]] bool run_block(const Block<double>& block) noexcept;
  void prepare(double sample_rate, std::size_t max_block);

  [[nodiscard]] bool waiting() const noexcept { return !queue_.empty(); }
  [[nodiscard]] double value(std::size_t parameter) const noexcept {
    return view_.value(parameter);
  }
  /// Whether a parameter has changed since the last call, other than by being set itself.
  [[nodiscard]] bool take_change(std::size_t parameter) noexcept {
    return view_.take_change(parameter);
  }

  /// For Host's functions, which the object calls while the token is held: keeps an output.
  void keep(Output::Kind kind, std::size_t outlet, std::span<const Atom> atoms);
  [[nodiscard]] bool in_audio() const noexcept { return outbox_ == nullptr; }
  [[nodiscard]] OutputRing& audio_output() noexcept { return audio_output_; }
  [[nodiscard]] unsigned lost_outputs() const noexcept { return lost_outputs_.load(); }

private:
  void carry_out(const QueuedCommand& command) noexcept;
  void call(const QueuedCommand& command);
  [[nodiscard]] bool take_for_block() noexcept;
  void wait_for_token();

  std::unique_ptr<AnyObject<double>> object_;
  const Traits& traits_;
  Shell& shell_;
  Host& host_;
  Token token_;
  CommandQueue queue_;
  ParameterView view_;
  OutputRing audio_output_;
  std::atomic<unsigned> lost_outputs_{0};
  std::atomic<bool> audio_waits_{false}; ///< a block has begun, and a message thread has the token
  // The members below belong to the holder of the token.
  Outbox* outbox_ = nullptr; // null: the audio thread holds it
  double sample_rate_ = 0;
  std::size_t max_block_ = 0;
};

} // namespace tactus::max
