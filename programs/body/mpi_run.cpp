#include "programs/body/mpi_run.hpp"

#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"
#include "programs/body/budget.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <sys/prctl.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace tactus::fem {
namespace {

namespace fs = std::filesystem;

std::string solver_path(const MpiEngine& engine) {
  return (fs::read_symlink("/proc/self/exe").parent_path() / engine.program).string();
}

std::string mpirun_path() {
  const char* path = std::getenv("PATH");
  for (const std::string& folder : split(path ? path : "/usr/bin", ':'))
    if (std::string file = folder + "/mpirun"; ::access(file.c_str(), X_OK) == 0)
      return file;
  return {};
}

constexpr const char* kErrors = "errors"; ///< file with the standard error of the processes

// The processes to end and the files to remove after an interrupt, stored so that a signal handler
// may use them.
std::array<std::array<char, 512>, 8> g_files;
std::array<char, 512> g_folder;
std::atomic<pid_t> g_child{0};

void remove_on_interrupt() {
  if (const pid_t child = g_child.load())
    ::kill(-child, SIGTERM);
  for (const auto& file : g_files)
    if (file[0] != '\0')
      ::unlink(file.data());
  ::rmdir(g_folder.data());
}

/// Starts mpirun in its own process group; its standard output can be read.
pid_t start(const MpiEngine& engine, const std::vector<std::string>& words,
            const std::string& errors, int& output) {
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0)
    throw InputError(std::string(engine.option) +
                     ": cannot create a pipe: " + std::strerror(errno));
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const std::string& word : words)
    arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    ::dup2(pipe[1], STDOUT_FILENO);
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, STDIN_FILENO);
    const int log = ::open(errors.c_str(), O_WRONLY | O_CREAT, 0600);
    ::dup2(log, STDERR_FILENO);
    ::setenv("OPENBLAS_NUM_THREADS", "1", 0);
    ::setenv("OMP_NUM_THREADS", "1", 0);
    ::setenv("OMPI_MCA_mpi_yield_when_idle", "1",
             0);            // waiting processes yield their core
    if (::geteuid() == 0) { // Open MPI requires two variables to run as root
      ::setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
      ::setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
    }
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(pipe[1]);
  output = pipe[0];
  if (child < 0) {
    ::close(output);
    throw InputError(std::string(engine.option) + ": cannot start mpirun: " + std::strerror(errno));
  }
  g_child = child;
  return child;
}

/// The solver's own sentence, else the last line that is not decoration.
std::string last_error_line(const MpiEngine& engine, const std::string& path) {
  const std::string own = std::string(engine.program) + ": ";
  std::ifstream file(path);
  std::string last = "no reason given";
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(own))
      return line.substr(own.size());
    if (line.find_first_of("abcdefghijklmnopqrstuvwxyz") != std::string::npos)
      last = line;
  }
  return last;
}

} // namespace

void check_ranks(int ranks, std::size_t nodes) {
  const std::size_t by_nodes = std::max<std::size_t>(1, nodes / kMinNodesPerProcess);
  if (static_cast<std::size_t>(ranks) > by_nodes)
    throw InputError(format("--ranks %d: expected at most %zu processes for %zu nodes, %zu each",
                            ranks, by_nodes, nodes, kMinNodesPerProcess));
  const int by_cores = 4 * static_cast<int>(std::max(4U, std::thread::hardware_concurrency()));
  if (ranks > by_cores && !std::getenv("OMPI_MCA_orte_default_hostfile"))
    throw InputError(format("--ranks %d: expected at most %d processes on this machine; others are "
                            "named by OMPI_MCA_orte_default_hostfile",
                            ranks, by_cores));
}

void check_engine(const MpiEngine& engine) {
  const std::string option = engine.option;
  if (::access(solver_path(engine).c_str(), X_OK) != 0)
    throw InputError(option + ": this program was built without " + engine.library +
                     ": install Debian's " + engine.packages + " and openmpi-bin and build again");
  if (mpirun_path().empty())
    throw InputError(option + ": mpirun was not found: install Debian's openmpi-bin");
}

MpiRun::MpiRun(const MpiEngine& engine, std::span<const char* const> files) : engine_(engine) {
  const char* temporary = std::getenv("TMPDIR");
  std::string pattern =
      std::string(temporary && *temporary ? temporary : "/tmp") + "/" + engine.program + ".XXXXXX";
  constexpr std::size_t kMaxNameLength = 16;
  if (files.size() + 1 > g_files.size() || pattern.size() + kMaxNameLength > g_folder.size() ||
      !::mkdtemp(pattern.data()))
    throw InputError(std::string(engine.option) + ": cannot create the folder " + pattern + ": " +
                     std::strerror(errno));
  folder_ = pattern;
  std::copy_n(folder_.c_str(), folder_.size() + 1, g_folder.data());
  for (auto& path : g_files)
    path[0] = '\0';
  for (std::size_t i = 0; i <= files.size(); ++i) {
    const std::string path = file(i < files.size() ? files[i] : kErrors);
    std::copy_n(path.c_str(), std::min(path.size() + 1, g_files[i].size()), g_files[i].data());
  }
  also_on_interrupt(remove_on_interrupt);
}

MpiRun::~MpiRun() {
  also_on_interrupt(nullptr);
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void MpiRun::require_disk_space(double bytes) const {
  struct statvfs disk {};
  const double free_bytes =
      ::statvfs(folder_.c_str(), &disk) == 0
          ? static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize)
          : bytes;
  if (free_bytes < bytes)
    throw InputError(std::string(engine_.option) + ": " + folder_ + " has " +
                     format_bytes(free_bytes) + " free, expected " + format_bytes(bytes) +
                     ": set TMPDIR to a larger disk");
}

void MpiRun::run(int ranks, const std::vector<std::string>& arguments, ProgressLine& progress,
                 const std::function<void(const char* line)>& on_line) const {
  std::vector<std::string> words{mpirun_path(), "--oversubscribe",     "--bind-to",         "none",
                                 "-n",          std::to_string(ranks), solver_path(engine_)};
  words.insert(words.end(), arguments.begin(), arguments.end());
  int output = -1;
  const pid_t child = start(engine_, words, file(kErrors), output);
  {
    std::FILE* lines = ::fdopen(output, "r");
    char line[256], stage[128];
    double share = 0;
    while (std::fgets(line, sizeof line, lines))
      if (std::sscanf(line, "stage %lf %127[^\n]", &share, stage) == 2)
        progress.stage(engine_.library + (": " + std::string(stage)), share);
      else
        on_line(line);
    std::fclose(lines);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR)
    ;
  g_child = 0;
  if (status != 0)
    throw InputError(std::string(engine_.option) +
                     " failed: " + last_error_line(engine_, file(kErrors)));
}

} // namespace tactus::fem
