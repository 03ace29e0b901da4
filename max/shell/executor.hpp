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

  /// Makes one attempt; returns false while the token is held. After success, the last holder's
  /// writes are visible.
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

/// Lets the messages of several threads and the audio thread use one object without a lock in the
/// audio thread. Calls of the object's members never overlap.
///
/// Every command goes into one queue, so that the commands of a thread stay in order. The audio
/// thread carries out commands that allocate nothing (parameters, messages declared realtime) at
/// the start of its next block. The message thread that gets the object's token carries out all
/// others: it empties the queue, including other threads' commands, releases the token and then
/// sends the object's output. If a message thread has the token when a block begins, it releases
/// the token after the current command. The audio thread retries a bounded number of times, for
/// about 30 microseconds. If the command takes longer, such as one that loads a file, the block is
/// lost: run_block() returns false and the caller outputs silence.
class Executor {
public:
  /// Functions that the shell provides.
  class Shell {
  public:
    virtual ~Shell() = default;
    [[nodiscard]] virtual bool audio_runs() const = 0;
    /// Called when commands wait for the audio thread. If audio has stopped, the shell must call
    /// carry_out_all().
    virtual void expect_audio() = 0;
    /// Sends the object's output to its outlets and the console.
    virtual void deliver(const Outbox& outbox) = 0;
    /// Called when a command was dropped because the queue stayed full.
    virtual void lost() noexcept = 0;
    /// Called when a command has changed parameters; take_change() returns which. It may be called
    /// in any thread, including audio's.
    virtual void changed() noexcept = 0;
  };

  /// `number`: the instance's number, which makes the seeds of instances differ.
  Executor(AnyObject<double>* object, const Traits& traits, Shell& shell, Host& host,
           std::size_t number = 0);

  /// Carries out the command, or leaves it to the thread that holds the object. For any thread
  /// except audio's.
  void post(QueuedCommand command);
  /// Empties the queue if no other thread does. For any thread except audio's.
  void carry_out_all();
  /// Carries out the queue's realtime commands, then computes a block. Returns false if a message
  /// thread held the object.
  [[nodiscard]] bool run_block(const Block<double>& block) noexcept;
  void prepare(double sample_rate, std::size_t max_block);

  [[nodiscard]] bool waiting() const noexcept { return !queue_.empty(); }
  [[nodiscard]] double value(std::size_t parameter) const noexcept {
    return view_.value(parameter);
  }
  /// Whether a parameter has changed since the last call for another reason than being set itself.
  [[nodiscard]] bool take_change(std::size_t parameter) noexcept {
    return view_.take_change(parameter);
  }

  /// Stores an output. For Host's functions, which the object calls while the token is held.
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
  std::atomic<bool> audio_waits_{false}; ///< a block waits for a message thread's token
  // Used by the holder of the token only.
  Outbox* outbox_ = nullptr; // null while the audio thread holds the token
  double sample_rate_ = 0;
  std::size_t max_block_ = 0;
};

} // namespace tactus::max
