/* Shared by the host's sources. */
#ifndef TACTUS_TESTS_PD_INTERNAL_H
#define TACTUS_TESTS_PD_INTERNAL_H

#define PD_CLASS_DEF /* the functions themselves, not the macros that cast */
#include <m_pd.h>

#include "host.h"

enum { MAX_METHODS = 64, MAX_PORTS = 64, MAX_CHAIN = 4096 };

typedef struct {
  t_symbol* selector;
  t_method function;
  t_atomtype types[MAXPDARG + 1];
} method_entry;

struct _class {
  t_symbol* name;
  t_newmethod make;
  t_method drop;
  size_t size;
  int flags;
  int main_signal_offset; /* 0: the left inlet takes no signal */
  method_entry methods[MAX_METHODS];
  int method_count;
  t_method anything, list, bang, number, word;
};

/* Pd 0.54's signal; its first three members are those of older Pds. */
typedef struct {
  int length;
  t_sample* samples;
  t_float rate;
  int channels;
  t_sample* owned;
} host_signal;

struct _inlet {
  host_object* owner;
  t_pd* target;
  t_symbol *from, *to; /* both &s_signal: a signal inlet */
  t_float value;
};

struct _outlet {
  host_object* owner;
  t_symbol* type;
  int index;
};

struct host_object {
  t_pd* pd;
  t_class* type;
  t_inlet* inlets[MAX_PORTS];
  t_outlet* outlets[MAX_PORTS];
  int inlet_count, outlet_count;
  host_signal* signals[2 * MAX_PORTS];
  int signal_ins, signal_outs, frames, channels;
  double rate;
  t_int chain[MAX_CHAIN];
  int chain_length;
  host_object* next;
};

host_object* host_of(const void* pd);
void host_die(const char* why);
void host_record_error(const char* sentence);
void host_add_event(t_outlet*, const char* selector, int count, const t_atom*);
void host_set_channels(host_signal*, int channels);
void host_deliver_queue(void);     /* of the newer host */
extern host_object* host_building; /* whose dsp method runs */

#endif
