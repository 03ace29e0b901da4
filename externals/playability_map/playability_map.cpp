#include "externals/playability_map/playability_map.hpp"

#include "core/reed/instrument/tuning.hpp"
#include "core/reed/playability/gradient_plane.hpp"
#include "core/reed/playability/linear_stability.hpp"
#include "core/reed/playability/playability_map.hpp"
#include "core/refusal.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace tactus::reed {
namespace {

constexpr double kBatch = 50; // ms between batches of cells
constexpr std::size_t kCellsPerBatch = 400;
constexpr unsigned kStepsPerBatch = 10; // portions computed in the host's own time
constexpr double kGrowthScale = 50;     // 1/s, a in the colour's x = (1 + g/(|g| + a))/2

struct Colour {
  double r, g, b;
};

/// Colour map from dark blue over green to yellow, perceptually uniform (viridis); x in [0, 1].
Colour colour(double x) {
  constexpr std::array<Colour, 5> kStops{
      {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
  const double at = (x > 0 ? std::min(x, 1.0) : 0.0) * (kStops.size() - 1);
  const auto stop = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double fraction = at - static_cast<double>(stop);
  const Colour &a = kStops[stop], &b = kStops[stop + 1];
  return {std::round(a.r + fraction * (b.r - a.r)), std::round(a.g + fraction * (b.g - a.g)),
          std::round(a.b + fraction * (b.b - a.b))};
}

/// The length that gives an instrument with these parameters this bore frequency.
double length_of(const Parameters& parameters, double bore_frequency) {
  const auto reeds = make_reed_ensemble(simd::Baseline{});
  reeds->set(parameters);
  reeds->prepare(48000);
  reeds->process({}, {}, bore_frequency, 1, {});
  return reeds->length();
}

} // namespace

PlayabilityMapObject::PlayabilityMapObject() { range_ = range_for(parameters_); }

std::string PlayabilityMapObject::key() const {
  std::string text;
  const auto add = [&text](double value) {
    char number[32];
    std::snprintf(number, sizeof number, "%.17g ", value);
    text += number;
  };
  for (const Row& row : kRows)
    add(row.get(&parameters_));
  for (const double value :
       {parameters_.length, parameters_.reed_frequency, range_.lowest_pressure,
        range_.highest_pressure, range_.lowest_frequency, range_.highest_frequency})
    add(value);
  for (const Parameter& row : Rows::own)
    add(row.get(this));
  return text;
}

MapWorker::Portion PlayabilityMapObject::portion() const {
  if (growth_) {
    const PlayingSetup playing =
        embouchure_for(clamped(parameters_), settings_.bore_frequency_hz,
                       length_of(parameters_, settings_.bore_frequency_hz));
    const LinearStability theory(playing.valve, playing.length, playing.fingering.end);
    const double scale = playing.reed_scale;
    const ControlRange range = range_;
    const std::size_t columns = columns_, rows = rows_;
    return [=](std::vector<double>& nodes, std::size_t first) {
      const std::size_t end = std::min(first + 8, nodes.size());
      for (std::size_t n = first; n < end; ++n) {
        const std::size_t column = n % columns, row = n / columns;
        const double y = static_cast<double>(column) / static_cast<double>(columns - 1);
        const double z = static_cast<double>(row) / static_cast<double>(rows - 1);
        nodes[n] = theory.dominant_mode(range.pressure(y), scale * range.frequency(z)).growth_rate;
      }
      return end;
    };
  }
  PlayabilityMapSettings settings;
  settings.parameters = parameters_;
  settings.bore_frequency = settings_.bore_frequency_hz;
  settings.range = range_;
  settings.sample_rate = settings_.rate_hz;
  settings.settle_s = 1e-3 * settings_.settle_ms;
  settings.listen_s = 1e-3 * settings_.listen_ms;
  auto map = std::make_shared<PlayabilityMap>();
  map->begin(settings, columns_, rows_);
  return [map](std::vector<double>& nodes, std::size_t first) {
    const std::size_t end = map->advance(first);
    const std::size_t columns = map->field().columns();
    for (std::size_t n = first; n < end; ++n)
      nodes[n] = map->field().node(n % columns, n / columns);
    return end;
  };
}

void PlayabilityMapObject::compute(Host& host) {
  columns_ = static_cast<std::size_t>(settings_.columns);
  rows_ = static_cast<std::size_t>(settings_.rows);
  growth_ = settings_.growth;
  total_ = columns_ * rows_;
  working_key_ = key();
  computing_ = true;
  if (const auto* stored = store_.find(working_key_)) {
    worker_.start_stepped(total_, [stored = *stored](std::vector<double>& nodes, std::size_t) {
      nodes = stored;
      return nodes.size();
    });
  } else if (settings_.background && host.real_time()) {
    if (const std::string error_text = worker_.start(total_, portion()); !error_text.empty())
      host.error("compute: " + error_text);
  } else {
    worker_.start_stepped(total_, portion());
  }
  draw(host);
}

void PlayabilityMapObject::cancel(Host& host) {
  worker_.cancel();
  if (computing_)
    total_ = 0; // an unfinished map has nothing left to draw
  computing_ = drawing_ = false;
  host.wake_in(0, -1);
}

/// Stores the finished map and uses it for look-ups.
void PlayabilityMapObject::finish(std::span<const double> nodes) {
  field_.resize(columns_, rows_);
  for (std::size_t n = 0; n < nodes.size(); ++n)
    field_.node(n % columns_, n / columns_) = nodes[n];
  field_.differentiate();
  store_.put(working_key_, {nodes.begin(), nodes.end()});
}

void PlayabilityMapObject::draw(Host& host) {
  if (total_ == 0)
    return host.error("draw: no map is computed: send compute first");
  sent_ = 0;
  drawing_ = true;
  host.send(2, {"cells", static_cast<double>(columns_), static_cast<double>(rows_)});
  host.wake_in(0, 0);
}

void PlayabilityMapObject::send_cells(Host& host, std::size_t to) {
  for (; sent_ < to; ++sent_) {
    const double value = worker_.node(sent_);
    const Colour c = colour(growth_ ? 0.5 + 0.5 * value / (std::abs(value) + kGrowthScale) : value);
    const std::size_t column = sent_ % columns_, row = sent_ / columns_;
    host.send(
        2, {"cell", static_cast<double>(column), static_cast<double>(row), value, c.r, c.g, c.b});
  }
}

/// Timer: computes a portion if there is no thread, and sends new cells twenty times a second.
void PlayabilityMapObject::tick(std::size_t, Host& host) {
  if (!drawing_)
    return;
  const bool steps = computing_ && worker_.is_stepped();
  if (steps)
    worker_.step();
  if (const std::string error_text = worker_.take_error(); !error_text.empty()) {
    host.error("compute: " + error_text);
    return cancel(host);
  }
  const std::size_t done = worker_.done();
  const bool finished = computing_ && done == total_;
  if (steps && !finished && ++step_ % kStepsPerBatch != 0)
    return host.wake_in(0, kBatch / kStepsPerBatch);
  if (finished) {
    computing_ = false;
    std::vector<double> nodes(total_);
    for (std::size_t n = 0; n < total_; ++n)
      nodes[n] = worker_.node(n);
    finish(nodes);
  }
  if (finished || computing_)
    host.send(3, {static_cast<double>(done) / static_cast<double>(total_)});
  send_cells(host, std::min(done, sent_ + kCellsPerBatch));
  drawing_ = computing_ || sent_ < total_;
  if (drawing_)
    host.wake_in(0, computing_ && steps ? kBatch / kStepsPerBatch : kBatch);
}

void PlayabilityMapObject::take_preset(const Atom& name, Host& host) {
  if (const auto preset = greed::preset_of(name, parameters_, host)) {
    parameters_ = *preset;
    range_ = range_for(parameters_);
  }
}

void PlayabilityMapObject::take_range(std::span<const Atom> words, Host& host) {
  if (const auto range = greed::range_of(words, host))
    range_ = *range;
}

void PlayabilityMapObject::write(std::span<const Atom> words, Host& host) {
  if (!words[0].is_word)
    return host.error(refusal("write", words, "the name of a file"));
  if (const std::string problem = store_.write(host.new_file(words[0].word)); !problem.empty())
    host.error(problem);
}

void PlayabilityMapObject::read(std::span<const Atom> words, Host& host) {
  if (!words[0].is_word)
    return host.error(refusal("read", words, "the name of a file"));
  const std::string path = host.find_file(words[0].word);
  if (path.empty())
    return host.error("read " + std::string(words[0].word) +
                      ": file not found beside the patch or in the search path");
  if (const std::string problem = store_.read(path); !problem.empty())
    host.error(problem);
}

void PlayabilityMapObject::scalar(std::size_t inlet, double value, Host& host) {
  if (inlet == 1) {
    z_ = value;
    return;
  }
  const Gradient slope = field_.gradient(value, z_);
  host.send(1, {slope.y, slope.z});
  host.send(0, {field_.value(value, z_)});
}

void PlayabilityMapObject::dump_first(Host& host) { greed::dump_preset(parameters_, host); }

void PlayabilityMapObject::dump(Host& host) {
  host.info({"range", range_.lowest_pressure, range_.highest_pressure, range_.lowest_frequency,
             range_.highest_frequency});
  host.info({"maps", static_cast<double>(store_.size())});
}

} // namespace tactus::reed
