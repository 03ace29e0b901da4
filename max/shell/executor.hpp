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

  /// One try; false while somebody holds it. What the last holder wrote is visible afterwards.
  [[nodiscard]] bool take(Holder by) noexcept {
    Holder expected = Holder::kNobody;
    return holder_.compare_exchange_strong(expected, by);
  }
  void release() noexcept { holder_.store(Holder::kNobody); }
  [[nodiscard]] Holder holder() const noexcept { return holder_.load(); }

private:
  // In one order with the queue's own atomics: see Executor::carry_out_all().
  std::atomic<Holder> holder_{Holder::kNobody};
};

/// Lets messages of several threads and the audio thread use one object, whose members must never
/// overlap, without a lock in the audio thread.
///
/// Every command goes into one queue, so that what a thread sends stays in its order. Commands that
/// allocate nothing (parameters, messages declared realtime) are carried out by the audio thread at
/// the start of its next block. All others by the message thread that gets the object's token: it
/// empties the queue, those of other threads too, gives the token back and then sends what the
/// object wanted to send. When a message thread has the token as a block begins, it gives it back
/// after the command at hand; the audio thread tries for some 30 microseconds, a bounded number of
/// times. A command that takes longer, such as one that loads, costs the block: the caller gets
/// false and plays silence.
class Executor {
public:
  /// What the shell does for the executor.
  class Shell {
  public:
    virtual ~Shell() = default;
    [[nodiscard]] virtual bool audio_runs() const = 0;
    /// Commands wait for the audio thread, which may have stopped: call carry_out_all() then.
    virtual void expect_audio() = 0;
    /// Sends what the object has sent to its outlets and the console.
    virtual void deliver(const Outbox& outbox) = 0;
    /// A command was dropped as the queue stayed full.
    virtual void lost() noexcept = 0;
    /// A command has changed parameters: take_change() says which. Any thread, audio's too.
    virtual void changed() noexcept = 0;
  };

  /// `number`: of the instance, by which its seeds differ from others'.
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
  /// Whether a parameter has changed, by anything but its own setting, since this was asked last.
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
  // What follows belongs to the holder of the token.
  Outbox* outbox_ = nullptr; // null: the audio thread holds it
  double sample_rate_ = 0;
  std::size_t max_block_ = 0;
};

} // namespace tactus::max
