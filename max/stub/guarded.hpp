#pragma once

#include <cstddef>
#include <span>
#include <string>

/// Memory that an external may not touch, and what happens when it does: a violation, then the
/// memory opens and the run goes on.
namespace tactus::stub {

void install_fault_handler();

/// Pages without access.
class ForbiddenPages {
public:
  explicit ForbiddenPages(const std::string& what);
  ~ForbiddenPages();
  ForbiddenPages(const ForbiddenPages&) = delete;
  ForbiddenPages& operator=(const ForbiddenPages&) = delete;
  [[nodiscard]] double* data() const noexcept { return static_cast<double*>(memory_); }

private:
  void* memory_;
  std::size_t slot_;
};

/// n doubles that end at a page without access; those before them are watched.
class GuardedVector {
public:
  GuardedVector(std::size_t count, const std::string& what);
  ~GuardedVector();
  GuardedVector(const GuardedVector&) = delete;
  GuardedVector& operator=(const GuardedVector&) = delete;
  [[nodiscard]] double* data() const noexcept { return data_; }
  [[nodiscard]] std::span<double> all() const noexcept { return {data_, count_}; }
  [[nodiscard]] bool front_intact() const noexcept;
  /// Forbids or allows the doubles themselves.
  void forbid(bool forbidden) noexcept;

private:
  std::size_t count_, bytes_, open_bytes_;
  std::byte* memory_;
  double* data_;
  std::size_t slot_, end_slot_;
  bool forbidden_ = false;
};

} // namespace tactus::stub
