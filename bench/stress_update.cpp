// One update of the stress of a part and of its feedback: Taylor's series over a million
// sensitivities, in two shapes (elements x parameters), beside a plain loop in double and Eigen's
// matrix-vector product of the same matrix in single and double precision.
//
//   bench_stress_update --benchmark_enable_random_interleaving=true --benchmark_repetitions=9
#include "core/stress/stress_model.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <random>
#include <vector>

#if defined(TACTUS_HAS_EIGEN)
#include <Eigen/Core>
#endif

namespace {

using namespace tactus::stress;

std::shared_ptr<const StressTable> part(std::size_t elements, std::size_t parameters) {
  auto table = std::make_shared<StressTable>();
  std::mt19937 random(1);
  std::uniform_real_distribution<float> number(0.1F, 1.0F);
  auto& field = table->base.von_mises;
  for (std::size_t i = 0; i < elements; ++i)
    field.stress.push_back(1e8F * number(random));
  for (std::size_t i = 0; i < elements * parameters; ++i)
    field.sensitivity.push_back(1e10F * (number(random) - 0.5F));
  for (std::size_t p = 0; p < parameters; ++p)
    table->parameters.push_back({p / 3, static_cast<int>(p % 3), -0.01, 0.01});
  table->control_point_m.resize((parameters + 2) / 3);
  table->base.displacement_m.assign(parameters, 0);
  table->trust_m = 0.001;
  return table;
}

std::vector<double> moves(std::size_t parameters) {
  std::vector<double> result(parameters);
  for (std::size_t p = 0; p < parameters; ++p)
    result[p] = 1e-4 * static_cast<double>(p % 7 + 1);
  return result;
}

void model(benchmark::State& state, Mapping mapping) {
  const auto elements = static_cast<std::size_t>(state.range(0));
  const auto parameters = static_cast<std::size_t>(state.range(1));
  StressModel model(part(elements, parameters));
  FeedbackSettings settings;
  settings.mapping = mapping;
  model.select(settings, 0);
  auto displacement = moves(parameters);
  for (auto _ : state) {
    displacement[0] = -displacement[0];
    benchmark::DoNotOptimize(model.update(displacement).gamma.x);
  }
}

/// s and its mean, row by row, as one would write it down.
void plain(benchmark::State& state) {
  const auto elements = static_cast<std::size_t>(state.range(0));
  const auto parameters = static_cast<std::size_t>(state.range(1));
  const auto table = part(elements, parameters);
  const std::vector<double> stress(table->base.von_mises.stress.begin(),
                                   table->base.von_mises.stress.end()),
      sensitivity(table->base.von_mises.sensitivity.begin(),
                  table->base.von_mises.sensitivity.end());
  const auto displacement = moves(parameters);
  std::vector<double> now(elements);
  for (auto _ : state) {
    now = stress;
    for (std::size_t p = 0; p < parameters; ++p)
      for (std::size_t i = 0; i < elements; ++i)
        now[i] += displacement[p] * sensitivity[p * elements + i];
    double sum = 0, min = now[0], max = now[0];
    for (const double s : now) {
      sum += s;
      min = std::min(min, s);
      max = std::max(max, s);
    }
    benchmark::DoNotOptimize(gamma_of(sum / static_cast<double>(elements), min, max));
  }
}

#if defined(TACTUS_HAS_EIGEN)
template <class T> void eigen(benchmark::State& state) {
  const auto elements = state.range(0), parameters = state.range(1);
  const auto table = part(static_cast<std::size_t>(elements), static_cast<std::size_t>(parameters));
  const auto& field = table->base.von_mises;
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;
  const Vector stress = Eigen::Map<const Eigen::VectorXf>(field.stress.data(), elements).cast<T>();
  const Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic> sensitivity =
      Eigen::Map<const Eigen::MatrixXf>(field.sensitivity.data(), elements, parameters).cast<T>();
  const auto moved = moves(static_cast<std::size_t>(parameters));
  const Vector displacement = Eigen::Map<const Eigen::VectorXd>(moved.data(), parameters).cast<T>();
  Vector now(elements);
  for (auto _ : state) {
    now = stress;
    now.noalias() += sensitivity * displacement;
    benchmark::DoNotOptimize(gamma_of(static_cast<double>(now.mean()),
                                      static_cast<double>(now.minCoeff()),
                                      static_cast<double>(now.maxCoeff())));
  }
}
BENCHMARK(eigen<float>)->Args({12346, 81})->Args({333334, 3})->Unit(benchmark::kMillisecond);
BENCHMARK(eigen<double>)->Args({12346, 81})->Args({333334, 3})->Unit(benchmark::kMillisecond);
#endif

BENCHMARK_CAPTURE(model, mean, Mapping::kMean)
    ->Args({12346, 81})
    ->Args({333334, 3})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(model, weighted, Mapping::kWeighted)
    ->Args({12346, 81})
    ->Args({333334, 3})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(model, axis, Mapping::kAxis)
    ->Args({12346, 81})
    ->Args({333334, 3})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(plain)->Args({12346, 81})->Args({333334, 3})->Unit(benchmark::kMillisecond);

} // namespace

BENCHMARK_MAIN();
