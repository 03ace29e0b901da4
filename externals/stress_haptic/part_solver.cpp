#include "externals/stress_haptic/part_solver.hpp"

#include "core/declaration_text.hpp"
#include "files/system_folders.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <string_view>
#include <utility>

namespace tactus::stress {

using serve::kKeepFactor;
using serve::kWithDerivatives;
using serve::ServeReady;
using serve::StressAnswer;

namespace {

constexpr const char* kProgram = "part_stress";
constexpr double kPollInterval_s = 0.1; // interval of checks of the time limit while waiting

template <class T> void append(std::vector<std::byte>& bytes, const T& value) {
  const auto* begin = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), begin, begin + sizeof value);
}

template <class T> std::vector<T> take_array(std::span<const std::byte>& bytes, std::size_t count) {
  std::vector<T> values(count);
  if (count > 0)
    std::memcpy(values.data(), bytes.data(), count * sizeof(T));
  bytes = bytes.subspan(count * sizeof(T));
  return values;
}

} // namespace

std::string find_part_stress(const std::string& program) { return find_program(kProgram, program); }

PartSolver::PartSolver(SolverOptions options, const Limits& limits)
    : options_(std::move(options)), limits_(limits) {}

void PartSolver::mark_lost(const std::string& reason) {
  child_.reset();
  state_ = State::kLost;
  result_ = Result{};
  result_->lost = true;
  result_->refusal = reason;
}

void PartSolver::launch() {
  const std::string program = find_part_stress(options_.program);
  if (program.empty())
    return mark_lost(
        "the program " + (options_.program.empty() ? kProgram : options_.program) +
        " was not found: expected beside stress_haptic or in PATH; else send solver with its path");
  std::string refusal;
  child_ = ServedProgram::start(
      {program, "serve", options_.path, "--tolerance", number_text(kTolerance)}, kProgram,
      limits_.start_s, refusal);
  if (!child_)
    return mark_lost("the solver: " + refusal);
  state_ = State::kLoading;
}

bool PartSolver::prepare() {
  if (options_.wait)
    return state_ != State::kLost; // start() loads the part when it is needed
  if (state_ == State::kNone)
    launch();
  advance();
  return state_ == State::kReady;
}

std::string PartSolver::start(std::span<const double> displacement_m, Method method,
                              bool sensitivities) {
  if (state_ == State::kNone)
    launch();
  while (options_.wait && (state_ == State::kLoading || state_ == State::kChecking))
    advance();
  if (state_ == State::kLost)
    return {}; // poll() reports the error
  if (state_ != State::kReady)
    return "the solver has not loaded the part yet";
  const bool direct = method == Method::kFull || sensitivities;
  sensitivities_ = sensitivities;
  // The time limit is twenty times the estimated duration of a solve.
  const double parameters = static_cast<double>(options_.table.parameters.size());
  const double expected_s =
      costs_.factor_s + (60 + parameters) * (costs_.product_s + costs_.solve_s);
  send_request(displacement_m, direct ? ServeMethod::refactor : ServeMethod::pcg,
               (sensitivities ? kWithDerivatives : 0U) | kKeepFactor,
               std::max(limits_.solve_s, 20 * expected_s));
  state_ = State::kSolving;
  return {};
}

std::optional<Reanalysis::Result> PartSolver::poll() {
  if (state_ != State::kNone && state_ != State::kLost)
    advance();
  while (options_.wait && state_ == State::kSolving)
    advance();
  return std::exchange(result_, std::nullopt);
}

void PartSolver::send_request(std::span<const double> displacement_m, ServeMethod method,
                              std::uint32_t flags, double limit_s) {
  std::vector<std::byte> payload;
  append(payload, static_cast<std::uint32_t>(method));
  append(payload, flags);
  const auto bytes = std::as_bytes(displacement_m);
  payload.insert(payload.end(), bytes.begin(), bytes.end());
  child_->send_request(ServeKind::solve, payload, limit_s);
}

std::uint64_t PartSolver::answer_bytes() const noexcept {
  const std::uint64_t rows = sensitivities_ ? 1 + options_.table.parameters.size() : 1;
  return sizeof(StressAnswer) + 8 * options_.table.parameters.size() +
         8 * rows * options_.table.elements();
}

/// Handles a complete message.
void PartSolver::advance() {
  if (state_ == State::kNone || state_ == State::kLost)
    return;
  if (options_.wait && state_ != State::kReady)
    child_->wait(kPollInterval_s);
  std::string reason;
  const auto expects = [this](const ServeHeader& header) {
    const auto kind = static_cast<ServeKind>(header.kind);
    return state_ == State::kLoading ? kind == ServeKind::ready && header.size == sizeof(ServeReady)
                                     : kind == ServeKind::stress && header.size == answer_bytes();
  };
  const auto message = child_->poll(expects, reason);
  if (!reason.empty())
    return mark_lost(reason);
  if (message)
    try {
      take(message->kind, message->payload);
    } catch (const std::bad_alloc&) {
      mark_lost("not enough memory for the solver's answer");
    }
}

void PartSolver::take(ServeKind kind, std::span<const std::byte> payload) {
  if (kind == ServeKind::ready)
    return take_ready(payload);
  if (kind == ServeKind::stress)
    return take_answer(payload);
  const std::string sentence = printable_line(
      std::string_view(reinterpret_cast<const char*>(payload.data()), payload.size()));
  if (state_ != State::kSolving)
    return mark_lost("the solver refused the part: " + sentence);
  state_ = State::kReady;
  result_ = Result{};
  result_->refusal = sentence;
}

void PartSolver::take_ready(std::span<const std::byte> payload) {
  const auto ready = value_at<ServeReady>(payload);
  const StressTable& table = options_.table;
  if (ready.elements != table.elements() || ready.parameters != table.parameters.size())
    return mark_lost("the solver's part has " + std::to_string(ready.elements) + " elements and " +
                     std::to_string(ready.parameters) + " parameters: expected the table's " +
                     std::to_string(table.elements()) + " and " +
                     std::to_string(table.parameters.size()));
  for (const double cost : {ready.product_s, ready.solve_s, ready.factor_s})
    if (!(cost >= 0 && cost < 1e5))
      return mark_lost("the solver reports a cost of " + number_text(cost) +
                       " s: expected 0..100000 s");
  costs_ = {ready.product_s, ready.solve_s, ready.factor_s};
  state_ = State::kChecking;
  send_request(std::vector<double>(table.parameters.size()), ServeMethod::pcg, kKeepFactor,
               limits_.start_s);
}

bool PartSolver::is_initial_base(const StressBase& base) const {
  const auto same = [](const std::vector<float>& a, const std::vector<float>& b) {
    double largest = 0, difference = 0;
    for (std::size_t i = 0; i < b.size(); ++i) {
      const double x = a[i], y = b[i];
      largest = std::max(largest, std::abs(y));
      if (!(std::abs(x - y) <= difference)) // true for NaN too
        difference = std::isfinite(x) ? std::abs(x - y) : HUGE_VAL;
    }
    return difference <= kSameStress * largest;
  };
  const StressBase& own = options_.table.base;
  return same(base.von_mises.stress, own.von_mises.stress) &&
         (!options_.table.has_shear() || same(base.max_shear.stress, own.max_shear.stress));
}

void PartSolver::take_answer(std::span<const std::byte> payload) {
  const StressTable& table = options_.table;
  const std::size_t elements = table.elements(), parameters = table.parameters.size();
  const auto fixed = value_at<StressAnswer>(payload);
  payload = payload.subspan(sizeof fixed);
  const StressBase& before = latest_ ? *latest_ : table.base;
  auto base = std::make_shared<StressBase>();
  base->displacement_m = take_array<double>(payload, parameters);
  base->von_mises.stress = take_array<float>(payload, elements);
  base->max_shear.stress = take_array<float>(payload, elements);
  const bool is_consistent = (fixed.method == static_cast<std::uint32_t>(ServeMethod::pcg) ||
                              fixed.method == static_cast<std::uint32_t>(ServeMethod::refactor)) &&
                             fixed.seconds >= 0 && fixed.seconds < 1e6 &&
                             fixed.iterations < 100000 &&
                             std::all_of(base->displacement_m.begin(), base->displacement_m.end(),
                                         [](double x) { return std::isfinite(x); });
  if (!is_consistent)
    return mark_lost("the solver sent impossible numbers and was stopped (method " +
                     std::to_string(fixed.method) + ", " + std::to_string(fixed.iterations) +
                     " iterations, " + number_text(fixed.seconds) + " s)");
  if (state_ == State::kChecking) {
    if (!is_initial_base(*base))
      return mark_lost("the solver's stress at the table's own shape differs from the table's: "
                       "expected the unchanged file that part_stress wrote");
    state_ = State::kReady;
    return;
  }
  if (sensitivities_) {
    base->von_mises.sensitivity = take_array<float>(payload, parameters * elements);
    base->max_shear.sensitivity = take_array<float>(payload, parameters * elements);
  } else {
    base->von_mises.sensitivity = before.von_mises.sensitivity;
    base->max_shear.sensitivity = before.max_shear.sensitivity;
  }
  if (!table.has_shear())
    base->max_shear = {};
  state_ = State::kReady;
  Result result;
  result.method =
      fixed.method == static_cast<std::uint32_t>(ServeMethod::pcg) ? Method::kPcg : Method::kFull;
  result.iterations = fixed.iterations;
  result.seconds = fixed.seconds;
  result.stale_sensitivities = !sensitivities_;
  result.base = base;
  latest_ = std::move(base);
  result_ = std::move(result);
}

} // namespace tactus::stress
