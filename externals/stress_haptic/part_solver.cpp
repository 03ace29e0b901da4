#include "externals/stress_haptic/part_solver.hpp"

#include "core/words.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <filesystem>
#include <new>
#include <string_view>
#include <type_traits>
#include <unistd.h>
#include <utility>

namespace tactus::stress {
namespace {

static_assert(std::endian::native == std::endian::little, "messages are copied as they lie");

constexpr const char* kProgram = "part_stress";
constexpr std::uint64_t kMaxSentence = 4096;
constexpr double kEndGrace_s = 0.1;
constexpr double kLook_s = 0.1; // between looks at the clock of one who waits

bool can_run(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
}

/// The folder of the module that this code is part of.
std::filesystem::path own_folder() {
  Dl_info found{};
  static const char here = 0;
  if (::dladdr(&here, &found) == 0 || !found.dli_fname)
    return {};
  return std::filesystem::path(found.dli_fname).parent_path();
}

/// What a child says, on one line.
std::string printable(std::string_view text) {
  std::string line(text.substr(0, 300));
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 32 || c == 127; }, ' ');
  return line;
}

template <class T> T read_at(std::span<const std::byte> bytes, std::size_t offset) {
  static_assert(std::is_trivially_copyable_v<T>);
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

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

std::string find_part_stress(const std::string& program) {
  if (program.find('/') != std::string::npos)
    return can_run(program) ? program : std::string();
  const std::string name = program.empty() ? kProgram : program;
  if (const auto beside = own_folder() / name; program.empty() && can_run(beside))
    return beside.string();
  const char* path = std::getenv("PATH");
  std::string_view left = path ? path : "";
  while (!left.empty()) {
    const std::string_view folder = left.substr(0, left.find(':'));
    left.remove_prefix(std::min(left.size(), folder.size() + 1));
    // An empty entry, the current folder, is left out: a patch's folder runs no programs.
    if (const auto here = std::filesystem::path(folder) / name; !folder.empty() && can_run(here))
      return here.string();
  }
  return {};
}

PartSolver::PartSolver(SolverOrder order, const Limits& limits)
    : order_(std::move(order)), limits_(limits) {}

void PartSolver::set_limit(double seconds) {
  limit_s_ = seconds;
  limit_ = Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

void PartSolver::lose(const std::string& reason) {
  child_.reset();
  state_ = State::kLost;
  result_ = Result{};
  result_->lost = true;
  result_->refusal = reason;
}

void PartSolver::launch() {
  const std::string program = find_part_stress(order_.program);
  if (program.empty())
    return lose("the program " + (order_.program.empty() ? kProgram : order_.program) +
                " was not found: expected it beside stress_haptic, in PATH, or by solver PATH");
  std::string refusal;
  child_ = ChildProcess::start(
      {program, "serve", order_.path, "--tolerance", number_text(kTolerance)}, refusal);
  if (!child_)
    return lose("the solver: " + refusal);
  state_ = State::kLoading;
  set_limit(limits_.start_s);
}

bool PartSolver::prepare() {
  if (order_.wait)
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
  while (order_.wait && (state_ == State::kLoading || state_ == State::kChecking))
    advance();
  if (state_ == State::kLost)
    return {}; // poll() tells
  if (state_ != State::kReady)
    return "the solver has not loaded the part yet";
  const bool direct = method == Method::kFull || sensitivities;
  sensitivities_ = sensitivities;
  ask(displacement_m, direct ? ServeMethod::refactor : ServeMethod::pcg,
      (sensitivities ? kWithDerivatives : 0U) | kKeepFactor);
  state_ = State::kSolving;
  // All that a solve may take by the costs, twenty times.
  const double parameters = static_cast<double>(order_.table.parameters.size());
  const double expected_s =
      costs_.factor_s + (60 + parameters) * (costs_.product_s + costs_.solve_s);
  set_limit(std::max(limits_.solve_s, 20 * expected_s));
  return {};
}

std::optional<Reanalysis::Result> PartSolver::poll() {
  if (state_ != State::kNone && state_ != State::kLost)
    advance();
  while (order_.wait && state_ == State::kSolving)
    advance();
  return std::exchange(result_, std::nullopt);
}

void PartSolver::ask(std::span<const double> displacement_m, ServeMethod method,
                     std::uint32_t flags) {
  out_.clear();
  sent_ = 0;
  append(out_, ServeHeader{ServeHeader::kMagic, static_cast<std::uint32_t>(ServeKind::solve),
                           8 + displacement_m.size_bytes()});
  append(out_, static_cast<std::uint32_t>(method));
  append(out_, flags);
  const auto bytes = std::as_bytes(displacement_m);
  out_.insert(out_.end(), bytes.begin(), bytes.end());
}

std::uint64_t PartSolver::answer_bytes() const noexcept {
  const std::uint64_t rows = sensitivities_ ? 1 + order_.table.parameters.size() : 1;
  return sizeof(StressAnswer) + 8 * order_.table.parameters.size() +
         8 * rows * order_.table.elements();
}

/// Sends and receives what the pipes take, and acts on a message that is whole.
void PartSolver::advance() {
  if (state_ == State::kNone || state_ == State::kLost)
    return;
  if (order_.wait && state_ != State::kReady)
    child_->wait(kLook_s);
  try {
    exchange();
  } catch (const std::bad_alloc&) {
    in_ = {};
    lose("there is not enough memory for the solver's answer");
  }
  const bool asked = state_ != State::kReady && state_ != State::kLost;
  if (asked && Clock::now() >= limit_)
    lose("the solver did not answer within " + number_text(limit_s_) + " s and was ended");
}

void PartSolver::exchange() {
  if (sent_ < out_.size())
    sent_ += child_->send(std::span(out_).subspan(sent_));
  const auto missing = [this](std::size_t whole) {
    return whole > in_.size() ? child_->receive(in_, whole - in_.size()) : true;
  };
  bool open = missing(sizeof(ServeHeader));
  if (in_.size() >= sizeof(ServeHeader)) {
    const auto header = read_at<ServeHeader>(in_, 0);
    const auto kind = static_cast<ServeKind>(header.kind);
    const bool waits = state_ != State::kReady;
    const bool fits = header.magic == ServeHeader::kMagic && waits &&
                      ((kind == ServeKind::ready && state_ == State::kLoading &&
                        header.size == sizeof(ServeReady)) ||
                       (kind == ServeKind::stress && state_ != State::kLoading &&
                        header.size == answer_bytes()) ||
                       (kind == ServeKind::refused && header.size <= kMaxSentence));
    if (!fits)
      return lose("the solver answered what is no answer (magic " + std::to_string(header.magic) +
                  ", kind " + std::to_string(header.kind) + ", " + std::to_string(header.size) +
                  " bytes) and was ended: expected part_stress of this version");
    const std::size_t whole = sizeof(ServeHeader) + static_cast<std::size_t>(header.size);
    open = missing(whole);
    if (in_.size() >= whole) {
      const std::vector<std::byte> message = std::exchange(in_, {});
      return take(kind, std::span(message).subspan(sizeof(ServeHeader)));
    }
  }
  if (!open)
    lose("the solver ended: " + printable(child_->end(kEndGrace_s)));
}

void PartSolver::take(ServeKind kind, std::span<const std::byte> payload) {
  if (kind == ServeKind::ready)
    return take_ready(payload);
  if (kind == ServeKind::stress)
    return take_answer(payload);
  const std::string sentence =
      printable(std::string_view(reinterpret_cast<const char*>(payload.data()), payload.size()));
  if (state_ != State::kSolving)
    return lose("the solver refuses the part: " + sentence);
  state_ = State::kReady;
  result_ = Result{};
  result_->refusal = sentence;
}

void PartSolver::take_ready(std::span<const std::byte> payload) {
  const auto ready = read_at<ServeReady>(payload, 0);
  const StressTable& table = order_.table;
  if (ready.elements != table.elements() || ready.parameters != table.parameters.size())
    return lose("the solver's part has " + std::to_string(ready.elements) + " elements and " +
                std::to_string(ready.parameters) + " parameters: expected the table's " +
                std::to_string(table.elements()) + " and " +
                std::to_string(table.parameters.size()));
  for (const double cost : {ready.product_s, ready.solve_s, ready.factor_s})
    if (!(cost >= 0 && cost < 1e5))
      return lose("the solver says that an operation takes " + number_text(cost) +
                  " s: expected 0..100000 s");
  costs_ = {ready.product_s, ready.solve_s, ready.factor_s};
  state_ = State::kChecking; // within the limit of loading
  ask(std::vector<double>(table.parameters.size()), ServeMethod::pcg, kKeepFactor);
}

bool PartSolver::is_tables_own(const StressBase& base) const {
  const auto same = [](const std::vector<float>& a, const std::vector<float>& b) {
    double largest = 0, difference = 0;
    for (std::size_t i = 0; i < b.size(); ++i) {
      const double x = a[i], y = b[i];
      largest = std::max(largest, std::abs(y));
      if (!(std::abs(x - y) <= difference)) // also what is no number
        difference = std::isfinite(x) ? std::abs(x - y) : HUGE_VAL;
    }
    return difference <= kSameStress * largest;
  };
  const StressBase& own = order_.table.base;
  return same(base.von_mises.stress, own.von_mises.stress) &&
         (!order_.table.has_shear() || same(base.max_shear.stress, own.max_shear.stress));
}

void PartSolver::take_answer(std::span<const std::byte> payload) {
  const StressTable& table = order_.table;
  const std::size_t elements = table.elements(), parameters = table.parameters.size();
  const auto fixed = read_at<StressAnswer>(payload, 0);
  payload = payload.subspan(sizeof fixed);
  const StressBase& before = latest_ ? *latest_ : table.base;
  auto base = std::make_shared<StressBase>();
  base->displacement_m = take_array<double>(payload, parameters);
  base->von_mises.stress = take_array<float>(payload, elements);
  base->max_shear.stress = take_array<float>(payload, elements);
  const bool makes_sense = (fixed.method == static_cast<std::uint32_t>(ServeMethod::pcg) ||
                            fixed.method == static_cast<std::uint32_t>(ServeMethod::refactor)) &&
                           fixed.seconds >= 0 && fixed.seconds < 1e6 && fixed.iterations < 100000 &&
                           std::all_of(base->displacement_m.begin(), base->displacement_m.end(),
                                       [](double x) { return std::isfinite(x); });
  if (!makes_sense)
    return lose("the solver's answer holds numbers that cannot be (method " +
                std::to_string(fixed.method) + ", " + std::to_string(fixed.iterations) +
                " iterations, " + number_text(fixed.seconds) + " s), and it was ended");
  if (state_ == State::kChecking) {
    if (!is_tables_own(*base))
      return lose("the solver finds another stress at the table's own shape than the table holds: "
                  "expected the file that part_stress wrote, unchanged");
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
  result.old_sensitivities = !sensitivities_;
  result.base = base;
  latest_ = std::move(base);
  result_ = std::move(result);
}

} // namespace tactus::stress
