#pragma once

#include "max/abi/max_abi.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// A stub of Max's kernel: declarations that its functions share with the host that runs externals.
namespace tactus::stub {

// --- calls and reports (calls.cpp) ---

/// Prints one line. A thread that collects lines stores them instead, so that no lock synchronises
/// it with others.
void print_line(const std::string& line);
void collect_lines(std::vector<std::string>* lines);
/// Prints "violation: TEXT [in WHERE]", each text once; the exit status is then not 0.
void violation(const std::string& text);
[[nodiscard]] bool any_violation();

enum Role : unsigned { kMain = 1, kScheduler = 2, kAudio = 4, kForeign = 8 };
inline constexpr unsigned kMessageThreads = kMain | kScheduler, kAnyThread = 15;
[[nodiscard]] Role current_role() noexcept;
void set_role(Role role) noexcept;

/// The kind of an external's function that a thread executes.
enum class Where {
  kLoad,
  kConstruct,
  kFree,
  kMessage,
  kAttribute,
  kAssist,
  kDsp,
  kPerform,
  kClock
};

struct Object;
/// One call of an external's function; current_call() returns the innermost call of this thread.
struct Call {
  Where where;
  Object* object = nullptr; ///< null while a class is set up, and before object_alloc
  long inlet = -1;          ///< inlet of a message
  bool sent = false;        ///< something was sent to an outlet
  int held = 0;             ///< number of critical regions and buffers held
  Call* outer = nullptr;
};
[[nodiscard]] Call* current_call() noexcept;

/// Marks this thread as being in a function of Max, which only threads with these roles may call.
class ApiCall {
public:
  explicit ApiCall(const char* function, unsigned roles = kMessageThreads);
  ~ApiCall();
  ApiCall(const ApiCall&) = delete;
  ApiCall& operator=(const ApiCall&) = delete;
};
/// Calls function() as a function of the external, and checks that it has left all regions and
/// locks.
void run_external(Call& call, const std::function<void()>& function);

/// Converts a method back to its type before registration. The double cast shows compilers that
/// this is intended.
template <class Function> Function as(method m) noexcept {
  return reinterpret_cast<Function>(reinterpret_cast<void (*)()>(m));
}

// --- objects that externals get (objects.cpp) ---

enum class Kind { kClass, kAttribute, kOutlet, kProxy, kClock, kQelem, kBufferRef, kBuffer };
/// An object that an external refers to by its address. Never deleted, so that a use after freeing
/// is detected.
struct Record {
  explicit Record(Kind of) : kind(of) {}
  Kind kind;
  std::atomic<bool> alive{true};
  Object* owner = nullptr; ///< the object whose call made this record
};
/// Stores a record, which its owner must free.
void keep(Record& record);
/// Returns the living record of this kind; otherwise reports a violation and returns null.
[[nodiscard]] Record* require_record(const void* address, Kind kind, const char* function);
template <class Type> Type* require(const void* address, const char* function) {
  return static_cast<Type*>(require_record(address, Type::kKind, function));
}

struct Attribute : Record {
  static constexpr Kind kKind = Kind::kAttribute;
  Attribute() : Record(kKind) {}
  std::string name{}, type{};
  method getter = nullptr, setter = nullptr;
  std::map<std::string, std::string> properties{}; ///< label, save, ...
};
struct Outlet : Record {
  static constexpr Kind kKind = Kind::kOutlet;
  Outlet() : Record(kKind) {}
  bool signal = false;
};
struct Proxy : Record {
  static constexpr Kind kKind = Kind::kProxy;
  Proxy() : Record(kKind) {}
  long id = 0;
  long* inlet = nullptr; ///< where the external expects the number
};

/// Gives an inlet's signal at a sample of the run.
using Source = std::function<double(std::uint64_t sample)>;
/// A box. The external has the address of the box's struct; the address of this Object is stored
/// before that struct.
struct Object {
  t_class* type = nullptr;
  std::byte* memory = nullptr;
  std::string id{};               ///< name in the script
  std::vector<Outlet*> outlets{}; ///< from left to right
  std::vector<Proxy*> proxies{};  ///< from right to left, the order of creation
  std::vector<Record*> made{};
  Outlet* dumpout = nullptr;
  long signal_inlets = 0;
  bool alive = true, constructed = false, in_chain = false;
  // The object's part of the signal chain (audio.cpp).
  std::vector<Source> sources{}; ///< for each signal inlet; empty if not connected
  t_perfroutine64 perform = nullptr;
  void* user = nullptr;
  std::vector<std::vector<double>> in{}, out{};
  std::string recording{};
  std::vector<double> recorded{}; ///< outputs, interleaved

  [[nodiscard]] t_pxobject* header() const { return reinterpret_cast<t_pxobject*>(memory); }
  [[nodiscard]] long inlets() const { return 1 + static_cast<long>(proxies.size()); }
  [[nodiscard]] std::string text() const;
};
[[nodiscard]] const std::vector<Object*>& living_objects();
/// Returns the object of a box's pointer; otherwise reports a violation and returns null.
Object* require_object(const void* x, const char* function);
/// Makes a box as a patcher does; null if its constructor refused.
Object* make_object(const std::string& id, std::string_view class_name,
                    std::span<t_atom> arguments);
void free_object(Object& object);
[[nodiscard]] t_class* find_class(std::string_view name);
/// Loads an external and runs its ext_main. Returns an empty text, or the reason why it cannot be
/// loaded (host.cpp).
[[nodiscard]] std::string load_external(const std::string& file);

// --- atoms (atoms.cpp) ---

[[nodiscard]] t_symbol* symbol(std::string_view name);
[[nodiscard]] std::string to_text(std::span<const t_atom> atoms);
[[nodiscard]] t_atom long_atom(t_atom_long value);
[[nodiscard]] t_atom float_atom(double value);
[[nodiscard]] t_atom symbol_atom(std::string_view name);
/// Converts a word: 3 is an integer; 3., #nan and #inf are floats; all others are symbols.
[[nodiscard]] t_atom to_atom(const std::string& word);

// --- messages (messages.cpp) ---

/// Sends a message as a patch cord does.
void send_message(Object& object, long inlet, std::string_view selector, std::span<t_atom> atoms);
/// Drops a file onto a box in a patcher that is "locked" or "unlocked". Returns false if the box
/// accepts none.
bool drop_file(Object& object, const std::string& state, const std::string& file);
/// Sets an attribute as the inspector does.
void set_attribute(Object& object, std::string_view name, std::span<t_atom> atoms);
[[nodiscard]] std::vector<t_atom> get_attribute(Object& object, const Attribute& attribute);
/// The value of the whole box, as pattr asks for it and sets it; empty if the class has none.
[[nodiscard]] std::vector<t_atom> get_value(Object& object);
void set_value(Object& object, std::span<t_atom> atoms);
[[nodiscard]] std::string assist_text(Object& object, long direction, long index);
void print_error(const Object* object, const std::string& text);

// --- time (time.cpp) ---

[[nodiscard]] double now_ms();
/// Runs all clocks that are due up to this time, in the scheduler's thread.
void advance_clocks(double until_ms);
/// Runs the low-priority queue, in the main thread.
void run_low_priority();
/// Removes the clocks and queue elements of an object.
void forget_timers(const Object& object);
void free_clock(Record& clock);

// --- files and buffers (files.cpp) ---

void add_search_path(const std::string& folder);
/// Sets the patcher's file, and whether boxes are in the patcher or in a subpatcher, which has no
/// file.
void set_patcher(const std::string& path, bool in_subpatcher);
[[nodiscard]] t_object* patcher();
void make_buffer(const std::string& name, long channels, const std::vector<float>& samples);

// --- audio (audio.cpp) ---

enum class Inplace { kOff, kSame, kCrossed };
struct Audio {
  double sample_rate = 48000;
  long vector = 64;
  Inplace inplace = Inplace::kOff; ///< whether output vectors are input vectors
  bool runs = false;
};
[[nodiscard]] Audio& audio();
/// Compiles the chain: dsp64 of every box.
void start_dsp();
void stop_dsp();
/// Calls perform of all boxes for one vector, in the audio thread.
void perform_vector();
[[nodiscard]] double audio_ms();
void write_recording(Object& object);

// --- the script (script.cpp, threads.cpp) ---

using Words = std::span<const std::string>;

/// Splits a line into words at blanks, except within "...".
[[nodiscard]] std::vector<std::string> split_line(const std::string& text);
/// Runs a command. Throws std::runtime_error if there is no such command.
void execute(Words line);
/// Prepares the action of "send", "get" or "value", so that nothing needs to be looked up later.
[[nodiscard]] std::function<void()> prepare(const std::string& command, Words words);
/// Runs lines that begin with "main" or "scheduler" repeatedly in two threads, while a third thread
/// performs at least this many vectors.
void run_threads(std::uint64_t vectors, std::span<const std::vector<std::string>> lines);
/// Frees all boxes and writes the recordings.
void finish();

} // namespace tactus::stub

/// Max's class; externals have only its address.
struct t_class : tactus::stub::Record {
  static constexpr tactus::stub::Kind kKind = tactus::stub::Kind::kClass;
  t_class() : Record(kKind) {}
  struct Method {
    method function;
    std::vector<short> types; ///< as registered, without the final 0
  };
  std::string name{};
  method constructor = nullptr, destructor = nullptr;
  std::size_t size = 0;
  std::map<std::string, Method, std::less<>> methods{};
  std::vector<tactus::stub::Attribute*> attributes{};
  bool dsp = false;
  [[nodiscard]] const Method* find(std::string_view method_name) const;
  [[nodiscard]] tactus::stub::Attribute* attribute(std::string_view attribute_name) const;
};
