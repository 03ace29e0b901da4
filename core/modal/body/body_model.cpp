#include "core/modal/body/body_model.hpp"

#include "core/dsp/complex.hpp"
#include "core/modal/radiation/combined_arrivals.hpp"
#include "core/modal/table/modal_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace tactus::modal {
namespace {

constexpr double kMaxFrequencyRatio = 0.45; // share of the sample rate: modes above it would alias
constexpr double kNepersIn60dB = 6.907755278982137;
constexpr double kUnknownModulus = 70e9, kUnknownDensity = 2700;

/// A loss curve's value, interpolated linearly in the logarithms of both axes.
double on_curve(const std::vector<std::array<double, 2>>& curve, double frequency) {
  if (curve.empty())
    return 0;
  if (frequency <= curve.front()[0])
    return curve.front()[1];
  for (std::size_t i = 1; i < curve.size(); ++i)
    if (frequency <= curve[i][0]) {
      const double x =
          math::log(frequency / curve[i - 1][0]) / math::log(curve[i][0] / curve[i - 1][0]);
      const double low = std::max(curve[i - 1][1], 1e-12), high = std::max(curve[i][1], 1e-12);
      return low * math::pow(high / low, x);
    }
  return curve.back()[1];
}

/// A-weighting as a factor, 1 at 1 kHz (IEC 61672-1, annex E).
double a_weighting(double frequency) {
  const double f = frequency * frequency;
  const double poles = (f + 20.6 * 20.6) * std::sqrt((f + 107.7 * 107.7) * (f + 737.9 * 737.9)) *
                       (f + 12194.0 * 12194.0);
  return 1.2589 * 12194.0 * 12194.0 * f * f / poles;
}

} // namespace

std::string_view missing_arrays(const LoadedTable& loaded, Radiation radiation) noexcept {
  const auto has_multipoles = [](const LoadedTable& one) { return !one.table.multipoles.empty(); };
  if (radiation == Radiation::kRaw && loaded.table.raw.empty())
    return "raw_v, raw_xyz, raw_ds, raw_hit and raw_fs";
  if (radiation == Radiation::kBody && !has_multipoles(loaded) &&
      std::none_of(loaded.parts.begin(), loaded.parts.end(),
                   [&](const LoadedTable::Part& part) { return has_multipoles(*part.loaded); }))
    return "mp_coef, mp_lmax, mp_off, mp_center and mp_rref (modal_fem --radiation body)";
  return {};
}

BodyModel::BodyModel(std::shared_ptr<const LoadedTable> from, const BodySettings& with)
    : loaded(std::move(from)), settings(with), bank({}, with.sample_rate, 0, 0),
      solver({}, with.sample_rate, 0, false) {
  const ModalTable& table = loaded->table;
  const Material& own = table.material;
  const auto first = [](double a, double b, double c) { return a > 0 ? a : b > 0 ? b : c; };
  youngs_modulus_pa = first(settings.youngs_modulus_pa, own.youngs_modulus_pa, kUnknownModulus);
  density_kg_per_m3 = first(settings.density_kg_per_m3, own.density_kg_per_m3, kUnknownDensity);
  poisson = settings.poisson >= 0 ? settings.poisson : own.poisson;
  const double volume = settings.size * settings.size * settings.size;
  const double mass_ratio =
      density_kg_per_m3 / first(own.density_kg_per_m3, kUnknownDensity, kUnknownDensity);
  shape_scale = 1 / std::sqrt(mass_ratio * volume);
  mass_kg = table.mass_kg * mass_ratio * volume;
  board_shape_scale_ = 1 / std::sqrt(volume);
  compute_rates();
  find_resting_contacts();
  const std::span<const Complex> all(rate);
  bank = ModeBank(all.first(audible_modes), settings.sample_rate, 1 + settings.voices,
                  settings.listeners, settings.vector_set);
  solver =
      ContactSolver(all, settings.sample_rate, resting_slot() + resting_contacts.size(),
                    table.free && table.mass_kg > 0, 3 * settings.listeners, settings.vector_set);
  compute_weights();
  for (std::size_t k = 0; k < audible_modes; ++k)
    loudness.push_back(a_weight[k] * loudest_weight(k));
  for (std::size_t l = 0; l < kMaxListeners; ++l) {
    bank.jump_to_weight(l, weight[l]);
  }
  for (auto& part : scratch_weight_)
    part.assign(audible_modes, 0);
  refresh_listener_weights();
}

void BodyModel::refresh_listener_weights() noexcept {
  if (weights_version_ == bank.glide_version())
    return;
  weights_version_ = bank.glide_version();
  listener_part_count = 0;
  const auto add = [&](std::size_t listener, ModeBank::Part part) {
    auto& weights = scratch_weight_[0];
    for (std::size_t k = 0; k < audible_modes; ++k)
      weights[k] = bank.weight(listener, part, k);
    solver.set_weight(listener_part_count, weights);
    listener_parts[listener_part_count++] = {listener, part};
  };
  for (std::size_t l = 0; l < settings.listeners; ++l) {
    const Glide& glide = bank.glide(l);
    if (glide.moving())
      add(l, ModeBank::kMiddle);
    if (glide.moving() && glide.has_old())
      add(l, ModeBank::kOld);
    if (!glide.moving() || glide.has_latest())
      add(l, ModeBank::kLatest);
  }
  solver.set_listening(listener_part_count);
}

double BodyModel::loudest_weight(std::size_t k) const noexcept {
  double maximum = 0;
  for (std::size_t l = 0; l < settings.listeners; ++l)
    maximum = std::max(maximum, math::abs(weight[l][k]));
  return maximum;
}

double BodyModel::decay_rate(std::size_t k, double omega) const {
  const ModalTable& table = loaded->table;
  const double before = 2 * std::numbers::pi * table.frequency_hz[k];
  double rate_per_s = 0;
  const bool of_board = loaded->is_board_mode(k);
  switch (of_board ? Damping::kTable : settings.damping) {
  case Damping::kRayleigh:
    rate_per_s = 0.5 * (settings.rayleigh_a_per_s + settings.rayleigh_b_s * omega * omega);
    break;
  case Damping::kLoss:
    rate_per_s = 0.5 * omega * settings.loss_factor;
    break;
  case Damping::kCurve:
    rate_per_s = 0.5 * omega * on_curve(settings.loss_curve, omega / (2 * std::numbers::pi));
    break;
  case Damping::kTable:
    rate_per_s = table.decay_rate.empty() ? 0.5 * omega * table.loss_factor[k]
                                          : table.decay_rate[k] * omega / before;
    break;
  }
  const double scale = shape_scale_of(of_board ? LoadedTable::kBoard : 0);
  if (!table.radiation_decay_rate.empty()) // ~ area times shape squared, at the same k a
    rate_per_s += table.radiation_decay_rate[k] * scale * scale * settings.size * settings.size;
  if (settings.choke_t60_s > 0 && !of_board)
    rate_per_s += kNepersIn60dB / settings.choke_t60_s;
  return rate_per_s;
}

void BodyModel::compute_rates() {
  const ModalTable& table = loaded->table;
  const Material& own = table.material;
  const double modulus = own.youngs_modulus_pa > 0 ? own.youngs_modulus_pa : kUnknownModulus;
  const double density = own.density_kg_per_m3 > 0 ? own.density_kg_per_m3 : kUnknownDensity;
  const double frequency_ratio =
      std::sqrt(youngs_modulus_pa / modulus / (density_kg_per_m3 / density)) / settings.size;
  const double highest = kMaxFrequencyRatio * settings.sample_rate;
  const std::size_t maximum = settings.max_modes > 0
                                  ? with_whole_groups(table.frequency_hz, settings.max_modes)
                                  : table.modes();
  const std::vector<double> factor =
      frequency_factors(table.sensitivity, table.frequency_hz, settings.shape_displacement_m);
  std::vector<std::pair<Complex, std::size_t>> low, high;
  for (std::size_t k = 0; k < table.modes(); ++k) {
    const bool of_board = loaded->is_board_mode(k);
    double frequency =
        table.frequency_hz[k] * factor[k] * (of_board ? 1 / settings.size : frequency_ratio);
    if (!table.poisson_slope.empty() && settings.poisson >= 0 && !of_board)
      frequency *= math::exp(table.poisson_slope[k] * (settings.poisson - own.poisson));
    const double omega = 2 * std::numbers::pi * frequency;
    // Damping is limited to just below critical, where a mode still oscillates.
    const double decay = std::min(decay_rate(k, omega), 0.999 * omega);
    const Complex s(-decay, std::sqrt(omega * omega - decay * decay));
    if (frequency < highest && k < maximum)
      low.emplace_back(s, k);
    else if (frequency < kContactLimit)
      high.emplace_back(s, k);
  }
  // Sorted by decay: blocks of the bank then become inaudible as a whole and are skipped.
  std::stable_sort(low.begin(), low.end(),
                   [](const auto& a, const auto& b) { return a.first.real() > b.first.real(); });
  audible_modes = low.size();
  low.insert(low.end(), high.begin(), high.end());
  index_of.assign(table.modes(), low.size());
  for (const auto& [s, k] : low) {
    index_of[k] = mode.size();
    rate.push_back(s);
    mode.push_back(k);
  }
  scratch.assign(mode.size(), 0);
  scratch_state.assign(mode.size(), 0);
  scratch_level.assign(audible_modes, 0);
  for (const Complex& s : rate) {
    const double x = std::min(0.5 * s.imag() / settings.sample_rate, 0.5 * std::numbers::pi);
    const double square = x * x;
    pulse_gain.push_back(1 + square * (1.0 / 6 + square * (7.0 / 360 + square * (31.0 / 15120))));
    band.push_back(pulse_band(s.imag()));
  }
  bank_state.assign(audible_modes, 0);
  force_gain.assign(mode.size(), 0.0F);
  for (std::size_t i = 0; i < audible_modes; ++i)
    a_weight.push_back(a_weighting(rate[i].imag() / (2 * std::numbers::pi)));
}

std::vector<DirectKernels::Mode> BodyModel::direct_modes() const {
  using Part = DirectKernels::Mode::Part;
  const double highest = 2 * std::numbers::pi * kMaxFrequencyRatio * settings.sample_rate;
  std::vector<DirectKernels::Mode> modes;
  for (std::size_t i = 0; i < mode.size(); ++i)
    modes.push_back({rate[i], mode[i],
                     i < audible_modes               ? Part::kRinging
                     : math::abs(rate[i]) >= highest ? Part::kTooHigh
                                                     : Part::kInaudible,
                     pulse_gain[i]});
  return modes;
}

RadiatingSurface::RigidShapes BodyModel::rigid_shapes() const {
  RadiatingSurface::RigidShapes shapes;
  if (!loaded->table.free || !(mass_kg > 0))
    return shapes;
  const RadiatingSurface& radiating = loaded->body().radiating; // its triangles are the first
  for (std::size_t t = 0; t < radiating.triangles(); ++t) {
    SurfacePoint point;
    point.triangle = t;
    point.position = radiating.centre(t);
    RigidGain outward = rigid_gains(point, radiating.normal(t));
    for (double& b : outward) // rigid_gains() is for a force inwards
      b = -b;
    shapes.push_back(outward);
  }
  return shapes;
}

/// Angular frequencies of a part's modes, 1/s; 0 for modes that are left out.
std::vector<double> BodyModel::omega_by_mode(std::size_t part) const {
  std::vector<double> omega(loaded->table.modes(), 0);
  for (std::size_t i = 0; i < mode.size(); ++i)
    omega[mode[i]] = rate[i].imag();
  if (loaded->parts.empty())
    return omega;
  std::vector<double> own;
  for (const std::size_t k : loaded->parts[part].mode)
    own.push_back(omega[k]);
  return own;
}

std::array<RigidDipole, 3> BodyModel::free_dipoles() const {
  const ModalTable& table = loaded->table;
  if (!table.free || !(mass_kg > 0))
    return {};
  double volume = 0; // divergence theorem
  const Surface& surface = loaded->body().surface;
  for (std::size_t t = 0; t < surface.triangles(); ++t) {
    const auto& c = surface.corners(t);
    volume += dot(c[0], cross(c[1], c[2])) / 6;
  }
  const double length = settings.size;
  std::array<Vec3, 3> inertia = table.inertia_kg_m2;
  for (Vec3& row : inertia)
    row = row * (mass_kg / table.mass_kg * length * length);
  return rigid_dipoles(mass_kg, inertia, volume * length * length * length);
}

/// The Arrivals of one body of the table; null: the listener gets the surface velocity.
std::unique_ptr<Arrivals> BodyModel::arrivals_of(std::size_t part, const Vec3& listener,
                                                 double delay_from_s) const {
  const LoadedTable& own = loaded->parts.empty() ? *loaded : *loaded->parts[part].loaded;
  const Vec3 displacement = loaded->parts.empty() ? Vec3{} : loaded->parts[part].displacement_m;
  const Vec3 from = listener - settings.size * displacement;
  const bool is_body = part != LoadedTable::kBoard;
  const RadiatingSurface::Scene scene{
      settings.size,
      shape_scale_of(part),
      loaded->table.air_density_kg_per_m3,
      loaded->table.sound_speed_m_per_s,
      settings.sample_rate,
      DirectKernels::max_spread(mode.size(), loaded->table.vertices()),
      delay_from_s};
  if (settings.radiation == Radiation::kBody && !own.table.multipoles.empty())
    return multipole_arrivals(own.table, omega_by_mode(part), from, scene,
                              is_body ? free_dipoles() : std::array<RigidDipole, 3>{},
                              is_body ? mass_kg : 0);
  // If there are two bodies, a body without multipoles radiates by its surface.
  if (settings.radiation == Radiation::kModal ||
      (settings.radiation == Radiation::kBody && !loaded->parts.empty()))
    return own.radiating.arrivals(from, scene,
                                  is_body ? rigid_shapes() : RadiatingSurface::RigidShapes{});
  return nullptr;
}

std::unique_ptr<Arrivals> BodyModel::arrivals(const Vec3& listener) const {
  auto of_body = arrivals_of(0, listener, -1);
  if (loaded->parts.empty() || !of_body)
    return of_body;
  auto of_board = arrivals_of(LoadedTable::kBoard, listener, of_body->delay_s);
  if (of_board->delay_s < of_body->delay_s &&
      !of_board->silent) // delays are relative to the shorter one
    of_body = arrivals_of(0, listener, of_board->delay_s);
  std::vector<CombinedArrivals::Part> parts(2);
  parts[0] = {std::move(of_body), loaded->parts[0].mode, 0};
  parts[1] = {std::move(of_board), loaded->parts[1].mode, 0};
  return std::make_unique<CombinedArrivals>(
      std::move(parts), settings.sample_rate,
      DirectKernels::max_spread(mode.size(), loaded->table.vertices()));
}

void BodyModel::compute_weights() {
  const ModalTable& table = loaded->table;
  const std::vector<DirectKernels::Mode> modes = direct_modes();
  const bool has_surface = !loaded->surface.empty();
  uses_recordings = settings.radiation == Radiation::kRaw && !table.raw.empty();
  const DirectKernels::SurfaceShapes shapes{loaded->shape, table.modes(),
                                            bank_kernel(settings.vector_set)};
  for (std::size_t l = 0; l < kMaxListeners; ++l) {
    weight[l].assign(audible_modes, 0);
    if (uses_recordings) {
      raw[l].set(table.raw, settings.listener[l], table.air_density_kg_per_m3,
                 table.sound_speed_m_per_s);
      continue;
    }
    if (l >= settings.listeners)
      continue;
    if (const auto listener_arrivals = has_surface ? arrivals(settings.listener[l]) : nullptr) {
      delay_s[l] = listener_arrivals->delay_s;
      direct[l].build(*listener_arrivals, modes, table.free && mass_kg > 0, settings.sample_rate,
                      shapes);
    } else {
      // The signal of a vibrometer at the nearest point: the outward normal velocity.
      std::vector<double> gain(audible_modes, -1);
      if (has_surface) {
        const SurfacePoint point = nearest(settings.listener[l]);
        gains(point, point.normal, gain);
      }
      std::vector<Complex> velocity(audible_modes);
      for (std::size_t k = 0; k < audible_modes; ++k) // q' = Im(s z)/omega_d
        velocity[k] = -gain[k] * rate[k] / rate[k].imag();
      direct[l].build_velocity(modes, velocity, settings.sample_rate);
    }
    weight[l] = direct[l].weight();
  }
  make_kernels();
  make_resting_kernels();
}

} // namespace tactus::modal
