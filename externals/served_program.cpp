#include "externals/served_program.hpp"

#include "core/declaration_text.hpp"

#include <algorithm>
#include <new>
#include <utility>

namespace tactus {

using serve::ServeHeader;
using serve::ServeKind;

namespace {

constexpr std::uint64_t kMaxSentence = 4096;
constexpr double kEndGrace_s = 0.1;

} // namespace

std::string printable_line(std::string_view text) {
  std::string line(text.substr(0, 300));
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 32 || c == 127; }, ' ');
  return line;
}

std::unique_ptr<ServedProgram> ServedProgram::start(const std::vector<std::string>& words,
                                                    std::string name, double limit_s,
                                                    std::string& refusal) {
  auto child = ChildProcess::start(words, refusal);
  if (!child)
    return nullptr;
  auto served = std::make_unique<ServedProgram>();
  served->name_ = std::move(name);
  served->child_ = std::move(child);
  served->set_limit(limit_s);
  return served;
}

void ServedProgram::set_limit(double seconds) {
  limit_s_ = seconds;
  limit_ = Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

void ServedProgram::send_request(ServeKind kind, std::span<const std::byte> payload,
                                 double limit_s) {
  const ServeHeader header{ServeHeader::kMagic, static_cast<std::uint32_t>(kind), payload.size()};
  const auto bytes = std::as_bytes(std::span(&header, 1));
  out_.assign(bytes.begin(), bytes.end());
  out_.insert(out_.end(), payload.begin(), payload.end());
  sent_ = 0;
  awaiting_response_ = true;
  set_limit(limit_s);
}

std::optional<ServedProgram::Message> ServedProgram::poll(const Expects& expects,
                                                          std::string& lost) {
  std::optional<Message> message;
  try {
    message = exchange(expects, lost);
  } catch (const std::bad_alloc&) {
    in_ = {};
    lost = "not enough memory for the solver's answer";
  }
  if (message)
    awaiting_response_ = false;
  else if (lost.empty() && awaiting_response_ && Clock::now() >= limit_)
    lost = "the solver did not answer within " + number_text(limit_s_) + " s and was stopped";
  return message;
}

std::optional<ServedProgram::Message> ServedProgram::exchange(const Expects& expects,
                                                              std::string& lost) {
  if (sent_ < out_.size())
    sent_ += child_->send(std::span(out_).subspan(sent_));
  const auto missing = [this](std::size_t whole) {
    return whole > in_.size() ? child_->receive(in_, whole - in_.size()) : true;
  };
  bool open = missing(sizeof(ServeHeader));
  if (in_.size() >= sizeof(ServeHeader)) {
    const auto header = value_at<ServeHeader>(in_);
    const auto kind = static_cast<ServeKind>(header.kind);
    if (!(header.magic == ServeHeader::kMagic && awaiting_response_ &&
          ((kind == ServeKind::refused && header.size <= kMaxSentence) || expects(header)))) {
      lost = "the solver sent an invalid answer (magic " + std::to_string(header.magic) +
             ", kind " + std::to_string(header.kind) + ", " + std::to_string(header.size) +
             " bytes) and was stopped: expected " + name_ + " of this version";
      return {};
    }
    const std::size_t whole = sizeof(ServeHeader) + static_cast<std::size_t>(header.size);
    open = missing(whole);
    if (in_.size() >= whole) {
      Message message{kind, {}};
      message.payload.assign(in_.begin() + sizeof(ServeHeader), in_.end());
      in_ = {};
      return message;
    }
  }
  if (!open)
    lost = "the solver ended: " + printable_line(child_->end(kEndGrace_s));
  return {};
}

} // namespace tactus
