#include "fem/modes/shifted_factor.hpp"

#include "fem/modes/single_factor.hpp"

#include <cholmod.h>
#include <cstring>

extern "C" void openblas_set_num_threads(int);

namespace tactus::fem {

void set_solver_threads(int count) { openblas_set_num_threads(count); }

struct ShiftedFactor::Implementation {
  cholmod_common common{};
  cholmod_sparse matrix{};
  std::vector<SuiteSparse_long> start, row;
  std::vector<double> value;
  cholmod_factor *symbolic = nullptr, *factor = nullptr;
  std::unique_ptr<SingleFactor> single; ///< copy of the factor
  cholmod_dense *solution = nullptr, *work_y = nullptr, *work_e = nullptr;

  Implementation() {
    cholmod_l_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    common.postorder = 1;
  }
  ~Implementation() {
    cholmod_l_free_factor(&symbolic, &common);
    cholmod_l_free_factor(&factor, &common);
    cholmod_l_free_dense(&solution, &common);
    cholmod_l_free_dense(&work_y, &common);
    cholmod_l_free_dense(&work_e, &common);
    cholmod_l_finish(&common);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void fill(const Matrices& m, double shift);
  std::vector<SuiteSparse_long> order(const NodeGraph&);
  /// Makes the factor that the numeric phase fills. `from` stays symbolic, so that further factors
  /// of the same graph can copy it.
  void copy_symbolic(cholmod_factor* from) {
    factor = from ? cholmod_l_copy_factor(from, &common) : nullptr;
    if (!factor)
      throw InputError("the equations cannot be analysed: out of memory");
  }
};

namespace {

cholmod_sparse lower_view(std::size_t size, SuiteSparse_long* start, SuiteSparse_long* row,
                          double* value) {
  cholmod_sparse a{};
  a.nrow = a.ncol = size;
  a.nzmax = static_cast<std::size_t>(start[size]);
  a.p = start;
  a.i = row;
  a.x = value;
  a.stype = -1;
  a.itype = CHOLMOD_LONG;
  a.xtype = value ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = a.packed = 1;
  return a;
}

} // namespace

void ShiftedFactor::Implementation::fill(const Matrices& m, double shift) {
  const NodeGraph& graph = m.graph;
  const std::size_t n = m.dofs();
  start.assign(n + 1, 0);
  row.reserve(9 * graph.row.size());
  value.reserve(9 * graph.row.size());
  for (std::size_t column = 0; column < graph.node_count(); ++column)
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t c = 3 * column + j;
      for (auto k = static_cast<std::size_t>(graph.start[column]);
           k < static_cast<std::size_t>(graph.start[column + 1]); ++k) {
        const auto r = static_cast<std::size_t>(graph.row[k]);
        for (std::size_t i = r == column ? j : 0; i < 3; ++i) {
          const bool constrained = m.constrained[3 * r + i] || m.constrained[c];
          const bool diagonal = 3 * r + i == c;
          double a = constrained ? (diagonal ? 1.0 : 0.0) : m.stiffness[9 * k + 3 * i + j];
          if (!constrained && i == j && shift != 0)
            a += shift * m.mass[k];
          row.push_back(static_cast<SuiteSparse_long>(3 * r + i));
          value.push_back(a);
        }
      }
      start[c + 1] = static_cast<SuiteSparse_long>(row.size());
    }
  matrix = lower_view(n, start.data(), row.data(), value.data());
}

/// Permutation of the degrees of freedom by nested dissection of the nodes; the three directions of
/// a node stay together. With a third of the rows this is several times faster than ordering the
/// degrees of freedom, with the same fill.
std::vector<SuiteSparse_long> ShiftedFactor::Implementation::order(const NodeGraph& graph) {
  const std::size_t n = graph.node_count();
  std::vector<SuiteSparse_long> graph_start(graph.start.begin(), graph.start.end());
  std::vector<SuiteSparse_long> graph_row(graph.row.begin(), graph.row.end());
  cholmod_sparse a = lower_view(n, graph_start.data(), graph_row.data(), nullptr);
  std::vector<SuiteSparse_long> of_node(n), of_dof(3 * n);
  if (!cholmod_l_metis(&a, nullptr, 0, 1, of_node.data(), &common))
    throw InputError("the equations cannot be ordered: out of memory");
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      of_dof[3 * i + k] = 3 * of_node[i] + static_cast<SuiteSparse_long>(k);
  return of_dof;
}

ShiftedFactor::ShiftedFactor(const Matrices& m, double shift)
    : impl_(std::make_unique<Implementation>()) {
  impl_->fill(m, shift);
  auto permutation = impl_->order(m.graph);
  impl_->symbolic =
      cholmod_l_analyze_p(&impl_->matrix, permutation.data(), nullptr, 0, &impl_->common);
  impl_->copy_symbolic(impl_->symbolic);
  cost_.entries = impl_->common.lnz;
  cost_.operations = impl_->common.fl;
  cost_.memory_bytes = 8.0 * static_cast<double>(impl_->factor->xsize) +
                       16.0 * static_cast<double>(impl_->row.size());
}

ShiftedFactor::ShiftedFactor(const ShiftedFactor& pattern, const Matrices& m, double shift)
    : impl_(std::make_unique<Implementation>()), cost_(pattern.cost_) {
  impl_->fill(m, shift);
  impl_->symbolic = cholmod_l_copy_factor(pattern.impl_->symbolic, &impl_->common);
  impl_->copy_symbolic(impl_->symbolic);
}

ShiftedFactor::~ShiftedFactor() = default;

void ShiftedFactor::factorise() {
  cholmod_l_factorize(&impl_->matrix, impl_->factor, &impl_->common);
  if (impl_->common.status == CHOLMOD_NOT_POSDEF)
    throw InputError("the stiffness matrix is not positive definite: an element near node " +
                     std::to_string(impl_->factor->minor / 3 + 1) + " is invalid");
  if (impl_->common.status != CHOLMOD_OK)
    throw InputError("the factor does not fit into memory: " +
                     std::to_string(static_cast<long>(cost_.memory_bytes / 1e6)) +
                     " MB are needed: use a coarser mesh (--h)");
  impl_->matrix.i = impl_->matrix.x = nullptr; // solutions need only the size
  impl_->row = {};
  impl_->value = {};
}

void ShiftedFactor::solve(std::span<const double> b, std::span<double> x, std::size_t columns) {
  const std::size_t n = impl_->matrix.nrow;
  cholmod_dense right{};
  right.nrow = right.d = n;
  right.ncol = columns;
  right.nzmax = n * columns;
  right.x = const_cast<double*>(b.data()); // only read by CHOLMOD
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  if (!cholmod_l_solve2(CHOLMOD_A, impl_->factor, &right, nullptr, &impl_->solution, nullptr,
                        &impl_->work_y, &impl_->work_e, &impl_->common))
    throw InputError("the equations cannot be solved: out of memory");
  std::memcpy(x.data(), impl_->solution->x, n * columns * sizeof(double));
}

void ShiftedFactor::prepare() {
  if (impl_->single)
    return;
  const cholmod_factor& f = *impl_->factor;
  const auto numbers = [](const void* all, std::size_t count) {
    static_assert(sizeof(SuiteSparse_long) == sizeof(std::int64_t));
    return std::span(static_cast<const std::int64_t*>(all), count);
  };
  impl_->single = std::make_unique<SingleFactor>(
      SupernodalFactor{numbers(f.super, f.nsuper + 1), numbers(f.pi, f.nsuper + 1),
                       numbers(f.px, f.nsuper + 1), numbers(f.s, f.ssize), numbers(f.Perm, f.n),
                       std::span(static_cast<const double*>(f.x), f.xsize)});
}

void ShiftedFactor::precondition(std::span<const double> b, std::span<double> x) {
  prepare();
  impl_->single->solve(b, x);
}

double ShiftedFactor::memory_bytes() const noexcept {
  return 8. * static_cast<double>(impl_->factor->xsize) +
         (impl_->single ? impl_->single->memory_bytes() : 0) +
         8. * static_cast<double>(impl_->factor->ssize);
}

} // namespace tactus::fem
