// Clocks, the console, outlet traffic, files and arrays.
#include "tests/pd/host/internal.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <list>
#include <map>
#include <utility>

struct _clock {
  void* owner;
  t_method function;
  double due = -1; // ms; negative when unset
};

struct _garray {
  std::vector<t_word> words;
};

t_class* garray_class = nullptr; // its address alone is of use

namespace tactus::test {
namespace {

constexpr double kUnitsPerMs = 32.0 * 441.0; // of Pd's own time scale
std::list<t_clock> clocks;
double logical_ms = 0;
Heard record;
std::string folder = ".";
std::map<std::string, t_garray> arrays;

std::string printed(const char* format, std::va_list values) {
  char text[4096];
  std::vsnprintf(text, sizeof text, format, values);
  return text;
}

void keep(const t_outlet* outlet, const char* selector, int count, const t_atom* atoms) {
  Sent& message = record.sent.emplace_back(Sent{outlet->index, logical_ms, selector, {}});
  for (const t_atom* atom = atoms; atom != atoms + count; ++atom) {
    if (atom->a_type == A_SYMBOL)
      message.atoms.emplace_back(atom->a_w.w_symbol->s_name);
    else
      message.atoms.emplace_back(static_cast<double>(atom->a_w.w_float));
  }
}

void expect_living(const void* object) {
  if (object && !host_of(object))
    die("an error or a remark for an object that does not live");
}

} // namespace

Heard heard() { return std::exchange(record, {}); }
void record_error(const std::string& sentence) { record.errors.push_back(sentence); }
double now_ms() { return logical_ms; }
std::size_t clock_count() { return clocks.size(); }
void set_folder(const char* path) { folder = path; }

void set_array(const char* name, const std::vector<double>& values) {
  std::vector<t_word>& words = arrays[name].words;
  words.resize(values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    words[i].w_float = static_cast<t_float>(values[i]);
}

void advance(double ms) {
  const double end = logical_ms + ms;
  for (;;) {
    deliver_queue();
    t_clock* first = nullptr;
    for (t_clock& clock : clocks)
      if (clock.due >= 0 && clock.due <= end && (!first || clock.due < first->due))
        first = &clock;
    if (!first)
      break;
    logical_ms = first->due;
    first->due = -1;
    as<void(void*)>(first->function)(first->owner);
  }
  logical_ms = end;
}

} // namespace tactus::test

using namespace tactus::test;

t_clock* clock_new(void* owner, t_method function) {
  return &clocks.emplace_back(_clock{owner, function});
}
void clock_delay(t_clock* c, double ms) { c->due = logical_ms + std::max(ms, 0.0); }
void clock_unset(t_clock* c) { c->due = -1; }
void clock_free(t_clock* c) {
  if (!clocks.remove_if([c](const t_clock& clock) { return &clock == c; }))
    die("clock_free of a clock that does not live");
}
double clock_getlogicaltime() { return logical_ms * kUnitsPerMs; }
double clock_gettimesince(double before) { return logical_ms - before / kUnitsPerMs; }
t_float sys_getsr() { return 48000; }
int sys_getblksize() { return 64; }

void pd_error(const void* object, const char* format, ...) {
  expect_living(object);
  std::va_list values;
  va_start(values, format);
  record_error(printed(format, values));
  va_end(values);
}
void logpost(const void* object, int level, const char*, ...) {
  expect_living(object);
  if (level > PD_NORMAL)
    die("logpost at a level that Pd's window hides");
}

void outlet_bang(t_outlet* o) { keep(o, "bang", 0, nullptr); }
void outlet_float(t_outlet* o, t_float value) {
  t_atom a;
  SETFLOAT(&a, value);
  keep(o, "float", 1, &a);
}
void outlet_list(t_outlet* o, t_symbol*, int count, t_atom* atoms) {
  keep(o, "list", count, atoms);
}
void outlet_anything(t_outlet* o, t_symbol* s, int count, t_atom* atoms) {
  keep(o, s->s_name, count, atoms);
}

t_glist* canvas_getcurrent() { return nullptr; }
void canvas_makefilename(const t_glist*, const char* file, char* result, int size) {
  const bool absolute = file[0] == '/' || (file[0] && file[1] == ':'); // of Windows: c:/
  const std::string path = absolute ? file : folder + "/" + file;
  std::snprintf(result, static_cast<std::size_t>(size), "%s", path.c_str());
}
extern "C" int canvas_path_iterate(const t_canvas*, int (*)(const char*, void*), void*) {
  return 0;
}

t_pd* pd_findbyclass(t_symbol* s, const t_class*) {
  const auto found = arrays.find(s->s_name);
  return found == arrays.end() ? nullptr : reinterpret_cast<t_pd*>(&found->second);
}
int garray_getfloatwords(t_garray* a, int* size, t_word** words) {
  *size = static_cast<int>(a->words.size());
  *words = a->words.data();
  return 1;
}
