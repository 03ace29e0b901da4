/* Symbols, classes, objects, inlets and outlets. */
#include "internal.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

t_symbol s_pointer = {"pointer", 0, 0}, s_float = {"float", 0, 0}, s_symbol = {"symbol", 0, 0},
         s_bang = {"bang", 0, 0}, s_list = {"list", 0, 0}, s_anything = {"anything", 0, 0},
         s_signal = {"signal", 0, 0}, s__N = {"#N", 0, 0}, s__X = {"#X", 0, 0}, s_x = {"x", 0, 0},
         s_y = {"y", 0, 0}, s_ = {"", 0, 0};
static t_symbol* const built_in[] = {&s_pointer, &s_float, &s_symbol, &s_bang, &s_list, &s_anything,
                                     &s_signal,  &s__N,    &s__X,     &s_x,    &s_y,    &s_};
t_pdinstance pd_maininstance;

static t_symbol* symbols;
static t_class* classes[64];
static int class_count;
static host_object* objects;
host_object* host_building;

void host_die(const char* why) {
  fprintf(stderr, "stub host: %s\n", why);
  abort();
}

t_symbol* gensym(const char* name) {
  for (size_t i = 0; i < sizeof built_in / sizeof *built_in; ++i)
    if (!strcmp(built_in[i]->s_name, name))
      return built_in[i];
  for (t_symbol* s = symbols; s; s = s->s_next)
    if (!strcmp(s->s_name, name))
      return s;
  t_symbol* s = calloc(1, sizeof *s);
  s->s_name = strdup(name);
  s->s_next = symbols;
  return symbols = s;
}

t_class* class_new(t_symbol* name, t_newmethod make, t_method drop, size_t size, int flags,
                   t_atomtype first, ...) {
  (void)first; /* classes under test take A_GIMME */
  t_class* c = calloc(1, sizeof *c);
  c->name = name;
  c->make = make;
  c->drop = drop;
  c->size = size;
  c->flags = flags;
  if (class_count == 64)
    host_die("too many classes");
  return classes[class_count++] = c;
}

void class_addmethod(t_class* c, t_method function, t_symbol* selector, t_atomtype first, ...) {
  if (c->method_count == MAX_METHODS)
    host_die("too many methods");
  method_entry* m = &c->methods[c->method_count++];
  m->selector = selector;
  m->function = function;
  va_list rest;
  va_start(rest, first);
  t_atomtype type = first;
  for (int i = 0; i <= MAXPDARG; ++i) {
    m->types[i] = type;
    if (type == A_NULL)
      break;
    type = (t_atomtype)va_arg(rest, int);
  }
  va_end(rest);
}

void class_addanything(t_class* c, t_method f) { c->anything = f; }
void class_addlist(t_class* c, t_method f) { c->list = f; }
void class_addbang(t_class* c, t_method f) { c->bang = f; }
void class_doaddfloat(t_class* c, t_method f) { c->number = f; }
void class_addsymbol(t_class* c, t_method f) { c->word = f; }
void class_domainsignalin(t_class* c, int offset) { c->main_signal_offset = offset; }
void class_sethelpsymbol(t_class* c, t_symbol* s) { (void)c, (void)s; }

t_pd* pd_new(t_class* c) {
  t_pd* pd = calloc(1, c->size);
  *pd = c;
  host_object* o = calloc(1, sizeof *o);
  o->pd = pd;
  o->type = c;
  o->next = objects;
  return (objects = o)->pd;
}

host_object* host_of(const void* pd) {
  for (host_object* o = objects; o; o = o->next)
    if (o->pd == pd)
      return o;
  return 0;
}

static void drop_signals(host_object* o) {
  for (int i = 0; i < o->signal_ins + o->signal_outs; ++i) {
    free(o->signals[i]->owned);
    free(o->signals[i]);
  }
  o->signal_ins = o->signal_outs = 0;
}

void pd_free(t_pd* pd) {
  host_object* o = host_of(pd);
  if (!o)
    host_die("pd_free of an object that does not live");
  if (o->type->drop)
    ((void (*)(void*))o->type->drop)(pd);
  for (int i = 0; i < o->inlet_count; ++i)
    free(o->inlets[i]);
  for (int i = 0; i < o->outlet_count; ++i)
    free(o->outlets[i]);
  drop_signals(o);
  for (host_object** p = &objects; *p; p = &(*p)->next)
    if (*p == o) {
      *p = o->next;
      break;
    }
  free(o);
  free(pd);
}

t_inlet* inlet_new(t_object* owner, t_pd* target, t_symbol* from, t_symbol* to) {
  host_object* o = host_of(owner);
  if (!o || o->inlet_count == MAX_PORTS)
    host_die("inlet_new");
  t_inlet* i = calloc(1, sizeof *i);
  i->owner = o;
  i->target = target;
  i->from = from;
  i->to = to;
  return o->inlets[o->inlet_count++] = i;
}

t_outlet* outlet_new(t_object* owner, t_symbol* type) {
  host_object* o = host_of(owner);
  if (!o || o->outlet_count == MAX_PORTS)
    host_die("outlet_new");
  t_outlet* out = calloc(1, sizeof *out);
  out->owner = o;
  out->type = type;
  out->index = o->outlet_count;
  return o->outlets[o->outlet_count++] = out;
}

static int to_pd(int count, const host_atom* from, t_atom* to) {
  for (int i = 0; i < count; ++i) {
    if (from[i].word)
      SETSYMBOL(to + i, gensym(from[i].word));
    else
      SETFLOAT(to + i, (t_float)from[i].number);
  }
  return count;
}

host_object* host_make(const char* name, int count, const host_atom* atoms) {
  t_atom* given = calloc((size_t)count + 1, sizeof *given);
  to_pd(count, atoms, given);
  void* made = 0;
  int known = 0;
  for (int i = 0; i < class_count && !made; ++i)
    if (!strcmp(classes[i]->name->s_name, name)) {
      known = 1;
      made = ((void* (*)(t_symbol*, int, t_atom*))(t_method)classes[i]->make)(gensym(name), count,
                                                                              given);
    }
  free(given);
  if (!known)
    host_die(name);
  return made ? host_of(made) : 0;
}

void host_drop(host_object* o) { pd_free(o->pd); }

static int is_signal_inlet(const t_inlet* i) { return i->to == &s_signal; }

int host_inlets(const host_object* o, int only_signal) {
  int count = !only_signal || o->type->main_signal_offset != 0;
  for (int i = 0; i < o->inlet_count; ++i)
    count += !only_signal || is_signal_inlet(o->inlets[i]);
  return count;
}

int host_outlets(const host_object* o, int only_signal) {
  int count = 0;
  for (int i = 0; i < o->outlet_count; ++i)
    count += !only_signal || o->outlets[i]->type == &s_signal;
  return count;
}

static void call(const method_entry* m, t_pd* pd, t_symbol* selector, int count, t_atom* atoms) {
  if (m->types[0] == A_GIMME) {
    ((void (*)(t_pd*, t_symbol*, int, t_atom*))m->function)(pd, selector, count, atoms);
  } else if (m->types[0] == A_NULL) {
    ((void (*)(t_pd*))m->function)(pd);
  } else if ((m->types[0] == A_FLOAT || m->types[0] == A_DEFFLOAT) && m->types[1] == A_NULL) {
    if (count && atoms[0].a_type != A_FLOAT)
      host_record_error("bad arguments for message");
    else
      ((void (*)(t_pd*, t_floatarg))m->function)(pd, count ? atoms[0].a_w.w_float : 0);
  } else {
    host_die("a method with arguments that this host does not know");
  }
}

/* To an object, by Pd's rules for classes with an anything method. */
void pd_typedmess(t_pd* pd, t_symbol* selector, int count, t_atom* atoms) {
  t_class* c = *pd;
  /* As Pd's default method for lists: a class without a method for what a short list stands for
     gets the list as it is. */
  if (selector == &s_list && count <= 1) {
    t_symbol* meant = count == 0 ? &s_bang : atoms[0].a_type == A_FLOAT ? &s_float : &s_symbol;
    if (meant == &s_float && c->main_signal_offset)
      selector = meant;
    for (int i = 0; i < c->method_count; ++i)
      if (c->methods[i].selector == meant)
        selector = meant;
  }
  if (selector == &s_float && c->main_signal_offset) {
    *(t_float*)(void*)((char*)pd + c->main_signal_offset) = count ? atoms[0].a_w.w_float : 0;
    return;
  }
  for (int i = 0; i < c->method_count; ++i)
    if (c->methods[i].selector == selector && c->methods[i].types[0] != A_CANT) {
      call(&c->methods[i], pd, selector, count, atoms);
      return;
    }
  t_method direct = selector == &s_list ? c->list : c->anything;
  if (!direct)
    direct = c->anything;
  if (!direct)
    host_record_error("no method for that message");
  else
    ((void (*)(t_pd*, t_symbol*, int, t_atom*))direct)(pd, selector, count, atoms);
}

void host_message(host_object* o, int inlet, const char* selector, int count,
                  const host_atom* atoms) {
  t_atom* given = calloc((size_t)count + 1, sizeof *given);
  to_pd(count, atoms, given);
  t_symbol* s = gensym(selector);
  if (inlet == 0) {
    pd_typedmess(o->pd, s, count, given);
  } else {
    t_inlet* i = o->inlets[inlet - 1];
    if (s == &s_list && count == 1 && given[0].a_type == A_FLOAT)
      s = &s_float;
    if (is_signal_inlet(i) && s == &s_float)
      i->value = given[0].a_w.w_float;
    else if (s == i->from || (i->from == &s_list && s == &s_float))
      pd_typedmess(i->target, i->to, count, given);
    else
      host_record_error("inlet: expected another type of message");
  }
  free(given);
}

/* To an inlet of an object. */
void pd_float(t_pd* x, t_float number) {
  for (host_object* o = objects; o; o = o->next)
    for (int i = 0; i < o->inlet_count; ++i)
      if ((void*)o->inlets[i] == (void*)x && is_signal_inlet(o->inlets[i])) {
        o->inlets[i]->value = number;
        return;
      }
  host_die("pd_float to what is no signal inlet");
}

const char* class_getname(const t_class* c) { return c->name->s_name; }

/* Names hold one thing: what is bound here takes care of that itself. */
void pd_bind(t_pd* thing, t_symbol* s) {
  if (s->s_thing)
    host_die("pd_bind to a name that is taken");
  s->s_thing = thing;
}
void pd_unbind(t_pd* thing, t_symbol* s) {
  if (s->s_thing != thing)
    host_die("pd_unbind of what is not bound");
  s->s_thing = 0;
}
