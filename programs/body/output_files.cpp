#include "programs/body/output_files.hpp"

#include "programs/body/budget.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tactus::fem {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return folder.empty() ? "." : folder;
}

std::string beside_program(const std::string& script) {
  return (fs::read_symlink("/proc/self/exe").parent_path() / script).string();
}

/// Runs Debian's Python; returns whether it succeeded. Python is isolated (-I), so it uses no
/// modules of the current folder and no PYTHON variables. It starts in / so that it reads no
/// `matplotlibrc` here.
bool python(std::vector<std::string> words) {
  words.insert(words.begin(), {"python3", "-I"});
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words)
    arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (chdir("/") == 0)
      execv("/usr/bin/python3", arguments.data());
    _exit(127);
  }
  int status = 0;
  return child > 0 && waitpid(child, &status, 0) == child && status == 0;
}

} // namespace

void check_output(const std::string& option, const std::string& path) {
  const std::string label = option + " " + path;
  const fs::path folder = folder_of(path);
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw InputError(label + ": there is no folder " + folder.string());
  if (fs::path(path).filename().empty() || fs::is_directory(path, error))
    throw InputError(label + " is a folder, expected the name of a file in it");
  if (fs::exists(path, error) && !fs::is_regular_file(path, error))
    throw InputError(
        label +
        " is a device or pipe, expected a file: outputs are written complete or not at all");
  if (fs::exists(path, error) && ::access(path.c_str(), W_OK) != 0)
    throw InputError(label + ": cannot write: " + std::strerror(errno));
  // The file will be written under another name in its folder and then renamed. This tests whether
  // that is possible.
  std::string trial = path + ".pXXXXXX"; // as long as the suffix .partial
  const int file = ::mkstemp(trial.data());
  if (file < 0)
    throw InputError(label + ": cannot write: " + std::strerror(errno));
  ::close(file);
  ::unlink(trial.c_str());
}

void check_outputs(std::span<const Output> all, const BodyOptions& options) {
  const auto same = [](const std::string& a, const std::string& b) {
    return fs::weakly_canonical(fs::absolute(a)) == fs::weakly_canonical(fs::absolute(b));
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].path.empty())
      continue;
    check_output(all[i].option, all[i].path);
    if (options.is_file && same(all[i].path, options.body))
      throw InputError(std::string(all[i].option) + " " + all[i].path + " is the body's own file");
    for (std::size_t j = 0; j < i; ++j)
      if (!all[j].path.empty() && same(all[i].path, all[j].path))
        throw InputError(std::string(all[j].option) + " and " + all[i].option +
                         " name the same file " + all[i].path);
  }
}

void check_disk_space(std::span<const Output> all) {
  for (const Output& out : all) {
    struct statvfs disk {};
    if (out.path.empty() || ::statvfs(folder_of(out.path).c_str(), &disk) != 0)
      continue; // writing the file will report the error
    const double free_bytes =
        static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
    if (out.bytes > free_bytes)
      throw TooLarge(std::string(out.option) + " " + out.path + " would take " +
                     format_bytes(out.bytes) + ", the disk has " + format_bytes(free_bytes) +
                     " free");
  }
}

void check_sheet(const std::string& script) {
  if (!fs::exists(beside_program(script)) ||
      !python({"-c", "import importlib.util, sys; "
                     "sys.exit(importlib.util.find_spec('matplotlib') is None)"}))
    throw InputError("--sheet needs python3-matplotlib and " + beside_program(script));
}

void draw_sheet(const std::string& script, const std::string& table, const std::string& picture,
                const std::vector<std::string>& more) {
  std::vector<std::string> words{beside_program(script), fs::absolute(table).string(),
                                 fs::absolute(picture).string()};
  words.insert(words.end(), more.begin(), more.end());
  if (!python(words))
    throw InputError(beside_program(script) + " could not draw the picture sheet " + picture);
}

std::string date_of_now() {
  if (std::getenv("SOURCE_DATE_EPOCH"))
    return {};
  const std::time_t time = std::time(nullptr);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&time));
  return text;
}

} // namespace tactus::fem
