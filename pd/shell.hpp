#pragma once

#include "core/object.hpp"

#include <m_pd.h>

/// The typed shell over Pd: makes a Pd class out of an object's declaration. See pd/README.md.
namespace tactus::pd {

/// One Pd class; lives as long as the module.
struct PdClass {
  t_class* handle;
  Traits traits;
  AnyObject<t_sample>* (*make)();
};

/// Registers the class under its declared name; create is Pd's new-method for it.
using Create = void* (*)(t_symbol*, int, t_atom*);
void register_class(PdClass& record, Create create);
/// Makes an instance; null, after one error sentence, when the creation arguments are malformed.
[[nodiscard]] void* create_instance(PdClass& record, int count, t_atom* atoms);

template <class T> struct External {
  static inline PdClass record{nullptr, traits_of<T>(),
                               []() -> AnyObject<t_sample>* { return new Adapter<T, t_sample>; }};
  static void* create(t_symbol*, int count, t_atom* atoms) {
    return create_instance(record, count, atoms);
  }
  static void setup() { register_class(record, &create); }
};

} // namespace tactus::pd

#ifdef _WIN32
#define TACTUS_PD_EXPORT extern "C" __declspec(dllexport)
#else
#define TACTUS_PD_EXPORT extern "C" __attribute__((visibility("default")))
#endif

/// The function that Pd calls after loading the module, e.g. greed_tilde_setup for [greed~].
#define TACTUS_PD_EXTERNAL(setup_name, Object)                                                     \
  TACTUS_PD_EXPORT void setup_name();                                                              \
  void setup_name() { tactus::pd::External<Object>::setup(); }
