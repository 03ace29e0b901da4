/* What Pd 0.54 to 0.57 add: multichannel signals and posting from threads. */
#include "internal.h"

#include <pthread.h>
#include <stdlib.h>

typedef void (*queued_function)(t_pd*, void*);
void signal_setmultiout(t_signal** signal, int channels);
void pd_queue_mess(t_pdinstance* instance, t_pd* object, void* argument, queued_function function);
void pd_queue_cancel(t_pd* object);

typedef struct entry {
  t_pd* object;
  void* argument;
  queued_function function;
  struct entry* next;
} entry;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static entry *head, **tail = &head;

void signal_setmultiout(t_signal** signal, int channels) {
  host_set_channels((host_signal*)(void*)*signal, channels);
}

void pd_queue_mess(t_pdinstance* instance, t_pd* object, void* argument, queued_function function) {
  if (instance != &pd_maininstance)
    host_die("pd_queue_mess for another instance");
  entry* e = calloc(1, sizeof *e);
  *e = (entry){object, argument, function, 0};
  pthread_mutex_lock(&lock);
  *tail = e;
  tail = &e->next;
  pthread_mutex_unlock(&lock);
}

void pd_queue_cancel(t_pd* object) {
  pthread_mutex_lock(&lock);
  for (entry* e = head; e; e = e->next)
    if (e->object == object)
      e->object = 0;
  pthread_mutex_unlock(&lock);
}

void host_deliver_queue(void) {
  for (;;) {
    pthread_mutex_lock(&lock);
    entry* e = head;
    if (e && !(head = e->next))
      tail = &head;
    pthread_mutex_unlock(&lock);
    if (!e)
      return;
    e->function(e->object, e->argument); /* with a null object when cancelled, as Pd does */
    free(e);
  }
}
