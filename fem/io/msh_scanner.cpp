#include "fem/io/msh_scanner.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/mesh.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace tactus::fem {

MshScanner::MshScanner(std::string path, std::string bytes)
    : path_(std::move(path)), bytes_(std::move(bytes)) {}

void MshScanner::refuse(const std::string& value, const std::string& expected) const {
  std::string location = path_;
  if (binary_) {
    location += " byte " + std::to_string(at_);
  } else {
    const auto end = bytes_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, bytes_.size()));
    location += " line " + std::to_string(1 + std::count(bytes_.begin(), end, '\n'));
  }
  if (!section_.empty())
    location += " in $" + section_;
  throw InputError(location + ": " + value + ", expected " + expected);
}

std::string MshScanner::printable_value(std::string_view text) const {
  if (text.empty())
    return "the file ends";
  return binary_ ? "other bytes" : printable(text, 60);
}

void MshScanner::skip_blanks() noexcept {
  while (at_ < bytes_.size() && is_blank(bytes_[at_]))
    ++at_;
}

std::string_view MshScanner::token() {
  skip_blanks();
  std::size_t end = at_;
  while (end < bytes_.size() && !is_blank(bytes_[end]))
    ++end;
  const std::string_view text = std::string_view(bytes_).substr(at_, end - at_);
  at_ = end;
  return text;
}

std::string_view MshScanner::line() {
  const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
  const std::string_view text = std::string_view(bytes_).substr(at_, end - at_);
  at_ = std::min(end + 1, bytes_.size());
  return trimmed(text);
}

std::string_view MshScanner::next_section() {
  section_.clear();
  skip_blanks();
  if (at_ == bytes_.size())
    return {};
  const std::size_t begin = at_;
  const std::string_view text = line();
  if (text.size() < 2 || text[0] != '$' || text.size() > 100 || text.starts_with("$End")) {
    at_ = begin;
    refuse(printable_value(text), "a section such as $MeshFormat, $Nodes or $Elements");
  }
  section_ = text.substr(1);
  return section_;
}

void MshScanner::end_section() {
  skip_blanks();
  const std::size_t begin = at_;
  const std::string_view text = token();
  if (text != "$End" + section_) {
    at_ = begin;
    refuse(printable_value(text), "$End" + section_);
  }
}

void MshScanner::skip_section() {
  const std::string end = "$End" + section_;
  const std::size_t found = bytes_.find("\n" + end, at_ > 0 ? at_ - 1 : 0);
  if (found == std::string::npos)
    refuse("the section never ends", end);
  at_ = found + 1 + end.size();
}

void MshScanner::set_binary(bool swapped_bytes, std::size_t word) {
  binary_ = true;
  byte_swapped_ = swapped_bytes;
  word_ = word;
}

std::uint64_t MshScanner::stored(std::size_t size, const char* what) {
  if (left() < size)
    refuse("the file ends", what);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) // stores the least significant byte last
    value =
        value << 8 | static_cast<unsigned char>(bytes_[at_ + (byte_swapped_ ? i : size - 1 - i)]);
  at_ += size;
  return value;
}

std::uint32_t MshScanner::raw_word() {
  const bool before = std::exchange(byte_swapped_, false);
  const auto value =
      static_cast<std::uint32_t>(stored(4, "the number 1 that tells the order of bytes"));
  byte_swapped_ = before;
  return value;
}

int MshScanner::integer(const char* what, int low, int high) {
  int value = 0;
  std::string text;
  bool good = true;
  if (binary_) {
    value = static_cast<int>(static_cast<std::uint32_t>(stored(4, what)));
    text = std::to_string(value);
  } else {
    const std::string_view word = token();
    good = read_number(word, value) == std::errc{};
    text = printable_value(word);
  }
  if (!good || value < low || value > high)
    refuse(text, what + (low == std::numeric_limits<int>::min()
                             ? std::string(", a whole number")
                             : format(", a whole number from %d to %d", low, high)));
  return value;
}

std::uint64_t MshScanner::tag(const char* what) {
  if (binary_)
    return stored(word_, what);
  const std::string_view word = token();
  const auto value = to_number<std::uint64_t>(word);
  if (!value)
    refuse(printable_value(word), std::string(what) + ", a whole number from 0");
  return *value;
}

std::size_t MshScanner::count(const char* what, std::size_t numbers, std::size_t bytes) {
  const std::uint64_t value = tag(what);
  const std::size_t max_count = left() / (binary_ ? bytes : 2 * numbers);
  if (value > max_count)
    refuse(std::to_string(value),
           std::string(what) + " of " + std::to_string(max_count) + " at most, by the bytes left");
  return static_cast<std::size_t>(value);
}

double MshScanner::real(const char* what) {
  double value = 0;
  if (binary_) {
    value = std::bit_cast<double>(stored(8, what));
    if (!std::isfinite(value))
      refuse(format("%g", value), std::string(what) + ", a finite number");
    return value;
  }
  const std::string_view word = token();
  const auto number = to_number(word);
  if (!number)
    refuse(printable_value(word), std::string(what) + ", a finite number");
  return *number;
}

} // namespace tactus::fem
