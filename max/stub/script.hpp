#pragma once

#include "max/stub/audio.hpp"

#include <istream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

/// The script that drives the host: README.md lists its commands.
namespace tactus::stub {

struct ScriptError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Token {
  std::string text;
  bool quoted = false;
};
using Line = std::vector<Token>;
/// Words of a line: blanks separate, "..." keeps them together, # begins a comment.
[[nodiscard]] Line split_line(const std::string& text);
/// 3 is an integer, 3. a float, #nan and #inf too, all else a symbol.
[[nodiscard]] t_atom to_atom(const Token& token);

class Script {
public:
  using Arguments = std::span<const Token>;
  struct Command {
    std::string_view name;
    std::size_t arguments; ///< at least
    std::string_view usage;
    void (Script::*run)(Arguments);
  };

  /// Reads and runs all of it. Throws ScriptError with the number of the line.
  void run(std::istream& stream);
  void execute(const Line& line);
  /// Frees all boxes, writes what is recorded, looks for leaks.
  void finish();
  [[nodiscard]] static std::span<const Command> commands();
  [[nodiscard]] Object& box(const Token& id) const;

private:
  // Boxes (commands_boxes.cpp).
  void load(Arguments a);
  void describe_class(Arguments a);
  void make(Arguments a);
  void free(Arguments a);
  void send(Arguments a);
  void drop(Arguments a);
  void set(Arguments a);
  void get(Arguments a);
  void describe(Arguments a);
  void expect(Arguments a);
  void loadbang(Arguments a);
  void cord(Arguments a);
  void save(Arguments a);
  void restore(Arguments a);
  void value(Arguments a);
  void preset(Arguments a);
  // The host (commands_audio.cpp).
  void signal(Arguments a);
  void rate(Arguments a);
  void vector(Arguments a);
  void inplace(Arguments a);
  void unconnected(Arguments a);
  void dsp(Arguments a);
  void mute(Arguments a);
  void run_vectors(Arguments a);
  void record(Arguments a);
  void levels(Arguments a);
  void advance(Arguments a);
  void service(Arguments a);
  void low_priority(Arguments a);
  void overdrive(Arguments a);
  void thread(Arguments a);
  void search_path(Arguments a);
  void patcher_path(Arguments a);
  void buffer(Arguments a);
  void echo(Arguments a);

  void run_block(std::span<const Line> lines);
  void write_recordings();
  void recompile();

  std::map<std::string, Object*> boxes_;
  struct Recording {
    std::string file;
    std::vector<double> samples;
  };
  std::map<std::string, std::unique_ptr<Recording>> recordings_;
  std::size_t line_ = 0;
  bool low_priority_by_hand_ = false;
};

/// Messages of a main thread (lines that begin with "main") and a scheduler's ("scheduler"), over
/// and over, while an audio thread performs at least so many vectors.
void run_threads(Script& script, std::uint64_t vectors, std::span<const Line> lines);

} // namespace tactus::stub
