#include "programs/body/budget.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

namespace tactus::fem {
namespace {

constexpr double kUnlimited = 1e18;

/// The number in a file, or `otherwise` for "max" and missing files.
double number_in(const std::string& path, double otherwise) {
  std::ifstream file(path);
  double value = 0;
  return file >> value ? value : otherwise;
}

/// The smallest free memory under the limits of this process's control groups.
double control_group_free_bytes() {
  double free_bytes = kUnlimited;
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
      const double limit_bytes = number_in(root + path + limit, kUnlimited);
      if (limit_bytes < kUnlimited)
        free_bytes =
            std::min(free_bytes, std::max(0.0, limit_bytes - number_in(root + path + usage, 0)));
      if (path.rfind('/') == std::string::npos)
        break;
    }
  }
  return free_bytes;
}

std::string format_count(double count) { return format(count < 1e7 ? "%.0f" : "%.2g", count); }

/// Rounds up to two digits, so that a suggested size fits.
double two_digits_up(double x) {
  const double step = std::pow(10, std::floor(std::log10(x)) - 1);
  return std::ceil(x / step - 1e-9) * step;
}

/// The largest x in [1, high] for which fits(x) is true; fits must be true below and false above
/// some x. 0 if there is none.
template <class Predicate> double largest_where(double high, Predicate&& fits) {
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
  const double free_bytes = control_group_free_bytes();
  return kilobytes > 0             ? std::min(1024 * kilobytes, free_bytes)
         : free_bytes < kUnlimited ? free_bytes
                                   : 0;
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
    throw InputError(option + " " + word +
                     ": expected a size of 1M or more, such as 800M, 4G or 1.5GiB");
  return bytes;
}

std::string format_bytes(double bytes) {
  return bytes < 9.995e8 ? format("%.0f MB", bytes / 1e6)
         : bytes < 1e13  ? format("%.3g GB", bytes / 1e9)
                         : format("%.1g GB", bytes / 1e9);
}

std::string format_seconds(double s) {
  return s < 100     ? format("%.0f s", std::max(s, 1.0))
         : s < 6000  ? format("%.0f min", s / 60)
         : s < 3.6e5 ? format("%.0f h", s / 3600)
                     : format("%.3g days", s / 86400);
}

Budget::Budget(double bytes) : bytes_(bytes > 0 ? bytes : free_memory() / 2), given_(bytes > 0) {
  if (!(bytes_ > 0))
    bytes_ = kUnlimited; // without /proc the memory is unknown
}

void Budget::check_budget(const std::string& body, const Workload& work,
                          const WithElementSize& with_element_size, const WithModes& with_modes,
                          double unit, const std::optional<FactorCost>& exact) const {
  const Cost cost = predict_cost(work, exact);
  if (cost.bytes <= (exact ? 1.0 : kCostMargin) * bytes_)
    return;
  const auto fits = [&](const Workload& other, const std::optional<FactorCost>& factor = {}) {
    return predict_cost(other, factor).bytes <= bytes_;
  };
  std::string options;
  const auto suggest = [&](const std::string& option) {
    options += (options.empty() ? "use " : " or ") + option;
  };
  Workload other = work;
  const double modes = largest_where(work.modes, [&](double count) {
    if (with_modes)
      return fits(with_modes(count));
    other.modes = count;
    return fits(other, exact);
  });
  other = work;
  const double triangles = work.acoustic_triangles > 20
                               ? largest_where(work.acoustic_triangles,
                                               [&](double count) {
                                                 other.acoustic_triangles = count;
                                                 return fits(other, exact);
                                               })
                               : 0;
  const Vec3& box = work.mesh.box;
  const double largest = std::max({box.x, box.y, box.z});
  if (triangles >= 20) {
    suggest(format("--acoustic-triangles %.0f", triangles));
  } else if (modes >= 1) {
    suggest(format("--modes %.0f", modes));
  }
  const bool sized_by_modes = with_modes && modes >= 1; // a coarser mesh would not resolve as many
                                                        // modes
  if (with_element_size && !sized_by_modes && fits(with_element_size(largest))) {
    double low = 1e-6 * largest, high = largest;
    for (int i = 0; i < 60; ++i) {
      const double middle = std::sqrt(low * high);
      (fits(with_element_size(middle)) ? high : low) = middle;
    }
    double h = two_digits_up(high / unit);
    while (!fits(with_element_size(h * unit)) &&
           h * unit < largest) // a size may fail, since numbers of elements are whole
      h = two_digits_up(1.05 * h);
    suggest(format("--h %.2g", h));
  }
  suggest("--engine slepc over several machines");
  if (!given_)
    suggest("more memory with --memory");
  throw TooLarge(body + ": " + cost.stage + " would take " + format_bytes(cost.bytes) + " (" +
                 format_count(work.mesh.elements) + " elements, " + format_count(work.mesh.dofs()) +
                 " unknowns, " + format_count(work.modes) + " modes), expected at most " +
                 format_bytes(bytes_) + (given_ ? " (--memory)" : ", half of the free memory") +
                 ": " + options);
}

} // namespace tactus::fem
