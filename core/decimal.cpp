#include "core/decimal.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <system_error>

// A decimal number D 10^e, D a whole number, is the quotient of two whole numbers. Where both are
// doubles, one division or product rounds correctly (Clinger, "How to read floating point numbers
// accurately", PLDI 1990). Else long division gives 62 or 63 bits of the quotient and whether a
// remainder is left, which is what rounding to 53 bits, ties to even, needs to know.
namespace tactus {
namespace {

/// A text's sign, significant digits and power of ten.
struct Decimal {
  /// More digits than decide: a number halfway between two doubles has 767 at most, so that of the
  /// digits after these it counts only whether one is not 0.
  static constexpr std::size_t kMaxDigits = 800;
  std::array<char, kMaxDigits + 1> digits{};
  std::size_t count = 0;
  int exponent = 0; ///< of the last digit
  bool negative = false;
};

/// Beyond it every number overflows or is 0.
constexpr int kMaxExponent = 100'000;

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

/// The text behind the sign: digits with a point at most, then the exponent if there is one.
bool parse(std::string_view text, Decimal& number) noexcept {
  number.negative = text.starts_with('-');
  std::size_t at = number.negative ? 1 : 0;
  bool any = false, point = false, lost = false;
  std::int64_t exponent = 0;
  for (; at < text.size() && (is_digit(text[at]) || (text[at] == '.' && !point)); ++at) {
    if (text[at] == '.') {
      point = true;
      continue;
    }
    any = true;
    exponent -= point ? 1 : 0;
    if (number.count == 0 && text[at] == '0')
      continue;
    if (number.count < Decimal::kMaxDigits) {
      number.digits[number.count++] = static_cast<char>(text[at] - '0');
      continue;
    }
    lost = lost || text[at] != '0';
    ++exponent;
  }
  if (lost) {
    number.digits[number.count++] = 1;
    --exponent;
  }
  if (any && at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    ++at;
    const bool down = at < text.size() && text[at] == '-';
    at += at < text.size() && (down || text[at] == '+') ? 1 : 0;
    any = at < text.size();
    std::int64_t written = 0;
    for (; at < text.size() && is_digit(text[at]); ++at)
      written = std::min<std::int64_t>(10 * written + (text[at] - '0'), 1LL << 40);
    exponent += down ? -written : written;
  }
  number.exponent =
      static_cast<int>(std::clamp<std::int64_t>(exponent, -kMaxExponent, kMaxExponent));
  return any && at == text.size();
}

/// A whole number up to the largest that occurs: 10^1131 times 2^64.
class Whole {
public:
  explicit Whole(std::uint32_t value) noexcept : size_(value == 0 ? 0 : 1) { words_[0] = value; }

  void multiply_and_add(std::uint32_t factor, std::uint32_t term) noexcept {
    std::uint64_t carry = term;
    for (std::size_t i = 0; i < size_; ++i, carry >>= 32)
      words_[i] = static_cast<std::uint32_t>(carry += std::uint64_t{words_[i]} * factor);
    if (carry != 0)
      words_[size_++] = static_cast<std::uint32_t>(carry);
  }
  void multiply_by_power_of_ten(int power) noexcept {
    for (; power >= 9; power -= 9)
      multiply_and_add(1'000'000'000, 0);
    for (; power > 0; --power)
      multiply_and_add(10, 0);
  }
  void shift_left(int bits) noexcept {
    for (; bits >= 31; bits -= 31)
      multiply_and_add(1U << 31, 0);
    multiply_and_add(1U << bits, 0);
  }
  void subtract(const Whole& smaller) noexcept {
    std::uint64_t borrow = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const std::uint64_t taken = (i < smaller.size_ ? smaller.words_[i] : 0) + borrow;
      borrow = words_[i] < taken ? 1 : 0;
      words_[i] = static_cast<std::uint32_t>(words_[i] - taken);
    }
    while (size_ > 0 && words_[size_ - 1] == 0)
      --size_;
  }
  [[nodiscard]] bool operator>=(const Whole& other) const noexcept {
    if (size_ != other.size_)
      return size_ > other.size_;
    for (std::size_t i = size_; i-- > 0;)
      if (words_[i] != other.words_[i])
        return words_[i] > other.words_[i];
    return true;
  }
  [[nodiscard]] bool is_zero() const noexcept { return size_ == 0; }
  [[nodiscard]] int bits() const noexcept {
    return size_ == 0 ? 0 : static_cast<int>(32 * size_) - std::countl_zero(words_[size_ - 1]);
  }

private:
  std::array<std::uint32_t, 128> words_{}; ///< the lowest first
  std::size_t size_;
};

/// D 10^e with D > 0; infinite or 0 beyond the range of double.
double nearest(const Decimal& number) noexcept {
  using Limits = std::numeric_limits<double>;
  const int magnitude = static_cast<int>(number.count) + number.exponent; // value < 10^magnitude
  if (magnitude > Limits::max_exponent10 + 1)
    return Limits::infinity();
  if (magnitude < Limits::min_exponent10 - Limits::digits10 - 2)
    return 0;
  Whole above(0), below(1);
  for (std::size_t i = 0; i < number.count; ++i)
    above.multiply_and_add(10, static_cast<std::uint32_t>(number.digits[i]));
  above.multiply_by_power_of_ten(number.exponent);
  below.multiply_by_power_of_ten(-number.exponent);

  constexpr int kQuotientBits = 62;
  const int shift = kQuotientBits + below.bits() - above.bits();
  above.shift_left(std::max(shift, 0));
  below.shift_left(std::max(-shift, 0) + kQuotientBits);
  std::uint64_t quotient = 0; // floor(2^shift D 10^e)
  for (int i = 0; i <= kQuotientBits; ++i) {
    quotient <<= 1;
    if (above >= below) {
      above.subtract(below);
      quotient |= 1;
    }
    above.shift_left(1);
  }
  const bool remainder = !above.is_zero();

  // The exponents of the quotient's first bit and of the result's last one; subnormal numbers end
  // at 2^-1074.
  const int first = 63 - std::countl_zero(quotient) - shift;
  const int last = std::max(first, Limits::min_exponent - 1) - (Limits::digits - 1);
  const int dropped = last + shift;
  if (dropped > 63)
    return 0;
  const std::uint64_t half = std::uint64_t{1} << (dropped - 1);
  const std::uint64_t rest = quotient & (2 * half - 1);
  std::uint64_t mantissa = quotient >> dropped;
  if (rest > half || (rest == half && (remainder || mantissa % 2 == 1)))
    ++mantissa;
  return std::ldexp(static_cast<double>(mantissa), last);
}

} // namespace

std::errc read_decimal(std::string_view text, double& value) noexcept {
  Decimal number;
  if (!parse(text, number))
    return std::errc::invalid_argument;
  double found = 0;
  constexpr std::array<double, 23> kPowers{1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                           1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                           1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
  const auto power = static_cast<std::size_t>(std::abs(number.exponent));
  if (number.count <= 15 && power < kPowers.size()) {
    for (std::size_t i = 0; i < number.count; ++i)
      found = 10 * found + number.digits[i];
    found = number.exponent < 0 ? found / kPowers[power] : found * kPowers[power];
  } else if (number.count > 0) {
    found = nearest(number);
    if (found == 0 || std::isinf(found))
      return std::errc::result_out_of_range;
  }
  value = number.negative ? -found : found;
  return {};
}

} // namespace tactus
