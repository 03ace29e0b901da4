#pragma once

#include "core/object.hpp"

namespace tactus {

/// The Host that an object's dump() is given when `get` asks for one name: it passes on only the
/// info lines that begin with this name.
class NamedLines final : public Host {
public:
  NamedLines(Host& host, std::string_view name) : host_(host), name_(name) {}
  /// Whether a line has begun with the name.
  [[nodiscard]] bool found() const noexcept { return found_; }

  void info(std::span<const Atom> atoms) override {
    if (atoms.empty() || !atoms[0].is_word || atoms[0].word != name_)
      return;
    found_ = true;
    host_.info(atoms);
  }
  void send(std::size_t, std::span<const Atom>) override {}
  void error(std::string_view sentence) override { host_.error(sentence); }
  void log(std::string_view sentence) override { host_.log(sentence); }
  void wake_in(std::size_t timer, double milliseconds) override {
    host_.wake_in(timer, milliseconds);
  }
  double now_ms() const override { return host_.now_ms(); }
  double created_ms() const override { return host_.created_ms(); }
  std::string find_file(std::string_view name) const override { return host_.find_file(name); }
  std::string new_file(std::string_view name) const override { return host_.new_file(name); }
  bool read_array(std::string_view name, std::vector<double>& values) const override {
    return host_.read_array(name, values);
  }
  bool real_time() const override { return host_.real_time(); }
  bool publish(std::string_view name, const std::shared_ptr<void>& what) override {
    return host_.publish(name, what);
  }
  std::shared_ptr<void> find_published(std::string_view name) const override {
    return host_.find_published(name);
  }
  void wake_from_thread() noexcept override { host_.wake_from_thread(); }
  using Host::info;
  using Host::send;

private:
  Host& host_;
  std::string_view name_;
  bool found_ = false;
};

/// Sends the lines of dump_first() and dump() that begin with the name; false if there are none.
template <class S>
[[nodiscard]] bool send_named_lines(AnyObject<S>& object, std::string_view name, Host& host) {
  NamedLines lines(host, name);
  object.dump_first(lines);
  object.dump(lines);
  return lines.found();
}

} // namespace tactus
