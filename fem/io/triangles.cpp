#include "fem/io/triangles.hpp"

#include "fem/io/words.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <set>
#include <sstream>

namespace tactus::fem {
namespace {

/// Points that are equal in their last bit but one are one point.
class Welder {
public:
  explicit Welder(Triangles& out) : out_(out) {}
  int put(const Vector3& p) {
    std::array<float, 3> key{static_cast<float>(p.x), static_cast<float>(p.y),
                             static_cast<float>(p.z)};
    for (float& k : key)
      k += 0.0f; // -0 is 0
    const auto [at, added] = known_.try_emplace(key, static_cast<int>(out_.points.size()));
    if (added)
      out_.points.push_back(p);
    return at->second;
  }

private:
  Triangles& out_;
  std::map<std::array<float, 3>, int> known_;
};

void read_binary_stl(const std::string& path, const std::string& bytes, double unit,
                     Triangles& out) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  if (bytes.size() < 84 + 50 * static_cast<std::size_t>(count))
    throw Refusal(path + " promises " + std::to_string(count) + " triangles and ends after " +
                  std::to_string((bytes.size() - 84) / 50));
  Welder welder(out);
  for (std::size_t i = 0; i < count; ++i) {
    std::array<int, 3> triangle;
    for (std::size_t c = 0; c < 3; ++c) {
      std::array<float, 3> p;
      std::memcpy(p.data(), bytes.data() + 84 + 50 * i + 12 + 12 * c, 12);
      if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])))
        throw Refusal(path + ": triangle " + std::to_string(i + 1) +
                      " has a corner that is no number");
      triangle[c] = welder.put({unit * p[0], unit * p[1], unit * p[2]});
    }
    out.triangles.push_back(triangle);
  }
}

Vector3 read_point(std::istringstream& words, const std::string& path, int line, double unit) {
  Vector3 p;
  for (int k = 0; k < 3; ++k) {
    std::string word;
    words >> word;
    const auto value = to_number(word);
    if (!value)
      throw Refusal(path + " line " + std::to_string(line) + ": expected three coordinates");
    p[k] = unit * *value;
  }
  return p;
}

/// Calls use(number, first word, the words after it) for each line that is not blank.
template <class Use> void each_line(const std::string& text, Use&& use) {
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream words(line);
    if (std::string first; words >> first)
      use(number, first, words);
  }
}

void read_ascii_stl(const std::string& path, const std::string& bytes, double unit,
                    Triangles& out) {
  Welder welder(out);
  std::vector<int> corners;
  each_line(bytes, [&](int number, const std::string& written, std::istringstream& words) {
    const std::string word = lower(written);
    if (word == "vertex")
      corners.push_back(welder.put(read_point(words, path, number, unit)));
    if (word != "endfacet")
      return;
    if (corners.size() != 3)
      throw Refusal(path + " line " + std::to_string(number) + ": a facet with " +
                    std::to_string(corners.size()) + " corners, expected 3");
    out.triangles.push_back({corners[0], corners[1], corners[2]});
    corners.clear();
  });
}

void read_obj(const std::string& path, const std::string& bytes, double unit, Triangles& out) {
  Welder welder(out);
  std::vector<int> vertices;
  each_line(bytes, [&](int number, const std::string& kind, std::istringstream& words) {
    if (kind == "v")
      vertices.push_back(welder.put(read_point(words, path, number, unit)));
    if (kind != "f")
      return;
    std::vector<int> corners;
    for (std::string word; words >> word;) {
      const auto index = to_integer(word.substr(0, word.find('/')));
      const int count = static_cast<int>(vertices.size());
      const int at = index ? (*index < 0 ? count + *index : *index - 1) : -1;
      if (at < 0 || at >= count)
        throw Refusal(path + " line " + std::to_string(number) + ": vertex " + word +
                      " does not exist");
      corners.push_back(vertices[static_cast<std::size_t>(at)]);
    }
    for (std::size_t k = 2; k < corners.size(); ++k)
      out.triangles.push_back({corners[0], corners[k - 1], corners[k]});
  });
}

double signed_volume(const Triangles& t, int shell) {
  double sum = 0;
  const Vector3 origin = t.points[0];
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    if (t.shell[i] == shell) {
      const auto at = [&](std::size_t k) {
        return t.points[static_cast<std::size_t>(t.triangles[i][k])] - origin;
      };
      sum += dot(at(0), cross(at(1), at(2))) / 6;
    }
  return sum;
}

Box shell_box(const Triangles& t, int shell) {
  std::vector<Vector3> corners;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    if (t.shell[i] == shell)
      for (const int p : t.triangles[i])
        corners.push_back(t.points[static_cast<std::size_t>(p)]);
  return bounding_box(corners);
}

} // namespace

std::string place_of(const Triangles& t, std::size_t i) {
  const Vector3& p = t.points[static_cast<std::size_t>(t.triangles[i][0])];
  return "triangle " + std::to_string(i + 1) +
         format(" near (%.4g, %.4g, %.4g) mm", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z);
}

Triangles read_triangles(const std::string& path, double unit) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Refusal("cannot read " + path);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  Triangles out;
  if (lower(path).ends_with(".obj")) {
    read_obj(path, bytes, unit, out);
  } else {
    // "solid" at the start is no proof: some binary files begin so.
    const bool ascii = bytes.starts_with("solid") && bytes.find("facet") != std::string::npos &&
                       bytes.find('\0') == std::string::npos;
    if (!ascii && bytes.size() < 84)
      throw Refusal(path + " is no STL file");
    if (ascii)
      read_ascii_stl(path, bytes, unit, out);
    else
      read_binary_stl(path, bytes, unit, out);
  }
  if (out.triangles.empty())
    throw Refusal(path + " holds no triangle");
  return out;
}

void close(Triangles& t) {
  std::erase_if(t.triangles,
                [](const auto& c) { return c[0] == c[1] || c[1] == c[2] || c[2] == c[0]; });
  std::set<std::array<int, 3>> seen;
  std::erase_if(t.triangles, [&](auto c) { // written twice
    std::sort(c.begin(), c.end());
    return !seen.insert(c).second;
  });
  // Every edge belongs to two triangles. Walk from neighbour to neighbour, turning those that run
  // along the shared edge the same way.
  std::map<std::array<int, 2>, std::vector<std::size_t>> edges;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t.triangles[i][k], b = t.triangles[i][(k + 1) % 3];
      edges[{std::min(a, b), std::max(a, b)}].push_back(i);
    }
  const auto open_edges =
      std::count_if(edges.begin(), edges.end(), [](const auto& e) { return e.second.size() == 1; });
  for (const auto& [edge, owners] : edges) {
    if (owners.size() == 1)
      throw Refusal("the surface is open at " + place_of(t, owners[0]) +
                    ": an edge has one triangle, expected two (" + std::to_string(open_edges) +
                    " such edges)");
    if (owners.size() > 2)
      throw Refusal("the surface crosses itself at " + place_of(t, owners[0]) + ": an edge has " +
                    std::to_string(owners.size()) + " triangles, expected two");
  }
  t.shell.assign(t.triangles.size(), -1);
  t.shells = 0;
  for (std::size_t seed = 0; seed < t.triangles.size(); ++seed) {
    if (t.shell[seed] >= 0)
      continue;
    std::vector<std::size_t> open{seed};
    t.shell[seed] = t.shells;
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = t.triangles[i][k], b = t.triangles[i][(k + 1) % 3];
        for (const std::size_t j : edges[{std::min(a, b), std::max(a, b)}]) {
          if (j == i)
            continue;
          bool same = false;
          for (std::size_t m = 0; m < 3; ++m)
            same = same || (t.triangles[j][m] == a && t.triangles[j][(m + 1) % 3] == b);
          if (t.shell[j] >= 0) {
            if (same)
              throw Refusal("the surface has one side only at " + place_of(t, j));
            continue;
          }
          if (same)
            std::swap(t.triangles[j][0], t.triangles[j][1]);
          t.shell[j] = t.shells;
          open.push_back(j);
        }
      }
    }
    ++t.shells;
  }
  // The largest shell is the outside; the others must be cavities in it.
  std::vector<double> volumes;
  volumes.reserve(static_cast<std::size_t>(t.shells));
  for (int s = 0; s < t.shells; ++s)
    volumes.push_back(signed_volume(t, s));
  const auto outer = static_cast<int>(
      std::max_element(volumes.begin(), volumes.end(),
                       [](double a, double b) { return std::abs(a) < std::abs(b); }) -
      volumes.begin());
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    const bool outside = t.shell[i] == outer;
    if ((volumes[static_cast<std::size_t>(t.shell[i])] > 0) != outside)
      std::swap(t.triangles[i][0], t.triangles[i][1]);
  }
  for (int& s : t.shell)
    s = s == outer ? 0 : s == 0 ? outer : s;
  const Box whole = shell_box(t, 0);
  if (!(std::abs(volumes[static_cast<std::size_t>(outer)]) > 0))
    throw Refusal("the surface encloses no volume");
  for (int s = 1; s < t.shells; ++s) {
    const Box inner = shell_box(t, s);
    for (int k = 0; k < 3; ++k)
      if (inner.low[k] < whole.low[k] || inner.high[k] > whole.high[k])
        throw Refusal("the surface has " + std::to_string(t.shells) +
                      " separate pieces, expected one body");
  }
}

double share_of_slivers(const Triangles& t, double degrees) {
  const double limit = std::cos(degrees * std::numbers::pi / 180);
  std::size_t slivers = 0;
  for (const auto& c : t.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3& p = t.points[static_cast<std::size_t>(c[k])];
      const Vector3 a = t.points[static_cast<std::size_t>(c[(k + 1) % 3])] - p;
      const Vector3 b = t.points[static_cast<std::size_t>(c[(k + 2) % 3])] - p;
      if (dot(a, b) > limit * length(a) * length(b)) {
        ++slivers;
        break;
      }
    }
  return static_cast<double>(slivers) / static_cast<double>(t.triangles.size());
}

} // namespace tactus::fem
