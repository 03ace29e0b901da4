#include "fem/modes/single_factor.hpp"

#include <algorithm>
#include <cblas.h>
#include <cmath>
#include <cstdlib>
#include <new>
#include <sys/mman.h>

namespace tactus::fem {
namespace {

/// Wider panels would store more zeros above the diagonal of their inverses; narrower panels need
/// more calls.
constexpr int kMaxPanelColumns = 48;

/// Row numbers have 32 bits, which CHOLMOD's own size limits allow.
std::int32_t narrow(std::int64_t value) { return static_cast<std::int32_t>(value); }

/// The inverse of a lower triangle of n columns, column by column, with zeros above.
void invert_lower(const float* triangle, int n, float* inverse) {
  std::fill_n(inverse, static_cast<std::size_t>(n) * static_cast<std::size_t>(n), 0.F);
  for (int j = 0; j < n; ++j) {
    float* column = inverse + static_cast<std::ptrdiff_t>(j) * n;
    column[j] = 1;
    cblas_strsv(CblasColMajor, CblasLower, CblasNoTrans, CblasNonUnit, n - j,
                triangle + static_cast<std::ptrdiff_t>(j) * (n + 1), n, column + j, 1);
  }
}

} // namespace

void SingleFactor::Release::operator()(float* memory) const noexcept { std::free(memory); }

SingleFactor::~SingleFactor() = default;

SingleFactor::SingleFactor(const SupernodalFactor& f) {
  const auto at = [](std::span<const std::int64_t> list, std::size_t k) { return list[k]; };
  int largest = 0;
  for (std::size_t s = 0; s + 1 < f.first_column.size(); ++s) {
    const std::int64_t begin = at(f.first_column, s), end = at(f.first_column, s + 1);
    const int columns = narrow(end - begin);
    const int beyond = narrow(at(f.first_row, s + 1) - at(f.first_row, s)) - columns;
    const auto first_row = static_cast<std::int64_t>(row_.size());
    for (int i = 0; i < beyond; ++i)
      row_.push_back(narrow(at(f.row, static_cast<std::size_t>(at(f.first_row, s) + columns + i))));
    const int pieces = (columns + kMaxPanelColumns - 1) / kMaxPanelColumns;
    for (int k = 0, done = 0; k < pieces; ++k) {
      const int width = (columns - done) / (pieces - k);
      done += width;
      const int inside = columns - done;
      panels_.push_back({end - inside - width, first_row, static_cast<std::int64_t>(values_), width,
                         inside, beyond});
      values_ +=
          static_cast<std::size_t>(width) * static_cast<std::size_t>(width + inside + beyond);
      largest = std::max(largest, width + inside + beyond);
    }
  }
  // Uses pages of two megabytes if the system offers them: since a substitution reads the whole
  // factor.
  constexpr std::size_t kHugePage = std::size_t{1} << 21;
  const std::size_t bytes = (values_ * sizeof(float) / kHugePage + 1) * kHugePage;
  value_.reset(static_cast<float*>(std::aligned_alloc(kHugePage, bytes)));
  if (!value_)
    throw std::bad_alloc();
  (void)::madvise(value_.get(), bytes, MADV_HUGEPAGE);

  std::vector<float> triangle(static_cast<std::size_t>(kMaxPanelColumns) * kMaxPanelColumns);
  auto panel = panels_.begin();
  for (std::size_t s = 0; s + 1 < f.first_column.size(); ++s) {
    const std::int64_t begin = at(f.first_column, s), end = at(f.first_column, s + 1);
    const auto all = static_cast<std::size_t>(at(f.first_row, s + 1) - at(f.first_row, s));
    for (; panel != panels_.end() && panel->column < end; ++panel) {
      const auto width = static_cast<std::size_t>(panel->width);
      const auto skip = static_cast<std::size_t>(panel->column - begin);
      const auto below = static_cast<std::size_t>(panel->inside + panel->beyond);
      float* to = value_.get() + panel->value;
      for (std::size_t j = 0; j < width; ++j) {
        const double* from =
            &f.value[static_cast<std::size_t>(at(f.first_value, s)) + (skip + j) * all + skip];
        std::transform(from, from + width, &triangle[j * width],
                       [](double v) { return static_cast<float>(v); });
        std::transform(from + width, from + width + below, to + width * width + j * below,
                       [](double v) { return static_cast<float>(v); });
      }
      invert_lower(triangle.data(), panel->width, to);
    }
  }
  permutation_.resize(f.permutation.size());
  std::transform(f.permutation.begin(), f.permutation.end(), permutation_.begin(), narrow);
  vector_.resize(permutation_.size());
  work_.resize(static_cast<std::size_t>(largest) + 1);
}

void SingleFactor::solve(std::span<const double> b, std::span<double> x) {
  // Scaled to unit size, since forces and stiffnesses may exceed the range of single precision.
  double largest = 0;
  for (const double v : b)
    largest = std::max(largest, std::abs(v));
  if (!(largest > 0)) {
    std::fill(x.begin(), x.end(), 0.0);
    return;
  }
  for (std::size_t i = 0; i < vector_.size(); ++i)
    vector_[i] = static_cast<float>(b[static_cast<std::size_t>(permutation_[i])] / largest);
  const auto triangle = [&](const Panel& p, CBLAS_TRANSPOSE transposed) {
    float* own = &vector_[static_cast<std::size_t>(p.column)];
    std::copy_n(own, p.width, work_.data());
    cblas_sgemv(CblasColMajor, transposed, p.width, p.width, 1, value_.get() + p.value, p.width,
                work_.data(), 1, 0, own, 1);
    return own;
  };
  const auto below = [&](const Panel& p) {
    return value_.get() + p.value + static_cast<std::ptrdiff_t>(p.width) * p.width;
  };
  for (const Panel& p : panels_) { // L y = b
    float* own = triangle(p, CblasNoTrans);
    const int rows = p.inside + p.beyond;
    if (rows == 0)
      continue;
    cblas_sgemv(CblasColMajor, CblasNoTrans, rows, p.width, 1, below(p), rows, own, 1, 0,
                work_.data(), 1);
    for (int i = 0; i < p.inside; ++i)
      own[p.width + i] -= work_[static_cast<std::size_t>(i)];
    const std::int32_t* row = row_.data() + p.first_row;
    const float* change = work_.data() + p.inside;
    for (int i = 0; i < p.beyond; ++i)
      vector_[static_cast<std::size_t>(row[i])] -= change[i];
  }
  for (auto at = panels_.rbegin(); at != panels_.rend(); ++at) { // L' x = y
    const Panel& p = *at;
    float* own = &vector_[static_cast<std::size_t>(p.column)];
    const int rows = p.inside + p.beyond;
    if (rows > 0) {
      std::copy_n(own + p.width, p.inside, work_.data());
      const std::int32_t* row = row_.data() + p.first_row;
      float* gathered = work_.data() + p.inside;
      for (int i = 0; i < p.beyond; ++i)
        gathered[i] = vector_[static_cast<std::size_t>(row[i])];
      cblas_sgemv(CblasColMajor, CblasTrans, rows, p.width, -1, below(p), rows, work_.data(), 1, 1,
                  own, 1);
    }
    (void)triangle(p, CblasTrans);
  }
  for (std::size_t i = 0; i < vector_.size(); ++i)
    x[static_cast<std::size_t>(permutation_[i])] = largest * static_cast<double>(vector_[i]);
}

double SingleFactor::memory_bytes() const noexcept {
  return static_cast<double>(4 * (values_ + row_.size() + permutation_.size() + vector_.size()) +
                             sizeof(Panel) * panels_.size());
}

} // namespace tactus::fem
