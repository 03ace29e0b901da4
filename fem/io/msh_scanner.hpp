#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace tactus::fem {

/// Numbers and sections of an MSH file, text or binary. Every value is read within the file's bytes
/// and within stated limits; everything else is an InputError that names file, line (text) or byte
/// (binary), section, value and expectation.
class MshScanner {
public:
  MshScanner(std::string path, std::string bytes);

  /// The next `$Name` line outside a section; empty at the end of the file. Text outside sections
  /// is refused.
  std::string_view next_section();
  /// Reads `$EndName` of the current section.
  void end_section();
  /// Skips to after `$EndName`.
  void skip_section();

  /// Sets how numbers are stored from here on. `word` is the size of a count in bytes, 4 or 8.
  void set_binary(bool swapped_bytes, std::size_t word);
  [[nodiscard]] bool binary() const noexcept { return binary_; }
  /// Reads text although the file is binary: the head of a section of MSH 2.
  class AsText {
  public:
    explicit AsText(MshScanner& s) : scanner_(s), before_(s.binary_) { s.binary_ = false; }
    ~AsText() { scanner_.binary_ = before_; }
    AsText(const AsText&) = delete;
    AsText& operator=(const AsText&) = delete;

  private:
    MshScanner& scanner_;
    bool before_;
  };

  /// Reads a whole number, 4 bytes in a binary file.
  int integer(const char* what, int low, int high);
  /// Reads a tag, in a binary file as long as a count.
  std::uint64_t tag(const char* what);
  /// Reads the number of items that follow. Refuses it if the remaining bytes cannot hold them: an
  /// item takes `numbers` numbers in text (at least two characters each) or `bytes` bytes.
  std::size_t count(const char* what, std::size_t numbers, std::size_t bytes);
  /// Reads a finite number.
  double real(const char* what);
  /// Reads the rest of the line, without surrounding blanks.
  std::string_view line();
  /// Reads four bytes as stored in the file, where the number 1 shows the byte order.
  std::uint32_t raw_word();

  /// Refuses `value` with the expected value.
  [[noreturn]] void refuse(const std::string& value, const std::string& expected) const;

  [[nodiscard]] std::size_t word() const noexcept { return word_; }

private:
  [[nodiscard]] std::size_t left() const noexcept { return bytes_.size() - at_; }
  void skip_blanks() noexcept;
  std::string_view token();
  [[nodiscard]] std::string printable_value(std::string_view text) const;
  std::uint64_t stored(std::size_t size, const char* what);

  std::string path_, bytes_, section_;
  std::size_t at_ = 0, word_ = 8;
  bool binary_ = false, byte_swapped_ = false;
};

} // namespace tactus::fem
