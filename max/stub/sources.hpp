#pragma once

#include "max/stub/audio.hpp"

namespace tactus::stub {

/// A test signal from words: "constant 0.5", "sine 440 0.5 [PHASE]" (Hz, amplitude, radians),
/// "noise SEED AMPLITUDE", "impulse SAMPLE", "nan", "inf", "file PATH" (float64), "wav PATH
/// [CHANNEL]". Throws std::runtime_error.
///
/// Noise: sample n is AMPLITUDE * (2 u - 1), u = (splitmix64(SEED + n) >> 11) * 2^-53.
[[nodiscard]] Source make_source(std::span<const std::string> words);

/// Samples of a float64 file, or of a channel of a WAV file (PCM of 16, 24, 32 bit, float of 32,
/// 64).
[[nodiscard]] std::vector<double> read_samples(const std::string& file);
[[nodiscard]] std::vector<double> read_wav(const std::string& file, std::size_t channel);
void write_samples(const std::string& file, std::span<const double> samples);

} // namespace tactus::stub
