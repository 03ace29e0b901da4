// STK's BiQuad, Csound's mode opcode and a plain loop, as banks of modes.
#include "bench/modal_bank/peers.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#ifdef TACTUS_HAS_STK
#include <stk/BiQuad.h>
#endif
#ifdef TACTUS_HAS_CSOUND
#include <csound/csound.h>
#endif

namespace {

double frequency(std::size_t i, std::size_t modes) {
  return 50 + 20000.0 * static_cast<double>(i) / static_cast<double>(modes);
}

/// The recursion as a textbook has it: a complex rotation a mode, mode by mode, sample by sample.
class Loop final : public Peer {
public:
  explicit Loop(std::size_t modes) : p_(modes), z_(modes) {
    for (std::size_t i = 0; i < modes; ++i)
      p_[i] = std::polar(0.9999F,
                         static_cast<float>(2 * std::numbers::pi * frequency(i, modes) / 48000));
  }
  void block(const float* in, float* out) override {
    for (std::size_t n = 0; n < 64; ++n) {
      float sum = 0;
      for (std::size_t i = 0; i < p_.size(); ++i) {
        const float re = p_[i].real() * z_[i].real() - p_[i].imag() * z_[i].imag() + in[n];
        const float im = p_[i].real() * z_[i].imag() + p_[i].imag() * z_[i].real();
        z_[i] = {re, im};
        sum += im;
      }
      out[n] = sum;
    }
  }

private:
  std::vector<std::complex<float>> p_, z_;
};

#ifdef TACTUS_HAS_STK
class StkBank final : public Peer {
public:
  explicit StkBank(std::size_t modes) {
    if (stk::Stk::sampleRate() != 48000)
      stk::Stk::setSampleRate(48000);
    bank_.resize(modes);
    for (std::size_t i = 0; i < modes; ++i)
      bank_[i].setResonance(frequency(i, modes), 0.9999, true);
  }
  void block(const float* in, float* out) override {
    for (std::size_t n = 0; n < 64; ++n) {
      double sum = 0;
      for (stk::BiQuad& filter : bank_)
        sum += filter.tick(static_cast<double>(in[n]));
      out[n] = static_cast<float>(sum);
    }
  }

private:
  std::vector<stk::BiQuad> bank_;
};
#endif

#ifdef TACTUS_HAS_CSOUND
class CsoundBank final : public Peer {
public:
  explicit CsoundBank(std::size_t modes) {
    std::string program =
        "sr=48000\nksmps=64\nnchnls=1\nnchnls_i=1\n0dbfs=1\ninstr 1\nain in\nasum = 0\n";
    for (std::size_t i = 0; i < modes; ++i)
      program += "am" + std::to_string(i) + " mode ain, " + std::to_string(frequency(i, modes)) +
                 ", 2000\nasum = asum + am" + std::to_string(i) + "\n";
    program += "out asum\nendin\n";
    for (const char* option : {"-n", "-d", "-m0"})
      csoundSetOption(csound_, option);
    csoundCompileOrc(csound_, program.c_str());
    csoundReadScore(csound_, "i 1 0 100000\n");
    csoundStart(csound_);
  }
  ~CsoundBank() override { csoundDestroy(csound_); }
  void block(const float* in, float* out) override {
    MYFLT* spin = csoundGetSpin(csound_);
    for (std::size_t n = 0; spin && n < 64; ++n)
      spin[n] = static_cast<MYFLT>(in[n]);
    csoundPerformKsmps(csound_);
    const MYFLT* spout = csoundGetSpout(csound_);
    for (std::size_t n = 0; spout && n < 64; ++n)
      out[n] = static_cast<float>(spout[n]);
  }

private:
  CSOUND* csound_ = csoundCreate(nullptr);
};
#endif

} // namespace

std::unique_ptr<Peer> make_loop(std::size_t modes) { return std::make_unique<Loop>(modes); }

std::unique_ptr<Peer> make_stk(std::size_t modes) {
#ifdef TACTUS_HAS_STK
  return std::make_unique<StkBank>(modes);
#else
  static_cast<void>(modes);
  return nullptr;
#endif
}

std::unique_ptr<Peer> make_csound(std::size_t modes) {
#ifdef TACTUS_HAS_CSOUND
  return std::make_unique<CsoundBank>(modes);
#else
  static_cast<void>(modes);
  return nullptr;
#endif
}
