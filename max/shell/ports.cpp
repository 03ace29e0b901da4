#include "max/shell/ports.hpp"

#include "max/shell/atoms.hpp"

namespace tactus::max {

std::size_t count_signal_inlets(const Declaration& declaration) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < declaration.inlets.size(); ++i)
    if (declaration.inlets[i].kind == Port::Kind::kSignal)
      count = i + 1;
  return count;
}

Ports::Ports(t_pxobject& object, const Declaration& declaration, bool processes)
    : outlets_(declaration.outlets.size()) {
  const std::size_t signals = count_signal_inlets(declaration);
  const std::size_t first = processes && signals > 0 ? signals : 1; // Max makes the leftmost inlet
                                                                    // itself
  for (std::size_t i = declaration.inlets.size(); i-- > first;)
    proxies_.push_back(proxy_new(&object, static_cast<long>(i), &object.z_in));
  if (processes)
    z_dsp_setup(&object, static_cast<long>(signals));

  const auto is_info = [](const Port& port) { return port.name == kInfoOutlet; };
  bool declared_info = false;
  for (const Port& port : declaration.outlets)
    declared_info = declared_info || is_info(port);
  if (!declared_info)
    info_ = outlet_new(&object, nullptr);
  for (std::size_t i = declaration.outlets.size(); i-- > 0;) {
    const Port& port = declaration.outlets[i];
    outlets_[i] = outlet_new(&object, port.kind == Port::Kind::kSignal ? "signal" : nullptr);
    if (is_info(port))
      info_ = outlets_[i];
  }
  object_obex_store(&object, gensym("dumpout"), static_cast<t_object*>(info_));
}

Ports::~Ports() {
  for (void* proxy : proxies_)
    object_free(proxy);
}

std::string assistance(const Declaration& declaration, bool is_inlet, std::size_t index) {
  const auto ports = is_inlet ? declaration.inlets : declaration.outlets;
  if (index >= ports.size())
    return is_inlet ? "messages" : "info: answers to get, dump and other queries";
  const Port& port = ports[index];
  std::string text;
  if (port.kind == Port::Kind::kSignal)
    text = is_inlet ? "(signal/float) " : "(signal) ";
  text += port.name;
  if (!port.unit.empty())
    text += ", " + std::string(port.unit);
  return text + ": " + std::string(port.text);
}

} // namespace tactus::max
