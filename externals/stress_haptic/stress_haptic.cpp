#include "externals/stress_haptic/stress_haptic.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactus::stress {

StressHaptic::StressHaptic(StressJob::SolverFactory solvers) : worker_(std::move(solvers)) {}

StressHaptic::StressHaptic()
    : StressHaptic([](SolverOptions options) -> std::unique_ptr<Reanalysis> {
        if (!options.table.has_mesh)
          return nullptr;
        return std::make_unique<PartSolver>(std::move(options));
      }) {}

void StressHaptic::set_power(double q) noexcept {
  const auto whole = static_cast<unsigned>(std::lround(q));
  if (whole == request_.settings.power)
    return;
  request_.settings.power = whole;
  settings_changed();
}

void StressHaptic::settings_changed() {
  if (host_)
    submit(*host_);
}

void StressHaptic::state_changed() {
  if (host_)
    warn_about_state(*host_);
  settings_changed();
}

void StressHaptic::weights_changed() {
  if (host_)
    warn_about_weights(*host_);
  settings_changed();
}

void StressHaptic::resolve_changed() {
  if (host_)
    warn_about_resolve(*host_);
  settings_changed();
}

void StressHaptic::warn_about_state(Host& host) const {
  if (table_ && request_.settings.state == State::kShear && !table_->has_shear())
    host.error("state shear: the table has no arrays shear0 and S_shear; "
               "using vonmises");
}

void StressHaptic::warn_about_weights(Host& host) const {
  if (table_ && request_.settings.weights == Weights::kVolume && table_->weight.empty())
    host.error("weights volume: the table has no array weights; using uniform");
}

void StressHaptic::warn_about_resolve(Host& host) const {
  const Resolve resolve = request_.resolve;
  if (table_ && !can_solve_ && (resolve == Resolve::kPcg || resolve == Resolve::kFull))
    host.error("resolve " + std::string(Rows::resolves[static_cast<std::size_t>(resolve)]) +
               ": the table has no mesh to solve: expected a table of part_stress, or resolve "
               "auto or taylor; using the Taylor series");
}

void StressHaptic::created(Host& host) {
  host_ = &host;
  threaded_ = host.real_time();
  request_.wait = !threaded_;
  worker_.on_ready([this] { host_->wake_from_thread(); });
  if (!first_name_.empty())
    load(Atom(std::string_view(first_name_)), host);
}

void StressHaptic::load(const Atom& name, Host& host) {
  if (!name.is_word)
    return host.error(sentence_of("load", std::span(&name, 1)) + ": expected the name of a file");
  if (!host_) {
    first_name_ = name.word;
    return;
  }
  std::string path = host.find_file(name.word);
  if (path.empty())
    path = host.find_file(std::string(name.word) + ".stress.npz");
  if (path.empty())
    return host.error("load " + std::string(name.word) +
                      ": file not found beside the patch or in the search path");
  request_.path = path;
  request_.name = name.word;
  ++request_.load;
  request(host);
}

void StressHaptic::set_solver(const Atom& program, Host& host) {
  if (!program.is_word)
    return host.error(sentence_of("solver", std::span(&program, 1)) +
                      ": expected the path of part_stress, or auto");
  std::string path;
  if (program.word != "auto") {
    path = host.find_file(program.word);
    if (path.empty() || find_part_stress(path).empty())
      return host.error("solver " + std::string(program.word) +
                        ": no executable file found beside the patch or in the search path: "
                        "expected the path of part_stress");
  }
  request_.program = path;
  ++request_.set_solver;
  submit(host);
}

void StressHaptic::take_table(const StressJob::Answer& answer, Host& host) {
  table_ = answer.table;
  can_solve_ = answer.can_solve;
  request_.table = answer.load;
  request_.control_point = -1;
  request_.picture = 0;
  sent_faces_.clear();
  request_.displacement_m.assign(table_->parameters.size(), 0);
  host.info({"loaded", std::string_view(table_->name.empty() ? "part" : table_->name),
             static_cast<double>(table_->elements()),
             static_cast<double>(table_->parameters.size()),
             static_cast<double>(table_->control_point_m.size())});
  warn_about_state(host);
  warn_about_weights(host);
  warn_about_resolve(host);
  submit(host);
  if (std::exchange(draw_when_loaded_, false))
    draw({}, host);
}

void StressHaptic::submit(Host& host) {
  if (table_)
    request(host);
}

void StressHaptic::request(Host& host) {
  if (threaded_) {
    const std::string reason = worker_.request(request_);
    if (reason.empty())
      return;
    threaded_ = false;
    host.error("cannot start a thread for the stress (" + reason +
               "); it is computed in the host's thread, which may interrupt the audio");
  } else {
    worker_.request_here(request_);
  }
  worker_.step(1e-3 * host.now_ms());
  collect(host);
}

/// Takes new tables, results and errors from the worker.
void StressHaptic::collect(Host& host) {
  const auto taken = worker_.take();
  if (taken.answer && taken.answer->load != request_.table)
    take_table(*taken.answer, host);
  for (const std::string& sentence : taken.sentences)
    host.error(sentence);
  const double now_s = 1e-3 * host.now_ms();
  if (taken.answer && taken.answer->result.table == request_.table) {
    const SessionResult& fresh = taken.answer->result;
    const bool base_changed =
        fresh.base_changes != result_.base_changes || fresh.table != result_.table;
    result_.update_s = fresh.update_s; // a measured time, excluded from comparison
    const bool changed = !(result_ == fresh);
    result_ = fresh;
    if (base_changed)
      gamma_.fade(result_.feedback.gamma, now_s, kFade_s);
    else if (!(result_.feedback.gamma == gamma_.target()))
      gamma_.go(result_.feedback.gamma, now_s);
    info_due_ = info_due_ || changed;
  }
  if (result_.table == request_.table && result_.picture_number > sent_picture_)
    send_picture(host);
  send(host, false);
  schedule(host);
}

RenderGains StressHaptic::gains_in_force() const noexcept {
  RenderGains gains = gains_;
  for (double* k : {&gains.stiffness_min_n_per_m, &gains.stiffness_max_n_per_m})
    *k = std::min(*k, stiffness_limit());
  for (double* b : {&gains.damping_min_n_s_per_m, &gains.damping_max_n_s_per_m})
    *b = std::min(*b, device_.damping_n_s_per_m);
  return gains;
}

Vec3 StressHaptic::force(double now_s) noexcept {
  const Feel feel = device_.feel;
  if (!table_ || !has_position_ || feel == Feel::kOff)
    return {};
  const Vec3 gamma = gamma_.at(now_s);
  const RenderGains gains = gains_in_force();
  Vec3 force_n;
  if (feel == Feel::kSpring || feel == Feel::kBoth)
    force_n += spring_force(gains, gamma, position_m_ - anchor_.at(now_s));
  if (feel == Feel::kDamper || feel == Feel::kBoth)
    force_n += damper_force(gains, gamma, velocity_m_per_s_);
  return force_n;
}

} // namespace tactus::stress
