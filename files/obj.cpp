#include "files/mesh_formats.hpp"

#include <algorithm>
#include <array>

namespace tactus::files {
namespace {

constexpr std::array<std::string_view, 16> kFreeForm{
    "curv", "curv2", "surf", "bmat", "cstype", "deg", "step",  "parm",
    "trim", "hole",  "scrv", "sp",   "end",    "con", "stech", "ctech"};
/// Other keywords of the format, which do not contribute to the shape of a solid.
constexpr std::array<std::string_view, 17> kPassedOver{
    "",       "vt",    "vn",       "vp",       "g",   "s",          "usemtl",    "mtllib", "usemap",
    "maplib", "bevel", "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj", "mg"};

bool is_one_of(std::span<const std::string_view> words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Joins lines that end with a backslash, without changing the numbers of the lines after them.
std::string joined(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  std::size_t skipped = 0; // line ends removed from the line being joined
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\') {
      const std::size_t end = text.find_first_not_of(" \t\r", i + 1);
      if (end != std::string_view::npos && text[end] == '\n') {
        out += ' ';
        ++skipped;
        i = end;
        continue;
      }
    } else if (text[i] == '\n') {
      out.append(skipped, '\n');
      skipped = 0;
    }
    out += text[i];
  }
  return out;
}

class ObjReader {
public:
  ObjReader(const MeshLimits& limits, PolygonMesh& mesh) : limits_(limits), mesh_(mesh) {}

  /// Reads one line; false on an error.
  bool line(std::size_t number, Words words) {
    const std::string_view kind = words.next();
    if (kind == "v")
      return add_point(words, number, mesh_);
    if (kind == "f")
      return face(number, words);
    if (kind == "o" || (kind == "g" && !objects_)) {
      if (kind == "o" && !objects_ && mesh_.polygons() == 0)
        mesh_.groups.clear();
      objects_ = objects_ || kind == "o";
      begin_group(words.rest());
    } else if (kind == "l") {
      ++lines_;
    } else if (kind == "p") {
      ++single_points_;
    } else if (is_one_of(kFreeForm, kind)) {
      if (mesh_.free_form.empty())
        mesh_.free_form = line_text(number) + "\"" + std::string(kind) +
                          "\" is a free-form curve or surface, expected polygons (f)";
    } else if (unknown_.empty() && !kind.starts_with('#') && !is_one_of(kPassedOver, kind)) {
      unknown_ = line_text(number) + "\"" + std::string(kind) + "\", expected a keyword of OBJ";
    }
    return true;
  }

  void end() {
    if (mesh_.error.empty() && mesh_.polygons() > 0)
      mesh_.error = unknown_;
    if (mesh_.error.empty() && mesh_.polygons() == 0 && lines_ + single_points_ > 0)
      mesh_.error = "holds " + std::to_string(lines_) + " lines and " +
                    std::to_string(single_points_) +
                    " points and no face: expected the polygons (f) of a closed surface";
  }

private:
  void begin_group(std::string_view name) {
    mesh_.groups.emplace_back(name.empty() ? "part" + std::to_string(mesh_.groups.size() + 1)
                                           : std::string(name));
  }

  /// A corner is "7", "7/1" or "7//2"; "-1" counts from the end.
  bool face(std::size_t number, Words words) {
    const std::size_t begin = mesh_.corner.size();
    const auto count = static_cast<std::int64_t>(mesh_.points.size());
    for (std::string_view word = words.next(); !word.empty() && word[0] != '#';
         word = words.next()) {
      const auto index = to_number<int>(word.substr(0, word.find('/')));
      const std::int64_t at = !index ? -1 : *index < 0 ? count + *index : *index - std::int64_t{1};
      if (at < 0 || at >= count) {
        mesh_.error = line_text(number) + "vertex " + std::string(word) + " does not exist";
        return false;
      }
      mesh_.corner.push_back(static_cast<std::uint32_t>(at));
    }
    const std::size_t corners = mesh_.corner.size() - begin;
    if (corners < 3 || corners > limits_.max_face_corners) {
      mesh_.error = line_text(number) + "a face with " + std::to_string(corners) +
                    " corners, expected 3 " +
                    (limits_.max_face_corners == MeshLimits{}.max_face_corners
                         ? std::string("or more")
                         : "to " + std::to_string(limits_.max_face_corners));
      return false;
    }
    if (mesh_.groups.empty())
      begin_group("");
    mesh_.end.push_back(static_cast<std::uint32_t>(mesh_.corner.size()));
    mesh_.group.push_back(static_cast<std::uint32_t>(mesh_.groups.size() - 1));
    triangles_ += corners - 2;
    return accepts(triangles_, limits_, mesh_);
  }

  const MeshLimits& limits_;
  PolygonMesh& mesh_;
  bool objects_ = false;
  std::string unknown_; ///< error text for the first line without a keyword
  std::size_t lines_ = 0, single_points_ = 0, triangles_ = 0;
};

} // namespace

void read_obj(std::string_view text, const MeshLimits& limits, PolygonMesh& mesh) {
  std::string whole_lines;
  if (text.find('\\') != std::string_view::npos)
    text = whole_lines = joined(text);
  ObjReader reader(limits, mesh);
  for_each_line(text, [&](std::size_t number, std::string_view line) {
    return reader.line(number, Words(line));
  });
  reader.end();
}

} // namespace tactus::files
