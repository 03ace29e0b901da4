#include "core/dsp/complex.hpp"
#include "core/modal/radiation/multipole.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace tactus::modal {
namespace {

using std::numbers::pi;
constexpr double kDecay = 9;      // length of a sphere's transients in units of a/c
constexpr double kBandDecay = 20; // length of the transients of a body with edges and cavities
constexpr double kMaxPhaseStep =
    2 * pi * 0.6; // rad per sample: the end of BandLimit's transition band

/// h_l' by the recursion h_l' = h_(l-1) - (l + 1)/x h_l.
Complex slope(const std::vector<Complex>& h, std::size_t l, double x) {
  return l == 0 ? -h[1] : h[l - 1] - static_cast<double>(l + 1) / x * h[l];
}

/// BandLimit's transfer function at an angular frequency in rad per sample.
double band_limit_transfer(const BandLimit& band, double turn) {
  constexpr int kSteps = 8;
  double sum = 1;
  for (int i = 1; i < kSteps * static_cast<int>(BandLimit::kHalfWidth); ++i) {
    const double t = static_cast<double>(i) / kSteps;
    sum += 2 * band.kernel(t) * math::cos(turn * t);
  }
  return sum / kSteps;
}

class MultipoleArrivals final : public Arrivals {
public:
  MultipoleArrivals(const ModalTable& table, std::span<const double> omega, const Vec3& listener,
                    const RadiatingSurface::Scene& scene, const std::array<RigidDipole, 3>& rigid,
                    double mass_kg)
      : table_(table), omega_(omega.begin(), omega.end()), scene_(scene), rigid_(rigid),
        mass_kg_(mass_kg), listener_(listener),
        direction_(table, listener - scene.size * table.multipoles.centre) {
    const Vec3 path = listener - scene.size * table.multipoles.centre;
    radius_ = scene.size * table.multipoles.reference_radius_m;
    distance_ = std::max(norm(path), radius_);
    towards_ = norm(path) > 0 ? path * (1 / norm(path)) : Vec3{0, 0, 1};
    const double c = scene.sound_speed_m_per_s;
    travel_ = TravelTime((distance_ - radius_) / c, scene.sample_rate, scene.delay_from_s);
    delay_s = travel_.delay_s;
    const double spread = std::min((table.multipoles.band.empty() ? kDecay : kBandDecay) * radius_ /
                                       c * scene.sample_rate,
                                   static_cast<double>(scene.max_spread));
    samples_ = static_cast<std::size_t>(spread) + BandLimit::kLength + 2;
    while (period_ < samples_ + samples_ / 2)
      period_ *= 2;
    for (std::size_t i = 1; static_cast<double>(i) * turn() < kMaxPhaseStep; ++i)
      band_.push_back(band_limit_transfer(BandLimit::at_rate(scene.sample_rate),
                                          static_cast<double>(i) * turn()));
  }
  [[nodiscard]] std::size_t modes() const noexcept override { return table_.modes(); }
  [[nodiscard]] std::size_t samples() const noexcept override { return samples_; }

  void find(std::size_t motion, std::span<double> pressure) const override {
    std::fill(pressure.begin(), pressure.end(), 0);
    if (motion >= modes()) {
      find_rigid(motion - modes(), pressure);
      return;
    }
    const double omega = omega_[motion];
    if (!(omega > 0))
      return;
    if (!table_.multipoles.band.empty()) {
      find_from_band(motion, pressure);
      return;
    }
    const double c = scene_.sound_speed_m_per_s;
    const double ratio = omega * scene_.size / (2 * pi * table_.frequency_hz[motion]);
    const std::vector<Complex> sums = direction_.sums(motion, ratio);
    const double x = omega / c * radius_;
    const auto h = spherical_hankel(sums.size(), x);
    // The octave's filter j omega tau/(1 + j omega tau) that is nearest to the mode.
    const int octave = static_cast<int>(std::lround(math::log2(omega)));
    const double at = omega * math::exp2(-octave);
    const Complex turned = Complex(0, at) / Complex(1, at);
    for (std::size_t l = 0; l < sums.size(); ++l) {
      // p = -j rho c v h_l(k r)/h_l'(k a); the table holds p on the sphere.
      const Complex ratio_on_sphere = slope(h, l, x) / h[l];
      const Complex velocity = sums[l] * Complex(0, 1) * ratio_on_sphere /
                               (table_.air_density_kg_per_m3 * c) * scene_.shape_scale;
      if (!std::isfinite(velocity.real()) || !std::isfinite(velocity.imag()))
        continue;
      const double second = velocity.imag() / turned.imag();
      const double first = velocity.real() - second * turned.real();
      add(first, kernel(l, kPlain, radius_), pressure);
      add(second, kernel(l, octave, radius_), pressure);
    }
  }

private:
  static constexpr int kPlain = -1000;
  static constexpr double kMinTurns = 2; ///< turns of a wave, whose main lobe then ends above 0 Hz
  static constexpr double kTravelRadii =
      0.5; ///< reference radii: path whose travel time is removed before v_l is interpolated
  [[nodiscard]] double turn() const noexcept { return 2 * pi / static_cast<double>(period_); }

  static void add(double amount, const std::vector<double>& kernel, std::span<double> to) {
    for (std::size_t i = 0; i < std::min(kernel.size(), to.size()); ++i)
      to[i] += amount * kernel[i];
  }

  void find_rigid(std::size_t motion, std::span<double> pressure) const {
    if (motion >= 3 || !(mass_kg_ > 0)) // rotations radiate as quadrupoles, which is negligible
      return;
    for (const RigidDipole& dipole : rigid_)
      if (dipole.radius_m > 0)
        add(dipole.axis[static_cast<int>(motion)] * dot(dipole.axis, towards_) /
                std::sqrt(mass_kg_),
            kernel(1, kPlain, std::min(dipole.radius_m, radius_)), pressure);
  }

  void find_from_band(std::size_t motion, std::span<double> pressure) const {
    const MultipoleTable::Band& band = table_.multipoles.band;
    const double c = scene_.sound_speed_m_per_s;
    const std::size_t count = band.frequency_hz.size();
    const auto degrees = static_cast<std::size_t>(band.highest_degree[motion]) + 1;
    // v_l exp(j k a/2) at the band's frequencies, over x = k a, which a change of size leaves.
    std::vector<double> x(count);
    std::vector<std::vector<Complex>> velocity(count);
    for (std::size_t i = 0; i < count; ++i) {
      x[i] = 2 * pi * band.frequency_hz[i] / c * table_.multipoles.reference_radius_m;
      velocity[i] = direction_.band_sums(motion, i);
      const auto h = spherical_hankel(degrees, x[i]);
      for (std::size_t l = 0; l < degrees; ++l) {
        const Complex v = velocity[i][l] * Complex(0, 1) * slope(h, l, x[i]) / h[l] *
                          math::polar(scene_.shape_scale / (table_.air_density_kg_per_m3 * c),
                                      kTravelRadii * x[i]);
        velocity[i][l] = std::isfinite(v.real()) && std::isfinite(v.imag()) ? v : 0.0;
      }
    }
    std::vector<Complex> transfer(1 + band_.size());
    for (std::size_t i = 0; i < transfer.size(); ++i) {
      const double at = static_cast<double>(i) * turn() * scene_.sample_rate / c * radius_;
      const Interpolation between(x, at);
      for (std::size_t l = 0; l < degrees; ++l)
        transfer[i] += between.value(velocity, l) * waves(l)[i];
      transfer[i] *= math::polar(1.0, -kTravelRadii * at);
    }
    transform(transfer, pressure);
    correct_low_frequencies(transfer, pressure);
    correct_own_frequency(motion, pressure);
  }

  /// Truncating the kernel has changed its transfer at the mode's own frequency, at which the mode
  /// rings. This adds a wave under a Hann window that restores the transfer of the table's waves at
  /// that frequency.
  void correct_own_frequency(std::size_t motion, std::span<double> out) const {
    const double turn = omega_[motion] / scene_.sample_rate;
    if (turn * static_cast<double>(samples_) < kMinTurns * 2 * pi || turn >= kMaxPhaseStep)
      return;
    const Complex rate(0, omega_[motion]);
    Complex missing =
        multipole_transfer(table_, std::span(&rate, 1), std::span(&motion, 1), listener_, scene_)
            .pressure[0] /
        rate * band_limit_transfer(BandLimit::at_rate(scene_.sample_rate), turn);
    const std::size_t nodes = samples_ * BandLimit::kNodes;
    std::vector<Complex> shape(nodes);
    Complex of_cosine = 0, of_sine = 0;
    for (std::size_t i = 0; i < nodes; ++i) {
      const std::size_t m = i % BandLimit::kNodes;
      const double at = static_cast<double>(i / BandLimit::kNodes) + BandLimit::kNode[m];
      const Complex wave = math::polar(
          1.0, turn * (at - static_cast<double>(BandLimit::kLatency) - travel_.fractional_samples));
      shape[i] = 0.5 * (1 - math::cos(2 * pi * at / static_cast<double>(samples_))) * wave;
      if (m == 0)
        continue;
      const Complex part = BandLimit::kGaussWeight[m - 1] * math::conj(wave);
      of_cosine += shape[i].real() * part;
      of_sine += shape[i].imag() * part;
      missing -= out[i] * part;
    }
    const auto area = [](Complex a, Complex b) {
      return a.real() * b.imag() - a.imag() * b.real();
    };
    const double whole = area(of_cosine, of_sine);
    const double cosine = area(missing, of_sine) / whole, sine = area(of_cosine, missing) / whole;
    for (std::size_t i = 0; i < nodes; ++i)
      out[i] += cosine * shape[i].real() + sine * shape[i].imag();
  }

  /// The data of correct_low_frequencies() that all motions share.
  struct LowFrequencyFit {
    static constexpr std::size_t kSmooth = 10;
    using Shapes = std::array<double, kSmooth>;
    std::size_t count = 0;                          ///< number of frequencies that are fitted
    std::vector<Shapes> shape;                      ///< shapes at every node of every sample
    std::vector<Complex> wave;                      ///< by frequency and node: part of the integral
    std::vector<std::array<Complex, kSmooth>> part; ///< part of each shape at each frequency
    std::array<Shapes, kSmooth> equation{};
  };

  [[nodiscard]] const LowFrequencyFit& low_frequency_fit() const {
    LowFrequencyFit& fit = low_frequency_fit_;
    if (!fit.shape.empty())
      return fit;
    for (std::size_t n = 0; n < samples_; ++n)
      for (std::size_t m = 0; m < BandLimit::kNodes; ++m) {
        const double u =
            (static_cast<double>(n) + BandLimit::kNode[m]) / static_cast<double>(samples_);
        LowFrequencyFit::Shapes& shape = fit.shape.emplace_back();
        for (std::size_t q = 0; q < LowFrequencyFit::kSmooth; ++q)
          shape[q] = 0.5 * (1 - math::cos(2 * pi * u)) * math::cos(pi * static_cast<double>(q) * u);
      }
    fit.count = std::min(period_ / 28, 1 + band_.size());
    fit.wave.reserve(fit.count * samples_ * (BandLimit::kNodes - 1));
    for (std::size_t i = 0; i < fit.count; ++i) {
      auto& part = fit.part.emplace_back();
      for (std::size_t n = 0; n < samples_; ++n)
        for (std::size_t m = 1; m < BandLimit::kNodes; ++m) {
          const double t = static_cast<double>(n) + BandLimit::kNode[m] -
                           static_cast<double>(BandLimit::kLatency) - travel_.fractional_samples;
          fit.wave.push_back(BandLimit::kGaussWeight[m - 1] *
                             math::polar(1.0, -static_cast<double>(i) * turn() * t));
          for (std::size_t q = 0; q < part.size(); ++q)
            part[q] += fit.shape[n * BandLimit::kNodes + m][q] * fit.wave.back();
        }
      for (std::size_t p = 0; p < part.size(); ++p)
        for (std::size_t q = 0; q < part.size(); ++q)
          fit.equation[p][q] += (math::conj(part[p]) * part[q]).real();
    }
    for (std::size_t p = 0; p < LowFrequencyFit::kSmooth; ++p)
      fit.equation[p][p] *= 1 + 1e-5; // these frequencies hardly separate the shapes
    return fit;
  }

  /// Corrects the low frequencies of a truncated kernel. The transfer of a high degree rises a
  /// thousandfold from 0 Hz to 20 kHz, so that truncating the high frequencies disturbs the low
  /// ones. The correction is a smooth pulse over the kernel's length, a sum of shapes under a Hann
  /// window, fitted by least squares at the transfer's lowest frequencies.
  void correct_low_frequencies(const std::vector<Complex>& transfer, std::span<double> out) const {
    constexpr std::size_t kSmooth = LowFrequencyFit::kSmooth;
    const LowFrequencyFit& fit = low_frequency_fit();
    std::array<std::array<double, kSmooth + 1>, kSmooth> equation{};
    for (std::size_t p = 0; p < kSmooth; ++p)
      std::copy(fit.equation[p].begin(), fit.equation[p].end(), equation[p].begin());
    const Complex* wave = fit.wave.data();
    for (std::size_t i = 0; i < fit.count; ++i) {
      Complex residual = i == 0 ? 2.0 * transfer[0] : transfer[i];
      for (std::size_t n = 0; n < samples_; ++n)
        for (std::size_t m = 1; m < BandLimit::kNodes; ++m)
          residual -= out[n * BandLimit::kNodes + m] * *wave++;
      for (std::size_t p = 0; p < kSmooth; ++p)
        equation[p][kSmooth] += (math::conj(fit.part[i][p]) * residual).real();
    }
    const std::array<double, kSmooth> amount = solve(equation);
    for (std::size_t n = 0; n < fit.shape.size(); ++n)
      for (std::size_t q = 0; q < kSmooth; ++q)
        out[n] += amount[q] * fit.shape[n][q];
  }

  /// Gaussian elimination with pivoting; the last column is the right-hand side.
  template <std::size_t Count>
  static std::array<double, Count> solve(std::array<std::array<double, Count + 1>, Count>& a) {
    for (std::size_t p = 0; p < Count; ++p) {
      std::size_t best = p;
      for (std::size_t r = p + 1; r < Count; ++r)
        if (std::abs(a[r][p]) > std::abs(a[best][p]))
          best = r;
      std::swap(a[p], a[best]);
      if (a[p][p] == 0)
        return {};
      for (std::size_t r = 0; r < Count; ++r) {
        const double ratio = r == p ? 0 : a[r][p] / a[p][p];
        for (std::size_t q = p; q <= Count; ++q)
          a[r][q] -= ratio * a[p][q];
      }
    }
    std::array<double, Count> x{};
    for (std::size_t p = 0; p < Count; ++p)
      x[p] = a[p][Count] / a[p][p];
    return x;
  }

  /// Interpolation weights for a function of k a that is known at the band's frequencies.
  struct Interpolation {
    std::size_t first = 0;
    std::array<double, 4> weight{};
    double below = 1; ///< factor of the imaginary part below the lowest frequency
    Interpolation(const std::vector<double>& x, double at) {
      if (at <= x.front()) {
        weight[0] = 1;
        below = at / x.front();
        return;
      }
      const double t = std::min(at, x.back());
      const auto next = static_cast<std::size_t>(std::lower_bound(x.begin(), x.end(), t) -
                                                 x.begin()); // x[next - 1] < t <= x[next]
      first = std::min(next > 2 ? next - 2 : 0, x.size() - 4);
      for (std::size_t i = 0; i < 4; ++i) { // Lagrange
        weight[i] = 1;
        for (std::size_t j = 0; j < 4; ++j)
          if (j != i)
            weight[i] *= (t - x[first + j]) / (x[first + i] - x[first + j]);
      }
    }
    [[nodiscard]] Complex value(const std::vector<std::vector<Complex>>& of, std::size_t l) const {
      Complex sum = 0;
      for (std::size_t i = 0; i < 4; ++i)
        sum += weight[i] * of[first + i][l];
      return {sum.real(), below * sum.imag()};
    }
  };

  /// Degree l's transfer from the acceleration of the sphere's surface to the listener,
  /// band-limited and without the common delay; halved at 0 Hz, for the integral below.
  [[nodiscard]] const std::vector<Complex>& waves(std::size_t l) const {
    const auto [entry, is_new] = waves_.try_emplace(l);
    if (is_new)
      entry->second = find_waves(l, radius_);
    return entry->second;
  }

  [[nodiscard]] std::vector<Complex> find_waves(std::size_t l, double radius) const {
    const double c = scene_.sound_speed_m_per_s, density = scene_.air_density_kg_per_m3;
    const auto degree = static_cast<double>(l);
    const double still =
        density * radius * math::pow(radius / distance_, degree + 1) / (degree + 1);
    std::vector<Complex> transfer(1 + band_.size());
    transfer[0] = 0.5 * still;
    for (std::size_t i = 1; i < transfer.size(); ++i) {
      const double omega = static_cast<double>(i) * turn() * scene_.sample_rate;
      const double wavenumber = omega / c;
      const auto near = spherical_hankel(l + 1, wavenumber * radius);
      const auto far = spherical_hankel(l + 1, wavenumber * distance_);
      Complex value = -density * c / omega * far[l] / slope(near, l, wavenumber * radius) *
                      math::polar(1.0, wavenumber * (distance_ - radius)); // minus the common delay
      if (!std::isfinite(value.real()) || !std::isfinite(value.imag()))
        value = still;
      transfer[i] = band_[i - 1] * value;
    }
    return transfer;
  }

  /// The inverse Fourier transform at the nodes of every sample. The wave at each time is a chain
  /// of rotations, in which every step waits for the step before, so kLanes chains run side by
  /// side.
  void transform(const std::vector<Complex>& transfer, std::span<double> out) const {
    constexpr std::size_t kLanes = 8;
    using Lanes = std::array<double, kLanes>;
    const std::size_t count = samples_ * BandLimit::kNodes;
    for (std::size_t first = 0; first < count; first += kLanes) {
      Lanes step_real{}, step_imag{}, real{}, imag{}, sum{};
      for (std::size_t k = 0; k < kLanes; ++k) {
        const std::size_t n = (first + k) / BandLimit::kNodes, m = (first + k) % BandLimit::kNodes;
        const double t = static_cast<double>(n) + BandLimit::kNode[m] -
                         static_cast<double>(BandLimit::kLatency) - travel_.fractional_samples;
        step_real[k] = math::cos(turn() * t);
        step_imag[k] = math::sin(turn() * t);
        real[k] = 1;
        sum[k] = transfer[0].real();
      }
      for (std::size_t i = 1; i < transfer.size(); ++i) {
        const double transfer_real = transfer[i].real(), transfer_imag = transfer[i].imag();
        for (std::size_t k = 0; k < kLanes; ++k) {
          const double turned = real[k] * step_real[k] - imag[k] * step_imag[k];
          imag[k] = real[k] * step_imag[k] + imag[k] * step_real[k];
          real[k] = turned;
          sum[k] += transfer_real * real[k] - transfer_imag * imag[k];
        }
      }
      for (std::size_t k = 0; k < std::min(kLanes, count - first); ++k)
        out[first + k] = 2 * sum[k] / static_cast<double>(period_);
    }
  }

  /// Band-limited pressure for an acceleration impulse of degree l, by Fourier's integral.
  [[nodiscard]] const std::vector<double>& kernel(std::size_t l, int octave, double radius) const {
    const auto [entry, is_new] = kernels_.try_emplace(Key{l, octave, radius});
    std::vector<double>& out = entry->second;
    if (!is_new)
      return out;
    std::vector<Complex> transfer = find_waves(l, radius);
    if (octave != kPlain)
      for (std::size_t i = 0; i < transfer.size(); ++i) {
        const double x = static_cast<double>(i) * turn() * scene_.sample_rate * math::exp2(-octave);
        transfer[i] *= Complex(0, x) / Complex(1, x);
      }
    out.resize(samples_ * BandLimit::kNodes);
    transform(transfer, out);
    return out;
  }

  struct Key {
    std::size_t degree;
    int octave;
    double radius;
    // clang-tidy 14 takes the 0 of the compiler's own comparison for a pointer.
    auto operator<=>(const Key&) const = default; // NOLINT(modernize-use-nullptr)
  };
  const ModalTable& table_;
  std::vector<double> omega_;
  RadiatingSurface::Scene scene_;
  std::array<RigidDipole, 3> rigid_;
  double mass_kg_;
  Vec3 listener_;
  MultipoleDirection direction_;
  Vec3 towards_{0, 0, 1};
  double radius_ = 0, distance_ = 0;
  TravelTime travel_;
  std::size_t samples_ = 0, period_ = 64;
  std::vector<double> band_;
  mutable std::map<Key, std::vector<double>> kernels_;
  mutable std::map<std::size_t, std::vector<Complex>> waves_; ///< waves by degree
  mutable LowFrequencyFit low_frequency_fit_;                 ///< empty: not needed yet
};

/// Eigenvalues (left on the diagonal) and eigenvectors of a symmetric matrix by Jacobi rotations.
void diagonalise(std::array<Vec3, 3>& a, std::array<Vec3, 3>& vectors) {
  vectors = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  for (int sweep = 0; sweep < 20; ++sweep)
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        const auto i = static_cast<std::size_t>(p), j = static_cast<std::size_t>(q);
        if (a[i][q] == 0)
          continue;
        const double angle = 0.5 * math::atan2(2 * a[i][q], a[j][q] - a[i][p]);
        const double cosine = math::cos(angle), sine = math::sin(angle);
        for (std::size_t k = 0; k < 3; ++k) {
          const double x = a[k][p], y = a[k][q];
          a[k][p] = cosine * x - sine * y;
          a[k][q] = sine * x + cosine * y;
        }
        const Vec3 x = a[i], y = a[j];
        a[i] = cosine * x - sine * y;
        a[j] = sine * x + cosine * y;
        const Vec3 u = vectors[i], v = vectors[j];
        vectors[i] = cosine * u - sine * v;
        vectors[j] = sine * u + cosine * v;
      }
}

} // namespace

std::array<RigidDipole, 3> rigid_dipoles(double mass_kg, const std::array<Vec3, 3>& inertia_kg_m2,
                                         double volume_m3) {
  std::array<RigidDipole, 3> dipoles{};
  std::array<Vec3, 3> inertia = inertia_kg_m2, axis;
  diagonalise(inertia, axis);
  const double sum = inertia[0][0] + inertia[1][1] + inertia[2][2];
  if (!(mass_kg > 0) || !(sum > 0) || !(volume_m3 > 0))
    return dipoles;
  std::array<double, 3> square{}; // squares of the semi-axes
  for (std::size_t i = 0; i < 3; ++i)
    square[i] =
        std::max(2.5 * (sum - 2 * inertia[i][static_cast<int>(i)]) / mass_kg, 1e-6 * sum / mass_kg);
  const double product = std::sqrt(square[0] * square[1] * square[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    // alpha = abc int over lambda from 0 of 1/((a_i^2 + lambda) sqrt((a^2 + l)(b^2 + l)(c^2 + l))),
    // over the logarithm of lambda.
    double alpha = 0;
    constexpr double kStep = 0.02;
    const double scale = square[0] + square[1] + square[2];
    for (int step = -1500; step < 1500; ++step) {
      const double lambda = scale * math::exp(step * kStep);
      alpha += kStep * lambda * product /
               ((square[i] + lambda) *
                std::sqrt((square[0] + lambda) * (square[1] + lambda) * (square[2] + lambda)));
    }
    const double added = 4.0 / 3 * pi * product * alpha / (2 - alpha);
    dipoles[i] = {axis[i], math::cbrt((volume_m3 + added) / (2 * pi))};
  }
  return dipoles;
}

std::unique_ptr<Arrivals> multipole_arrivals(const ModalTable& table, std::span<const double> omega,
                                             const Vec3& listener,
                                             const RadiatingSurface::Scene& scene,
                                             const std::array<RigidDipole, 3>& rigid,
                                             double mass_kg) {
  return std::make_unique<MultipoleArrivals>(table, omega, listener, scene, rigid, mass_kg);
}

} // namespace tactus::modal
