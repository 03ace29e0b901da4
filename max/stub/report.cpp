// What the host says, in order.
#include "max/stub/kernel.hpp"

#include <cstdio>
#include <set>

namespace tactus::stub {
namespace {
std::mutex report_mutex;
std::set<std::string>& reported() {
  static std::set<std::string> texts;
  return texts;
}
thread_local std::vector<std::string>* collected = nullptr;
} // namespace

void collect_lines(std::vector<std::string>* lines) { collected = lines; }

void print_line(const std::string& line) {
  const HostWork work;
  if (collected) {
    collected->push_back(line);
    return;
  }
  std::fprintf(stdout, "%s\n", line.c_str());
  std::fflush(stdout);
}

void violation(const std::string& text) {
  const HostWork work;
  const std::string where = describe_call();
  const std::string line = "violation: " + text + (where.empty() ? "" : " [in " + where + "]");
  const std::lock_guard lock(report_mutex);
  if (!reported().insert(line).second)
    return;
  std::fprintf(stdout, "%s\n", line.c_str());
  std::fflush(stdout);
}

std::size_t violation_count() {
  const std::lock_guard lock(report_mutex);
  return reported().size();
}

} // namespace tactus::stub
