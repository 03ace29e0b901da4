/* A small host that loads Pd externals without Pd, so that tests can drive them at any block size,
   rate and float size, see every error sentence and outlet message, and step logical time.
   Numbers cross this interface as double whatever the size of t_float. Not thread-safe, but for
   pd_queue_mess (which the newer variant of the host offers, as Pd does since 0.56). */
#ifndef TACTUS_TESTS_PD_HOST_H
#define TACTUS_TESTS_PD_HOST_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct host_object host_object;

typedef struct {
  const char* word; /* null for a number */
  double number;
} host_atom;

/* A message that left an outlet. */
typedef struct {
  const host_object* object;
  int outlet;
  double ms; /* logical time */
  const char* selector;
  int count;
  const host_atom* atoms;
} host_event;

/* Loads a module and calls its setup function; null or a sentence of what went wrong. */
const char* host_load(const char* file, const char* setup);

/* As typing the name and arguments into a box; null when the class refuses. */
host_object* host_make(const char* name, int count, const host_atom* atoms);
void host_drop(host_object*);

int host_inlets(const host_object*, int only_signal);
int host_outlets(const host_object*, int only_signal);

/* A message to an inlet, dispatched as Pd does. */
void host_message(host_object*, int inlet, const char* selector, int count, const host_atom* atoms);

/* Calls the dsp method. channels: of every signal inlet, for hosts with multichannel signals.
   alias: outputs use the inputs' memory, as Pd likes to do. Returns 0 for objects without dsp. */
int host_dsp(host_object*, double rate, int frames, int channels, int alias);
int host_channels(const host_object*, int signal_outlet);

/* One block: inputs[inlet] holds frames * channels numbers, null leaves the inlet unconnected (its
   float value is then the signal); outputs[outlet] gets as many as the object makes. */
void host_run(host_object*, const double* const* inputs, double* const* outputs);

/* Lets logical time pass and runs the clocks that are due; also delivers queued messages. */
void host_advance(double ms);
double host_now(void);

/* What was said and sent since the last host_clear_events(). */
int host_error_count(void);
const char* host_error(int index);
int host_event_count(void);
host_event host_get_event(int index);
void host_clear_events(void);

/* A named array that objects can read, and the folder that file names are relative to. */
void host_set_array(const char* name, int size, const double* values);
void host_set_folder(const char* folder);

#ifdef __cplusplus
}
#endif
#endif
