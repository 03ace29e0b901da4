#pragma once

#include "core/object.hpp"
#include "programs/describe/describe.hpp"
#include "tests/pd/host/host.h"

#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// The stub host for C++: real modules, driven by tests.
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
  double ms;
  std::string selector;
  MessageAtoms atoms;
};

/// Every object of the package, and the probe, with its module loaded.
[[nodiscard]] const std::vector<ObjectDescription>& objects();

/// Buffers of one object's signal ports: [port][sample].
using Buffers = std::vector<std::vector<double>>;
[[nodiscard]] Buffers part_of(const Buffers& whole, std::size_t begin, std::size_t frames);
void append(Buffers& whole, const Buffers& part);

/// An instance of a class.
class Box {
public:
  explicit Box(std::string_view name, const MessageAtoms& arguments = {});
  [[nodiscard]] bool made() const { return object_ != nullptr; }
  [[nodiscard]] host_object* get() const { return object_.get(); }
  void send(int inlet, std::string_view selector, const MessageAtoms& atoms = {});
  void send(std::string_view selector, const MessageAtoms& atoms = {}) { send(0, selector, atoms); }
  void dsp(double rate, int frames, int channels = 1, bool alias = false);
  /// Runs the samples through in blocks of the current size, letting logical time pass; inputs has
  /// a buffer for each signal inlet (an empty one: not connected), whole blocks long.
  [[nodiscard]] Buffers run(const Buffers& inputs, std::size_t samples);
  [[nodiscard]] int signal_inlets() const { return host_inlets(object_.get(), 1); }
  [[nodiscard]] int signal_outlets() const { return host_outlets(object_.get(), 1); }

private:
  struct Deleter {
    void operator()(host_object* object) const { host_drop(object); }
  };
  std::unique_ptr<host_object, Deleter> object_;
  double rate_ = 0;
  std::size_t frames_ = 0, channels_ = 1;
  bool has_dsp_ = false;
};

/// What was said and sent since the last call; both forget it.
[[nodiscard]] std::vector<std::string> errors();
[[nodiscard]] std::vector<Sent> sent();

/// For every signal inlet what is plausible for its unit (a pressure swells and ebbs, a frequency
/// wanders), of no more digits than a float has.
[[nodiscard]] Buffers plausible_inputs(const Declaration& declaration, double rate,
                                       std::size_t samples);

} // namespace tactus::test
