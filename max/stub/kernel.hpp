#pragma once

#include "max/abi/max_abi.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// What the functions of the stub share: records of all that was handed to externals, and who
/// calls.
namespace tactus::stub {

// --- reports (report.cpp) ---

/// Prints one line in order. In threads mode each thread keeps its lines until the threads end.
void print_line(const std::string& line);
/// Prints "violation: TEXT [in WHERE]", each text once; the program's exit status is then not 0.
void violation(const std::string& text);
[[nodiscard]] std::size_t violation_count();
/// Collects lines of this thread, or prints them at once if null.
void collect_lines(std::vector<std::string>* lines);

// --- threads and calls (calls.cpp) ---

enum class Role : unsigned { kForeign = 8, kMain = 1, kScheduler = 2, kAudio = 4 };
inline constexpr unsigned kMessageThreads = 3; ///< main and scheduler
inline constexpr unsigned kAnyThread = 15;

/// Which function of an external the thread executes.
enum class Where {
  kLoad,
  kConstruct,
  kFree,
  kMessage,
  kSetter,
  kGetter,
  kAssist,
  kDsp,
  kPerform,
  kCallback
};

struct Object;
/// One call of an external's function; the innermost of this thread is current_call().
struct Call {
  Where where;
  Object* object = nullptr; ///< null while a class is set up, or before object_alloc
  std::string_view name{};  ///< of the message or attribute
  long inlet = 0;
  bool has_inlet = false; ///< came through an inlet: proxy_getinlet may be asked
  bool sent = false;      ///< something was sent to an outlet
  int critical = 0;       ///< critical regions entered and not left
  int buffer_locks = 0;
  t_object* chain = nullptr; ///< of dsp64
  Call* outer = nullptr;
};
[[nodiscard]] Call* current_call() noexcept;
[[nodiscard]] Role current_role() noexcept;
void set_role(Role role) noexcept;
[[nodiscard]] std::string describe_call();

/// While it lives, this thread is in a function of Max: checks that the thread may call it.
class ApiCall {
public:
  explicit ApiCall(const char* function, unsigned roles = kMessageThreads);
  ~ApiCall();
  ApiCall(const ApiCall&) = delete;
  ApiCall& operator=(const ApiCall&) = delete;
};
/// The host's own work: nothing in it counts as the external's.
class HostWork {
public:
  HostWork() noexcept;
  ~HostWork();
  HostWork(const HostWork&) = delete;
  HostWork& operator=(const HostWork&) = delete;
};
/// Whether code of an external, not of the stub, runs in this thread.
[[nodiscard]] bool in_external() noexcept;

/// Enters and leaves an external's function; checks what it left behind.
class Entered {
public:
  explicit Entered(Call& call) noexcept;
  ~Entered();
  Entered(const Entered&) = delete;
  Entered& operator=(const Entered&) = delete;

private:
  Call& call_;
  int kernel_depth_;
};
/// A method as what it was before it was registered; the detour tells compilers that it is meant.
template <class Function> Function as(method m) noexcept {
  return reinterpret_cast<Function>(reinterpret_cast<void (*)()>(m));
}
/// Runs function() as the external's; false if an exception left it.
template <class Function> bool run_external(Call& call, Function&& function) {
  const Entered entered(call);
  try {
    function();
    return true;
  } catch (...) {
    const HostWork work;
    violation("an exception left the external's function");
    return false;
  }
}

/// For realtime_watch: an allocation, lock or system call of an external.
void note_system_call(const char* function, bool releases) noexcept;

// --- records (records.cpp) ---

enum class Kind {
  kSymbol,
  kClass,
  kAttribute,
  kObject,
  kOutlet,
  kProxy,
  kClock,
  kQelem,
  kAtoms,
  kBufferRef,
  kBuffer,
  kPatcher
};
[[nodiscard]] const char* kind_name(Kind kind);

/// Something handed to an external. Never deleted, so that a later use is recognised.
struct Record {
  explicit Record(Kind k) : kind(k) {}
  virtual ~Record() = default;
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  const Kind kind;
  std::atomic<bool> alive{true};
  Object* owner = nullptr; ///< the object in whose call it was made
};
/// Adds it to the table under its address; owner: the current object.
void add_record(const void* address, Record* record);
/// The record of an address, alive or not; null if the stub never gave it.
[[nodiscard]] Record* find_record(const void* address) noexcept;
/// The living record of this kind, or a violation and null.
[[nodiscard]] Record* require_record(const void* address, Kind kind, const char* function);
template <class Type> Type* require(const void* address, const char* function) {
  return static_cast<Type*>(require_record(address, Type::kKind, function));
}
/// Violations for all living records of owner (null: of nobody) that an external had to free.
void report_leaks(const Object* owner);
[[nodiscard]] std::mutex& kernel_mutex();

/// A block between guard zones. Those that externals had are kept after they are freed, and
/// watched.
class Block {
public:
  explicit Block(std::size_t size);
  ~Block();
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
  [[nodiscard]] std::byte* data() const noexcept { return data_; }
  [[nodiscard]] bool guards_intact() const noexcept;
  void bury() noexcept;                            ///< fills it: nobody may use it any more
  [[nodiscard]] bool undisturbed() const noexcept; ///< whether nobody wrote after bury()

private:
  static constexpr std::size_t kGuard = 64;
  std::size_t size_;
  std::byte* memory_;
  std::byte* data_;
};

// --- symbols and atoms (symbols.cpp) ---

struct Symbol : Record {
  static constexpr Kind kKind = Kind::kSymbol;
  explicit Symbol(std::string text);
  std::string name;
  t_symbol symbol;
  Symbol* next = nullptr;
};
struct Atoms : Record {
  static constexpr Kind kKind = Kind::kAtoms;
  explicit Atoms(std::size_t n) : Record(kKind), count(n), block(n * sizeof(t_atom)) {}
  std::size_t count;
  Block block;
};
[[nodiscard]] t_symbol* symbol(std::string_view name);
[[nodiscard]] std::string_view name_of(const t_symbol* symbol);
bool check_symbol(const t_symbol* symbol, const char* function);
bool check_atoms(long count, const t_atom* atoms, const char* function);
[[nodiscard]] std::string to_text(std::span<const t_atom> atoms);
[[nodiscard]] t_atom long_atom(t_atom_long value);
[[nodiscard]] t_atom float_atom(double value);
[[nodiscard]] t_atom symbol_atom(std::string_view name);

// --- classes and objects (classes.cpp, objects.cpp) ---

struct Method {
  method function;
  std::vector<short> types; ///< as registered, without the final 0
};
struct Attribute : Record {
  static constexpr Kind kKind = Kind::kAttribute;
  Attribute() : Record(kKind) {}
  std::string name, type;
  long flags = 0;
  method getter = nullptr, setter = nullptr;
  bool added = false;
  std::map<std::string, std::string> properties{}; ///< label, save, ...
  [[nodiscard]] bool saved() const;
};

struct Outlet : Record {
  static constexpr Kind kKind = Kind::kOutlet;
  Outlet() : Record(kKind) {}
  std::string type; ///< empty: any message
  struct Cord {
    Object* receiver;
    long inlet;
  };
  std::vector<Cord> cords{};
  [[nodiscard]] bool signal() const { return type == "signal"; }
};
struct Proxy : Record {
  static constexpr Kind kKind = Kind::kProxy;
  Proxy() : Record(kKind) {}
  long id = 0;
  long* inlet = nullptr; ///< where the external wants the number
  bool of_dsp = false;   ///< made by z_dsp_setup
};
struct Performer;
struct Object : Record {
  static constexpr Kind kKind = Kind::kObject;
  Object(t_class* c, std::size_t size) : Record(kKind), type(c), block(size) {}
  t_class* type;
  Block block;
  std::string id{};               ///< of the script
  std::vector<Outlet*> outlets{}; ///< left to right
  std::vector<Proxy*> proxies{};  ///< right to left, as they are made
  std::map<const t_symbol*, t_object*> obex{};
  long signal_inlets = 0;
  bool constructed = false, attributes_processed = false, dsp_set_up = false, dsp_freed = false;
  Performer* performer = nullptr;      ///< in the signal chain
  std::atomic<bool> performing{false}; ///< it has added itself to the chain, and audio is on
  [[nodiscard]] t_object* header() const { return reinterpret_cast<t_object*>(block.data()); }
  [[nodiscard]] long inlets() const { return 1 + static_cast<long>(proxies.size()); }
  [[nodiscard]] std::string text() const;
};
inline constexpr intptr_t kMagic = 1758379419;

[[nodiscard]] t_class* find_class(std::string_view name);
[[nodiscard]] const std::vector<t_class*>& classes();
/// The record of a box's pointer; checks that its header is whole.
Object* require_object(const void* x, const char* function);
/// Makes a box as a patcher does; null if its constructor refused.
[[nodiscard]] Object* make_object(const std::string& id, std::string_view class_name,
                                  std::span<t_atom> arguments);
void free_object(Object& object);
[[nodiscard]] const std::vector<Object*>& living_objects();

/// Tells where the patcher was saved, and whether boxes are made in it or in a subpatcher, which
/// has no file of its own.
void set_patcher_path(const std::string& path, bool in_subpatcher);
void add_search_path(const std::string& folder);
/// The patcher of the boxes, and the one around it, if any.
[[nodiscard]] t_object* patcher();
[[nodiscard]] t_object* parent_patcher();
/// Where boxes are made from now on.
void use_subpatcher(bool in_subpatcher);

// --- messages (messages.cpp) ---

/// Sends as a patch cord does.
void send_message(Object& object, long inlet, std::string_view selector, std::span<t_atom> atoms);
/// Drops a file onto a box in a patcher that is "locked" or "unlocked": sends the message that the
/// box asks for (drag.cpp). False if it wants none.
[[nodiscard]] bool drop_file(Object& object, std::string_view state, const std::string& file);
/// As the inspector or pattr does. False when there is no such attribute or it cannot be set.
bool set_attribute(Object& object, std::string_view name, std::span<t_atom> atoms);
[[nodiscard]] std::vector<t_atom> get_attribute(Object& object, const Attribute& attribute);
/// The value of the whole box, as pattr stores it (value.cpp); empty if the class has none.
[[nodiscard]] std::vector<t_atom> get_value(Object& object);
/// False if the class has no value.
[[nodiscard]] bool set_value(Object& object, std::span<t_atom> atoms);
/// Asks the box as Max's preset object does: by its method of that name, with the box alone. False
/// if it has none.
[[nodiscard]] bool ask_for_preset(Object& object);
[[nodiscard]] std::string assist_text(Object& object, long direction, long index);
void print_error(const Object* object, const std::string& text);

// --- scheduler (scheduler.cpp) ---

[[nodiscard]] double now_ms();
/// Lets clocks that are due until then run, in the role of the scheduler.
void advance_clocks(double until_ms);
void run_low_priority();
void set_overdrive(bool on);
void forget_owner(const Object& object); ///< its clocks and queue elements must not run any more
[[nodiscard]] Role scheduler_role();

} // namespace tactus::stub

/// Max's class, of which externals know only the address.
struct t_class : tactus::stub::Record {
  static constexpr tactus::stub::Kind kKind = tactus::stub::Kind::kClass;
  t_class() : Record(kKind) {}
  std::string name;
  method constructor = nullptr, destructor = nullptr;
  std::vector<short> types{};
  std::size_t size = 0;
  std::map<std::string, tactus::stub::Method, std::less<>> methods{};
  std::vector<tactus::stub::Attribute*> attributes{};
  bool registered = false, dsp = false;
  [[nodiscard]] const tactus::stub::Method* find(std::string_view method_name) const;
  [[nodiscard]] tactus::stub::Attribute* attribute(std::string_view attribute_name) const;
};
