// All that externals were given, and whether it still lives.
#include "max/stub/kernel.hpp"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#if defined(__SANITIZE_ADDRESS__)
#define STUB_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define STUB_ADDRESS_SANITIZER 1
#endif
#endif
#if defined(STUB_ADDRESS_SANITIZER)
// Of <sanitizer/asan_interface.h>, which g++ does not bring along.
extern "C" void __asan_poison_memory_region(const volatile void*, std::size_t);
extern "C" void __asan_unpoison_memory_region(const volatile void*, std::size_t);
#endif

namespace tactus::stub {
namespace {
/// Address to record. It only grows, and readers take no lock: a lock would order threads, and so
/// hide an external's races from the thread sanitizer.
class Table {
public:
  void add(const void* address, Record* record) {
    const std::lock_guard lock(mutex_);
    std::size_t i = first(address);
    while (slots_[i].address.load(std::memory_order_relaxed))
      i = (i + 1) % kSlots;
    if (++count_ > kSlots / 2) {
      std::fputs("the stub's table is full\n", stderr);
      std::abort();
    }
    slots_[i].record = record;
    slots_[i].address.store(address, std::memory_order_release);
    all_.push_back(record);
  }
  [[nodiscard]] Record* find(const void* address) const noexcept {
    for (std::size_t i = first(address);; i = (i + 1) % kSlots) {
      const void* found = slots_[i].address.load(std::memory_order_acquire);
      if (!found || found == address)
        return found ? slots_[i].record : nullptr;
    }
  }
  [[nodiscard]] std::vector<Record*> all() {
    const std::lock_guard lock(mutex_);
    return all_;
  }

private:
  static constexpr std::size_t kSlots = 1U << 20;
  struct Slot {
    std::atomic<const void*> address{nullptr};
    Record* record = nullptr;
  };
  [[nodiscard]] static std::size_t first(const void* address) noexcept {
    const auto bits = reinterpret_cast<std::uintptr_t>(address);
    return static_cast<std::size_t>((bits >> 4) * 0x9e3779b97f4a7c15ULL >> 44) % kSlots;
  }
  std::unique_ptr<Slot[]> slots_ = std::make_unique<Slot[]>(kSlots);
  std::size_t count_ = 0;
  std::mutex mutex_;
  std::vector<Record*> all_;
};
Table& table() {
  static Table& instance = *new Table; // lives as long as threads of externals may
  return instance;
}
constexpr std::byte kGuardByte{0xA5}, kFreshByte{0xCD}, kBuriedByte{0xDD};
} // namespace

std::mutex& kernel_mutex() {
  static std::mutex mutex;
  return mutex;
}

const char* kind_name(Kind kind) {
  static constexpr std::array names{"symbol", "class",      "attribute", "object",
                                    "outlet", "proxy",      "clock",     "qelem",
                                    "atoms",  "buffer_ref", "buffer",    "patcher"};
  return names[static_cast<std::size_t>(kind)];
}

namespace {
std::string with_article(Kind kind) {
  std::string name = kind_name(kind);
  if (kind == Kind::kAtoms)
    return name;
  return (name.find_first_of("ao") == 0 ? "an " : "a ") + name;
}
} // namespace

void add_record(const void* address, Record* record) {
  record->owner = current_call() ? current_call()->object : nullptr;
  table().add(address, record);
}
Record* find_record(const void* address) noexcept {
  return address ? table().find(address) : nullptr;
}

Record* require_record(const void* address, Kind kind, const char* function) {
  Record* record = find_record(address);
  const std::string start = std::string(function) + ": ";
  if (!address)
    violation(start + "null instead of " + kind_name(kind));
  else if (!record)
    violation(start + "not " + with_article(kind) + " that Max gave");
  else if (record->kind != kind)
    violation(start + with_article(record->kind) + " instead of " + kind_name(kind));
  else if (!record->alive)
    violation(start + "use of " + with_article(kind) + " after it was freed");
  else
    return record;
  return nullptr;
}

void report_leaks(const Object* owner) {
  for (Record* record : table().all()) {
    const bool to_free = record->kind == Kind::kProxy || record->kind == Kind::kClock ||
                         record->kind == Kind::kQelem || record->kind == Kind::kAtoms ||
                         record->kind == Kind::kBufferRef;
    if (to_free && record->owner == owner && record->alive.exchange(false))
      violation(std::string("leak: ") + kind_name(record->kind) + " of " +
                (owner ? owner->text() : "nobody") + " was not freed");
    if (!owner && record->kind == Kind::kAttribute && !static_cast<Attribute*>(record)->added)
      violation("leak: attribute " + static_cast<Attribute*>(record)->name +
                " was added to no class");
    if (!owner && record->kind == Kind::kObject) {
      const auto& object = static_cast<Object&>(*record);
      if (record->alive)
        violation("leak: object " + object.text() + " was not freed");
      else if (!object.block.undisturbed())
        violation("write to " + object.text() + " after it was freed");
    }
  }
}

Block::Block(std::size_t size)
    : size_(size), memory_(static_cast<std::byte*>(std::malloc(size + 2 * kGuard))),
      data_(memory_ + kGuard) {
  std::memset(memory_, static_cast<int>(kGuardByte), size + 2 * kGuard);
  std::memset(data_, static_cast<int>(kFreshByte), size); // Max promises no zeros
#if defined(STUB_ADDRESS_SANITIZER)
  __asan_poison_memory_region(data_ + ((size + 7) & ~std::size_t{7}), kGuard / 2);
#endif
}

Block::~Block() {
#if defined(STUB_ADDRESS_SANITIZER)
  __asan_unpoison_memory_region(memory_, size_ + 2 * kGuard);
#endif
  std::free(memory_);
}

bool Block::guards_intact() const noexcept {
#if defined(STUB_ADDRESS_SANITIZER)
  __asan_unpoison_memory_region(memory_, size_ + 2 * kGuard);
#endif
  for (std::size_t i = 0; i < kGuard; ++i)
    if (memory_[i] != kGuardByte || data_[size_ + i] != kGuardByte)
      return false;
  return true;
}

void Block::bury() noexcept {
  std::memset(data_, static_cast<int>(kBuriedByte), size_);
#if defined(STUB_ADDRESS_SANITIZER)
  __asan_poison_memory_region(data_, size_);
#endif
}

bool Block::undisturbed() const noexcept {
#if defined(STUB_ADDRESS_SANITIZER)
  __asan_unpoison_memory_region(data_, size_);
#endif
  for (std::size_t i = 0; i < size_; ++i)
    if (data_[i] != kBuriedByte)
      return false;
  return true;
}

} // namespace tactus::stub
