#include "core/modal/contact/contact_modes.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace tactus::modal {
namespace {

template <class T> class ModesOf final : public ContactModes {
public:
  ModesOf(std::span<const Complex> rate, double sample_rate, unsigned max_steps,
          std::size_t contacts, std::size_t listeners, VectorSet widest)
      : kernel_(contact_kernels(widest).of<T>()), modes_(rate.size()), max_steps_(max_steps),
        alpha_(modes_, 0), omega_(modes_, 1), inverse_omega_(modes_, 1), inverse_square_(modes_, 1),
        finest_(modes_), force_response_(modes_), pole_minus_one_(modes_), state_(modes_),
        slots_(contacts),
        weights_(std::min(listeners, ContactPass<T>::kMaxPickups), Split<T>(modes_)),
        pickups_(weights_.size()), direct_output_(contacts * weights_.size()) {
    padded_ = state_.real.padded();
    pass_.count = padded_;
    pass_.z = state_.view();
    pass_.pole_minus_one = std::as_const(pole_minus_one_).view();
    pass_.pickup = pickups_.data();
    for (std::size_t k = 0; k < modes_; ++k) {
      alpha_[k] = -rate[k].real();
      omega_[k] = rate[k].imag();
      inverse_omega_[k] = 1 / omega_[k];
      inverse_square_[k] = 1 / (alpha_[k] * alpha_[k] + omega_[k] * omega_[k]);
      // exp(x + j y) - 1 without cancellation
      const double x = rate[k].real() / (sample_rate * max_steps);
      const double y = rate[k].imag() / (sample_rate * max_steps);
      const double half = math::sin(0.5 * y);
      finest_.real[k] = math::expm1(x) - 2 * math::exp(x) * half * half;
      finest_.imaginary[k] = math::exp(x) * math::sin(y);
    }
    for (Slot& slot : slots_) {
      slot.gain = slot.displacement_gain = LaneArray<T>(modes_);
      slot.input_gain = Split<T>(modes_);
    }
    for (std::size_t l = 0; l < pickups_.size(); ++l)
      pickups_[l] = std::as_const(weights_[l]).view();
    listening_ = pickups_.size();
    set_steps(1);
  }

  void set_steps(unsigned steps) noexcept override {
    flush_pending();
    for (std::size_t k = 0; k < modes_; ++k) {
      double re = finest_.real[k], im = finest_.imaginary[k];
      for (unsigned s = steps; s < max_steps_; s *= 2) { // (1 + t)^2 - 1
        const double twice = 2 * re + re * re - im * im;
        im = 2 * im + 2 * re * im;
        re = twice;
      }
      pole_minus_one_.real[k] = static_cast<T>(re);
      pole_minus_one_.imaginary[k] = static_cast<T>(im);
      // t/s, s = -alpha + j omega
      const double inverse = inverse_square_[k];
      force_response_.real[k] = (im * omega_[k] - re * alpha_[k]) * inverse;
      force_response_.imaginary[k] = -(re * omega_[k] + im * alpha_[k]) * inverse;
    }
    for (std::size_t i = 0; i < slots_.size(); ++i)
      if (slots_[i].used)
        update_input_gain(i);
  }

  double set_gain(std::size_t slot, std::span<const double> gain) noexcept override {
    flush_pending();
    Slot& s = slots_[slot];
    double squares = 0;
    const std::size_t gain_count = std::min(gain.size(), modes_);
    for (std::size_t k = 0; k < gain_count; ++k) {
      s.gain[k] = static_cast<T>(gain[k]);
      s.displacement_gain[k] = static_cast<T>(gain[k] * inverse_omega_[k]);
      squares += gain[k] * gain[k];
    }
    for (std::size_t k = gain_count; k < modes_; ++k)
      s.gain[k] = s.displacement_gain[k] = 0;
    s.used = true;
    update_input_gain(slot);
    return squares;
  }

  [[nodiscard]] double gain(std::size_t slot, std::size_t mode) const noexcept override {
    return static_cast<double>(slots_[slot].gain[mode]);
  }

  void remove_contact(std::size_t slot) noexcept override {
    if (pending_slot_ == slot)
      flush_pending();
    slots_[slot].used = false;
  }

  [[nodiscard]] double compliance(std::size_t to, std::size_t from,
                                  std::size_t lag) noexcept override {
    const Split<T>& input = slots_[from].input_gain;
    const T* gain = slots_[to].displacement_gain.data();
    double sum = kernel_->sum(gain, input.imaginary.data(), padded_);
    if (lag == 0)
      return sum;
    for (std::size_t k = 0; k < modes_; ++k)
      sum += static_cast<double>(gain[k] * (pole_minus_one_.real[k] * input.imaginary[k] +
                                            pole_minus_one_.imaginary[k] * input.real[k]));
    return sum;
  }

  [[nodiscard]] const double* predict_displacement(std::size_t slot, std::size_t steps,
                                                   bool ends_sample) noexcept override {
    if (pending_slot_ != slot || pass_.pending > steps)
      flush_pending();
    if (pending_slot_ != slot) {
      pending_slot_ = slot;
      pass_.input_gain = std::as_const(slots_[slot].input_gain).view();
      pass_.gain = slots_[slot].displacement_gain.data();
    }
    pass_.steps = steps;
    pass_.pickups = ends_sample ? listening_ : 0;
    kernel_->advance(pass_);
    pass_.pending = steps;
    pass_.force[0] = pass_.force[1] = 0;
    outputs_valid_ = ends_sample;
    return pass_.displacement;
  }

  void apply_forces(const double* force) noexcept override {
    const std::size_t last = pass_.pending - 1;
    for (std::size_t j = 0; j <= last; ++j) {
      pass_.force[j] = force[j];
      if (outputs_valid_ && force[j] != 0)
        add_force_to_outputs(pending_slot_, last - j, force[j]);
    }
  }
  void apply_force_at(std::size_t slot, double force) noexcept override {
    kernel_->add_force(state_.view(), std::as_const(slots_[slot].input_gain).view(), force,
                       padded_);
    if (outputs_valid_)
      add_force_to_outputs(slot, 0, force);
  }
  [[nodiscard]] double predicted_displacement(std::size_t slot) noexcept override {
    return kernel_->sum(slots_[slot].displacement_gain.data(), state_.imaginary.data(), padded_);
  }

  void flush_pending() noexcept override {
    if (pending_slot_ >= slots_.size())
      return;
    const Slot& s = slots_[pending_slot_];
    if (pass_.pending == 2) {
      pass_.pending = pass_.steps = 1;
      pass_.pickups = 0;
      const double last = pass_.force[1];
      kernel_->advance(pass_);
      pass_.force[0] = last;
    }
    if (const double last = pass_.force[pass_.pending - 1]; last != 0)
      kernel_->add_force(state_.view(), s.input_gain.view(), last, padded_);
    pass_.pending = 1;
    pass_.force[0] = pass_.force[1] = 0;
    pending_slot_ = slots_.size();
  }

  [[nodiscard]] double displacement(std::size_t slot) noexcept override {
    flush_pending();
    return kernel_->sum(slots_[slot].displacement_gain.data(), state_.imaginary.data(), padded_);
  }
  [[nodiscard]] double velocity(std::size_t slot) noexcept override {
    flush_pending();
    return kernel_->sum(slots_[slot].gain.data(), state_.real.data(), padded_);
  }

  void set_weight(std::size_t listener, std::span<const Complex> weight) noexcept override {
    if (listener >= weights_.size())
      return;
    for (std::size_t k = 0; k < std::min(modes_, weight.size()); ++k) {
      weights_[listener].real[k] = static_cast<T>(weight[k].real());
      weights_[listener].imaginary[k] = static_cast<T>(weight[k].imag());
    }
    outputs_valid_ = false;
    for (std::size_t i = 0; i < slots_.size(); ++i)
      slots_[i].direct_output_valid = false;
  }
  void set_listening(std::size_t listeners) noexcept override {
    listening_ = std::min(listeners, pickups_.size());
    outputs_valid_ = false;
  }
  [[nodiscard]] double output(std::size_t listener) noexcept override {
    if (outputs_valid_)
      return pass_.outputs[listener];
    flush_pending();
    return kernel_->output(pickups_[listener], std::as_const(state_).view(), padded_);
  }

  [[nodiscard]] double output(std::span<const Complex> w) noexcept override {
    flush_pending();
    double sum = 0;
    for (std::size_t k = 0; k < std::min(w.size(), modes_); ++k)
      sum += w[k].real() * static_cast<double>(state_.imaginary[k]) +
             w[k].imag() * static_cast<double>(state_.real[k]);
    return sum;
  }

  void apply_impulse(std::span<const float> gain, double impulse) noexcept override {
    if (pass_.pending > 1) // the impulse acts on the state after the first of two pending forces
      flush_pending();
    const std::size_t count = std::min(gain.size(), modes_);
    const T size = static_cast<T>(impulse);
    for (std::size_t k = 0; k < count; ++k)
      state_.real[k] += static_cast<T>(gain[k]) * size;
    for (std::size_t l = 0; l < listening_ && outputs_valid_; ++l)
      pass_.outputs[l] += impulse * partial_sums(count, [&](std::size_t k) {
                            return static_cast<T>(gain[k]) * pickups_[l].imaginary[k];
                          });
  }

  [[nodiscard]] Complex state(std::size_t k) const noexcept override {
    Complex z(static_cast<double>(state_.real[k]), static_cast<double>(state_.imaginary[k]));
    if (pending_slot_ >= slots_.size())
      return z;
    const Split<T>& input = slots_[pending_slot_].input_gain;
    const Complex b(static_cast<double>(input.real[k]), static_cast<double>(input.imaginary[k]));
    const Complex t(static_cast<double>(pole_minus_one_.real[k]),
                    static_cast<double>(pole_minus_one_.imaginary[k]));
    for (std::size_t j = 0; j < pass_.pending; ++j) {
      if (j > 0)
        z += t * z;
      z += pass_.force[j] * b;
    }
    return z;
  }
  void set_state(std::size_t k, Complex z) noexcept override {
    flush_pending();
    outputs_valid_ = false;
    state_.real[k] = static_cast<T>(z.real());
    state_.imaginary[k] = static_cast<T>(z.imag());
  }
  void read_states(std::span<Complex> z) noexcept override {
    flush_pending();
    for (std::size_t k = 0; k < std::min(z.size(), modes_); ++k)
      z[k] = {static_cast<double>(state_.real[k]), static_cast<double>(state_.imaginary[k])};
  }
  void write_states(std::span<const Complex> z) noexcept override {
    silence();
    for (std::size_t k = 0; k < std::min(z.size(), modes_); ++k) {
      state_.real[k] = static_cast<T>(z[k].real());
      state_.imaginary[k] = static_cast<T>(z[k].imag());
    }
  }
  void silence() noexcept override {
    flush_pending();
    outputs_valid_ = false;
    std::fill_n(state_.real.data(), modes_, T{0});
    std::fill_n(state_.imaginary.data(), modes_, T{0});
  }

  [[nodiscard]] MotionBounds motion_bounds(std::size_t slot) noexcept override {
    flush_pending();
    // An upper bound of |z| without square roots: a + (sqrt(2) - 1) b, a the larger and b the
    // smaller of |Re z| and |Im z|; at most 8 % above |z|.
    constexpr T kSum = T(0.70711), kDifference = T(0.29290);
    const Slot& s = slots_[slot];
    constexpr std::size_t kStride = 16;
    std::array<T, kStride> displacement{}, speed{}, displacement_square{}, speed_square{};
    for (std::size_t first = 0; first < padded_; first += kStride)
      for (std::size_t i = 0; i < kStride; ++i) {
        const std::size_t k = first + i;
        const T re = std::abs(state_.real[k]), im = std::abs(state_.imaginary[k]);
        const T size = kSum * (re + im) + kDifference * std::abs(re - im);
        const T a = std::abs(s.displacement_gain[k]) * size, b = std::abs(s.gain[k]) * size;
        displacement[i] += a;
        speed[i] += b;
        displacement_square[i] += a * a;
        speed_square[i] += b * b;
      }
    MotionBounds bounds;
    for (std::size_t i = 0; i < kStride; ++i) {
      bounds.displacement += static_cast<double>(displacement[i]);
      bounds.speed += static_cast<double>(speed[i]);
      bounds.displacement_square += static_cast<double>(displacement_square[i]);
      bounds.speed_square += static_cast<double>(speed_square[i]);
    }
    return bounds;
  }

private:
  /// Complex numbers of all modes.
  template <class N> struct Split {
    LaneArray<N> real, imaginary;
    explicit Split(std::size_t count = 0) : real(count), imaginary(count) {}
    [[nodiscard]] SplitView<N> view() noexcept { return {real.data(), imaginary.data()}; }
    [[nodiscard]] ConstSplitView<N> view() const noexcept {
      return {real.data(), imaginary.data()};
    }
  };
  struct Slot {
    LaneArray<T> gain, displacement_gain; ///< b and b/omega_d of the modes
    Split<T> input_gain;                  ///< b (p - 1)/s
    bool used = false, direct_output_valid = false;
  };
  /// A listener's output now for 1 N in the last step, and for 1 N in the step before.
  using DirectOutput = std::array<double, kMaxStepsAhead>;

  /// The sum of part(k), in several partial sums, so that additions do not wait for each other.
  template <class Part> static double partial_sums(std::size_t count, const Part& part) noexcept {
    constexpr std::size_t kSums = 16;
    std::array<T, kSums> sums{};
    std::size_t k = 0;
    for (; k + kSums <= count; k += kSums)
      for (std::size_t i = 0; i < kSums; ++i)
        sums[i] += part(k + i);
    for (; k < count; ++k)
      sums[k % kSums] += part(k);
    double sum = 0;
    for (const T x : sums)
      sum += static_cast<double>(x);
    return sum;
  }

  void update_input_gain(std::size_t slot) noexcept {
    Slot& s = slots_[slot];
    for (std::size_t k = 0; k < modes_; ++k) {
      const auto b = static_cast<double>(s.gain[k]);
      s.input_gain.real[k] = static_cast<T>(b * force_response_.real[k]);
      s.input_gain.imaginary[k] = static_cast<T>(b * force_response_.imaginary[k]);
    }
    s.direct_output_valid = false;
  }

  void compute_direct_output(std::size_t slot) noexcept {
    Slot& s = slots_[slot];
    s.direct_output_valid = true;
    for (std::size_t l = 0; l < listening_; ++l) {
      DirectOutput& direct = direct_output_[slot * pickups_.size() + l];
      const ConstSplitView<T> w = pickups_[l];
      direct[0] = kernel_->output(w, std::as_const(s.input_gain).view(), padded_);
      double later = 0;
      for (std::size_t k = 0; k < modes_; ++k) {
        const T re = pole_minus_one_.real[k] * s.input_gain.real[k] -
                     pole_minus_one_.imaginary[k] * s.input_gain.imaginary[k];
        const T im = pole_minus_one_.real[k] * s.input_gain.imaginary[k] +
                     pole_minus_one_.imaginary[k] * s.input_gain.real[k];
        later += static_cast<double>(w.real[k] * im + w.imaginary[k] * re);
      }
      direct[1] = direct[0] + later;
    }
  }
  void add_force_to_outputs(std::size_t slot, std::size_t lag, double force) noexcept {
    if (!slots_[slot].direct_output_valid)
      compute_direct_output(slot);
    for (std::size_t l = 0; l < listening_; ++l)
      pass_.outputs[l] += force * direct_output_[slot * pickups_.size() + l][lag];
  }

  const ContactKernel<T>* kernel_;
  std::size_t modes_, padded_ = 0, listening_ = 0;
  unsigned max_steps_;
  std::vector<double> alpha_, omega_, inverse_omega_, inverse_square_;
  Split<double> finest_,
      force_response_;      ///< p - 1 of the shortest step; (p - 1)/s of the present step
  Split<T> pole_minus_one_; ///< p - 1 of the present step
  Split<T> state_;          ///< z before the forces of pass_
  std::vector<Slot> slots_;
  std::vector<Split<T>> weights_;
  std::vector<ConstSplitView<T>> pickups_;
  std::vector<DirectOutput> direct_output_;
  ContactPass<T> pass_;
  std::size_t pending_slot_ = static_cast<std::size_t>(-1); ///< the slot whose forces pass_ holds
  bool outputs_valid_ = false; ///< pass_.outputs are those of the present state
};

} // namespace

std::unique_ptr<ContactModes> ContactModes::make(std::span<const Complex> rate, double sample_rate,
                                                 unsigned max_steps, std::size_t contacts,
                                                 std::size_t listeners, VectorSet widest) {
  if (rate.size() <= kMaxModesInDouble)
    return std::make_unique<ModesOf<double>>(rate, sample_rate, max_steps, contacts, listeners,
                                             widest);
  return std::make_unique<ModesOf<float>>(rate, sample_rate, max_steps, contacts, listeners,
                                          widest);
}

} // namespace tactus::modal
