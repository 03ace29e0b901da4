#pragma once

#include "core/object.hpp"
#include "programs/describe/describe.hpp"

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// A small host that loads Pd externals without Pd, so that tests can drive them at any block size,
/// rate and float size, see every error sentence and outlet message, and step logical time.
/// Not thread-safe, but for pd_queue_mess.
namespace tactus::test {

/// One message atom that owns its word.
struct MessageAtom {
  std::string text;
  double number = 0;
  bool is_word = false;

  MessageAtom(double value) : number(value) {}
  MessageAtom(std::string word) : text(std::move(word)), is_word(true) {}
  MessageAtom(const char* word) : text(word), is_word(true) {}
  bool operator==(const MessageAtom&) const = default;
};
using MessageAtoms = std::vector<MessageAtom>;

/// A message that left an outlet.
struct Sent {
  int outlet;
  double ms; ///< logical time
  std::string selector;
  MessageAtoms atoms;
};

/// What was said and sent since the last call of any of these, which forget it.
struct Heard {
  std::vector<std::string> errors;
  std::vector<Sent> sent;
};
Heard heard();
[[nodiscard]] inline std::vector<std::string> errors() { return heard().errors; }
[[nodiscard]] inline std::vector<Sent> sent() { return heard().sent; }

/// Buffers of one object's signal ports: [port][sample].
using Buffers = std::vector<std::vector<double>>;
[[nodiscard]] Buffers part_of(const Buffers& whole, std::size_t begin, std::size_t frames);
void append(Buffers& whole, const Buffers& part);

/// Every object of the package, and the probe, with its module loaded.
[[nodiscard]] const std::vector<ObjectDescription>& objects();

struct HostObject;

/// An instance of a class, as typing its name and arguments into a box.
class Box {
public:
  explicit Box(std::string_view name, const MessageAtoms& arguments = {})
      : object_((static_cast<void>(objects()), make(name, arguments))) {}
  [[nodiscard]] bool made() const { return object_ != nullptr; }
  [[nodiscard]] std::size_t inlets() const; ///< of signals and messages
  /// Dispatched as Pd does.
  void send(std::size_t inlet, std::string_view selector, const MessageAtoms& atoms = {});
  void send(std::string_view selector, const MessageAtoms& atoms = {}) { send(0, selector, atoms); }
  /// Calls the dsp method. channels: of every signal inlet, for hosts with multichannel signals.
  /// alias: outputs use the inputs' memory, as Pd likes to do.
  void dsp(double rate, int frames, int channels = 1, bool alias = false) {
    dsp(rate, frames, std::vector<int>{channels}, alias);
  }
  /// Of each inlet; the last for those beyond.
  void dsp(double rate, int frames, const std::vector<int>& channels, bool alias = false);
  /// Runs the samples through in blocks of the current size, letting logical time pass; inputs has
  /// a buffer for each signal inlet, whole blocks long. An empty one is not connected: the inlet's
  /// number is then the signal. within_tick: time stands still, as in a window of blocks shorter
  /// than Pd's tick.
  [[nodiscard]] Buffers run(const Buffers& inputs, std::size_t samples, bool within_tick = false);

private:
  [[nodiscard]] static HostObject* make(std::string_view name, const MessageAtoms& arguments);
  struct Deleter {
    void operator()(HostObject* object) const;
  };
  std::unique_ptr<HostObject, Deleter> object_;
};

/// Loads a module and calls its setup function; what went wrong, or an empty sentence.
[[nodiscard]] std::string load_module(const std::string& file, const std::string& setup);
/// Lets logical time pass and runs the clocks that are due; also delivers queued messages.
void advance(double ms);
[[nodiscard]] double now_ms();
/// Clocks that objects have made and not freed.
[[nodiscard]] std::size_t clock_count();
/// Whether this host is as new as Pd 0.56, with several channels in a signal.
[[nodiscard]] bool is_newer();
/// A named array that objects can read, and the folder that file names are relative to.
void set_array(const char* name, const std::vector<double>& values);
void set_folder(const char* folder);

/// For every signal inlet what is plausible for its unit (a pressure swells and ebbs, a frequency
/// wanders).
[[nodiscard]] Buffers plausible_inputs(const Declaration& declaration, double rate,
                                       std::size_t samples);

/// The first signal outlet with a sample that is not finite, or with sound beyond 1; or none.
[[nodiscard]] std::string bad_outlet(const Buffers& outputs, const Declaration& declaration);

} // namespace tactus::test
