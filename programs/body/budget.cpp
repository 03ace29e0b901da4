#include "programs/body/budget.hpp"

#include "fem/io/words.hpp"
#include "fem/mesh/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace tactus::fem {
namespace {

constexpr double kUnlimited = 1e18;

/// A file's one number, or `otherwise` ("max" and missing files).
double number_in(const std::string& path, double otherwise) {
  std::ifstream file(path);
  double value = 0;
  return file >> value ? value : otherwise;
}

/// What the control groups above this process leave of their limits.
double control_group_room() {
  double room = kUnlimited;
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const auto cells = split(line, ':');
    if (cells.size() < 3)
      continue;
    const bool second = cells[0] == "0";
    if (!second && cells[1].find("memory") == std::string::npos)
      continue;
    const std::string root = second ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
    const std::string limit = second ? "/memory.max" : "/memory.limit_in_bytes";
    const std::string usage = second ? "/memory.current" : "/memory.usage_in_bytes";
    // Each group up to the root may set a limit.
    for (std::string path = cells[2];; path.erase(path.rfind('/'))) {
      if (path == "/")
        path.clear();
      const double most = number_in(root + path + limit, kUnlimited);
      if (most < kUnlimited)
        room = std::min(room, std::max(0.0, most - number_in(root + path + usage, 0)));
      if (path.rfind('/') == std::string::npos)
        break;
    }
  }
  return room;
}

std::string words_of_count(double count) { return format(count < 1e7 ? "%.0f" : "%.2g", count); }

/// Rounded up to two digits, so that what is suggested fits.
double two_digits_up(double x) {
  const double step = std::pow(10, std::floor(std::log10(x)) - 1);
  return std::ceil(x / step - 1e-9) * step;
}

/// The largest x in [1, high] that `fits`, for fits that are true below and false above; 0: none.
template <class Fits> double largest_that(double high, Fits&& fits) {
  if (!fits(1.0))
    return 0;
  double low = 1;
  while (high - low > 1) {
    const double middle = std::floor((low + high) / 2);
    (fits(middle) ? low : high) = middle;
  }
  return low;
}

} // namespace

double free_memory() {
  double kilobytes = 0;
  std::ifstream file("/proc/meminfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("MemAvailable:")) {
      std::istringstream(line.substr(13)) >> kilobytes;
      break;
    }
  const double room = control_group_room();
  return kilobytes > 0 ? std::min(1024 * kilobytes, room) : room < kUnlimited ? room : 0;
}

double read_memory(const std::string& option, const std::string& word) {
  const auto letters = word.find_first_not_of("0123456789.");
  const std::string unit = lower(letters == std::string::npos ? "" : word.substr(letters));
  const auto value = to_number(word.substr(0, letters));
  static const std::string kPrefixes = "kmgt";
  const bool binary = unit.size() > 1 && unit[1] == 'i';
  const auto power = unit.empty() || unit == "b" ? 0 : kPrefixes.find(unit[0]) + 1;
  const std::string rest = power == 0 ? "" : unit.substr(binary ? 2 : 1);
  const double bytes =
      value && power <= 4 ? *value * std::pow(binary ? 1024 : 1000, static_cast<double>(power)) : 0;
  if (!(rest.empty() || rest == "b") || !(bytes >= 1e6 && bytes <= 1e16))
    throw Refusal(option + " " + word + ": expected a size from 1M, such as 800M, 4G or 1.5GiB");
  return bytes;
}

std::string words_of_bytes(double bytes) {
  return bytes < 9.995e8 ? format("%.0f MB", bytes / 1e6)
         : bytes < 1e13  ? format("%.3g GB", bytes / 1e9)
                         : format("%.1g GB", bytes / 1e9);
}

std::string words_of_seconds(double s) {
  return s < 100     ? format("%.0f s", std::max(s, 1.0))
         : s < 6000  ? format("%.0f min", s / 60)
         : s < 3.6e5 ? format("%.0f h", s / 3600)
                     : format("%.3g days", s / 86400);
}

Budget::Budget(double bytes) : bytes_(bytes > 0 ? bytes : free_memory() / 2), given_(bytes > 0) {
  if (!(bytes_ > 0))
    bytes_ = kUnlimited; // no /proc: nobody can tell
}

void Budget::hold(const std::string& body, const Workload& work, const Resized& resized,
                  const Fewer& fewer, double unit, const std::optional<FactorCost>& exact) const {
  const Cost cost = foretell(work, exact);
  if (cost.bytes <= (exact ? 1.0 : kCostMargin) * bytes_)
    return;
  const auto fits = [&](const Workload& other, const std::optional<FactorCost>& factor = {}) {
    return foretell(other, factor).bytes <= bytes_;
  };
  std::string options;
  const auto offer = [&](const std::string& option) {
    options += (options.empty() ? "take " : " or ") + option;
  };
  Workload other = work;
  const double modes = largest_that(work.modes, [&](double count) {
    if (fewer)
      return fits(fewer(count));
    other.modes = count;
    return fits(other, exact);
  });
  other = work;
  const double triangles = work.acoustic_triangles > 20
                               ? largest_that(work.acoustic_triangles,
                                              [&](double count) {
                                                other.acoustic_triangles = count;
                                                return fits(other, exact);
                                              })
                               : 0;
  const Vector3& box = work.mesh.box;
  const double largest = std::max({box.x, box.y, box.z});
  if (triangles >= 20) {
    offer(format("--acoustic-triangles %.0f", triangles));
  } else if (modes >= 1) {
    offer(format("--modes %.0f", modes));
  }
  const bool sized_by_modes = fewer && modes >= 1; // a coarser mesh would not resolve as many
  if (resized && !sized_by_modes && fits(resized(largest))) {
    double low = 1e-6 * largest, high = largest;
    for (int i = 0; i < 60; ++i) {
      const double middle = std::sqrt(low * high);
      (fits(resized(middle)) ? high : low) = middle;
    }
    double h = two_digits_up(high / unit);
    while (!fits(resized(h * unit)) && h * unit < largest) // counts are whole numbers
      h = two_digits_up(1.05 * h);
    offer(format("--h %.2g", h));
  }
  offer("--engine slepc over several machines");
  if (!given_)
    offer("more with --memory");
  throw TooLarge(body + ": " + cost.stage + " would take " + words_of_bytes(cost.bytes) + " (" +
                 words_of_count(work.mesh.elements) + " elements, " +
                 words_of_count(work.mesh.dofs()) + " unknowns, " + words_of_count(work.modes) +
                 " modes), expected at most " + words_of_bytes(bytes_) +
                 (given_ ? " (--memory)" : ", half of what is free") + ": " + options);
}

} // namespace tactus::fem
