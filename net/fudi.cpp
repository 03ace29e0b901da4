#include "net/fudi.hpp"

#include "core/text.hpp"

#include <charconv>
#include <cmath>

namespace tactus::net {
namespace {

struct Word {
  std::string_view text;
  bool has_escape = false; ///< contained a backslash, so it is not a number
};

constexpr bool is_blank(char c) noexcept { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
constexpr bool is_control(char c) noexcept {
  const auto byte = static_cast<unsigned char>(c);
  return byte < 0x20 || byte == 0x7f;
}

bool reads_as_number(std::string_view text) noexcept {
  bool digit = false;
  for (const char c : text) {
    if (c >= '0' && c <= '9')
      digit = true;
    else if (c != '+' && c != '-' && c != '.' && c != 'e' && c != 'E')
      return false;
  }
  return digit && text.front() != 'e' && text.front() != 'E';
}

/// Takes one word from text[read..] and writes it, without its backslashes, to text[write..].
std::string_view take_word(std::span<char> text, std::size_t& read, std::size_t& write,
                           Word& word) noexcept {
  const std::size_t begin = write;
  word.has_escape = false;
  for (; read < text.size() && !is_blank(text[read]); ++read) {
    char c = text[read];
    if (c == '\\') {
      if (++read == text.size())
        return "the message ends in a backslash";
      word.has_escape = true;
      c = text[read];
    } else if (c == ',') {
      return "a comma: end each message with its own semicolon";
    }
    if (is_control(c))
      return "a byte that is not text";
    text[write++] = c;
  }
  word.text = {text.data() + begin, write - begin};
  return {};
}

std::string_view add_word(const Word& word, Message& message) noexcept {
  if (word.has_escape || !reads_as_number(word.text)) {
    message.string(word.text);
    return {};
  }
  if (const auto whole = to_number<std::int32_t>(word.text)) {
    message.integer(*whole);
    return {};
  }
  double number = 0;
  const std::errc failed = read_number(word.text, number);
  if (failed == std::errc::invalid_argument) {
    message.string(word.text); // a word such as 1-2
    return {};
  }
  if (failed != std::errc() || !std::isfinite(static_cast<float>(number)))
    return "a number is out of range";
  message.real(number);
  return {};
}

class FudiWriter {
public:
  explicit FudiWriter(std::span<char> out) noexcept : out_(out) {}

  void raw(std::string_view text) noexcept {
    for (const char c : text)
      put(c);
  }
  void word(std::string_view text) noexcept {
    if (text.empty())
      return put('-');
    if (reads_as_number(text))
      put('\\');
    for (const char c : text) {
      if (c == ' ' || c == ';' || c == ',' || c == '\\' || c == '$')
        put('\\');
      put(is_control(c) ? '?' : c);
    }
  }
  template <class Number> void word(Number value) noexcept {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    raw({digits.data(), static_cast<std::size_t>(end - digits.data())});
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_ <= out_.size() ? size_ : 0; }

private:
  void put(char c) noexcept {
    if (size_ < out_.size())
      out_[size_] = c;
    ++size_;
  }
  std::span<char> out_;
  std::size_t size_ = 0;
};

} // namespace

std::string_view decode_fudi(std::span<char> text, Message& message, bool& found) noexcept {
  message = Message{};
  found = false;
  std::array<Word, Message::kMaxArguments + 3> words;
  std::size_t count = 0, read = 0, write = 0;
  for (;;) {
    while (read < text.size() && is_blank(text[read]))
      ++read;
    if (read == text.size())
      break;
    found = true;
    Word word;
    if (const std::string_view reason = take_word(text, read, write, word); !reason.empty())
      return reason;
    if (count == words.size())
      return "more than 16 arguments";
    words[count++] = word;
  }
  if (count == 0)
    return {};
  const bool topic = words[0].text == "bus" && count > 1;
  if (!topic && (words[0].text != "hap" || count == 1)) {
    message = Message(Address::kUnknown, words[0].text);
    return {};
  }
  std::size_t first = 2; // index of the first argument
  Address address = topic ? Address::kTopic : find_address(words[1].text);
  if (address == Address::kUnknown && count > 2) {
    address = find_address(words[1].text, words[2].text);
    first = address == Address::kUnknown ? 2 : 3;
  }
  message = Message(address, words[1].text);
  if (count - first > Message::kMaxArguments)
    return "more than 16 arguments";
  for (std::size_t i = first; i < count; ++i)
    if (const std::string_view reason = add_word(words[i], message); !reason.empty())
      return reason;
  return {};
}

std::size_t encode_fudi(const Message& message, std::span<char> out) noexcept {
  FudiWriter writer(out);
  if (message.address() == Address::kTopic) {
    writer.raw("bus ");
    writer.word(message.name());
  } else {
    writer.raw("hap ");
    for (const char c : message.name())
      writer.raw(c == '/' ? " " : std::string_view(&c, 1));
  }
  for (std::size_t i = 0; i < message.size(); ++i) {
    writer.raw(" ");
    std::visit([&](auto value) { writer.word(value); }, message[i]);
  }
  writer.raw(";\n");
  return writer.size();
}

} // namespace tactus::net
