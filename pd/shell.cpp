#include "pd/shell.hpp"

#include "core/command.hpp"
#include "core/declaration_text.hpp"
#include "core/guarded.hpp"
#include "core/named_lines.hpp"
#include "core/published.hpp"
#include "pd/atoms.hpp"
#include "pd/host_features.hpp"
#include "pd/host_process.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

/// Calls the function with each folder in which the canvas looks for files, until the function
/// returns 0. Declared here because not every Pd installs g_canvas.h.
extern "C" int canvas_path_iterate(const t_canvas* canvas, int (*function)(const char*, void*),
                                   void* data);

namespace tactus::pd {
namespace {

class PdObject;

/// Pd stores every function as one untyped pointer type.
template <class Function> t_method method(Function* function) {
  return reinterpret_cast<t_method>(reinterpret_cast<void (*)()>(function));
}

/// The memory that Pd allocates. No constructor runs for it: all C++ members are in self.
struct Instance {
  t_object object;
  t_float main_inlet; // value of the left signal inlet while no signal is connected
  PdObject* self;
};

struct Timer {
  PdObject* owner;
  std::size_t index;
  t_clock* clock;
};

std::size_t count_signals(std::span<const Port> ports) {
  return static_cast<std::size_t>(std::count_if(ports.begin(), ports.end(), [](const Port& port) {
    return port.kind == Port::Kind::kSignal;
  }));
}

/// Expands a leading ~/ to the user's home folder, as Pd does when it opens a file.
std::string with_home(std::string_view name) {
  const char* home = name.starts_with("~/") ? std::getenv("HOME") : nullptr;
  return home ? home + std::string(name.substr(1)) : std::string(name);
}

/// The C++ part of an instance: the object, its voices and its outlets.
class PdObject final : public Host {
public:
  PdObject(Instance& instance, PdClass& record)
      : instance_(instance), record_(record), declaration_(*record.traits().declaration),
        canvas_(canvas_getcurrent()), creation_time_(clock_getlogicaltime()),
        signal_inlets_(count_signals(declaration_.inlets)),
        signal_outlets_(count_signals(declaration_.outlets)), in_(signal_inlets_),
        out_(signal_outlets_) {
    voices_.emplace_back(record.module->make());
    for (std::size_t i = 0; i < declaration_.parameters.size(); ++i)
      voices_[0]->set(i, initial_value(declaration_.parameters[i], hold_.number()));
    make_ports();
    flood_clock_ = clock_new(this, method(&on_flood));
    timers_.resize(record.traits().timers);
    for (std::size_t i = 0; i < timers_.size(); ++i) {
      timers_[i] = {this, i, nullptr};
      timers_[i].clock = clock_new(&timers_[i], method(&on_timer));
    }
    if (record.traits().reports)
      report_clock_ = clock_new(this, method(&on_report));
    if (record.traits().posts && !host_features().queue_message) {
      post_clock_ = clock_new(this, method(&on_poll));
      clock_delay(post_clock_, kPollMilliseconds);
    }
  }

  ~PdObject() override {
    voices_.clear(); // joins worker threads, after which none calls wake_from_thread
    if (record_.traits().posts && host_features().queue_message)
      host_features().queue_cancel(&instance_.object.ob_pd);
    clock_free(flood_clock_);
    for (Timer& timer : timers_)
      clock_free(timer.clock);
    if (report_clock_)
      clock_free(report_clock_);
    if (post_clock_)
      clock_free(post_clock_);
  }
  PdObject(const PdObject&) = delete;
  PdObject& operator=(const PdObject&) = delete;

  [[nodiscard]] bool begin(int count, const t_atom* atoms) {
    std::vector<Command> commands;
    const std::string refusal = creation_commands(declaration_, to_atoms(count, atoms), commands);
    if (!refusal.empty()) {
      error(refusal);
      return false;
    }
    for (const Command& command : commands)
      run(command);
    voices_[0]->created(*this);
    return true;
  }

  // Callbacks of Pd: each calls members only through enter().
  static void on_message(Instance* instance, t_symbol* selector, int count, t_atom* atoms) {
    instance->self->enter(selector->s_name, &PdObject::receive, selector, count, atoms);
  }
  static void on_dsp(Instance* instance, t_signal** signals) { instance->self->dsp(signals); }
  /// Handles the control inlets right of the first: a number arrives as `_inletN value`, a list as
  /// `_listN ...`.
  template <std::size_t N> static void on_inlet(Instance* instance, t_floatarg value) {
    instance->self->enter("float", &PdObject::scalar, N, static_cast<double>(value));
  }
  template <std::size_t N>
  static void on_list(Instance* instance, t_symbol*, int count, t_atom* atoms) {
    instance->self->enter("list", &PdObject::list, N, count, atoms);
  }

  void send(std::size_t outlet, std::span<const Atom> atoms) override {
    if (outlet < outlets_.size())
      send_to(outlets_[outlet], atoms);
  }
  void info(std::span<const Atom> atoms) override { send_to(info_, atoms); }
  void error(std::string_view sentence) override {
    const std::string_view kind = sentence.substr(0, sentence.find_first_of(" :"));
    if (kind != error_kind_) {
      print_held_errors();
      error_kind_ = kind;
      errors_ = 0;
    }
    if (errors_++ == 0)
      clock_delay(flood_clock_, kFloodMilliseconds);
    if (errors_ > kMaxErrors)
      ++held_errors_;
    else
      print_error(sentence);
  }
  void log(std::string_view sentence) override {
    logpost(&instance_.object, PD_NORMAL, "%.*s: %.*s", static_cast<int>(declaration_.name.size()),
            declaration_.name.data(), static_cast<int>(sentence.size()), sentence.data());
  }
  void wake_in(std::size_t timer, double milliseconds) override {
    if (timer >= timers_.size())
      return;
    if (milliseconds < 0)
      clock_unset(timers_[timer].clock);
    else
      clock_delay(timers_[timer].clock, milliseconds);
  }
  double now_ms() const override { return clock_gettimesince(creation_time_); }
  double created_ms() const override { return clock_gettimesince(0) - now_ms(); }
  std::string find_file(std::string_view name) const override {
    const std::string text = with_home(name);
    if (std::string found = open_in_path(text); !found.empty() || is_absolute(text))
      return found;
    if (const std::string folder = module_folder(); !folder.empty())
      if (std::string found = open_in_path(folder + "/" + text); !found.empty())
        return found;
    return open_in_path(std::string(kLibrary) + "/" + text);
  }
  std::string new_file(std::string_view name) const override {
    char path[MAXPDSTRING];
    canvas_makefilename(canvas_, with_home(name).c_str(), path, MAXPDSTRING);
    return path;
  }
  bool read_array(std::string_view name, std::vector<double>& values) const override {
    t_symbol* symbol = gensym(std::string(name).c_str());
    auto* array = reinterpret_cast<t_garray*>(pd_findbyclass(symbol, garray_class));
    int size = 0;
    t_word* words = nullptr;
    if (!array || !garray_getfloatwords(array, &size, &words))
      return false;
    values.resize(static_cast<std::size_t>(size));
    for (int i = 0; i < size; ++i)
      values[static_cast<std::size_t>(i)] = static_cast<double>(words[i].w_float);
    return true;
  }
  bool real_time() const override { return !runs_in_batch(); }
  bool publish(std::string_view name, const std::shared_ptr<void>& what) override {
    return published_.publish(name, what);
  }
  std::shared_ptr<void> find_published(std::string_view name) const override {
    return tactus::find_published(name);
  }
  void wake_from_thread() noexcept override {
    if (posted_.exchange(true, std::memory_order_acq_rel))
      return;
    if (const auto queue = host_features().queue_message)
      queue(pd_, &instance_.object.ob_pd, nullptr, &on_queued);
  }

private:
  static constexpr double kPollMilliseconds = 5;
  /// Maximum number of errors printed about one message. Above it, only the number of further
  /// errors is printed, every half second.
  static constexpr int kMaxErrors = 100;
  static constexpr double kFloodMilliseconds = 500;
  static constexpr std::string_view kLibrary = "tactus"; // name of its folder within Pd's path
  static constexpr HostPrecision kPrecision =
      sizeof(t_float) == sizeof(float) ? HostPrecision::kSingle : HostPrecision::kDouble;

  /// Calls a member. A failure is printed as one sentence with the message or event that caused it;
  /// returns false then.
  template <class... Parameters, class... Arguments>
  bool enter(const char* event, void (PdObject::*member)(Parameters...),
             Arguments... arguments) noexcept {
    return guarded([&] { (this->*member)(arguments...); },
                   [&](const char* why) {
                     pd_error(&instance_.object, "%.*s: %s: %s",
                              static_cast<int>(declaration_.name.size()), declaration_.name.data(),
                              event, why);
                   });
  }

  void print_error(std::string_view sentence) {
    pd_error(&instance_.object, "%.*s: %.*s", static_cast<int>(declaration_.name.size()),
             declaration_.name.data(), static_cast<int>(sentence.size()), sentence.data());
  }
  void print_held_errors() {
    if (held_errors_ > 0)
      print_error(error_kind_ + ": " + std::to_string(held_errors_) + " more errors");
    held_errors_ = 0;
  }
  /// Called half a second after the first error. While errors continue, it prints only their
  /// number.
  void end_half_second() {
    errors_ = held_errors_ > 0 ? kMaxErrors : 0;
    if (held_errors_ > 0)
      clock_delay(flood_clock_, kFloodMilliseconds);
    print_held_errors();
  }

  void receive(const t_symbol* selector, int count, const t_atom* atoms) {
    const std::string_view name = selector->s_name;
    if (name == "get")
      return get(count, atoms);
    if (name == "dump")
      return dump();
    if (name == "float" || name == "list") {
      if (count == 0) // Pd's empty list is a bang
        return run({"bang", {}});
      const bool number = count == 1 && atoms[0].a_type == A_FLOAT; // [t l] sends a number as a
                                                                    // list
      const bool takes_numbers = signal_inlets_ > 0 || record_.traits().takes_numbers;
      if (takes_numbers && (number || !find_message(declaration_, name)))
        return numbers_to_inlets(to_atoms(count, atoms));
    }
    run({name, to_atoms(count, atoms)});
  }

  void scalar(std::size_t inlet, double value) {
    for (auto& voice : voices_)
      voice->scalar(inlet, value, *this);
  }

  void list(std::size_t inlet, int count, const t_atom* atoms) {
    const std::vector<Atom> given = to_atoms(count, atoms);
    for (auto& voice : voices_)
      voice->list(inlet, given, *this);
  }

  /// Makes one object per channel, and buffers for their signals.
  void prepare(std::size_t channels, double rate, std::size_t frames) {
    while (voices_.size() < channels) {
      std::unique_ptr<AnyObject<t_sample>> copy(voices_[0]->clone());
      if (!copy)
        break;
      for (std::size_t i = 0; i < declaration_.parameters.size(); ++i)
        if (declaration_.parameters[i].seeds)
          copy->set(i, channel_value(declaration_.parameters[i], copy->get(i), voices_.size()));
      voices_.push_back(std::move(copy));
    }
    voices_.resize(std::min(voices_.size(), std::max<std::size_t>(channels, 1)));
    silence_.assign(frames, 0);
    in_.resize(voices_.size() * signal_inlets_);
    out_.resize(voices_.size() * signal_outlets_);
    for (auto& voice : voices_)
      voice->prepare(rate, frames);
  }

  void dsp(t_signal** signals) noexcept {
    const auto& features = host_features();
    const auto frames = static_cast<std::size_t>(signals[0]->s_n);
    std::size_t channels = 1;
    if (record_.traits().multichannel)
      for (std::size_t i = 0; i < signal_inlets_; ++i)
        channels = std::max(channels, static_cast<std::size_t>(channel_count(signals[i])));
    const auto rate = static_cast<double>(signals[0]->s_sr);
    prepared_ = enter("dsp", &PdObject::prepare, channels, rate, frames);
    if (!prepared_)
      voices_.resize(1); // output silence
    if (features.signal_setmultiout && record_.traits().multichannel)
      for (std::size_t i = 0; i < signal_outlets_; ++i)
        features.signal_setmultiout(&signals[signal_inlets_ + i], static_cast<int>(voices_.size()));
    for (std::size_t v = 0; v < voices_.size(); ++v) {
      for (std::size_t i = 0; i < signal_inlets_; ++i) {
        const auto has = static_cast<std::size_t>(channel_count(signals[i]));
        in_[v * signal_inlets_ + i] =
            has == 0 ? silence_.data() : signals[i]->s_vec + (v % has) * frames;
      }
      for (std::size_t i = 0; i < signal_outlets_; ++i)
        out_[v * signal_outlets_ + i] = signals[signal_inlets_ + i]->s_vec + v * frames;
    }
    block_ms_ = 1e3 * static_cast<double>(frames) / rate;
    tick_ms_ = 1e3 * sys_getblksize() / static_cast<double>(sys_getsr());
    dsp_add(&on_perform, 2, this, static_cast<t_int>(frames));
  }

  void make_ports() {
    t_object* object = &instance_.object;
    t_symbol* const signal = gensym("signal");
    inlets_.resize(declaration_.inlets.size());
    for (std::size_t i = 1; i < declaration_.inlets.size(); ++i) {
      if (declaration_.inlets[i].kind == Port::Kind::kSignal)
        inlets_[i] = inlet_new(object, &object->ob_pd, signal, signal);
      else if (declaration_.inlets[i].kind == Port::Kind::kList)
        inlet_new(object, &object->ob_pd, list_, gensym(("_list" + std::to_string(i)).c_str()));
      else
        inlet_new(object, &object->ob_pd, gensym("float"),
                  gensym(("_inlet" + std::to_string(i)).c_str()));
    }
    for (const Port& port : declaration_.outlets) {
      outlets_.push_back(outlet_new(object, port.kind == Port::Kind::kSignal ? signal : nullptr));
      if (port.name == kInfoOutlet)
        info_ = outlets_.back();
    }
    if (!info_)
      info_ = outlet_new(object, nullptr);
  }

  void run(const Command& command) {
    const Request request = resolve(declaration_, command.name, command.arguments, kPrecision);
    if (request.kind == Request::Kind::kRefused)
      return error(request.refusal);
    for (std::size_t channel = 0; channel < voices_.size(); ++channel) {
      if (request.kind == Request::Kind::kParameter)
        voices_[channel]->set(request.index, channel_value(declaration_.parameters[request.index],
                                                           request.value, channel));
      else
        voices_[channel]->message(request.index, command.arguments, *this);
    }
  }

  /// Distributes numbers to the inlets from the left, and sets the rightmost inlet first.
  void numbers_to_inlets(std::span<const Atom> numbers) {
    if (const std::string refusal = list_refusal(declaration_, numbers); !refusal.empty())
      return error(refusal);
    for (std::size_t i = numbers.size(); i-- > 0;) {
      const Port::Kind kind = declaration_.inlets[i].kind;
      const auto number = static_cast<t_float>(numbers[i].number);
      if (kind == Port::Kind::kSignal && i == 0)
        instance_.main_inlet = number;
      else if (kind == Port::Kind::kSignal)
        pd_float(reinterpret_cast<t_pd*>(inlets_[i]), number);
      else if (kind == Port::Kind::kControl)
        scalar(i, numbers[i].number);
      else
        for (auto& voice : voices_)
          voice->list(i, numbers.subspan(i, 1), *this);
    }
  }

  void get(int count, const t_atom* atoms) {
    const std::vector<Atom> names = to_atoms(count, atoms);
    if (names.empty())
      return list_parameters();
    for (const Atom& given : names) {
      const std::string name = text_of(given);
      if (const auto index = find_parameter(declaration_, name))
        send_parameter(*index);
      else if (!send_named_lines(*voices_[0], name, *this))
        error(no_answer_text(declaration_, name));
    }
  }

  void dump() {
    voices_[0]->dump_first(*this);
    list_parameters();
    voices_[0]->dump(*this);
  }

  void list_parameters() {
    for (std::size_t i = 0; i < declaration_.parameters.size(); ++i)
      send_parameter(i);
  }

  void send_parameter(std::size_t index) {
    const Parameter& parameter = declaration_.parameters[index];
    const double value = voices_[0]->get(index);
    const auto choice = static_cast<std::size_t>(std::max(value, 0.0));
    if (choice < parameter.choices.size())
      Host::info({parameter.name, parameter.choices[choice]});
    else
      Host::info({parameter.name, value});
  }

  /// Full path of a file beside the patch or in Pd's path, or of an absolute name; empty if there
  /// is none. It does not use canvas_open, which opens a FIFO and waits for ever.
  [[nodiscard]] std::string open_in_path(const std::string& name) const {
    struct Search {
      const std::string& name;
      std::string found;
      /// Callback of Pd; returns whether to continue.
      int look(std::string path) {
        std::error_code failed;
        if (std::filesystem::is_regular_file(std::u8string(path.begin(), path.end()), failed))
          found = std::move(path);
        return found.empty() ? 1 : 0;
      }
    } search{name, {}};
    char beside[MAXPDSTRING];
    canvas_makefilename(canvas_, name.c_str(), beside, MAXPDSTRING);
    if (search.look(beside) == 1 &&
        !std::filesystem::path(std::u8string(name.begin(), name.end())).is_absolute())
      canvas_path_iterate(
          canvas_,
          [](const char* folder, void* data) {
            auto* const one = static_cast<Search*>(data);
            return one->look(with_home(folder) + "/" + one->name);
          },
          &search);
    return search.found;
  }

  void send_to(t_outlet* outlet, std::span<const Atom> atoms) {
    if (atoms.empty())
      return outlet_bang(outlet);
    std::vector<t_atom> list = to_pd_atoms(atoms);
    const auto count = static_cast<int>(list.size());
    if (atoms[0].is_word)
      outlet_anything(outlet, list[0].a_w.w_symbol, count - 1, list.data() + 1);
    else if (count == 1)
      outlet_float(outlet, list[0].a_w.w_float);
    else
      outlet_list(outlet, list_, count, list.data());
  }

  void perform(std::size_t frames) noexcept {
    const auto guard = host_features().audio_guard;
    if (guard)
      guard(1);
    const double start_ms = block_start_ms();
    if (!prepared_)
      for (t_sample* samples : std::span(out_).first(signal_outlets_))
        std::fill_n(samples, frames, t_sample{});
    for (std::size_t v = 0; prepared_ && v < voices_.size(); ++v)
      voices_[v]->process({std::span(in_).subspan(v * signal_inlets_, signal_inlets_),
                           std::span(out_).subspan(v * signal_outlets_, signal_outlets_), frames,
                           start_ms, start_ms + std::max(block_ms_ - tick_ms_, 0.0)});
    if (guard)
      guard(0);
    if (report_clock_)
      clock_delay(report_clock_, 0);
  }

  void tick(std::size_t timer) { voices_[0]->tick(timer, *this); }
  void report() { voices_[0]->report(*this); }

  /// Logical time of the first sample of the current block. While Pd computes signals, its logical
  /// time is the end of the tick, which is also the end of a block of a tick or more. In a
  /// re-blocked or upsampled window, several shorter blocks follow each other within one tick.
  double block_start_ms() noexcept {
    const double now = now_ms();
    if (now != performed_ms_) {
      performed_ms_ = now;
      next_block_ms_ = now - std::max(block_ms_, tick_ms_);
    }
    const double start = next_block_ms_;
    next_block_ms_ += block_ms_;
    return start;
  }

  void deliver_posts() {
    if (posted_.exchange(false, std::memory_order_acq_rel))
      voices_[0]->posted(*this);
  }

  static t_int* on_perform(t_int* words) {
    reinterpret_cast<PdObject*>(words[1])->perform(static_cast<std::size_t>(words[2]));
    return words + 3;
  }
  static void on_flood(PdObject* self) { self->enter("error", &PdObject::end_half_second); }
  static void on_report(PdObject* self) { self->enter("report", &PdObject::report); }
  static void on_timer(Timer* timer) {
    timer->owner->enter("timer", &PdObject::tick, timer->index);
  }
  static void on_poll(PdObject* self) {
    self->enter("result", &PdObject::deliver_posts);
    clock_delay(self->post_clock_, kPollMilliseconds);
  }
  static void on_queued(t_pd* object, void*) {
    if (object)
      reinterpret_cast<Instance*>(object)->self->enter("result", &PdObject::deliver_posts);
  }

  Instance& instance_;
  PdClass& record_;
  const Declaration& declaration_;
  t_canvas* canvas_;
  t_pdinstance* pd_ = current_instance(); // kept here because worker threads have no instance
  InstanceNumbers::Hold hold_{record_.numbers, pd_};
  t_symbol* list_ = gensym("list"); // not s_list, because each instance has its own
  double creation_time_;
  double block_ms_ = 0, tick_ms_ = 0; // lengths of a block and a tick
  double performed_ms_ = -1, next_block_ms_ = 0;
  std::size_t signal_inlets_, signal_outlets_;
  std::vector<std::unique_ptr<AnyObject<t_sample>>> voices_;
  std::vector<t_inlet*> inlets_; // inlets of the signals right of the first
  std::vector<t_outlet*> outlets_;
  t_outlet* info_ = nullptr;
  std::vector<Timer> timers_;
  t_clock* flood_clock_ = nullptr;
  std::string error_kind_{}; ///< the message that the last error was about
  int errors_ = 0;           ///< errors of this kind in this half second
  int held_errors_ = 0;      ///< number of these errors not printed
  t_clock* report_clock_ = nullptr;
  t_clock* post_clock_ = nullptr;
  std::atomic<bool> posted_{false};
  PublishedObjects published_;
  std::vector<const t_sample*> in_;
  std::vector<t_sample> silence_; // for an inlet whose signal has no channels
  std::vector<t_sample*> out_;
  bool prepared_ = false;
};

void destroy(Instance* instance) { delete instance->self; }

template <std::size_t... N> void add_inlets(t_class* handle, std::index_sequence<N...>) {
  (class_addmethod(handle, method(&PdObject::on_inlet<N + 1>),
                   gensym(("_inlet" + std::to_string(N + 1)).c_str()), A_FLOAT, 0),
   ...);
  (class_addmethod(handle, method(&PdObject::on_list<N + 1>),
                   gensym(("_list" + std::to_string(N + 1)).c_str()), A_GIMME, 0),
   ...);
}

} // namespace

void register_class(PdClass& record, Create create) {
  const Declaration& declaration = *record.traits().declaration;
  int flags = CLASS_DEFAULT;
  if (record.traits().multichannel && host_features().signal_setmultiout)
    flags |= kMultichannelFlag;
  record.handle = class_new(gensym(std::string(declaration.name).c_str()),
                            reinterpret_cast<t_newmethod>(method(create)), method(&destroy),
                            sizeof(Instance), flags, A_GIMME, 0);
  if (record.traits().processes)
    class_addmethod(record.handle, method(&PdObject::on_dsp), gensym("dsp"), A_CANT, 0);
  if (!declaration.inlets.empty() && declaration.inlets[0].kind == Port::Kind::kSignal)
    class_domainsignalin(record.handle, static_cast<int>(offsetof(Instance, main_inlet)));
  add_inlets(record.handle, std::make_index_sequence<7>{});
  class_addanything(record.handle, method(&PdObject::on_message));
}

void* create_instance(PdClass& record, int count, t_atom* atoms) {
  auto* instance = reinterpret_cast<Instance*>(pd_new(record.handle));
  instance->main_inlet = 0;
  instance->self = nullptr;
  bool begun = false;
  guarded(
      [&] {
        instance->self = new PdObject(*instance, record);
        begun = instance->self->begin(count, atoms);
      },
      [&](const char* why) {
        pd_error(instance, "%s: %s", record.traits().declaration->name.data(), why);
      });
  if (begun)
    return instance;
  pd_free(&instance->object.ob_pd);
  return nullptr;
}

} // namespace tactus::pd
