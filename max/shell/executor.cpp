#include "max/shell/executor.hpp"

#include "core/command.hpp"
#include "core/declaration_text.hpp"
#include "core/guarded.hpp"
#include "core/instance_numbers.hpp"
#include "core/named_lines.hpp"

#include <string>
#include <thread>
#include <utility>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace tactus::max {
namespace {

/// Maximum number of tries of the audio thread to take the token in one block. They last 15 to 50
/// microseconds on present processors, longer than a command that computes nothing.
constexpr int kBlockTries = 1000;

/// Leaves the processor's pipeline to the thread that shares it, without a system call.
void relax() noexcept {
#ifdef __SSE2__
  _mm_pause();
#elif defined(__aarch64__)
  __asm__ __volatile__("yield");
#endif
}

/// Longer than any block, so that only an audio thread that stopped within a block loses commands.
constexpr int kMaxTries = 100000;

/// A message thread's hold on the object's token. The destructor releases the token, also after an
/// exception, because a token that is never released would silence the object permanently.
class MessageHold {
public:
  MessageHold(Token& token, Outbox*& current, Outbox& outbox) : token_(token), current_(current) {
    current_ = &outbox;
  }
  ~MessageHold() {
    current_ = nullptr;
    token_.release();
  }
  MessageHold(const MessageHold&) = delete;
  MessageHold& operator=(const MessageHold&) = delete;

private:
  Token& token_;
  Outbox*& current_;
};

} // namespace

Executor::Executor(AnyObject<double>* object, const Traits& traits, Shell& shell, Host& host,
                   std::size_t number)
    : object_(object), traits_(traits), shell_(shell), host_(host),
      view_(traits.declaration->parameters.size()) {
  for (std::size_t i = 0; i < traits.declaration->parameters.size(); ++i)
    object_->set(i, initial_value(traits.declaration->parameters[i], number));
  view_.refresh(*object_);
}

void Executor::post(QueuedCommand command) {
  const bool is_parameter = command.kind == QueuedCommand::Kind::kParameter;
  const bool left_to_audio = command.realtime && shell_.audio_runs();
  const std::size_t index = command.index;
  if (is_parameter)
    view_.ask(index, command.value);
  for (int tries = 0; !queue_.push(command); ++tries) {
    if (tries == kMaxTries) {
      if (is_parameter)
        view_.answer(index);
      return shell_.lost();
    }
    carry_out_all();
    std::this_thread::yield();
  }
  if (left_to_audio)
    shell_.expect_audio();
  else
    carry_out_all();
}

/// The queue and the token are sequentially consistent. The holder checks the queue after it
/// releases the token. Either it then sees a command that was pushed meanwhile, or the sender of
/// that command sees a free token.
void Executor::carry_out_all() {
  while (!queue_.empty()) {
    if (audio_waits_.load() || !token_.take(Token::Holder::kMessage)) {
      if (token_.holder() == Token::Holder::kMessage)
        return;
      std::this_thread::yield(); // the audio thread's block ends soon
      continue;
    }
    Outbox outbox;
    {
      const MessageHold hold(token_, outbox_, outbox);
      do {
        QueuedCommand* next = queue_.front();
        if (!next)
          break;
        const QueuedCommand command = std::move(*next);
        queue_.pop();
        carry_out(command);
      } while (!audio_waits_.load());
    }
    shell_.deliver(outbox);
  }
}

/// Message threads release the token to the audio thread after the current command.
bool Executor::take_for_block() noexcept {
  if (token_.take(Token::Holder::kAudio))
    return true;
  audio_waits_.store(true);
  bool taken = false;
  for (int tries = 0; !taken && tries < kBlockTries; ++tries) {
    relax();
    taken = token_.take(Token::Holder::kAudio);
  }
  audio_waits_.store(false);
  return taken;
}

bool Executor::run_block(const Block<double>& block) noexcept {
  if (!take_for_block())
    return false;
  while (QueuedCommand* next = queue_.front()) {
    if (!next->realtime)
      break; // later commands wait, too, so that the order is preserved
    carry_out(*next);
    queue_.pop();
  }
  object_->process(block);
  if (traits_.reports)
    object_->report(host_);
  token_.release();
  return true;
}

void Executor::prepare(double sample_rate, std::size_t max_block) {
  wait_for_token();
  {
    Outbox none;
    const MessageHold hold(token_, outbox_, none);
    if (sample_rate != sample_rate_ || max_block != max_block_) {
      object_->prepare(sample_rate, max_block);
      sample_rate_ = sample_rate;
      max_block_ = max_block;
    }
  }
  carry_out_all();
}

void Executor::wait_for_token() {
  while (!token_.take(Token::Holder::kMessage))
    std::this_thread::yield();
}

/// Also called by the audio thread. A command that fails does not prevent later commands.
void Executor::carry_out(const QueuedCommand& command) noexcept {
  tactus::guarded([&] { call(command); }, [this](const char* why) { host_.error(why); });
  const bool is_parameter = command.kind == QueuedCommand::Kind::kParameter;
  if (view_.refresh(*object_, is_parameter ? command.index : ParameterView::kNone))
    shell_.changed();
  if (is_parameter)
    view_.answer(command.index);
}

void Executor::call(const QueuedCommand& command) {
  using Kind = QueuedCommand::Kind;
  switch (command.kind) {
  case Kind::kParameter:
    object_->set(command.index, command.value);
    break;
  case Kind::kMessage:
    object_->message(command.index, command.atoms(), host_);
    break;
  case Kind::kScalar:
    object_->scalar(command.index, command.value, host_);
    break;
  case Kind::kList:
    object_->list(command.index, command.atoms(), host_);
    break;
  case Kind::kTick:
    object_->tick(command.index, host_);
    break;
  case Kind::kPosted:
    object_->posted(host_);
    break;
  case Kind::kCreated:
    object_->created(host_);
    break;
  case Kind::kDumpFirst:
    object_->dump_first(host_);
    break;
  case Kind::kDump:
    object_->dump(host_);
    break;
  case Kind::kGet: {
    const std::string name = text_of(command.atoms()[0]);
    if (!send_named_lines(*object_, name, host_))
      host_.error(no_answer_text(*traits_.declaration, name));
    break;
  }
  }
}

void Executor::keep(Output::Kind kind, std::size_t outlet, std::span<const Atom> atoms) {
  if (!in_audio())
    outbox_->add(kind, outlet, atoms);
  else if (!audio_output_.add(kind, outlet, atoms))
    lost_outputs_.fetch_add(1, std::memory_order_relaxed);
}

} // namespace tactus::max
