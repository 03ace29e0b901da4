#include "fem/io/inp_lines.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/mesh.hpp"

#include <algorithm>
#include <tuple>

namespace tactus::fem {
namespace {

/// Like split() at commas, but not at commas within quotation marks.
std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells;
  std::size_t first = 0;
  bool quoted = false;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    quoted ^= i < line.size() && line[i] == '"';
    if (i < line.size() && (quoted || line[i] != ','))
      continue;
    cells.emplace_back(trimmed(line.substr(first, i - first)));
    first = i + 1;
  }
  return cells;
}

std::string without_blanks(std::string text) {
  std::erase_if(text, [](char c) { return c == ' ' || c == '\t'; });
  return lower(text);
}

std::string unquoted(const std::string& text) {
  return text.size() > 1 && text.front() == '"' && text.back() == '"'
             ? text.substr(1, text.size() - 2)
             : text;
}

} // namespace

std::string InpKeyword::value(const std::string& parameter) const {
  const auto at = parameters.find(parameter);
  return at == parameters.end() ? "" : at->second;
}

InpLines::InpLines(const std::string& path) : path_(path), file_(path) {
  if (!file_)
    throw InputError("cannot read " + path);
}

bool InpLines::next() {
  if (!again_.empty()) {
    std::tie(text_, number_) = std::move(again_.back());
    again_.pop_back();
    return true;
  }
  for (std::string line; std::getline(file_, line);) {
    number_ = ++in_file_;
    std::string_view text = line;
    if (number_ == 1 && text.starts_with("\xEF\xBB\xBF"))
      text.remove_prefix(3);
    text_ = trimmed(text);
    if (text_.find('\0') != std::string::npos)
      refuse("a byte of 0, expected text in ASCII or UTF-8");
    if (!text_.empty() && !text_.starts_with("**"))
      return true;
  }
  return false;
}

InpLines::Kept InpLines::keep_until(const std::string& name, const InpKeyword& begin) {
  Kept kept;
  while (next()) {
    if (is_keyword()) {
      const std::string found = without_blanks(text_.substr(1, text_.find(',') - 1));
      if (found == name)
        return kept;
      if (found == begin.name)
        break;
    }
    kept.emplace_back(text_, number_);
  }
  refuse(begin.words + " without its end", begin.line);
}

void InpLines::read_again(const Kept& lines) {
  again_.insert(again_.end(), lines.rbegin(), lines.rend());
}

InpKeyword InpLines::keyword() {
  InpKeyword keyword;
  keyword.line = number_;
  std::string all = text_;
  while (all.ends_with(',')) {
    if (!next() || is_keyword())
      refuse("expected the rest of the line that ends with a comma", keyword.line);
    all += text_;
  }
  const auto cells = cells_of(all);
  keyword.words = printable(cells[0], 60);
  keyword.name = without_blanks(cells[0].substr(1));
  for (std::size_t i = 1; i < cells.size(); ++i) {
    const auto equals = cells[i].find('=');
    const std::string value =
        equals == std::string::npos ? "" : std::string(trimmed(cells[i].substr(equals + 1)));
    keyword.parameters[without_blanks(cells[i].substr(0, equals))] = unquoted(value);
  }
  return keyword;
}

std::vector<std::string> InpLines::cells() const {
  auto cells = cells_of(text_);
  if (cells.back().empty())
    cells.pop_back();
  std::transform(cells.begin(), cells.end(), cells.begin(), unquoted);
  return cells;
}

void InpLines::refuse(const std::string& sentence, int line) const {
  throw InputError(path_ + " line " + std::to_string(line > 0 ? line : number_) + ": " + sentence);
}

double InpLines::number(const std::string& cell) const {
  std::string text = cell;
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == 'd' || c == 'D'; }, 'e');
  const auto value = to_number(text);
  if (!value)
    refuse(printable(cell, 60) + ": not a finite number");
  return *value;
}

} // namespace tactus::fem
