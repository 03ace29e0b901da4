#include "fem/io/cad_format.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/mesh.hpp"

#include <fstream>

namespace tactus::fem {
namespace {

void skip_blanks(std::string_view& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  text.remove_prefix(first == std::string_view::npos ? text.size() : first);
}

} // namespace

std::string cad_format(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw InputError("cannot read " + path);
  std::string head(1024, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  std::string_view text = head;
  skip_blanks(text);
  if (text.starts_with("DBRep_DrawableShape") || text.starts_with("CASCADE Topology"))
    return "brep";
  while (text.starts_with("/*")) {
    const auto end = text.find("*/", 2);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 2);
    skip_blanks(text);
  }
  if (text.starts_with("ISO-10303-21;"))
    return "step";
  const std::string_view line = text.substr(0, text.find('\n'));
  throw InputError(path + " begins with \"" + printable(line, 40) +
                   "\", expected ISO-10303-21; (STEP) or DBRep_DrawableShape (BREP)");
}

} // namespace tactus::fem
