#pragma once
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace tactus::fem {

/// A line that begins with `*`, and the lines that continue it.
struct InpKeyword {
  std::string name;  ///< in lower case without blanks, as CalculiX compares it, such as
                     ///< "solidsection"
  std::string words; ///< as written, for messages, such as "*SOLID SECTION"
  std::map<std::string, std::string> parameters; ///< by name in lower case
  int line = 0;

  [[nodiscard]] bool has(const std::string& parameter) const {
    return parameters.contains(parameter);
  }
  /// Returns the parameter's value; empty if it is not given.
  [[nodiscard]] std::string value(const std::string& parameter) const;
};

/// The lines of a CalculiX / Abaqus file, comments (`**`) and empty lines left out.
class InpLines {
public:
  explicit InpLines(const std::string& path);

  /// Goes on to the next line; false at the end.
  bool next();
  [[nodiscard]] bool is_keyword() const noexcept { return text_.front() == '*'; }
  /// The line as a keyword, with the lines that continue it after a comma at its end.
  InpKeyword keyword();
  /// The line's cells between commas; a single comma at the end adds none.
  [[nodiscard]] std::vector<std::string> cells() const;
  [[nodiscard]] const std::string& text() const noexcept { return text_; }
  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  [[nodiscard]] int number() const noexcept { return number_; }

  /// Lines to read again, and their numbers in the file.
  using Kept = std::vector<std::pair<std::string, int>>;
  /// Returns the lines from here to the keyword of that name, which is then the present line.
  [[nodiscard]] Kept keep_until(const std::string& name, const InpKeyword& begin);
  /// Reads these lines next, then those after the current one.
  void read_again(const Kept& lines);

  /// Refuses with file and line; line 0 stands for the current line.
  [[noreturn]] void refuse(const std::string& sentence, int line = 0) const;
  /// Reads a number of the line; accepts Fortran's exponent (1.5D+03).
  [[nodiscard]] double number(const std::string& cell) const;

private:
  const std::string& path_;
  std::ifstream file_;
  std::string text_; ///< blanks around it removed
  int number_ = 0, in_file_ = 0;
  Kept again_; ///< in reverse order
};

} // namespace tactus::fem
