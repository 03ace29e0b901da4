#include "core/guarded.hpp"
#include "pd/host_process.hpp"

#include <string>

#include <m_pd.h>

/// The module `tactus`, for [declare -lib tactus] and `pd -lib tactus`: puts its own folder into
/// Pd's search path, so that every object, abstraction and table of the library is found by its
/// bare name, and each module loads when it is first used. A box [tactus/tactus] does the same.
namespace {

t_class* library;

/// A path in the form that Pd's own dialogs send: '+' in front, and escapes for characters that
/// would end a message.
std::string encoded(const std::string& path) {
  std::string text = "+";
  for (const char c : path)
    switch (c) {
    case ' ':
      text += "+_";
      break;
    case '+':
      text += "++";
      break;
    case ',':
      text += "+c";
      break;
    case ';':
      text += "+s";
      break;
    case '$':
      text += "+d";
      break;
    default:
      text += c;
    }
  return text;
}

/// Pd expects a module to define a class of the module's name.
void* make_box() { return pd_new(library); }

void set_up() {
  library = class_new(gensym("tactus"), reinterpret_cast<t_newmethod>(&make_box), nullptr,
                      sizeof(t_object), CLASS_NOINLET, A_NULL);
  const std::string folder = tactus::pd::module_folder();
  t_pd* pd = gensym("pd")->s_thing;
  if (folder.empty() || !pd)
    return pd_error(nullptr, "tactus: the library's folder was not found: add it to Pd's path");
  t_atom path_and_save[2];
  SETSYMBOL(&path_and_save[0], gensym(encoded(folder).c_str()));
  SETFLOAT(&path_and_save[1], 0); // for this session only
  pd_typedmess(pd, gensym("add-to-path"), 2, path_and_save);
}

} // namespace

#ifdef _WIN32
#define TACTUS_SET_UP __declspec(dllexport)
#else
#define TACTUS_SET_UP __attribute__((visibility("default")))
#endif
extern "C" TACTUS_SET_UP void tactus_setup();
extern "C" TACTUS_SET_UP void tactus_setup() {
  tactus::guarded(&set_up, [](const char* why) { pd_error(nullptr, "tactus: %s", why); });
}
