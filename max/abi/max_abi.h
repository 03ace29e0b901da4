/* The part of Max's 64-bit binary interface that max/ uses, declared from public facts, without the
   vendor's text. A function's number and width of arguments are its contract: `long` has 4 bytes on
   Windows and 8 elsewhere, and only functions declared with ... here are variadic in Max. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define MAX_EXPORT __declspec(dllexport)
#if defined(TACTUS_MAX_STUB)
#define MAX_IMPORT /* exported by max/stub's own .def files */
#else
#define MAX_IMPORT __declspec(dllimport)
#endif
#else
#define MAX_EXPORT __attribute__((visibility("default")))
#define MAX_IMPORT __attribute__((visibility("default")))
#endif

extern "C" {
typedef intptr_t t_atom_long;
typedef t_atom_long t_max_err; /* 0: done */
typedef uint32_t t_fourcc;
typedef void* (*method)(void*);

struct t_class;
struct t_messlist;
struct t_object {
  t_messlist* o_messlist;
  intptr_t o_magic;
  void* o_inlet;
  void* o_outlet;
};
struct t_symbol {
  char* s_name;
  t_object* s_thing;
};
struct t_pxobject { /* an object of the signal chain */
  t_object z_ob;
  long z_in; /* the inlet of the last message; read it by proxy_getinlet() */
  void* z_proxy;
  long z_disabled; /* not 0: muted */
  short z_count;
  short z_misc;
};
union t_word {
  t_atom_long w_long;
  double w_float;
  t_symbol* w_sym;
  t_object* w_obj;
};
struct t_atom {
  short a_type;
  t_word a_w;
};
enum { A_NOTHING = 0, A_LONG = 1, A_FLOAT = 2, A_SYM = 3, A_OBJ = 4 };
enum { A_DEFLONG = 5, A_DEFFLOAT = 6, A_DEFSYM = 7, A_GIMME = 8, A_CANT = 9 };
enum { ASSIST_INLET = 1, ASSIST_OUTLET = 2 };
enum { Z_NO_INPLACE = 1 };
enum { MAX_PATH_CHARS = 2048, MAX_FILENAME_CHARS = 512 };
enum { PATH_STYLE_SLASH = 3 };
enum { PATH_TYPE_ABSOLUTE = 1, PATH_TYPE_BOOT = 3 };
typedef void (*t_perfroutine64)(t_object*, t_object*, double**, long, double**, long, long, long,
                                void*);
typedef struct t_critical_region* t_critical; /* null: the one that all modules share */

/* MaxAPI */
MAX_IMPORT t_class* class_new(const char*, method, method, long, method, short, ...);
MAX_IMPORT t_max_err class_addmethod(t_class*, method, const char*, ...);
MAX_IMPORT t_max_err class_addattr(t_class*, t_object*);
MAX_IMPORT t_max_err class_attr_addattr_parse(t_class*, const char*, const char*, t_symbol*, long,
                                              const char*);
MAX_IMPORT t_max_err class_register(t_symbol*, t_class*);
MAX_IMPORT t_object* attribute_new(const char*, t_symbol*, long, method, method);
MAX_IMPORT void attr_args_process(void*, short, t_atom*);
MAX_IMPORT void* object_alloc(t_class*);
MAX_IMPORT t_max_err object_free(void*);
MAX_IMPORT t_max_err object_obex_store(void*, t_symbol*, t_object*);
MAX_IMPORT t_max_err object_obex_lookup(void*, t_symbol*, t_object**);
MAX_IMPORT t_max_err object_attr_touch(t_object*, t_symbol*);
MAX_IMPORT t_max_err object_notify(void*, t_symbol*, void*);
MAX_IMPORT void object_post(t_object*, const char*, ...);
MAX_IMPORT void object_error(t_object*, const char*, ...);
MAX_IMPORT t_symbol* gensym(const char*);
MAX_IMPORT t_max_err atom_setfloat(t_atom*, double);
MAX_IMPORT t_max_err atom_setsym(t_atom*, const t_symbol*);
MAX_IMPORT t_max_err atom_alloc(long*, t_atom**, char*);
MAX_IMPORT t_max_err atom_alloc_array(long, long*, t_atom**, char*);
MAX_IMPORT void* outlet_new(void*, const char*);
MAX_IMPORT void* outlet_bang(void*);
MAX_IMPORT void* outlet_float(void*, double);
MAX_IMPORT void* outlet_list(void*, t_symbol*, short, t_atom*);
MAX_IMPORT void* outlet_anything(void*, t_symbol*, short, t_atom*);
MAX_IMPORT void* proxy_new(void*, long, long*);
MAX_IMPORT long proxy_getinlet(t_object*);
MAX_IMPORT void* clock_new(void*, method);
MAX_IMPORT void clock_fdelay(void*, double);
MAX_IMPORT void clock_unset(void*);
MAX_IMPORT void clock_getftime(double*);
MAX_IMPORT void* qelem_new(void*, method);
MAX_IMPORT void qelem_set(void*);
MAX_IMPORT void qelem_free(void*);
MAX_IMPORT short systhread_ismainthread(void);
MAX_IMPORT void critical_enter(t_critical);
MAX_IMPORT void critical_exit(t_critical);
MAX_IMPORT short locatefile_extended(char*, short*, t_fourcc*, const t_fourcc*, short);
MAX_IMPORT short path_getdefault(void);
MAX_IMPORT short path_topathname(short, const char*, char*);
MAX_IMPORT short path_nameconform(const char*, char*, long, long);
MAX_IMPORT t_symbol* jpatcher_get_filepath(t_object*);
MAX_IMPORT t_object* jpatcher_get_parentpatcher(t_object*);
MAX_IMPORT void jdrag_object_add(t_object*, t_object*, t_symbol*);

/* MaxAudio */
MAX_IMPORT void class_dspinit(t_class*);
MAX_IMPORT void z_dsp_setup(t_pxobject*, long);
MAX_IMPORT void z_dsp_free(t_pxobject*);
MAX_IMPORT void dsp_add64(t_object*, t_object*, t_perfroutine64, long, void*);
MAX_IMPORT int sys_getdspobjdspstate(t_object*);
struct t_buffer_ref;
struct t_buffer_obj;
MAX_IMPORT t_buffer_ref* buffer_ref_new(t_object*, t_symbol*);
MAX_IMPORT t_buffer_obj* buffer_ref_getobject(t_buffer_ref*);
MAX_IMPORT float* buffer_locksamples(t_buffer_obj*);
MAX_IMPORT void buffer_unlocksamples(t_buffer_obj*);
MAX_IMPORT t_atom_long buffer_getchannelcount(t_buffer_obj*);
MAX_IMPORT t_atom_long buffer_getframecount(t_buffer_obj*);
}

static_assert(sizeof(void*) == 8, "Max is a 64-bit program");
static_assert(sizeof(t_symbol) == 16 && offsetof(t_symbol, s_thing) == 8, "t_symbol");
static_assert(sizeof(t_object) == 32 && offsetof(t_object, o_outlet) == 24, "t_object");
static_assert(sizeof(t_atom) == 16 && offsetof(t_atom, a_w) == 8, "t_atom");
static_assert(offsetof(t_pxobject, z_in) == 32 && offsetof(t_pxobject, z_proxy) == 40 &&
                  offsetof(t_pxobject, z_disabled) == 48,
              "t_pxobject");
#if defined(_WIN32)
static_assert(sizeof(long) == 4 && offsetof(t_pxobject, z_count) == 52 &&
                  offsetof(t_pxobject, z_misc) == 54 && sizeof(t_pxobject) == 56,
              "t_pxobject on Windows");
#else
static_assert(sizeof(long) == 8 && offsetof(t_pxobject, z_count) == 56 &&
                  offsetof(t_pxobject, z_misc) == 58 && sizeof(t_pxobject) == 64,
              "t_pxobject on macOS and Linux");
#endif
