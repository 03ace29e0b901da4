#pragma once

#include "core/command.hpp"
#include "core/guarded.hpp"
#include "core/instance_numbers.hpp"
#include "core/module_object.hpp"
#include "core/published.hpp"
#include "max/abi/max_abi.h"
#include "max/shell/block_clock.hpp"
#include "max/shell/executor.hpp"
#include "max/shell/files.hpp"
#include "max/shell/ports.hpp"
#include "max/shell/signal_inlets.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// One object box in Max: the object behind its executor, its ports, clocks and files. Max's
/// callbacks, in max_class.cpp, translate their arguments and call this.
namespace tactus::max {

class MaxObject;

/// The memory that Max allocates. No constructor runs for it: all C++ members are in self.
struct Instance {
  t_pxobject object; // must be first; control objects use only its first part
  MaxObject* self;   // null if the constructor has failed
};

class MaxObject final : public Host, private Executor::Shell {
public:
  MaxObject(Instance& instance, const ModuleObject<double>& module, InstanceNumbers& numbers);
  ~MaxObject() override;
  MaxObject(const MaxObject&) = delete;
  MaxObject& operator=(const MaxObject&) = delete;

  /// Carries out the creation arguments: positional ones, flags and messages, then Max attributes
  /// (`@name value`). Returns false after one error if they are malformed.
  [[nodiscard]] bool begin(std::span<const Atom> arguments);

  // Messages, for any thread except audio's.
  void number(std::size_t inlet, double value);
  void list(std::size_t inlet, std::span<const Atom> atoms);
  void message(std::string_view name, std::vector<Atom> arguments);
  [[nodiscard]] Atom parameter(std::size_t index) const;
  [[nodiscard]] const Declaration& declaration() const { return declaration_; }

  // For audio. counts[i] is not 0 if something is connected to Max's signal inlet i.
  void prepare(std::span<const short> counts, double sample_rate, long max_frames);
  void perform(std::span<double* const> in, std::span<double* const> out,
               std::size_t frames) noexcept;

  // Functions of Host.
  void send(std::size_t outlet, std::span<const Atom> atoms) override;
  void info(std::span<const Atom> atoms) override;
  void error(std::string_view sentence) override;
  void log(std::string_view sentence) override;
  void wake_in(std::size_t timer, double milliseconds) override;
  [[nodiscard]] double now_ms() const override;
  [[nodiscard]] double created_ms() const override { return creation_ms_; }
  [[nodiscard]] std::string find_file(std::string_view name) const override;
  [[nodiscard]] std::string new_file(std::string_view name) const override;
  bool read_array(std::string_view name, std::vector<double>& values) const override;
  bool publish(std::string_view name, const std::shared_ptr<void>& what) override;
  [[nodiscard]] std::shared_ptr<void> find_published(std::string_view name) const override;
  void wake_from_thread() noexcept override;

private:
  struct Timer {
    MaxObject* owner;
    std::size_t index;
    void* clock;
  };
  static constexpr std::uint32_t kInfo = 0xffffffff; ///< in place of an outlet's index

  // Functions of Executor::Shell.
  [[nodiscard]] bool audio_runs() const override;
  void expect_audio() override;
  void deliver(const Outbox& outbox) override;
  void lost() noexcept override;
  void changed() noexcept override;

  void get(std::span<const Atom> names);
  [[nodiscard]] bool takes_numbers() const noexcept;
  void send_parameter(std::size_t index);
  void post(QueuedCommand::Kind kind, std::size_t index = 0);
  void posted() { post(QueuedCommand::Kind::kPosted); }
  void carry_out_left();
  void notify_changes();
  void nudge();
  void deliver_audio_output();
  void leave_to_main_thread(std::string_view name, std::vector<Atom> arguments);
  void deliver(const Output& output);
  void say_error(std::string_view sentence);
  [[nodiscard]] t_object* box() const { return &instance_.object.z_ob; }
  void run_block(std::span<double* const> in, std::span<double* const> out, std::size_t first,
                 std::size_t frames) noexcept;

  static void on_timer(Timer* timer);
  template <void (MaxObject::*function)()> static void on(MaxObject* self);

  Instance& instance_;
  const Traits& traits_;
  const Declaration& declaration_;
  Ports ports_;
  double creation_ms_; ///< time of creation by the scheduler's clock
  SignalInlets inlets_;
  mutable Files files_;
  std::vector<Timer> timers_;
  void* output_clock_; ///< set by the audio thread when it has written outputs
  void* nudge_clock_;  ///< checks whether audio has stopped with commands pending
  void* posted_element_ = nullptr;
  void* left_element_;    ///< set when messages have been left to the main thread
  void* changed_element_; ///< set when parameters have changed
  std::mutex left_mutex_;
  std::vector<Command> left_;
  std::atomic<bool> prepared_{false}, nudge_set_{false}, notifies_changes_{false};
  std::atomic<unsigned> blocks_{0}, blocks_at_nudge_{0}, lost_{0};
  std::atomic<double> nudge_ms_{50}, sample_rate_{48000};
  unsigned lost_outputs_reported_ = 0;
  PublishedObjects published_;
  // Used by the audio thread only.
  BlockClock block_clock_;
  double block_start_ms_ = 0;
  std::vector<double*> out_;
  InstanceNumbers::Hold hold_;
  std::unique_ptr<Executor> executor_;
};

/// Calls function(object) for an instance; catches every exception, so that none reaches Max.
template <class Function> void guarded(Instance* instance, Function&& function) noexcept {
  if (instance->self)
    tactus::guarded([&] { function(*instance->self); },
                    [&](const char* why) { object_error(&instance->object.z_ob, "%s", why); });
}

/// Makes the Max class of this module from its object's declaration: methods, an attribute for each
/// parameter, and Max's callbacks. `module` must live as long as the module is loaded.
void register_class(const ModuleObject<double>& module);

} // namespace tactus::max
