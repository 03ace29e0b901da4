#include "core/refusal.hpp"
#include "core/sentence.hpp"
#include "externals/modal_impact~/modal_impact~.hpp"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <utility>

/// The message `load`, and messages to a body that is still being read.
namespace tactus::modal {

using namespace modal_impact;

bool ModalImpact::must_wait(const Message& row, Numbers numbers,
                            void (ModalImpact::*handler)(Numbers, Host&), Waits waits, Host& host) {
  const bool strikes = waits == Waits::kAsStrike;
  const bool changes =
      sync_ == Sync::kInOrder && body_change_ > answered_ && (strikes || waits == Waits::kAsInfo);
  const bool for_a_body = strikes || waits == Waits::kForBody;
  if (!changes && !(for_a_body && loads_first()))
    return false;
  body_.adopt();
  if (body_.model() && !changes)
    return false;
  if (waiting_count_ == waiting_.size() || numbers.size() > kFewNumbers) {
    Sentence sentence(row.name);
    sentence +=
        body_.model()
            ? ": 64 messages are already queued for a change that is being computed"
            : ": 64 messages are already queued for the body that is being read; send more after "
              "`loaded`";
    host.error(sentence);
    return true;
  }
  WaitingMessage& kept = waiting_[waiting_count_++];
  kept.carry_out = handler;
  kept.strikes = strikes;
  kept.after = changes ? body_change_ : 0;
  kept.count = numbers.size();
  std::copy(numbers.begin(), numbers.end(), kept.numbers.begin());
  return true;
}

/// Silences the object: waiting strikes are dropped.
void ModalImpact::reset(Numbers, Host& host) {
  waiting_count_ = static_cast<std::size_t>(
      std::remove_if(waiting_.begin(),
                     waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_),
                     [](const WaitingMessage& kept) { return kept.strikes; }) -
      waiting_.begin());
  random_.seed(options_.seed);
  body_.schedule(Reset{}, sample_now(host));
}

void ModalImpact::carry_out_waiting(Host& host) {
  body_.adopt();
  if (!body_.model() && loads_first())
    return;
  std::size_t count = 0; // number of messages whose request has been answered
  while (count < waiting_count_ && waiting_[count].after <= answered_)
    ++count;
  if (body_.model()) // without a model, the missing body has been reported already
    for (const WaitingMessage& kept : std::span(waiting_).first(count))
      (this->*kept.carry_out)(std::span(kept.numbers).first(kept.count), host);
  std::move(waiting_.begin() + static_cast<std::ptrdiff_t>(count),
            waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_), waiting_.begin());
  waiting_count_ -= count;
}

std::string ModalImpact::find_table(std::string_view message, const std::string& name, Host& host) {
  for (const char* end : {"", ".modal.npz"})
    if (std::string path = host.find_file(name + end); !path.empty())
      return path;
  host.error(std::string(message) + " " + name +
             ": file not found beside the patch, in the search path or beside the object");
  return {};
}

void ModalImpact::load_named(std::span<const Atom> arguments, Host& host) {
  if (!arguments[0].is_word)
    return host.error(refusal("load", arguments, "the name of a file"));
  bool sync = at_once();
  if (arguments.size() > 1) {
    if (!arguments[1].is_word || arguments[1].word != "-sync")
      return host.error(refusal("load", arguments, "the name of a file, optionally -sync"));
    sync = true;
  }
  const std::string name(arguments[0].word);
  if (created_ || sync)
    return load(name, sync, host);
  first_name_ = name;
}

void ModalImpact::load(const std::string& name, bool at_once, Host& host) {
  const std::string path = find_table("load", name, host);
  if (path.empty())
    return;
  wanted_.body = {path, name, wanted_.body.number + 1};
  request(at_once, host);
  body_change_ = load_ = worker_.requested();
}

} // namespace tactus::modal
