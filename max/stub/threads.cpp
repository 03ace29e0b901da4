// Messages of two threads while a third performs: for the sanitizers.
#include "max/stub/script.hpp"

#include <thread>

namespace tactus::stub {
namespace {
constexpr std::uint64_t kMinRounds = 10; // of each thread's messages

/// A message or attribute, looked up beforehand, so that nothing but the external orders the
/// threads.
struct Sent {
  enum class Kind { kMessage, kSet, kGet } kind;
  Object* object;
  long inlet;
  std::string name;
  std::vector<t_atom> atoms;
  void run() const {
    std::vector<t_atom> own = atoms;
    if (kind == Kind::kMessage)
      send_message(*object, inlet, name, own);
    else if (kind == Kind::kSet)
      set_attribute(*object, name, own);
    else if (const Attribute* attribute = object->type->attribute(name))
      static_cast<void>(get_attribute(*object, *attribute));
  }
};

Sent prepare(const Script& script, Script::Arguments a) {
  const std::string& command = a.empty() ? "" : a[0].text;
  const bool message = command == "send";
  if ((!message && command != "set" && command != "get") || a.size() < (message ? 4U : 3U))
    throw ScriptError("the scheduler's thread can send, set and get");
  Sent sent{message            ? Sent::Kind::kMessage
            : command == "set" ? Sent::Kind::kSet
                               : Sent::Kind::kGet,
            &script.box(a[1]),
            message ? std::stol(a[2].text) : 0,
            a[message ? 3 : 2].text,
            {}};
  for (const Token& token : a.subspan(message ? 4 : 3))
    sent.atoms.push_back(to_atom(token));
  return sent;
}
struct Work {
  std::vector<Line> main_lines{};
  std::vector<Sent> scheduled{};
};
Work read_work(const Script& script, std::span<const Line> lines) {
  Work work;
  for (const Line& line : lines) {
    const Script::Arguments rest = Script::Arguments(line).subspan(1);
    if (line.front().text == "main" && !rest.empty())
      work.main_lines.emplace_back(rest.begin(), rest.end());
    else if (line.front().text == "scheduler")
      work.scheduled.push_back(prepare(script, rest));
    else
      throw ScriptError("between threads and end: main COMMAND or scheduler COMMAND");
  }
  return work;
}
double audio_ms() {
  return 1000.0 * static_cast<double>(sample_position()) / audio_settings().sample_rate;
}
} // namespace

void run_threads(Script& script, std::uint64_t vectors, std::span<const Line> lines) {
  const Work work = read_work(script, lines);
  std::atomic<std::uint64_t> main_rounds{0}, scheduler_rounds{0};
  std::atomic<bool> done{false};
  std::vector<std::string> from_main, from_scheduler, from_audio;
  std::thread audio([&] {
    collect_lines(&from_audio);
    set_role(Role::kAudio);
    for (std::uint64_t i = 0;
         i < vectors || main_rounds.load(std::memory_order_relaxed) < kMinRounds ||
         scheduler_rounds.load(std::memory_order_relaxed) < kMinRounds;
         ++i) {
      perform_vector();
      std::this_thread::yield();
    }
    done.store(true, std::memory_order_relaxed);
  });
  std::thread scheduler([&] {
    collect_lines(&from_scheduler);
    set_role(Role::kScheduler);
    while (!done.load(std::memory_order_relaxed)) {
      for (const Sent& sent : work.scheduled)
        sent.run();
      advance_clocks(audio_ms());
      scheduler_rounds.fetch_add(1, std::memory_order_relaxed);
      std::this_thread::yield();
    }
  });
  collect_lines(&from_main);
  std::string error;
  try {
    while (!done.load(std::memory_order_relaxed)) {
      for (const Line& line : work.main_lines)
        script.execute(line);
      run_low_priority();
      main_rounds.fetch_add(1, std::memory_order_relaxed);
      std::this_thread::yield();
    }
  } catch (const std::exception& reason) {
    error = reason.what();
    main_rounds = kMinRounds;
  }
  audio.join();
  scheduler.join();
  collect_lines(nullptr);
  for (const auto* collected : {&from_main, &from_scheduler, &from_audio})
    for (const std::string& line : *collected)
      print_line(line);
  if (!error.empty())
    throw ScriptError(error);
}

} // namespace tactus::stub
