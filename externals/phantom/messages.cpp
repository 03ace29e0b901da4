#include "externals/phantom/numbers.hpp"
#include "externals/phantom/path_message.hpp"
#include "externals/phantom/phantom.hpp"

#include <cmath>

/// What each message of [phantom] does. A refused message changes nothing and costs one sentence.
namespace tactus {

using namespace phantom;
using haptic::Vec3;

namespace {

constexpr std::array<std::string_view, 7> kTags{"mm",     "vel",    "force", "button",
                                                "status", "jitter", "error"};

Vec3 metres(const double* mm) { return Vec3{mm[0], mm[1], mm[2]} * 1e-3; }

} // namespace

void Phantom::on_list(Words words, Host& host) {
  for (const Atom& atom : words)
    if (atom.is_word)
      return host.error(expected("list", atom, "three numbers, fx fy fz"));
  for (std::size_t inlet = 3; inlet-- > 0;)
    scalar(inlet, words[inlet].number, host);
}

void Phantom::on_backend(Words words, Host& host) {
  if (!is(words[0], "sim"))
    return host.error(expected("backend", words[0], "sim, the only driver in this build"));
  if (words.size() > 1)
    return host.error("backend sim: takes no arguments");
  if (created_ && !open_)
    open(host);
}

void Phantom::on_clock(Words words, Host& host) {
  if (is(words[0], "auto") || is(words[0], "logical"))
    wall_ = false;
  else if (is(words[0], "wall"))
    wall_ = true;
  else
    return host.error(expected("clock", words[0], "auto, logical or wall"));
  restart(host);
}

void Phantom::on_workspace(Words words, Host& host) {
  haptic::Workspace& workspace = settings_.chain.workspace;
  if (words.size() == 1 && is(words[0], "device")) {
    const haptic::Caps caps = simulated_.caps();
    workspace = {caps.workspace_min, caps.workspace_max};
    learning_ = false;
  } else if (words.size() == 2 && is(words[0], "learn") && !words[1].is_word) {
    const bool begin = words[1].number != 0;
    if (begin && has_report_ && !learning_) {
      const Vec3 here = servo_.exchange().reports.latest().state.position;
      workspace = {here, here};
    }
    if (learning_ && !begin)
      send_workspace(host);
    learning_ = begin;
  } else if (words.size() == 6) {
    constexpr Range ranges[] = {millimetres("xmin"), millimetres("ymin"), millimetres("zmin"),
                                millimetres("xmax"), millimetres("ymax"), millimetres("zmax")};
    double mm[6];
    const std::string refusal = read_numbers(words, ranges, mm);
    if (!refusal.empty())
      return host.error("workspace: " + refusal);
    const haptic::Workspace wanted{metres(mm), metres(mm + 3)};
    if (!wanted.valid())
      return host.error("workspace: each minimum must not exceed its maximum");
    workspace = wanted;
    learning_ = false;
  } else {
    return host.error(
        "workspace: expected device, learn 0|1 or xmin ymin zmin xmax ymax zmax in mm");
  }
  settle();
}

void Phantom::send_workspace(Host& host) const {
  const Vec3 low = settings_.chain.workspace.min * 1e3, high = settings_.chain.workspace.max * 1e3;
  host.info({"workspace", low.x, low.y, low.z, high.x, high.y, high.z});
}

void Phantom::on_map(Words words, Host& host) {
  std::array<double, 3> signs{1, 1, 1};
  for (std::size_t i = 1; i < words.size() && i < 4; ++i)
    signs[i - 1] = words[i].number;
  const auto map = words[0].is_word && (words.size() == 1 || words.size() == 4)
                       ? haptic::AxisMap::parse(words[0].word, signs)
                       : std::nullopt;
  if (!map)
    return host.error("map: expected the letters xyz in some order and three signs 1 or -1");
  settings_.map = *map;
  settle();
}

void Phantom::on_interp(Words words, Host& host) {
  using Interpolation = haptic::ChainSettings::Interpolation;
  auto& chain = settings_.chain;
  if (is(words[0], "auto")) {
    chain.interpolation = Interpolation::kAuto;
  } else if (is(words[0], "off")) {
    chain.interpolation = Interpolation::kOff;
  } else if (!words[0].is_word && words[0].number >= 0.25 && words[0].number <= 1000) {
    chain.interpolation = Interpolation::kFixed;
    chain.interpolation_s = words[0].number * 1e-3;
  } else {
    return host.error(expected("interp", words[0], "auto, off or 0.25..1000 ms"));
  }
  settle();
}

void Phantom::on_watchdog(Words words, Host& host) {
  constexpr Range ranges[] = {{"hold", "ms", 1, 10000}, {"ramp", "ms", 1, 10000}};
  double ms[2];
  const std::string refusal = read_numbers(words, ranges, ms);
  if (!refusal.empty())
    return host.error("watchdog: " + refusal);
  settings_.chain.hold_s = ms[0] * 1e-3;
  settings_.chain.ramp_s = ms[1] * 1e-3;
  settle();
}

void Phantom::on_report(Words words, Host& host) {
  for (std::size_t i = 0; i < kTags.size(); ++i)
    if (is(words[0], kTags[i])) {
      if (words[1].is_word)
        return host.error(expected("report", words[1], "0 or 1"));
      reported_[i] = words[1].number != 0;
      return;
    }
  host.error(expected("report", words[0], "mm, vel, force, button, status, jitter or error"));
}

void Phantom::on_stats(Words words, Host& host) {
  if (!words.empty() && !is(words[0], "reset"))
    return host.error(expected("stats", words[0], "reset"));
  if (!words.empty()) {
    servo_.exchange().actions.push(haptic::Action::kResetStatistics);
    return;
  }
  collect(host);
  const haptic::ServoStatistics s = statistics();
  const haptic::Report& r = servo_.exchange().reports.latest();
  const auto line = [&host](std::string_view name, double value) {
    host.info({"stats", name, value});
  };
  const auto count = [&line](std::string_view name, std::uint64_t value) {
    line(name, static_cast<double>(value));
  };
  count("ticks", s.ticks);
  count("overruns", s.overruns);
  count("skipped", s.skipped);
  line("late_mean_ms", s.lateness.mean_s() * 1e3);
  line("late_p50_ms", s.lateness.quantile_s(0.5) * 1e3);
  line("late_p99_ms", s.lateness.quantile_s(0.99) * 1e3);
  line("late_max_ms", s.lateness.longest_s() * 1e3);
  line("work_mean_ms", s.work.mean_s() * 1e3);
  line("work_max_ms", s.work.longest_s() * 1e3);
  count("device_errors", s.device_errors);
  count("watchdog_trips", r.counters.watchdog_trips);
  count("clamped", r.counters.clamped);
  count("slewed", r.counters.slewed);
  count("braked", r.counters.braked);
  count("refused", r.counters.refused);
  count("events_lost", servo_.exchange().events.dropped());
  count("trace_lost", servo_.exchange().trace.dropped());
  line("energy_j", r.energy_j);
  line("lowest_energy_j", r.lowest_energy_j);
}

void Phantom::on_trace(Words words, Host& host) {
  if (!words[0].is_word)
    return host.error(expected("trace", words[0], "a file name or stop"));
  drain_trace();
  servo_.exchange().tracing = false;
  const std::string rest = trace_.close();
  if (!rest.empty())
    host.error("trace: " + rest);
  if (is(words[0], "stop"))
    return;
  const std::string path = host.new_file(words[0].word);
  const std::string refusal = trace_.open(path);
  if (!refusal.empty())
    return host.error("trace " + std::string(words[0].word) + ": cannot be written, " + refusal);
  servo_.exchange().tracing = true;
}

void Phantom::on_hand(Words words, Host& host) {
  using Hold = haptic::HandSettings::Hold;
  haptic::HandSettings hand = simulation_.hand;
  if (is(words[0], "free"))
    hand.hold = Hold::kFree;
  else if (is(words[0], "rigid"))
    hand.hold = Hold::kRigid;
  else if (is(words[0], "spring"))
    hand.hold = Hold::kSpring;
  else if (is(words[0], "person"))
    hand.hold = Hold::kPerson;
  else
    return host.error(expected("hand", words[0], "free, rigid, spring or person"));

  constexpr Range ranges[] = {{"K", "N/m", 0, 20000},
                              {"B", "N s/m", 0, 1000},
                              {"tremor", "mm", 0, 10},
                              {"wander", "mm", 0, 50},
                              {"yield", "ms", 0, 60000}};
  const std::size_t given = words.size() - 1;
  const bool person = hand.hold == Hold::kPerson, spring = hand.hold == Hold::kSpring;
  if (given != 0 && !(spring && given == 2) && !(person && (given == 2 || given == 5)))
    return host.error("hand " + std::string(words[0].word) +
                      (spring   ? ": expected K B"
                       : person ? ": expected K B or K B tremor wander yield"
                                : ": takes no numbers"));
  double values[5] = {};
  const std::string refusal = read_numbers(words.subspan(1), std::span(ranges, given), values);
  if (!refusal.empty())
    return host.error("hand: " + refusal);
  if (given >= 2) {
    hand.stiffness_n_per_m = values[0];
    hand.damping_n_s_per_m = values[1];
  }
  if (given == 5) {
    hand.tremor_m = values[2] * 1e-3;
    hand.wander_m = values[3] * 1e-3;
    hand.yield_s = values[4] * 1e-3;
  }
  simulation_.hand = hand;
  settle_device();
}

void Phantom::on_path(Words words, Host& host) {
  PathChoice choice = choose_path(words, host);
  if (!choice.refusal.empty())
    return host.error(choice.refusal);
  path_name_ = words[0].word;
  with_device([this, &choice] { simulated_.follow(std::move(choice.path)); });
}

void Phantom::on_target(Words words, Host& host) {
  constexpr Range ranges[] = {millimetres("x"), millimetres("y"), millimetres("z")};
  double mm[3];
  const std::string refusal = read_numbers(words, ranges, mm);
  if (!refusal.empty())
    return host.error("target: " + refusal);
  path_name_ = "target";
  with_device([this, &mm] { simulated_.reach_for(metres(mm)); });
}

void Phantom::on_seek(Words words, Host& host) {
  constexpr Range ranges[] = {{"time", "ms", -1e9, 1e9}};
  double ms = 0;
  const std::string refusal = read_numbers(words, ranges, &ms);
  if (!refusal.empty())
    return host.error("seek: " + refusal);
  with_device([this, ms] { simulated_.seek(ms * 1e-3); });
}

void Phantom::on_button(Words words, Host& host) {
  constexpr Range ranges[] = {{"number", "", 0, 31}, {"state", "", 0, 1}};
  double values[2];
  const std::string refusal = read_numbers(words, ranges, values);
  if (!refusal.empty())
    return host.error("button: " + refusal);
  with_device([this, &values] { simulated_.press(static_cast<int>(values[0]), values[1] != 0); });
}

void Phantom::dump(Host& host) {
  using Interpolation = haptic::ChainSettings::Interpolation;
  using Hold = haptic::HandSettings::Hold;
  const auto& chain = settings_.chain;
  host.info({"backend", "sim"});
  host.info({"name", std::string_view(name_)});
  host.info({"clock", wall_ ? "wall" : "logical"});
  send_workspace(host);
  std::string axes;
  for (const int source : settings_.map.source)
    axes += static_cast<char>('x' + source);
  const auto& sign = settings_.map.sign;
  host.info({"map", std::string_view(axes), sign[0], sign[1], sign[2]});
  if (chain.interpolation == Interpolation::kFixed)
    host.info({"interp", chain.interpolation_s * 1e3});
  else
    host.info({"interp", chain.interpolation == Interpolation::kAuto ? "auto" : "off"});
  host.info({"watchdog", chain.hold_s * 1e3, chain.ramp_s * 1e3});
  host.info({"path", std::string_view(path_name_)});
  const auto& hand = simulation_.hand;
  switch (hand.hold) {
  case Hold::kFree:
    host.info({"hand", "free"});
    break;
  case Hold::kRigid:
    host.info({"hand", "rigid"});
    break;
  case Hold::kSpring:
    host.info({"hand", "spring", hand.stiffness_n_per_m, hand.damping_n_s_per_m});
    break;
  case Hold::kPerson:
    host.info({"hand", "person", hand.stiffness_n_per_m, hand.damping_n_s_per_m,
               hand.tremor_m * 1e3, hand.wander_m * 1e3, hand.yield_s * 1e3});
    break;
  }
}

} // namespace tactus
