#pragma once

#include "max/stub/stub.hpp"

/// The script that drives the host: README.md lists its commands.
namespace tactus::stub {

using Words = std::span<const std::string>;

/// Words of a line: blanks separate, "..." keeps them together.
[[nodiscard]] std::vector<std::string> split_line(const std::string& text);
/// Runs a command. Throws std::runtime_error when there is no such one.
void execute(Words line);
[[nodiscard]] Object& box(const std::string& id);
/// What "send", "get" or "value" do, looked up beforehand.
[[nodiscard]] std::function<void()> prepare(const std::string& command, Words words);
/// Messages of two threads, lines that begin with "main" or "scheduler", over and over, while a
/// third performs at least so many vectors.
void run_threads(std::uint64_t vectors, std::span<const std::vector<std::string>> lines);
/// Frees all boxes and writes what is recorded.
void finish();

} // namespace tactus::stub
