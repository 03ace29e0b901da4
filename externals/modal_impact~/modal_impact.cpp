#include "externals/modal_impact~/modal_impact~.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace tactus::modal {

using namespace modal_impact;

namespace {

/// Upper limit of modes x triangles x listeners for a model that is built at once (within 1 ms).
constexpr std::size_t kMaxInlineWork = 5000;
constexpr double kNepersIn60dB = 6.907755278982137;

} // namespace

ModalImpact::ModalImpact() {
  body_.prepare(sample_rate_);
  update_options();
}

void ModalImpact::prepare(double sample_rate, std::size_t) {
  const bool changed = sample_rate != sample_rate_;
  sample_rate_ = sample_rate;
  body_.prepare(sample_rate);
  if (!changed || !table_)
    return;
  // A model belongs to one sample rate: the new one must be ready before the next block.
  body_.publish(std::make_unique<BodyModel>(table_, settings()), true);
  body_.adopt();
  model_request_ = 0;
}

void ModalImpact::begin_block(double start_ms) noexcept {
  if (!std::isfinite(start_ms))
    return body_.begin_block(std::numeric_limits<std::int64_t>::max() / 2); // everything is due
  const std::int64_t sample = std::llround(1e-3 * start_ms * sample_rate_);
  // Rounding must not open a gap of one sample between consecutive blocks.
  if (std::abs(sample - body_.clock()) > 1)
    body_.begin_block(sample);
}

std::int64_t ModalImpact::sample_now(const Host& host) const {
  return std::llround(1e-3 * host.now_ms() * sample_rate_);
}

BodySettings ModalImpact::settings() const {
  BodySettings now = settings_;
  now.sample_rate = sample_rate_;
  now.max_modes = static_cast<std::size_t>(max_modes_);
  now.voices = static_cast<std::size_t>(voices_);
  now.listeners = static_cast<std::size_t>(listeners_);
  return now;
}

void ModalImpact::update_options() noexcept {
  options_.soft_limit =
      limit_ == Limit::kOn || (limit_ == Limit::kAuto && options_.gain < kMeasuringGain);
  body_.set_options(options_);
  Striker striker = body_.striker();
  striker.restitution = restitution_;
  body_.set_striker(striker);
}

void ModalImpact::set_radiation(Radiation wanted) {
  if (wanted == settings_.radiation)
    return;
  if (const std::string refusal =
          table_ ? TableJob::radiation_refusal(*table_, wanted, settings_.radiation)
                 : std::string();
      !refusal.empty()) {
    if (host_)
      host_->error(refusal);
    return;
  }
  settings_.radiation = wanted;
  model_changed();
}

void ModalImpact::set_pulses(bool on) noexcept {
  options_.coupled = !on;
  update_options();
}

void ModalImpact::set_seed(unsigned value) noexcept {
  random_.seed(value); // also if the value is the same
  if (options_.seed == value)
    return;
  options_.seed = value;
  update_options();
}

bool ModalImpact::at_once() const {
  return sync_ == Sync::kAtOnce || (host_ && !host_->real_time());
}

void ModalImpact::request(bool at_once, Host& host) {
  wanted_.settings = settings();
  wanted_.shaped_body = in_use_.body.number;
  if (at_once) {
    worker_.request_here(wanted_);
  } else {
    worker_.on_ready([waiting = &host] { waiting->wake_from_thread(); });
    const std::string reason = worker_.request(wanted_);
    if (reason.empty())
      return;
    host.error("cannot start a thread to read tables (" + reason +
               "); they are read in the host's thread, which may interrupt the sound");
  }
  worker_.finish();
  take_tables(&host);
}

void ModalImpact::rebuild_model(bool changes_body) {
  const bool waits = answered_ < worker_.requested(); // the worker also needs the settings for a
                                                      // table that it reads
  if (!table_ && !waits)
    return;
  const BodySettings now = settings();
  const bool here =
      table_ &&
      (at_once() || !host_ ||
       (now.radiation != Radiation::kBody &&
        table_->table.modes() * table_->surface.triangles() * now.listeners <= kMaxInlineWork));
  if (here)
    build_here(now);
  if (!host_ || (here && !waits))
    return;
  const std::uint64_t next = worker_.requested() + 1;
  if (!here)
    model_request_ = next;
  if (changes_body)
    body_change_ = next;
  request(false, *host_);
}

void ModalImpact::build_here(const BodySettings& now) {
  try {
    auto model = std::make_unique<BodyModel>(table_, now);
    model_request_ = 0;
    if (accept_support(*model, true, host_))
      body_.publish(std::move(model), true);
    else
      rebuild_model();
  } catch (const std::exception&) { // bad_alloc, or the length_error of a container
    if (host_)
      host_->error(TableJob::kOutOfMemory);
  }
}

void ModalImpact::take_tables(Host* host) {
  auto taken = worker_.take();
  answered_ = taken.finished;
  if (host)
    for (const std::string& sentence : taken.sentences)
      host->error(sentence);
  if (taken.answer)
    accept(std::move(*taken.answer), host);
}

void ModalImpact::accept(TableJob::Answer answer, Host* host) {
  const TablesInUse before = std::exchange(in_use_, answer.in_use);
  const bool loaded = in_use_.body.number != before.body.number;
  const bool solved = !loaded && in_use_.solved != before.solved;
  const bool same = table_ && (answer.table == table_ || answer.table->follows(*table_));
  if (answer.table == table_ && model_request_ == 0)
    return; // the owner has already built this model itself
  if (answer.table != table_)
    model_request_ = worker_.requested(); // this model may lack the newest request's settings
  if (answered_ >= model_request_)
    model_request_ = 0;
  const bool supported = accept_support(*answer.model, same, host);
  table_ = answer.table;
  if (!missing_arrays(*table_, settings().radiation).empty()) // the missing arrays have been
                                                              // reported
    settings_.radiation = BodySettings().radiation;
  if (loaded) { // the displacements were those of the old body
    settings_.shape_displacement_m.clear();
    warned_of_trust_ = warned_still_ = false;
    wanted_.solved = nullptr;
    reset_solver(host);
  }
  if (!same)
    last_point_.reset();
  const bool stale = answer.model->settings.sample_rate != sample_rate_;
  if (supported)
    body_.publish(std::move(answer.model), same);
  if (solved && host)
    resolved(*host);
  if (loaded && host && !has_cords_)
    host->wake_in(kLoadedTimer, 0); // the patch's connections do not exist yet
  else if (loaded && host)
    post_loaded(*host);
  if (in_use_.board.number != before.board.number && host && !table_->parts.empty()) {
    const ModalTable& board = table_->parts[LoadedTable::kBoard].loaded->table;
    host->info({"board", std::string_view(board.body_name.empty() ? "body" : board.body_name),
                static_cast<double>(board.modes())});
  }
  if (stale || !supported)
    rebuild_model();
}

void ModalImpact::posted(Host& host) {
  host_ = &host;
  take_tables(&host);
  take_solution(host);
  if (waiting_count_ > 0)
    carry_out_waiting(host);
}

void ModalImpact::post_loaded(Host& host) {
  const ModalTable& table = table_->table;
  host.info({"loaded", std::string_view(table.body_name.empty() ? "body" : table.body_name),
             static_cast<double>(table.modes())});
  if (table_->shape.empty())
    host.log("the table has no mode shapes: all modes have the same gain");
}

void ModalImpact::created(Host& host) {
  host_ = &host;
  created_ = true;
  if (!first_name_.empty())
    load(first_name_, at_once(), host);
  has_cords_ = true;
}

const BodyModel* ModalImpact::body(Host& host) {
  body_.adopt();
  if (!body_.model())
    host.error("no body is loaded: send load NAME first");
  return body_.model();
}

void ModalImpact::dump(Host& host) {
  body_.adopt();
  post_info(host);
  post_settings(host);
}

void ModalImpact::post_info(Host& host) {
  host.info({"version", "0.1.0"});
  const BodyModel* model = body_.model();
  if (!model) {
    host.info({"body", loads_first() ? "loading" : "none"});
    return;
  }
  const ModalTable& table = model->loaded->table;
  host.info({"body", std::string_view(table.body_name.empty() ? "unnamed" : table.body_name)});
  host.info(
      {"modes", static_cast<double>(table.modes()), static_cast<double>(model->audible_modes)});
  host.info({"culled", static_cast<double>(body_.culled())});
  host.info({"contacts", static_cast<double>(body_.contacts())});
  host.info({"mass", model->mass_kg});
  if (!model->resting_contacts.empty()) {
    std::vector<Atom> carried{"carried"};
    for (const BodyModel::RestingContact& rest : model->resting_contacts)
      carried.emplace_back(rest.preload_n);
    host.info(carried);
  }
  post_shape(host);
  host.info({"material", model->youngs_modulus_pa, model->density_kg_per_m3, model->poisson});
  if (!model->loaded->surface.empty()) {
    const Vec3 low = model->loaded->surface.lowest(), high = model->loaded->surface.highest();
    const double mm = 1000 * model->settings.size;
    host.info({"box", mm * low.x, mm * low.y, mm * low.z, mm * high.x, mm * high.y, mm * high.z});
  }
  constexpr std::size_t kMaxListed = 128;
  std::vector<std::pair<double, double>> modes;
  for (std::size_t k = 0; k < model->audible_modes; ++k)
    modes.emplace_back(math::abs(model->rate[k]) / (2 * std::numbers::pi),
                       kNepersIn60dB / std::max(-model->rate[k].real(), 1e-9));
  std::sort(modes.begin(), modes.end());
  std::vector<Atom> frequencies{"frequencies"}, times{"t60"};
  for (std::size_t k = 0; k < std::min(modes.size(), kMaxListed); ++k) {
    frequencies.emplace_back(modes[k].first);
    times.emplace_back(std::min(modes[k].second, 1e6));
  }
  host.info(frequencies);
  host.info(times);
}

void ModalImpact::post_ring(Numbers, Host& host) {
  body_.adopt();
  constexpr std::size_t kMaxListed = 64;
  const auto levels = body_.levels(kMaxListed);
  std::vector<Atom> list{"ring"};
  for (const double level : levels)
    list.emplace_back(level);
  host.info(list);
}

} // namespace tactus::modal
