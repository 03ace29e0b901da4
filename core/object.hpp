#pragma once

#include "core/declaration.hpp"

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The interface between an object (an external) and the program that hosts it, Pd. An object is a
/// class with a `static const Declaration declaration`, whose rows set its parameters and carry out
/// its messages (core/rows.hpp), and those of the following members that it needs:
///
///   void prepare(double sample_rate, std::size_t max_block);   may allocate; keeps physical state
///   void scalar(std::size_t inlet, double value, Host&);       a number to a control inlet
///   void list(std::size_t inlet, std::span<const Atom>, Host&);  a list to an inlet of that kind
///   template <class S> void process(const Block<S>&) noexcept; audio; inputs may alias outputs
///   void report(Host&);              after a block: control outlets; in some hosts by the audio
///                                    thread, so it allocates nothing
///   void tick(std::size_t timer, Host&);                       answer to Host::wake_in
///   void posted(Host&);                                        answer to Host::wake_from_thread
///   void created(Host&);                                       once, after the creation arguments
///   void dump_first(Host&);          lines before the parameters, which refine them: a preset
///   void dump(Host&);                more lines after the parameters; both change nothing, since
///                                    `get NAME` runs them for one line
///   static constexpr std::size_t timers = N;                   timers used with wake_in
///   static constexpr bool multichannel = true;                 one copy of the object per channel
namespace tactus {

/// A number or a word of a message. A word is valid only during the call.
struct Atom {
  double number = 0;
  std::string_view word{};
  bool is_word = false;

  Atom(double value) : number(value) {}
  Atom(std::string_view text) : word(text), is_word(true) {}
  Atom(const char* text) : word(text), is_word(true) {}
};

/// The functions of the host that an object may call; never from process().
class Host {
public:
  virtual ~Host() = default;
  /// Sends to an outlet: one number as a float, several as a list, with a leading word as a
  /// message.
  virtual void send(std::size_t outlet, std::span<const Atom> atoms) = 0;
  /// Sends to the info outlet (kInfoOutlet).
  virtual void info(std::span<const Atom> atoms) = 0;
  /// Prints an error of one sentence; the host puts the object's name in front.
  virtual void error(std::string_view sentence) = 0;
  virtual void log(std::string_view sentence) = 0;
  /// Calls tick(timer) after this logical time, in place of an earlier request of this timer; a
  /// negative time cancels it.
  virtual void wake_in(std::size_t timer, double milliseconds) = 0;
  /// Logical time since the object was made, ms.
  [[nodiscard]] virtual double now_ms() const = 0;
  /// Logical time at which the object was made, ms on a clock that all objects share.
  [[nodiscard]] virtual double created_ms() const { return 0; }
  /// Full path of an existing file, searched beside the patch and in the search path; empty if
  /// there is none.
  [[nodiscard]] virtual std::string find_file(std::string_view name) const = 0;
  /// Full path for a file to be written; relative names are beside the patch.
  [[nodiscard]] virtual std::string new_file(std::string_view name) const = 0;
  /// Copies the host's named array; false if there is none.
  virtual bool read_array(std::string_view name, std::vector<double>& values) const = 0;
  /// False if the host renders as fast as it can, so that its time is not real time.
  [[nodiscard]] virtual bool real_time() const { return true; }
  /// Publishes a pointer under a name to the objects of all modules. Null withdraws it, as does the
  /// end of the object. Returns false while another object holds the name. The name must state the
  /// type and its version, because the pointer has none.
  virtual bool publish(std::string_view name, const std::shared_ptr<void>& what) {
    return static_cast<void>(name), static_cast<void>(what), false;
  }
  /// The pointer published under this name now; null if there is none.
  [[nodiscard]] virtual std::shared_ptr<void> find_published(std::string_view name) const {
    return static_cast<void>(name), nullptr;
  }
  /// Requests a call of posted() in host time. The only function that any thread may call.
  virtual void wake_from_thread() noexcept = 0;

  void send(std::size_t outlet, std::initializer_list<Atom> atoms) {
    send(outlet, std::span<const Atom>(atoms.begin(), atoms.size()));
  }
  void info(std::initializer_list<Atom> atoms) {
    info(std::span<const Atom>(atoms.begin(), atoms.size()));
  }
};

/// One block of audio: `frames` samples of every signal inlet and outlet, in declared order,
/// without the control ports.
template <class S> struct Block {
  std::span<const S* const> inputs;
  std::span<S* const> outputs;
  std::size_t frames;
  /// Logical time of the first sample, on the clock of Host::now_ms(); NaN if unknown.
  double start_ms = std::numeric_limits<double>::quiet_NaN();
  /// Logical time at which the host plays the first output sample. It is later than start_ms if a
  /// re-blocked window is longer than the host's tick, because the host has to collect the inputs
  /// of the whole window first; the delay is the difference of the two lengths.
  double output_ms = std::numeric_limits<double>::quiet_NaN();

  [[nodiscard]] std::span<const S> in(std::size_t i) const { return {inputs[i], frames}; }
  [[nodiscard]] std::span<S> out(std::size_t i) const { return {outputs[i], frames}; }
};

/// An object of any type, as the shell calls it. S is the host's sample type.
template <class S> class AnyObject {
public:
  virtual ~AnyObject() = default;
  virtual void prepare(double sample_rate, std::size_t max_block) = 0;
  virtual void set(std::size_t parameter, double value) = 0;
  [[nodiscard]] virtual double get(std::size_t parameter) const = 0;
  virtual void message(std::size_t index, std::span<const Atom> arguments, Host& host) = 0;
  virtual void scalar(std::size_t inlet, double value, Host& host) = 0;
  virtual void list(std::size_t inlet, std::span<const Atom> atoms, Host& host) = 0;
  virtual void process(const Block<S>& block) noexcept = 0;
  virtual void report(Host& host) = 0;
  virtual void tick(std::size_t timer, Host& host) = 0;
  virtual void posted(Host& host) = 0;
  virtual void created(Host& host) = 0;
  virtual void dump_first(Host& host) = 0;
  virtual void dump(Host& host) = 0;
  /// A copy with the same parameters; null when the object cannot be copied.
  [[nodiscard]] virtual AnyObject* clone() const = 0;
};

/// Properties of an object's type that the shell needs before it makes one.
struct Traits {
  const Declaration* declaration;
  bool processes, reports, posts, multichannel, takes_numbers;
  std::size_t timers;
};

template <class T> constexpr Traits traits_of() {
  Traits traits{&T::declaration, false, false, false, false, false, 0};
  traits.processes = requires(T & t, const Block<float>& b) { t.process(b); };
  traits.reports = requires(T & t, Host & h) { t.report(h); };
  traits.posts = requires(T & t, Host & h) { t.posted(h); };
  traits.takes_numbers = requires(T & t, Host & h) { t.scalar(std::size_t{}, 0.0, h); };
  if constexpr (requires { T::multichannel; })
    traits.multichannel = T::multichannel;
  if constexpr (requires { T::timers; })
    traits.timers = T::timers;
  return traits;
}

/// Whether each row of an object's declaration is for that class.
template <class T> consteval bool has_its_rows() {
  const Declaration& d = T::declaration;
  return std::all_of(d.parameters.begin(), d.parameters.end(),
                     [](const Parameter& row) { return row.owner == &kOwner<T>; }) &&
         std::all_of(d.messages.begin(), d.messages.end(),
                     [](const Message& row) { return row.owner == &kOwner<T>; });
}

/// Adapts a plain object to AnyObject; members that the object lacks do nothing.
template <class T, class S> class Adapter final : public AnyObject<S> {
  static_assert(has_its_rows<T>());

public:
  void prepare(double sample_rate, std::size_t max_block) override {
    if constexpr (requires { object_.prepare(sample_rate, max_block); })
      object_.prepare(sample_rate, max_block);
  }
  void set(std::size_t parameter, double value) override {
    T::declaration.parameters[parameter].set(&object_, value);
  }
  double get(std::size_t parameter) const override {
    return T::declaration.parameters[parameter].get(&object_);
  }
  void message(std::size_t index, std::span<const Atom> arguments, Host& host) override {
    const Message& row = T::declaration.messages[index];
    row.run(&object_, row, arguments, host);
  }
  void scalar(std::size_t inlet, double value, Host& host) override {
    if constexpr (requires { object_.scalar(inlet, value, host); })
      object_.scalar(inlet, value, host);
  }
  void list(std::size_t inlet, std::span<const Atom> atoms, Host& host) override {
    if constexpr (requires { object_.list(inlet, atoms, host); })
      object_.list(inlet, atoms, host);
  }
  void process(const Block<S>& block) noexcept override {
    if constexpr (requires { object_.process(block); })
      object_.process(block);
  }
  void report(Host& host) override {
    if constexpr (requires { object_.report(host); })
      object_.report(host);
  }
  void tick(std::size_t timer, Host& host) override {
    if constexpr (requires { object_.tick(timer, host); })
      object_.tick(timer, host);
  }
  void posted(Host& host) override {
    if constexpr (requires { object_.posted(host); })
      object_.posted(host);
  }
  void created(Host& host) override {
    if constexpr (requires { object_.created(host); })
      object_.created(host);
  }
  void dump_first(Host& host) override {
    if constexpr (requires { object_.dump_first(host); })
      object_.dump_first(host);
  }
  void dump(Host& host) override {
    if constexpr (requires { object_.dump(host); })
      object_.dump(host);
  }
  AnyObject<S>* clone() const override {
    if constexpr (requires { T(object_); })
      return new Adapter(*this);
    else
      return nullptr;
  }

private:
  T object_{};
};

} // namespace tactus
