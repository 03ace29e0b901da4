#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace tactus {

/// A sentence built without allocating, for errors of realtime messages. Text beyond its capacity
/// is cut off.
class Sentence {
public:
  explicit Sentence(std::string_view begin) { *this += begin; }
  Sentence& operator+=(std::string_view text) noexcept {
    const std::size_t count = std::min(text.size(), text_.size() - size_);
    std::copy_n(text.begin(), count, text_.begin() + size_);
    size_ += count;
    return *this;
  }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  operator std::string_view() const noexcept { return {text_.data(), size_}; }

private:
  static constexpr std::size_t kMaxSize = 480;
  std::array<char, kMaxSize> text_{};
  std::size_t size_ = 0;
};

} // namespace tactus
