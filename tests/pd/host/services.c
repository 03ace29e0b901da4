/* Clocks, the console, outlet traffic, files and arrays. */
#include "internal.h"

#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct _clock {
  void* owner;
  t_method function;
  double due; /* ms; negative when unset */
  t_clock* next;
};

static const double kUnitsPerMs = 32.0 * 441.0; /* of Pd's own time scale */
static t_clock* clocks;
static double now_ms;

t_clock* clock_new(void* owner, t_method function) {
  t_clock* c = calloc(1, sizeof *c);
  c->owner = owner;
  c->function = function;
  c->due = -1;
  c->next = clocks;
  return clocks = c;
}

void clock_delay(t_clock* c, double ms) { c->due = now_ms + (ms > 0 ? ms : 0); }
void clock_unset(t_clock* c) { c->due = -1; }
double clock_getlogicaltime(void) { return now_ms * kUnitsPerMs; }
double clock_gettimesince(double before) { return now_ms - before / kUnitsPerMs; }
double host_now(void) { return now_ms; }
t_float sys_getsr(void) { return 48000; }
int sys_getblksize(void) { return 64; }

void clock_free(t_clock* c) {
  for (t_clock** p = &clocks; *p; p = &(*p)->next)
    if (*p == c) {
      *p = c->next;
      free(c);
      return;
    }
  host_die("clock_free of a clock that does not live");
}

void host_advance(double ms) {
  const double end = now_ms + ms;
  for (;;) {
    host_deliver_queue();
    t_clock* first = 0;
    for (t_clock* c = clocks; c; c = c->next)
      if (c->due >= 0 && c->due <= end && (!first || c->due < first->due))
        first = c;
    if (!first)
      break;
    now_ms = first->due;
    first->due = -1;
    ((void (*)(void*))first->function)(first->owner);
  }
  now_ms = end;
}

static char** errors;
static int error_count;
typedef struct {
  host_event event;
  host_atom* atoms;
} kept_event;
static kept_event* events;
static int event_count, event_room;

void host_record_error(const char* sentence) {
  errors = realloc(errors, (size_t)(error_count + 1) * sizeof *errors);
  errors[error_count++] = strdup(sentence);
}

void pd_error(const void* object, const char* format, ...) {
  if (object && !host_of(object))
    host_die("pd_error for an object that does not live");
  char text[4096];
  va_list values;
  va_start(values, format);
  vsnprintf(text, sizeof text, format, values);
  va_end(values);
  host_record_error(text);
}

void logpost(const void* object, int level, const char* format, ...) {
  (void)format;
  if (object && !host_of(object))
    host_die("logpost for an object that does not live");
  if (level > PD_NORMAL)
    host_die("logpost at a level that Pd's window hides");
}
void post(const char* format, ...) { (void)format; }

void host_add_event(t_outlet* outlet, const char* selector, int count, const t_atom* atoms) {
  if (event_count == event_room) {
    event_room = event_room ? 2 * event_room : 256;
    events = realloc(events, (size_t)event_room * sizeof *events);
  }
  kept_event* e = &events[event_count++];
  e->atoms = calloc((size_t)count + 1, sizeof *e->atoms);
  for (int i = 0; i < count; ++i) {
    if (atoms[i].a_type == A_SYMBOL)
      e->atoms[i].word = atoms[i].a_w.w_symbol->s_name;
    else
      e->atoms[i].number = (double)atoms[i].a_w.w_float;
  }
  e->event = (host_event){outlet->owner, outlet->index, now_ms, selector, count, e->atoms};
}

void outlet_bang(t_outlet* o) { host_add_event(o, "bang", 0, 0); }
void outlet_float(t_outlet* o, t_float value) {
  t_atom a;
  SETFLOAT(&a, value);
  host_add_event(o, "float", 1, &a);
}
void outlet_symbol(t_outlet* o, t_symbol* s) {
  t_atom a;
  SETSYMBOL(&a, s);
  host_add_event(o, "symbol", 1, &a);
}
void outlet_list(t_outlet* o, t_symbol* s, int count, t_atom* atoms) {
  (void)s;
  host_add_event(o, "list", count, atoms);
}
void outlet_anything(t_outlet* o, t_symbol* s, int count, t_atom* atoms) {
  host_add_event(o, s->s_name, count, atoms);
}

int host_error_count(void) { return error_count; }
const char* host_error(int index) { return errors[index]; }
int host_event_count(void) { return event_count; }
host_event host_get_event(int index) { return events[index].event; }

void host_clear_events(void) {
  for (int i = 0; i < error_count; ++i)
    free(errors[i]);
  for (int i = 0; i < event_count; ++i)
    free(events[i].atoms);
  error_count = event_count = 0;
}

static char folder[MAXPDSTRING] = ".";
void host_set_folder(const char* path) { snprintf(folder, sizeof folder, "%s", path); }
t_glist* canvas_getcurrent(void) { return (t_glist*)(void*)folder; }

void canvas_makefilename(const t_glist* canvas, const char* file, char* result, int size) {
  (void)canvas;
  const int absolute = file[0] == '/' || (file[0] && file[1] == ':'); /* of Windows: c:/ */
  const char* format = absolute ? "%.0s%s" : "%s/%s";
  if (snprintf(result, (size_t)size, format, folder, file) >= size)
    result[size - 1] = 0;
}

int canvas_open(const t_canvas* canvas, const char* name, const char* extension, char* directory,
                char** base, unsigned int size, int binary) {
  (void)binary;
  char path[MAXPDSTRING * 2];
  snprintf(path, sizeof path, "%s%s", name, extension);
  canvas_makefilename(canvas, path, directory, (int)size);
  const int file = open(directory, O_RDONLY);
  if (file < 0)
    return -1;
  char* slash = strrchr(directory, '/');
  *slash = 0;
  *base = slash + 1;
  return file;
}
int sys_close(int file) { return close(file); }

struct _garray {
  t_symbol* name;
  int size;
  t_word* words;
  t_garray* next;
};
static struct _class garray_type;
t_class* garray_class = &garray_type;
static t_garray* arrays;

void host_set_array(const char* name, int size, const double* values) {
  t_garray* a = calloc(1, sizeof *a);
  a->name = gensym(name);
  a->size = size;
  a->words = calloc((size_t)size + 1, sizeof *a->words);
  for (int i = 0; i < size; ++i)
    a->words[i].w_float = (t_float)values[i];
  a->next = arrays;
  arrays = a;
}

t_pd* pd_findbyclass(t_symbol* s, const t_class* c) {
  if (c == garray_class)
    for (t_garray* a = arrays; a; a = a->next)
      if (a->name == s)
        return (t_pd*)(void*)a;
  return 0;
}

int garray_getfloatwords(t_garray* a, int* size, t_word** words) {
  *size = a->size;
  *words = a->words;
  return 1;
}
