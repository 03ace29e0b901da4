#pragma once

#include "max/stub/guarded.hpp"
#include "max/stub/kernel.hpp"

#include <functional>
#include <memory>

/// The signal chain: who performs, with which vectors.
namespace tactus::stub {

/// Fills a vector with an inlet's signal, from a sample of the run on.
using Source = std::function<void(std::span<double> vector, std::uint64_t sample)>;
struct Input {
  Source source{};       ///< none: not connected
  Object* box = nullptr; ///< instead: another box's outlet
  std::size_t outlet = 0;
  [[nodiscard]] bool connected() const { return source || box; }
};

/// A box in the chain: what it added by dsp_add64, its inputs and outputs.
struct Performer {
  struct Entry {
    t_perfroutine64 function;
    long flags;
    void* user;
  };
  Object* object = nullptr;
  std::vector<Input> inputs{};
  std::vector<Entry> entries{}, added{}; ///< that perform; that dsp64 adds just now
  std::vector<std::unique_ptr<GuardedVector>> in{}, out{};
  std::vector<std::vector<double>> kept{}; ///< copies of inputs, to see whether they were written
  bool no_inplace = false;
  std::vector<double>* recorded = nullptr; ///< outputs, interleaved
  struct Level {
    double peak = 0, square_sum = 0;
    std::uint64_t samples = 0, not_finite = 0;
  };
  std::vector<Level> levels{};
};

enum class Inplace { kOff, kSame, kCrossed };
struct AudioSettings {
  double sample_rate = 48000;
  long vector = 64, max_vector = 64;
  Inplace inplace = Inplace::kOff;
  bool zeros_unconnected =
      false; ///< Max's zeros for inlets without a cord, else memory that may not be read
};
[[nodiscard]] AudioSettings& audio_settings();

Performer& performer_of(Object& object); ///< made when asked for
/// Connects an inlet, between two vectors.
void connect_input(Object& object, std::size_t inlet, Input input);
/// Compiles the chain again: dsp64 of every box.
void start_dsp();
void stop_dsp();
[[nodiscard]] bool dsp_runs();
/// Lets all boxes perform one vector, in the audio thread's role.
void perform_vector();
/// Takes a box out, waiting for the vector that is performed now.
void remove_from_chain(Object& object);
[[nodiscard]] std::uint64_t sample_position();

void make_buffer(const std::string& name, long channels, const std::vector<float>& samples);
void free_clock(Record& record);

} // namespace tactus::stub
