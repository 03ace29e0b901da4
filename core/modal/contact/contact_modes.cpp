#include "core/modal/contact/contact_modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace tactus::modal {
namespace {

template <class T> class ModesOf final : public ContactModes {
public:
  ModesOf(std::span<const std::complex<double>> rate, double sample_rate, unsigned most_steps,
          std::size_t contacts, std::size_t listeners, VectorSet set)
      : kernel_(contact_kernel<T>(set)), modes_(rate.size()), most_steps_(most_steps),
        alpha_(modes_, 0), omega_(modes_, 1), inverse_omega_(modes_, 1), inverse_square_(modes_, 1),
        finest_(modes_), change_(modes_), turn_(modes_), state_(modes_), slots_(contacts),
        weights_(std::min(listeners, ContactPass<T>::kMostEars), Split<T>(modes_)),
        ears_(weights_.size()), echo_(contacts * weights_.size()) {
    padded_ = state_.real.padded();
    pass_.count = padded_;
    pass_.z = state_.view();
    pass_.turn = std::as_const(turn_).view();
    pass_.ear = ears_.data();
    for (std::size_t k = 0; k < modes_; ++k) {
      alpha_[k] = -rate[k].real();
      omega_[k] = rate[k].imag();
      inverse_omega_[k] = 1 / omega_[k];
      inverse_square_[k] = 1 / (alpha_[k] * alpha_[k] + omega_[k] * omega_[k]);
      // exp(x + j y) - 1 without the difference
      const double x = rate[k].real() / (sample_rate * most_steps);
      const double y = rate[k].imag() / (sample_rate * most_steps);
      const double half = std::sin(0.5 * y);
      finest_.real[k] = std::expm1(x) - 2 * std::exp(x) * half * half;
      finest_.imaginary[k] = std::exp(x) * std::sin(y);
    }
    for (Slot& slot : slots_) {
      slot.gain = slot.place_gain = LaneArray<T>(modes_);
      slot.push = Split<T>(modes_);
    }
    for (std::size_t l = 0; l < ears_.size(); ++l)
      ears_[l] = std::as_const(weights_[l]).view();
    listening_ = ears_.size();
    set_steps(1);
  }

  void set_steps(unsigned steps) noexcept override {
    settle();
    for (std::size_t k = 0; k < modes_; ++k) {
      double re = finest_.real[k], im = finest_.imaginary[k];
      for (unsigned s = steps; s < most_steps_; s *= 2) { // (1 + t)^2 - 1
        const double twice = 2 * re + re * re - im * im;
        im = 2 * im + 2 * re * im;
        re = twice;
      }
      turn_.real[k] = static_cast<T>(re);
      turn_.imaginary[k] = static_cast<T>(im);
      // t/s, s = -alpha + j omega
      const double inverse = inverse_square_[k];
      change_.real[k] = (im * omega_[k] - re * alpha_[k]) * inverse;
      change_.imaginary[k] = -(re * omega_[k] + im * alpha_[k]) * inverse;
    }
    for (std::size_t i = 0; i < slots_.size(); ++i)
      if (slots_[i].used)
        make_push(i);
  }

  double set_gain(std::size_t slot, std::span<const double> gain) noexcept override {
    settle();
    Slot& s = slots_[slot];
    double squares = 0;
    const std::size_t given = std::min(gain.size(), modes_);
    for (std::size_t k = 0; k < given; ++k) {
      s.gain[k] = static_cast<T>(gain[k]);
      s.place_gain[k] = static_cast<T>(gain[k] * inverse_omega_[k]);
      squares += gain[k] * gain[k];
    }
    for (std::size_t k = given; k < modes_; ++k)
      s.gain[k] = s.place_gain[k] = 0;
    s.used = true;
    make_push(slot);
    return squares;
  }

  void drop(std::size_t slot) noexcept override {
    if (given_to_ == slot)
      settle();
    slots_[slot].used = false;
  }

  [[nodiscard]] double answer(std::size_t to, std::size_t from, std::size_t lag) noexcept override {
    const Split<T>& push = slots_[from].push;
    const T* gain = slots_[to].place_gain.data();
    double sum = kernel_->sum(gain, push.imaginary.data(), padded_);
    if (lag == 0)
      return sum;
    for (std::size_t k = 0; k < modes_; ++k)
      sum += static_cast<double>(
          gain[k] * (turn_.real[k] * push.imaginary[k] + turn_.imaginary[k] * push.real[k]));
    return sum;
  }

  [[nodiscard]] const double* look_ahead(std::size_t slot, std::size_t steps,
                                         bool ends_sample) noexcept override {
    if (given_to_ != slot || pass_.pushes > steps)
      settle();
    if (given_to_ != slot) {
      given_to_ = slot;
      pass_.push = std::as_const(slots_[slot].push).view();
      pass_.gain = slots_[slot].place_gain.data();
    }
    pass_.steps = steps;
    pass_.ears = ends_sample ? listening_ : 0;
    kernel_->advance(pass_);
    pass_.pushes = steps;
    pass_.force[0] = pass_.force[1] = 0;
    heard_ = ends_sample;
    return pass_.place;
  }

  void give(const double* force) noexcept override {
    const std::size_t last = pass_.pushes - 1;
    for (std::size_t j = 0; j <= last; ++j) {
      pass_.force[j] = force[j];
      if (heard_ && force[j] != 0)
        hear_force(given_to_, last - j, force[j]);
    }
  }
  void give_besides(std::size_t slot, double force) noexcept override {
    kernel_->push(state_.view(), std::as_const(slots_[slot].push).view(), force, padded_);
    if (heard_)
      hear_force(slot, 0, force);
  }
  [[nodiscard]] double place_besides(std::size_t slot) noexcept override {
    return kernel_->sum(slots_[slot].place_gain.data(), state_.imaginary.data(), padded_);
  }

  void settle() noexcept override {
    if (given_to_ >= slots_.size())
      return;
    const Slot& s = slots_[given_to_];
    if (pass_.pushes == 2) {
      pass_.pushes = pass_.steps = 1;
      pass_.ears = 0;
      const double last = pass_.force[1];
      kernel_->advance(pass_);
      pass_.force[0] = last;
    }
    if (const double last = pass_.force[pass_.pushes - 1]; last != 0)
      kernel_->push(state_.view(), s.push.view(), last, padded_);
    pass_.pushes = 1;
    pass_.force[0] = pass_.force[1] = 0;
    given_to_ = slots_.size();
  }

  [[nodiscard]] double place(std::size_t slot) noexcept override {
    settle();
    return kernel_->sum(slots_[slot].place_gain.data(), state_.imaginary.data(), padded_);
  }
  [[nodiscard]] double velocity(std::size_t slot) noexcept override {
    settle();
    return kernel_->sum(slots_[slot].gain.data(), state_.real.data(), padded_);
  }

  void set_weight(std::size_t listener,
                  std::span<const std::complex<double>> weight) noexcept override {
    if (listener >= weights_.size())
      return;
    for (std::size_t k = 0; k < std::min(modes_, weight.size()); ++k) {
      weights_[listener].real[k] = static_cast<T>(weight[k].real());
      weights_[listener].imaginary[k] = static_cast<T>(weight[k].imag());
    }
    heard_ = false;
    for (std::size_t i = 0; i < slots_.size(); ++i)
      slots_[i].echo_known = false;
  }
  void set_listening(std::size_t listeners) noexcept override {
    listening_ = std::min(listeners, ears_.size());
    heard_ = false;
  }
  [[nodiscard]] double hear(std::size_t listener) noexcept override {
    if (heard_)
      return pass_.heard[listener];
    settle();
    return kernel_->hear(ears_[listener], std::as_const(state_).view(), padded_);
  }

  [[nodiscard]] double hear(std::span<const std::complex<double>> w) noexcept override {
    settle();
    double sum = 0;
    for (std::size_t k = 0; k < std::min(w.size(), modes_); ++k)
      sum += w[k].real() * static_cast<double>(state_.imaginary[k]) +
             w[k].imag() * static_cast<double>(state_.real[k]);
    return sum;
  }

  void kick(std::span<const float> gain, double impulse) noexcept override {
    if (pass_.pushes > 1) // one force that is still to come in is added to the same state
      settle();
    const std::size_t count = std::min(gain.size(), modes_);
    const T size = static_cast<T>(impulse);
    for (std::size_t k = 0; k < count; ++k)
      state_.real[k] += static_cast<T>(gain[k]) * size;
    for (std::size_t l = 0; l < listening_ && heard_; ++l)
      pass_.heard[l] += impulse * apart(count, [&](std::size_t k) {
                          return static_cast<T>(gain[k]) * ears_[l].imaginary[k];
                        });
  }

  [[nodiscard]] std::complex<double> state(std::size_t k) const noexcept override {
    std::complex<double> z(static_cast<double>(state_.real[k]),
                           static_cast<double>(state_.imaginary[k]));
    if (given_to_ >= slots_.size())
      return z;
    const Split<T>& push = slots_[given_to_].push;
    const std::complex<double> b(static_cast<double>(push.real[k]),
                                 static_cast<double>(push.imaginary[k]));
    const std::complex<double> t(static_cast<double>(turn_.real[k]),
                                 static_cast<double>(turn_.imaginary[k]));
    for (std::size_t j = 0; j < pass_.pushes; ++j) {
      if (j > 0)
        z += t * z;
      z += pass_.force[j] * b;
    }
    return z;
  }
  void set_state(std::size_t k, std::complex<double> z) noexcept override {
    settle();
    heard_ = false;
    state_.real[k] = static_cast<T>(z.real());
    state_.imaginary[k] = static_cast<T>(z.imag());
  }
  void read_states(std::span<std::complex<double>> z) noexcept override {
    settle();
    for (std::size_t k = 0; k < std::min(z.size(), modes_); ++k)
      z[k] = {static_cast<double>(state_.real[k]), static_cast<double>(state_.imaginary[k])};
  }
  void write_states(std::span<const std::complex<double>> z) noexcept override {
    silence();
    for (std::size_t k = 0; k < std::min(z.size(), modes_); ++k) {
      state_.real[k] = static_cast<T>(z[k].real());
      state_.imaginary[k] = static_cast<T>(z[k].imag());
    }
  }
  void silence() noexcept override {
    settle();
    heard_ = false;
    std::fill_n(state_.real.data(), modes_, T{0});
    std::fill_n(state_.imaginary.data(), modes_, T{0});
  }

  [[nodiscard]] Reach reach(std::size_t slot) noexcept override {
    settle();
    // Amplitudes |z| from above without roots: at most a + (sqrt(2) - 1) b of the larger part a
    // and the smaller b, 8 % too much.
    constexpr T kSum = T(0.70711), kDifference = T(0.29290);
    const Slot& s = slots_[slot];
    constexpr std::size_t kApart = 16;
    std::array<T, kApart> place{}, speed{}, place_square{}, speed_square{};
    for (std::size_t first = 0; first < padded_; first += kApart)
      for (std::size_t i = 0; i < kApart; ++i) {
        const std::size_t k = first + i;
        const T re = std::abs(state_.real[k]), im = std::abs(state_.imaginary[k]);
        const T size = kSum * (re + im) + kDifference * std::abs(re - im);
        const T a = std::abs(s.place_gain[k]) * size, b = std::abs(s.gain[k]) * size;
        place[i] += a;
        speed[i] += b;
        place_square[i] += a * a;
        speed_square[i] += b * b;
      }
    Reach reach;
    for (std::size_t i = 0; i < kApart; ++i) {
      reach.place += static_cast<double>(place[i]);
      reach.speed += static_cast<double>(speed[i]);
      reach.place_square += static_cast<double>(place_square[i]);
      reach.speed_square += static_cast<double>(speed_square[i]);
    }
    return reach;
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
    LaneArray<T> gain, place_gain; ///< b and b/omega_d of the modes
    Split<T> push;                 ///< b (p - 1)/s
    bool used = false, echo_known = false;
  };
  /// What a listener hears at once of 1 N in the last step, and of 1 N in the one before.
  using Echo = std::array<double, kMostAhead>;

  /// Sum of part(k), in several sums that do not wait for each other.
  template <class Part> static double apart(std::size_t count, const Part& part) noexcept {
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

  void make_push(std::size_t slot) noexcept {
    Slot& s = slots_[slot];
    for (std::size_t k = 0; k < modes_; ++k) {
      const auto b = static_cast<double>(s.gain[k]);
      s.push.real[k] = static_cast<T>(b * change_.real[k]);
      s.push.imaginary[k] = static_cast<T>(b * change_.imaginary[k]);
    }
    s.echo_known = false;
  }

  void find_echo(std::size_t slot) noexcept {
    Slot& s = slots_[slot];
    s.echo_known = true;
    for (std::size_t l = 0; l < listening_; ++l) {
      Echo& echo = echo_[slot * ears_.size() + l];
      const ConstSplitView<T> w = ears_[l];
      echo[0] = kernel_->hear(w, std::as_const(s.push).view(), padded_);
      double later = 0;
      for (std::size_t k = 0; k < modes_; ++k) {
        const T re = turn_.real[k] * s.push.real[k] - turn_.imaginary[k] * s.push.imaginary[k];
        const T im = turn_.real[k] * s.push.imaginary[k] + turn_.imaginary[k] * s.push.real[k];
        later += static_cast<double>(w.real[k] * im + w.imaginary[k] * re);
      }
      echo[1] = echo[0] + later;
    }
  }
  void hear_force(std::size_t slot, std::size_t lag, double force) noexcept {
    if (!slots_[slot].echo_known)
      find_echo(slot);
    for (std::size_t l = 0; l < listening_; ++l)
      pass_.heard[l] += force * echo_[slot * ears_.size() + l][lag];
  }

  const ContactKernel<T>* kernel_;
  std::size_t modes_, padded_ = 0, listening_ = 0;
  unsigned most_steps_;
  std::vector<double> alpha_, omega_, inverse_omega_, inverse_square_;
  Split<double> finest_, change_; ///< p - 1 of the shortest step; (p - 1)/s of the step at work
  Split<T> turn_;                 ///< p - 1 of the step at work
  Split<T> state_;                ///< z before the forces of pass_
  std::vector<Slot> slots_;
  std::vector<Split<T>> weights_;
  std::vector<ConstSplitView<T>> ears_;
  std::vector<Echo> echo_;
  ContactPass<T> pass_;
  std::size_t given_to_ = static_cast<std::size_t>(-1); ///< whose forces pass_ holds
  bool heard_ = false;                                  ///< pass_.heard is of now
};

} // namespace

std::unique_ptr<ContactModes> ContactModes::make(std::span<const std::complex<double>> rate,
                                                 double sample_rate, unsigned most_steps,
                                                 std::size_t contacts, std::size_t listeners,
                                                 VectorSet set) {
  if (!contact_kernel<double>(set))
    set = VectorSet::kBaseline;
  if (rate.size() <= kMostInDouble)
    return std::make_unique<ModesOf<double>>(rate, sample_rate, most_steps, contacts, listeners,
                                             set);
  return std::make_unique<ModesOf<float>>(rate, sample_rate, most_steps, contacts, listeners, set);
}

} // namespace tactus::modal
