#pragma once

#include "core/object.hpp"

/// The one object of a module that a host loads. The module's object file defines it by
/// TACTUS_MODULE_OBJECT, once for each sample type; a host's shell registers what it finds.
namespace tactus {

template <class S> struct ModuleObject {
  Traits traits;
  AnyObject<S>* (*make)(); ///< the caller owns it
};

template <class S> [[nodiscard]] const ModuleObject<S>& module_object();

} // namespace tactus

#define TACTUS_MODULE_OBJECT(Object, Sample)                                                       \
  template <> const tactus::ModuleObject<Sample>& tactus::module_object<Sample>() {                \
    static constexpr tactus::ModuleObject<Sample> object{                                          \
        tactus::traits_of<Object>(),                                                               \
        []() -> tactus::AnyObject<Sample>* { return new tactus::Adapter<Object, Sample>; }};       \
    return object;                                                                                 \
  }
