#pragma once

#include "core/declaration_text.hpp"
#include "core/object.hpp"

#include <atomic>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace tactus::test {

/// A host whose logical time the test advances; records what the object sends and says.
class RecordingHost final : public Host {
public:
  explicit RecordingHost(std::filesystem::path folder = {}, bool real_time = false)
      : folder_(std::move(folder)), real_time_(real_time) {}
  using Host::info;
  using Host::send;
  void send(std::size_t outlet, std::span<const Atom> atoms) override {
    sent[outlet].push_back(numbers(atoms));
  }
  void info(std::span<const Atom> atoms) override {
    std::string text;
    for (const Atom& atom : atoms)
      text += (text.empty() ? "" : " ") +
              (atom.is_word ? std::string(atom.word) : number_text(atom.number));
    infos.push_back(text);
  }
  void error(std::string_view sentence) override { errors.emplace_back(sentence); }
  void log(std::string_view) override {}
  void wake_in(std::size_t, double ms) override { due_ms = ms < 0 ? 1e300 : time_ms + ms; }
  [[nodiscard]] double now_ms() const override { return time_ms; }
  [[nodiscard]] std::string find_file(std::string_view name) const override {
    const std::filesystem::path path = folder_ / name;
    return std::filesystem::is_regular_file(path) ? path.string() : std::string();
  }
  [[nodiscard]] std::string new_file(std::string_view name) const override {
    return std::string(name);
  }
  bool read_array(std::string_view, std::vector<double>&) const override { return false; }
  [[nodiscard]] bool real_time() const override { return real_time_; }
  void wake_from_thread() noexcept override { ++woken; }

  /// What the info outlet said last that begins so; empty: nothing.
  [[nodiscard]] std::string said(const std::string& start) const {
    for (auto one = infos.rbegin(); one != infos.rend(); ++one)
      if (one->starts_with(start))
        return *one;
    return {};
  }

  std::map<std::size_t, std::vector<std::vector<double>>> sent; // by outlet
  std::vector<std::string> infos, errors;
  double time_ms = 0, due_ms = 1e300;
  std::atomic<int> woken{0};

private:
  static std::vector<double> numbers(std::span<const Atom> atoms) {
    std::vector<double> found;
    for (const Atom& atom : atoms)
      if (!atom.is_word)
        found.push_back(atom.number);
    return found;
  }
  std::filesystem::path folder_;
  bool real_time_;
};

} // namespace tactus::test
