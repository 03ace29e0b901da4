/* The audio side: signals, the dsp method, the perform chain. */
#include "internal.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

void host_set_channels(host_signal* s, int channels) {
  s->channels = channels;
  free(s->owned);
  s->owned = calloc((size_t)(s->length * channels), sizeof(t_sample));
  s->samples = s->owned;
}

static host_signal* new_signal(int frames, double rate, int channels) {
  host_signal* s = calloc(1, sizeof *s);
  s->length = frames;
  s->rate = (t_float)rate;
  host_set_channels(s, channels);
  return s;
}

static void append(t_int word) {
  if (host_building->chain_length == MAX_CHAIN)
    host_die("the perform chain is too long");
  host_building->chain[host_building->chain_length++] = word;
}

void dsp_add(t_perfroutine f, int n, ...) {
  va_list words;
  va_start(words, n);
  append((t_int)f);
  for (int i = 0; i < n; ++i)
    append(va_arg(words, t_int));
  va_end(words);
}

void dsp_addv(t_perfroutine f, int n, t_int* words) {
  append((t_int)f);
  for (int i = 0; i < n; ++i)
    append(words[i]);
}

int host_dsp(host_object* o, double rate, int frames, int channels, int alias) {
  t_method dsp = 0;
  for (int i = 0; i < o->type->method_count; ++i)
    if (!strcmp(o->type->methods[i].selector->s_name, "dsp"))
      dsp = o->type->methods[i].function;
  if (!dsp)
    return 0;
  for (int i = 0; i < o->signal_ins + o->signal_outs; ++i) {
    free(o->signals[i]->owned);
    free(o->signals[i]);
  }
  memset(o->signals, 0, sizeof o->signals); /* Pd hands an object without signals none */
  o->signal_ins = host_inlets(o, 1);
  o->signal_outs = host_outlets(o, 1);
  o->frames = frames;
  o->channels = channels;
  o->rate = rate;
  for (int i = 0; i < o->signal_ins; ++i)
    o->signals[i] = new_signal(frames, rate, channels);
  for (int i = 0; i < o->signal_outs; ++i) {
    o->signals[o->signal_ins + i] = new_signal(frames, rate, 1);
    if (alias && channels == 1 && i < o->signal_ins)
      o->signals[o->signal_ins + i]->samples = o->signals[i]->samples;
  }
  o->chain_length = 0;
  host_building = o;
  ((void (*)(t_pd*, t_signal**))dsp)(o->pd, (t_signal**)(void*)o->signals);
  host_building = 0;
  return 1;
}

int host_channels(const host_object* o, int signal_outlet) {
  return o->signals[o->signal_ins + signal_outlet]->channels;
}

static t_float inlet_value(const host_object* o, int signal_inlet) {
  if (o->type->main_signal_offset && signal_inlet-- == 0)
    return *(const t_float*)(const void*)((const char*)o->pd + o->type->main_signal_offset);
  for (int i = 0; i < o->inlet_count; ++i)
    if (o->inlets[i]->to == &s_signal && signal_inlet-- == 0)
      return o->inlets[i]->value;
  return 0;
}

void host_run(host_object* o, const double* const* inputs, double* const* outputs) {
  for (int i = 0; i < o->signal_ins; ++i) {
    host_signal* s = o->signals[i];
    const t_float value = inlet_value(o, i);
    for (int n = 0; n < s->length * s->channels; ++n)
      s->samples[n] = inputs && inputs[i] ? (t_sample)inputs[i][n] : value;
  }
  t_int* word = o->chain;
  while (word < o->chain + o->chain_length)
    word = ((t_perfroutine)*word)(word);
  for (int i = 0; i < o->signal_outs; ++i) {
    const host_signal* s = o->signals[o->signal_ins + i];
    if (outputs && outputs[i])
      for (int n = 0; n < s->length * s->channels; ++n)
        outputs[i][n] = (double)s->samples[n];
  }
}
