#include "max/stub/sources.hpp"
#include "files/utf8_path.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>

namespace tactus::stub {
namespace {

std::string read_file(const std::string& file) {
  std::ifstream stream(utf8_path(file), std::ios::binary);
  if (!stream)
    throw std::runtime_error("cannot read " + file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

double number(std::span<const std::string> words, std::size_t index, double otherwise) {
  return index < words.size() ? std::stod(words[index]) : otherwise;
}

std::uint64_t splitmix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

Source of_function(std::function<double(std::uint64_t)> f) {
  return [f = std::move(f)](std::span<double> vector, std::uint64_t sample) {
    for (double& v : vector)
      v = f(sample++);
  };
}
Source of_samples(std::vector<double> samples) {
  auto shared = std::make_shared<const std::vector<double>>(std::move(samples));
  return of_function([shared](std::uint64_t n) { return n < shared->size() ? (*shared)[n] : 0.0; });
}

std::uint32_t little(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count && at + i < bytes.size(); ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return value;
}
double wav_sample(std::string_view bytes, std::size_t at, bool is_float, std::size_t size) {
  if (is_float && size == 8)
    return std::bit_cast<double>(little(bytes, at, 4) |
                                 (static_cast<std::uint64_t>(little(bytes, at + 4, 4)) << 32));
  if (is_float)
    return static_cast<double>(std::bit_cast<float>(little(bytes, at, 4)));
  const std::uint32_t left = little(bytes, at, size) << (32 - 8 * size);
  return static_cast<double>(static_cast<std::int32_t>(left)) / 2147483648.0;
}
} // namespace

Source make_source(std::span<const std::string> words) {
  const std::string kind = words.empty() ? "" : words[0];
  const double first = kind == "file" || kind == "wav" ? 0 : number(words, 1, 0);
  if (kind == "constant")
    return of_function([first](std::uint64_t) { return first; });
  if (kind == "sine") {
    const double amplitude = number(words, 2, 1), phase = number(words, 3, 0);
    const double step = 2 * std::numbers::pi * first / audio_settings().sample_rate;
    return of_function([=](std::uint64_t n) {
      return amplitude * std::sin(phase + step * static_cast<double>(n));
    });
  }
  if (kind == "noise") {
    const auto seed = static_cast<std::uint64_t>(first);
    const double amplitude = number(words, 2, 1);
    return of_function([=](std::uint64_t n) {
      return amplitude * (2 * static_cast<double>(splitmix64(seed + n) >> 11) * 0x1p-53 - 1);
    });
  }
  if (kind == "impulse") {
    const auto at = static_cast<std::uint64_t>(first);
    return of_function([at](std::uint64_t n) { return n == at ? 1.0 : 0.0; });
  }
  if (kind == "nan")
    return of_function([](std::uint64_t) { return std::numeric_limits<double>::quiet_NaN(); });
  if (kind == "inf")
    return of_function([](std::uint64_t) { return std::numeric_limits<double>::infinity(); });
  if (kind == "file" && words.size() > 1)
    return of_samples(read_samples(words[1]));
  if (kind == "wav" && words.size() > 1)
    return of_samples(read_wav(words[1], static_cast<std::size_t>(number(words, 2, 0))));
  throw std::runtime_error("no test signal: " + kind);
}

std::vector<double> read_samples(const std::string& file) {
  const std::string bytes = read_file(file);
  std::vector<double> samples(bytes.size() / sizeof(double));
  std::memcpy(samples.data(), bytes.data(), samples.size() * sizeof(double));
  return samples;
}

std::vector<double> read_wav(const std::string& file, std::size_t channel) {
  const std::string bytes = read_file(file);
  if (bytes.size() < 12 || bytes.compare(0, 4, "RIFF") != 0 || bytes.compare(8, 4, "WAVE") != 0)
    throw std::runtime_error(file + " is no WAV file");
  std::size_t channels = 0, size = 0;
  bool is_float = false;
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const std::string_view name(bytes.data() + at, 4);
    const std::size_t length = little(bytes, at + 4, 4);
    at += 8;
    if (name == "fmt ") {
      const std::uint32_t format = little(bytes, at, 2);
      is_float = (format == 0xFFFE ? little(bytes, at + 24, 2) : format) == 3;
      channels = little(bytes, at + 2, 2);
      size = little(bytes, at + 14, 2) / 8;
    } else if (name == "data") {
      if (channels == 0 || channel >= channels || size < 2 || size > 8)
        break;
      std::vector<double> samples;
      const std::size_t end = std::min(at + length, bytes.size());
      for (std::size_t s = at + channel * size; s + size <= end; s += channels * size)
        samples.push_back(wav_sample(bytes, s, is_float, size));
      return samples;
    }
    at += length + length % 2;
  }
  throw std::runtime_error(file + " has no such channel, or another format than PCM or float");
}

void write_samples(const std::string& file, std::span<const double> samples) {
  std::ofstream stream(utf8_path(file), std::ios::binary);
  stream.write(reinterpret_cast<const char*>(samples.data()),
               static_cast<std::streamsize>(samples.size_bytes()));
  if (!stream.flush())
    throw std::runtime_error("cannot write " + file);
}

} // namespace tactus::stub
