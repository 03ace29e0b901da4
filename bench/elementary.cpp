// The core's elementary functions beside the C library's: nanoseconds a call, one after the other
// on arguments as the core uses them, and the sum over the calls that stand in the core's sources.
//
//   bench_elementary
//
// Each pair is timed in turn and the least of all rounds is printed; trust the ratios.
#include "core/dsp/elementary.hpp"
#include "core/dsp/random.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

namespace {

namespace math = tactus::math;

constexpr int kRounds = 60, kArguments = 4000;
volatile double sink = 0;

using Function = double (*)(double);

struct Row {
  const char* name;
  int calls; ///< in the sources of core and externals
  double low, high;
  Function ours, library;
};
constexpr Row kRows[] = {
    {"exp", 77, -20, 3, math::exp, [](double x) { return std::exp(x); }},
    {"exp2", 13, -3, 3, math::exp2, [](double x) { return std::exp2(x); }},
    {"exp10", 7, -4, 1, math::exp10, [](double x) { return std::pow(10.0, x); }},
    {"expm1", 7, -3, 0.1, math::expm1, [](double x) { return std::expm1(x); }},
    {"log", 16, 0.01, 100, math::log, [](double x) { return std::log(x); }},
    {"log1p", 3, -0.9, 1, math::log1p, [](double x) { return std::log1p(x); }},
    {"log2", 9, 0.1, 1000, math::log2, [](double x) { return std::log2(x); }},
    {"log10", 3, 0.01, 100, math::log10, [](double x) { return std::log10(x); }},
    {"pow", 39, 0.01, 10, [](double x) { return math::pow(x, 1.3); },
     [](double x) { return std::pow(x, 1.3); }},
    {"sin", 33, -6, 6, math::sin, [](double x) { return std::sin(x); }},
    {"cos", 35, -6, 6, math::cos, [](double x) { return std::cos(x); }},
    {"polar", 17, -6, 6,
     [](double x) {
       const math::SineCosine of = math::sincos(x);
       return of.sine + of.cosine;
     },
     [](double x) { return std::sin(x) + std::cos(x); }},
    {"tan", 8, 0, 1.5, math::tan, [](double x) { return std::tan(x); }},
    {"atan2", 9, -10, 10, [](double x) { return math::atan2(x, 1.3); },
     [](double x) { return std::atan2(x, 1.3); }},
    {"hypot", 35, 0.01, 10, [](double x) { return math::hypot(x, 1.3); },
     [](double x) { return std::hypot(x, 1.3); }},
    {"cbrt", 1, 0.1, 10, math::cbrt, [](double x) { return std::cbrt(x); }},
    {"cosh", 1, -3, 3, math::cosh, [](double x) { return std::cosh(x); }},
    {"tanh", 3, -3, 3, math::tanh, [](double x) { return std::tanh(x); }},
    {"tgamma", 2, 0.5, 2, math::tgamma, [](double x) { return std::tgamma(x); }},
};

double seconds(Function f, const std::vector<double>& arguments) {
  const auto start = std::chrono::steady_clock::now();
  double sum = 0;
  for (const double x : arguments)
    sum += f(x);
  sink = sum;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

int main() {
  std::printf("%-8s %5s %8s %8s %8s\n", "", "calls", "ours", "C", "ours/C");
  double calls = 0, ours = 0, library = 0;
  for (const Row& row : kRows) {
    tactus::Random random(1);
    std::vector<double> arguments(kArguments);
    for (double& x : arguments)
      x = row.low + (row.high - row.low) * random.uniform();
    double a = 1, b = 1;
    for (int n = 0; n < kRounds; ++n) {
      a = std::min(a, seconds(row.ours, arguments));
      b = std::min(b, seconds(row.library, arguments));
    }
    a *= 1e9 / kArguments;
    b *= 1e9 / kArguments;
    std::printf("%-8s %5d %8.2f %8.2f %8.2f\n", row.name, row.calls, a, b, a / b);
    calls += row.calls;
    ours += row.calls * a;
    library += row.calls * b;
  }
  std::printf("%-8s %5.0f %8.2f %8.2f %8.2f\n", "all", calls, ours / calls, library / calls,
              ours / library);
}
