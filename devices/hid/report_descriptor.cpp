#include "devices/hid/report_descriptor.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace tactus::devices::hid {
namespace {

constexpr std::uint32_t kMaxBits = 8 * 4096; // maximum size of a report
constexpr std::size_t kMaxFields = 256, kMaxUsages = 256, kMaxStackDepth = 8;
constexpr std::uint8_t kLongItem = 0xfe;

enum Main : std::uint8_t { kInput = 8, kCollection = 10 };
enum Global : std::uint8_t {
  kUsagePage,
  kLogicalLow,
  kLogicalHigh,
  kReportSize = 7,
  kReportId = 8,
  kReportCount = 9,
  kPush = 10,
  kPop = 11
};
enum Local : std::uint8_t { kUsage, kUsageLow, kUsageHigh };
enum Type : std::uint8_t { kMain, kGlobal, kLocal };
enum InputFlags : std::uint32_t { kConstant = 1, kVariable = 2, kRelative = 4, kNullState = 0x40 };
constexpr std::uint32_t kApplication = 1;

struct Item {
  std::uint8_t tag = 0, type = 0;
  std::uint32_t unsigned_value = 0;
  std::int32_t signed_value = 0;
  unsigned bytes = 0;
};

struct Globals {
  std::uint16_t page = 0;
  std::int32_t low = 0, high = 0;
  std::uint32_t high_unsigned = 0;
  std::uint32_t size = 0, count = 0;
  std::uint8_t report = 0;
};

class Parser {
public:
  ReportDescriptor parse(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty() && result_.complete) {
      Item item;
      const std::size_t length = read_item(bytes, item);
      if (length == 0) {
        result_.complete = false;
        break;
      }
      if (bytes[0] != kLongItem)
        decode(item);
      bytes = bytes.subspan(length);
    }
    return std::move(result_);
  }

private:
  // Returns the item's length, 0 if the item is cut short.
  static std::size_t read_item(std::span<const std::uint8_t> bytes, Item& item) {
    if (bytes[0] == kLongItem) {
      const std::size_t length = bytes.size() < 2 ? 0 : std::size_t{3} + bytes[1];
      return length <= bytes.size() ? length : 0;
    }
    constexpr std::array<unsigned, 4> kSizes{0, 1, 2, 4};
    item.bytes = kSizes[bytes[0] & 3u];
    item.type = bytes[0] >> 2 & 3;
    item.tag = bytes[0] >> 4;
    if (bytes.size() < 1 + item.bytes)
      return 0;
    for (unsigned i = 0; i < item.bytes; ++i)
      item.unsigned_value |= static_cast<std::uint32_t>(bytes[1 + i]) << 8 * i;
    const unsigned unused = 32 - 8 * item.bytes;
    item.signed_value =
        item.bytes == 0 ? 0 : static_cast<std::int32_t>(item.unsigned_value << unused) >> unused;
    return 1 + item.bytes;
  }

  void decode(const Item& item) {
    if (item.type == kGlobal)
      take_global(item);
    else if (item.type == kLocal)
      take_local(item);
    else if (item.type == kMain)
      take_main(item);
  }

  void take_global(const Item& item) {
    switch (item.tag) {
    case kUsagePage:
      now_.page = static_cast<std::uint16_t>(item.unsigned_value);
      break;
    case kLogicalLow:
      now_.low = item.signed_value;
      break;
    case kLogicalHigh:
      now_.high = item.signed_value;
      now_.high_unsigned = item.unsigned_value;
      break;
    case kReportSize:
      now_.size = item.unsigned_value;
      break;
    case kReportId:
      now_.report = static_cast<std::uint8_t>(item.unsigned_value);
      result_.numbered = true;
      if (item.unsigned_value == 0 || item.unsigned_value > 255)
        result_.complete = false;
      break;
    case kReportCount:
      now_.count = item.unsigned_value;
      break;
    case kPush:
      if (stack_.size() < kMaxStackDepth)
        stack_.push_back(now_);
      else
        result_.complete = false;
      break;
    case kPop:
      if (stack_.empty()) {
        result_.complete = false;
      } else {
        now_ = stack_.back();
        stack_.pop_back();
      }
      break;
    default:
      break;
    }
  }

  void take_local(const Item& item) {
    // A usage of four bytes contains its own page.
    const std::uint32_t usage = item.bytes == 4
                                    ? item.unsigned_value
                                    : item.unsigned_value | std::uint32_t{now_.page} << 16;
    if (item.tag == kUsage && usages_.size() < kMaxUsages) {
      usages_.push_back(usage);
    } else if (item.tag == kUsageLow) {
      range_low_ = usage;
    } else if (item.tag == kUsageHigh && usage >= range_low_) {
      for (std::uint32_t i = range_low_; i <= usage && usages_.size() < kMaxUsages; ++i) {
        usages_.push_back(i);
        if (i == 0xffffffffu)
          break;
      }
    }
  }

  void take_main(const Item& item) {
    if (item.tag == kCollection && item.unsigned_value == kApplication && result_.usage == 0 &&
        !usages_.empty()) {
      result_.page = static_cast<std::uint16_t>(usages_.front() >> 16);
      result_.usage = static_cast<std::uint16_t>(usages_.front());
    }
    if (item.tag == kInput)
      take_input(item.unsigned_value);
    usages_.clear();
    range_low_ = 0;
  }

  void take_input(std::uint32_t flags) {
    std::uint32_t& end = ends_[now_.report];
    const std::uint64_t more = std::uint64_t{now_.size} * now_.count;
    if (more > kMaxBits || end + more > kMaxBits) {
      result_.complete = false;
      return;
    }
    const std::uint32_t first = end + (result_.numbered ? 8 : 0);
    end += static_cast<std::uint32_t>(more);
    if ((flags & kConstant) || now_.size == 0 || now_.size > 32 || usages_.empty())
      return;
    Field field;
    field.report = now_.report;
    field.bits = static_cast<std::uint8_t>(now_.size);
    field.low = now_.low;
    // Many devices write an unsigned maximum without the zero byte that would keep it positive.
    field.high = now_.low >= 0 && now_.high < now_.low && now_.high_unsigned <= 0x7fffffffu
                     ? static_cast<std::int32_t>(now_.high_unsigned)
                     : now_.high;
    field.relative = (flags & kRelative) != 0;
    field.choice = !(flags & kVariable);
    field.nullable = (flags & kNullState) != 0;
    if (field.high <= field.low)
      return;
    for (std::uint32_t i = 0; i < now_.count && result_.fields.size() < kMaxFields; ++i) {
      const std::uint32_t usage =
          field.choice ? usages_.front() : usages_[std::min<std::size_t>(i, usages_.size() - 1)];
      field.bit = first + i * now_.size;
      field.page = static_cast<std::uint16_t>(usage >> 16);
      field.usage = static_cast<std::uint16_t>(usage);
      const bool axis = field.page == kDesktopPage && !field.choice &&
                        field.usage >= static_cast<std::uint16_t>(Usage::kX) &&
                        field.usage <= static_cast<std::uint16_t>(Usage::kWheel);
      if (axis || field.page == kButtonPage)
        result_.fields.push_back(field);
    }
  }

  ReportDescriptor result_;
  Globals now_;
  std::vector<Globals> stack_;
  std::vector<std::uint32_t> usages_;
  std::uint32_t range_low_ = 0;
  std::array<std::uint32_t, 256> ends_{}; // bits that each report has so far
};

} // namespace

ReportDescriptor parse_report_descriptor(std::span<const std::uint8_t> bytes) {
  return Parser().parse(bytes);
}

bool extract(std::span<const std::uint8_t> report, const Field& field,
             std::int32_t& value) noexcept {
  if (field.report != 0 && (report.empty() || report[0] != field.report))
    return false;
  if (field.bits == 0 || field.bits > 32 || std::size_t{field.bit} + field.bits > 8 * report.size())
    return false;
  std::uint64_t bits = 0;
  for (unsigned i = 0; i < field.bits; ++i) {
    const std::size_t at = std::size_t{field.bit} + i;
    bits |= static_cast<std::uint64_t>(report[at / 8] >> at % 8 & 1) << i;
  }
  if (field.low < 0 && bits >> (field.bits - 1) & 1)
    bits |= ~std::uint64_t{0} << field.bits;
  const auto number = static_cast<std::int64_t>(bits);
  const std::int64_t inside =
      std::clamp<std::int64_t>(number, std::int64_t{field.low}, std::int64_t{field.high});
  if (inside != number && (field.nullable || field.choice))
    return false;
  value = static_cast<std::int32_t>(inside);
  return true;
}

} // namespace tactus::devices::hid
