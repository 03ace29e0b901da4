#pragma once
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace tactus::fem {

/// A line that begins with `*`, and those it is continued on.
struct InpKeyword {
  std::string name;  ///< in lower case and without blanks, as CalculiX compares it: "solidsection"
  std::string words; ///< as it is written, for messages: "*SOLID SECTION"
  std::map<std::string, std::string> parameters; ///< by their names in lower case
  int line = 0;

  [[nodiscard]] bool has(const std::string& parameter) const {
    return parameters.contains(parameter);
  }
  /// Empty where it is not given.
  [[nodiscard]] std::string value(const std::string& parameter) const;
};

/// The lines of a CalculiX / Abaqus file, comments (`**`) and empty lines left out.
class InpLines {
public:
  explicit InpLines(const std::string& path);

  /// Goes on to the next line; false at the end.
  bool next();
  [[nodiscard]] bool is_keyword() const noexcept { return text_.front() == '*'; }
  /// The line as a keyword, with those that continue it: after a comma at its end.
  InpKeyword keyword();
  /// The line's cells between commas; a single comma at the end adds none.
  [[nodiscard]] std::vector<std::string> cells() const;
  [[nodiscard]] const std::string& text() const noexcept { return text_; }
  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  [[nodiscard]] int number() const noexcept { return number_; }

  /// Lines to read again, and their numbers in the file.
  using Kept = std::vector<std::pair<std::string, int>>;
  /// The lines from here to the keyword of that name, which is the present line then.
  [[nodiscard]] Kept keep_until(const std::string& name, const InpKeyword& begin);
  /// Reads these lines next, then those after the current one.
  void read_again(const Kept& lines);

  /// Refuses with file and line; 0: the current line.
  [[noreturn]] void refuse(const std::string& sentence, int line = 0) const;
  /// A number of the line, also with Fortran's exponent (1.5D+03).
  [[nodiscard]] double number(const std::string& cell) const;

private:
  const std::string& path_;
  std::ifstream file_;
  std::string text_; ///< blanks around it removed
  int number_ = 0, in_file_ = 0;
  Kept again_; ///< in reverse order
};

} // namespace tactus::fem
