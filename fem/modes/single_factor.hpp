#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tactus::fem {

/// A supernodal Cholesky factor as CHOLMOD stores it: columns first_column[s] to first_column[s +
/// 1] of supernode s have the rows row[first_row[s]] to row[first_row[s + 1]], with the supernode's
/// own columns first. Their values are stored column by column from value[first_value[s]] on.
/// Entries above the diagonal are not defined.
struct SupernodalFactor {
  std::span<const std::int64_t> first_column, first_row, first_value, row, permutation;
  std::span<const double> value;
};

/// A copy of a Cholesky factor in single precision, stored for substitutions: panels of a few
/// columns, each with the inverse of its triangle and the rows below it. A substitution then
/// consists of products of dense matrices and vectors that read memory once from front to back.
class SingleFactor {
public:
  explicit SingleFactor(const SupernodalFactor&);
  ~SingleFactor();
  SingleFactor(const SingleFactor&) = delete;
  SingleFactor& operator=(const SingleFactor&) = delete;

  /// x = (L L')^-1 b, with an error of about 1e-6 of its largest entry times the condition of L;
  /// `x` and `b` may be the same memory.
  void solve(std::span<const double> b, std::span<double> x);
  [[nodiscard]] double memory_bytes() const noexcept;

private:
  struct Panel {
    std::int64_t column;    ///< first column
    std::int64_t first_row; ///< position in row_ of the rows below its supernode
    std::int64_t value;     ///< first position in value_
    int width, inside,
        beyond; ///< number of columns; rows below, within the supernode and beyond
  };
  struct Release {
    void operator()(float*) const noexcept;
  };
  std::vector<Panel> panels_;
  std::vector<std::int32_t> row_, permutation_;
  std::unique_ptr<float[], Release> value_;
  std::size_t values_ = 0;
  std::vector<float> vector_, work_;
};

} // namespace tactus::fem
