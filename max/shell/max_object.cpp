#include "max/shell/max_object.hpp"

#include "core/declaration_text.hpp"
#include "max/shell/atoms.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace tactus::max {
namespace {

/// Max counts atoms of a message in a short.
constexpr std::size_t kMaxAtoms = 32767;

void send_to(void* outlet, std::span<const Atom> atoms) {
  if (atoms.empty()) {
    outlet_bang(outlet);
    return;
  }
  std::vector<t_atom> list = to_max_atoms(atoms.first(std::min(atoms.size(), kMaxAtoms)));
  const auto count = static_cast<short>(list.size());
  if (atoms[0].is_word)
    outlet_anything(outlet, list[0].a_w.w_sym, static_cast<short>(count - 1), list.data() + 1);
  else if (count == 1)
    outlet_float(outlet, list[0].a_w.w_float);
  else
    outlet_list(outlet, gensym("list"), count, list.data());
}

/// True for an attribute argument of the object or of Max, that is for all except messages of the
/// object.
bool is_attribute(const Declaration& declaration, const Atom& atom) {
  return atom.is_word && atom.word.size() > 1 && atom.word[0] == '@' &&
         !find_message(declaration, atom.word.substr(1));
}
bool is_flag(const Atom& atom) {
  return atom.is_word && atom.word.size() > 1 && (atom.word[0] == '-' || atom.word[0] == '@');
}

double scheduler_ms() noexcept {
  double now = 0;
  clock_getftime(&now);
  return now;
}

} // namespace

// Max's callbacks.
template <void (MaxObject::*function)()> void MaxObject::on(MaxObject* self) {
  guarded(&self->instance_, [](MaxObject& object) { (object.*function)(); });
}
void MaxObject::on_timer(Timer* timer) {
  guarded(&timer->owner->instance_,
          [timer](MaxObject& self) { self.post(QueuedCommand::Kind::kTick, timer->index); });
}

MaxObject::MaxObject(Instance& instance, const ModuleObject<double>& module,
                     InstanceNumbers& numbers)
    : instance_(instance), traits_(module.traits), declaration_(*module.traits.declaration),
      ports_(instance.object, declaration_, traits_.processes), creation_ms_(scheduler_ms()),
      inlets_(declaration_), files_(box()), timers_(traits_.timers),
      output_clock_(clock_new(this, method_of(&on<&MaxObject::deliver_audio_output>))),
      nudge_clock_(clock_new(this, method_of(&on<&MaxObject::nudge>))),
      left_element_(qelem_new(this, method_of(&on<&MaxObject::carry_out_left>))),
      changed_element_(qelem_new(this, method_of(&on<&MaxObject::notify_changes>))),
      hold_(numbers, nullptr) {
  for (std::size_t i = 0; i < timers_.size(); ++i) {
    timers_[i] = {this, i, nullptr};
    timers_[i].clock = clock_new(&timers_[i], method_of(&on_timer));
  }
  if (traits_.posts)
    posted_element_ = qelem_new(this, method_of(&on<&MaxObject::posted>));
  out_.resize(static_cast<std::size_t>(
      std::count_if(declaration_.outlets.begin(), declaration_.outlets.end(),
                    [](const Port& port) { return port.kind == Port::Kind::kSignal; })));
  executor_ = std::make_unique<Executor>(
      module.make(), traits_, static_cast<Executor::Shell&>(*this), *this, hold_.number());
}

MaxObject::~MaxObject() {
  for (void* element : {left_element_, changed_element_})
    qelem_free(element);
  for (void* clock : {output_clock_, nudge_clock_}) {
    clock_unset(clock);
    object_free(clock);
  }
  for (Timer& timer : timers_) {
    clock_unset(timer.clock);
    object_free(timer.clock);
  }
  timers_.clear();
  executor_.reset(); // joins worker threads, after which none calls wake_from_thread
  if (posted_element_)
    qelem_free(posted_element_);
}

bool MaxObject::begin(std::span<const Atom> arguments) {
  std::vector<Atom> own, attributes;
  for (std::size_t i = 0; i < arguments.size();) {
    std::vector<Atom>& to = is_attribute(declaration_, arguments[i]) ? attributes : own;
    do
      to.push_back(arguments[i++]);
    while (i < arguments.size() && !is_flag(arguments[i]));
  }
  std::vector<Command> commands;
  if (const std::string refusal = creation_commands(declaration_, own, commands);
      !refusal.empty()) {
    say_error(refusal);
    return false;
  }
  for (Command& command : commands)
    message(command.name, std::move(command.arguments));
  if (!attributes.empty()) {
    std::vector<t_atom> list = to_max_atoms(attributes);
    attr_args_process(&instance_, static_cast<short>(list.size()), list.data());
  }
  post(QueuedCommand::Kind::kCreated);
  for (std::size_t i = 0; i < declaration_.parameters.size(); ++i)
    (void)executor_->take_change(i); // a new box has no changes to report
  notifies_changes_.store(true);
  return true;
}

void MaxObject::number(std::size_t inlet, double value) {
  if (inlets_.set(inlet, value))
    return;
  if (inlet < declaration_.inlets.size() && declaration_.inlets[inlet].kind == Port::Kind::kList) {
    const Atom atom(value);
    return list(inlet, {&atom, 1});
  }
  if (inlet == 0 && !takes_numbers())
    return message("float", {value});
  QueuedCommand command;
  command.kind = QueuedCommand::Kind::kScalar;
  command.index = inlet;
  command.value = value;
  executor_->post(std::move(command));
}

/// Handles a list at the left inlet. Unless the object declares lists itself, it is one number for
/// each inlet, and the rightmost inlet is set first.
void MaxObject::list(std::size_t inlet, std::span<const Atom> atoms) {
  if (inlet == 0 && find_message(declaration_, "list"))
    return message("list", {atoms.begin(), atoms.end()});
  if (inlet < declaration_.inlets.size() && declaration_.inlets[inlet].kind == Port::Kind::kList) {
    QueuedCommand command;
    command.kind = QueuedCommand::Kind::kList;
    command.index = inlet;
    command.set_atoms({atoms.begin(), atoms.end()});
    return executor_->post(std::move(command));
  }
  if (inlet == 0) {
    if (!takes_numbers())
      return message(atoms.empty() ? "bang" : "list", {atoms.begin(), atoms.end()});
    if (const std::string refusal = list_refusal(declaration_, atoms); !refusal.empty())
      return say_error(refusal);
  }
  for (std::size_t i = std::min<std::size_t>(atoms.size(), inlet == 0 ? atoms.size() : 1); i-- > 0;)
    if (!atoms[i].is_word)
      number(inlet + i, atoms[i].number);
}

/// Whether the left inlet accepts numbers.
bool MaxObject::takes_numbers() const noexcept {
  return traits_.takes_numbers ||
         std::any_of(declaration_.inlets.begin(), declaration_.inlets.end(),
                     [](const Port& port) { return port.kind == Port::Kind::kSignal; });
}

void MaxObject::message(std::string_view name, std::vector<Atom> arguments) {
  if (name == "get")
    return get(arguments);
  if (name == "dump") {
    post(QueuedCommand::Kind::kDumpFirst);
    get({});
    return post(QueuedCommand::Kind::kDump);
  }
  const Request request = resolve(declaration_, name, arguments, HostPrecision::kDouble);
  if (request.kind == Request::Kind::kRefused)
    return say_error(request.refusal);
  QueuedCommand command;
  command.index = request.index;
  if (request.kind == Request::Kind::kParameter) {
    command.kind = QueuedCommand::Kind::kParameter;
    command.realtime = declaration_.parameters[request.index].realtime;
    command.value = request.value;
  } else {
    const Message& declared = declaration_.messages[request.index];
    if (names_file(declared, arguments) &&
        !in_main_thread()) // Max's file and buffer functions need the main thread
      return leave_to_main_thread(name, std::move(arguments));
    command.kind = QueuedCommand::Kind::kMessage;
    command.realtime = declared.realtime;
    command.set_atoms(std::move(arguments));
  }
  executor_->post(std::move(command));
}

Atom MaxObject::parameter(std::size_t index) const {
  const Parameter& parameter = declaration_.parameters[index];
  const double value = executor_->value(index);
  const auto choice = static_cast<std::size_t>(std::max(value, 0.0));
  return choice < parameter.choices.size() ? Atom(parameter.choices[choice]) : Atom(value);
}

void MaxObject::get(std::span<const Atom> names) {
  if (names.empty())
    for (std::size_t i = 0; i < declaration_.parameters.size(); ++i)
      send_parameter(i);
  for (const Atom& name : names) {
    if (const auto index = find_parameter(declaration_, text_of(name))) {
      send_parameter(*index);
      continue;
    }
    QueuedCommand command;
    command.kind = QueuedCommand::Kind::kGet;
    command.set_atoms({name});
    executor_->post(std::move(command));
  }
}

void MaxObject::send_parameter(std::size_t index) {
  const std::array<Atom, 2> atoms{declaration_.parameters[index].name, parameter(index)};
  send_to(ports_.info(), atoms);
}

void MaxObject::post(QueuedCommand::Kind kind, std::size_t index) {
  QueuedCommand command;
  command.kind = kind;
  command.index = index;
  executor_->post(std::move(command));
}

void MaxObject::leave_to_main_thread(std::string_view name, std::vector<Atom> arguments) {
  {
    const std::lock_guard lock(left_mutex_);
    left_.push_back({name, std::move(arguments)});
  }
  qelem_set(left_element_);
}

void MaxObject::carry_out_left() {
  std::vector<Command> commands;
  {
    const std::lock_guard lock(left_mutex_);
    commands.swap(left_);
  }
  for (Command& command : commands)
    message(command.name, std::move(command.arguments));
}

void MaxObject::deliver(const Outbox& outbox) {
  outbox.deliver([this](const Output& output) { deliver(output); });
}

void MaxObject::deliver(const Output& output) {
  switch (output.kind) {
  case Output::Kind::kOutlet:
    if (void* outlet = output.outlet == kInfo ? ports_.info() : ports_.outlet(output.outlet))
      send_to(outlet, output.atoms);
    break;
  case Output::Kind::kError:
    say_error(output.atoms.at(0).word);
    break;
  case Output::Kind::kLog:
    object_post(box(), "%s", std::string(output.atoms.at(0).word).c_str());
    break;
  }
}

void MaxObject::say_error(std::string_view sentence) {
  object_error(box(), "%s", std::string(sentence).c_str());
}

void MaxObject::lost() noexcept {
  if (lost_.fetch_add(1, std::memory_order_relaxed) == 0)
    object_error(box(), "%s",
                 "messages arrive faster than they can be processed: some are lost; send them more "
                 "slowly (reported once)");
}

void MaxObject::changed() noexcept {
  if (notifies_changes_.load(std::memory_order_relaxed))
    qelem_set(changed_element_);
}

/// Views of attributes read them again, and pattr is notified that the box's value has changed.
void MaxObject::notify_changes() {
  for (std::size_t i = 0; i < declaration_.parameters.size(); ++i)
    if (executor_->take_change(i))
      object_attr_touch(box(), symbol_of(declaration_.parameters[i].name));
  object_notify(box(), gensym("modified"), nullptr);
}

bool MaxObject::audio_runs() const {
  return prepared_.load(std::memory_order_relaxed) && instance_.object.z_disabled == 0 &&
         sys_getdspobjdspstate(box()) != 0;
}

void MaxObject::expect_audio() {
  if (nudge_set_.exchange(true))
    return;
  blocks_at_nudge_.store(blocks_.load());
  clock_fdelay(nudge_clock_, nudge_ms_.load());
}

/// Commands may have arrived after the nudge was scheduled. Audio has stopped only if no block has
/// been computed since then.
void MaxObject::nudge() {
  nudge_set_.store(false);
  if (!executor_->waiting())
    return;
  if (blocks_.load() != blocks_at_nudge_.load())
    return expect_audio();
  executor_->carry_out_all();
}

void MaxObject::deliver_audio_output() {
  while (executor_->audio_output().deliver_one([this](const Output& output) { deliver(output); }))
    continue;
  const unsigned lost = executor_->lost_outputs();
  if (lost != 0 && std::exchange(lost_outputs_reported_, lost) == 0)
    say_error(
        "the audio thread sends more messages than Max can receive: some are lost (reported once)");
}

void MaxObject::prepare(std::span<const short> counts, double sample_rate, long max_frames) {
  inlets_.connect(counts);
  const auto frames = static_cast<std::size_t>(std::max(max_frames, 1L));
  nudge_ms_.store(std::max(50.0, 4e3 * static_cast<double>(frames) / sample_rate));
  executor_->prepare(sample_rate, std::min(frames, SignalInlets::kMaxFrames));
  sample_rate_.store(sample_rate);
  prepared_.store(true);
}

void MaxObject::perform(std::span<double* const> in, std::span<double* const> out,
                        std::size_t frames) noexcept {
  blocks_.fetch_add(1, std::memory_order_relaxed);
  const bool muted = instance_.object.z_disabled != 0 || out.size() < out_.size();
  for (std::size_t first = 0; first < frames;) {
    const std::size_t count = std::min(frames - first, SignalInlets::kMaxFrames);
    if (muted)
      for (double* samples : out)
        std::fill_n(samples + first, count, 0.0);
    else
      run_block(in, out, first, count);
    first += count;
  }
  if (!executor_->audio_output().empty())
    clock_fdelay(output_clock_, 0);
}

void MaxObject::run_block(std::span<double* const> in, std::span<double* const> out,
                          std::size_t first, std::size_t frames) noexcept {
  for (std::size_t i = 0; i < out_.size(); ++i)
    out_[i] = out[i] + first;
  const double length_ms = 1e3 * static_cast<double>(frames) / sample_rate_.load();
  block_start_ms_ = block_clock_.next(scheduler_ms() - creation_ms_, length_ms);
  const Block<double> block{inlets_.samples(in, first), out_, frames, block_start_ms_,
                            block_start_ms_};
  if (!executor_->run_block(block))
    for (double* samples : out_)
      std::fill_n(samples, frames, 0.0);
}

void MaxObject::send(std::size_t outlet, std::span<const Atom> atoms) {
  executor_->keep(Output::Kind::kOutlet, outlet, atoms);
}
void MaxObject::info(std::span<const Atom> atoms) {
  executor_->keep(Output::Kind::kOutlet, kInfo, atoms);
}
void MaxObject::error(std::string_view sentence) {
  const Atom word(sentence);
  executor_->keep(Output::Kind::kError, 0, {&word, 1});
}
void MaxObject::log(std::string_view sentence) {
  const Atom word(sentence);
  executor_->keep(Output::Kind::kLog, 0, {&word, 1});
}

void MaxObject::wake_in(std::size_t timer, double milliseconds) {
  if (timer >= timers_.size())
    return;
  if (milliseconds < 0)
    clock_unset(timers_[timer].clock);
  else
    clock_fdelay(timers_[timer].clock, milliseconds);
}

double MaxObject::now_ms() const {
  if (executor_ && executor_->in_audio())
    return block_start_ms_;
  return scheduler_ms() - creation_ms_;
}

std::string MaxObject::find_file(std::string_view name) const { return files_.find(name); }
std::string MaxObject::new_file(std::string_view name) const { return files_.to_write(name); }
bool MaxObject::read_array(std::string_view name, std::vector<double>& values) const {
  return files_.read_buffer(name, values);
}

bool MaxObject::publish(std::string_view name, const std::shared_ptr<void>& what) {
  return published_.publish(name, what);
}
std::shared_ptr<void> MaxObject::find_published(std::string_view name) const {
  return tactus::find_published(name);
}

void MaxObject::wake_from_thread() noexcept {
  if (posted_element_)
    qelem_set(posted_element_);
}

} // namespace tactus::max
