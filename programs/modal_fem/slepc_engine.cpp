#include "programs/modal_fem/slepc_engine.hpp"

#include "fem/io/exchange.hpp"
#include "fem/io/safe_file.hpp"
#include "fem/io/words.hpp"
#include "fem/modes/rigid.hpp"
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
#include <numbers>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tactus::fem {
namespace {

namespace fs = std::filesystem;

std::string solver_path() {
  return (fs::read_symlink("/proc/self/exe").parent_path() / "slepc_solve").string();
}

std::string mpirun_path() {
  const char* path = std::getenv("PATH");
  for (const std::string& folder : split(path ? path : "/usr/bin", ':'))
    if (const std::string file = folder + "/mpirun"; ::access(file.c_str(), X_OK) == 0)
      return file;
  return {};
}

// What an interrupt has to end and remove, within what a signal handler may do.
constexpr std::array<const char*, 5> kFiles{"matrices", "rigid", "values", "vectors", "errors"};
std::array<std::array<char, 512>, kFiles.size()> g_files;
std::array<char, 512> g_folder;
std::atomic<pid_t> g_child{0};

void remove_on_interrupt() {
  if (const pid_t child = g_child.load())
    ::kill(-child, SIGTERM);
  for (const auto& file : g_files)
    ::unlink(file.data());
  ::rmdir(g_folder.data());
}

/// A private folder that goes away with this object.
class Folder {
public:
  Folder() {
    const char* temporary = std::getenv("TMPDIR");
    std::string pattern =
        std::string(temporary && *temporary ? temporary : "/tmp") + "/modal_fem.XXXXXX";
    if (pattern.size() + 16 > g_folder.size() || !::mkdtemp(pattern.data()))
      throw Refusal("--engine slepc: cannot make a folder " + pattern + ": " +
                    std::strerror(errno));
    path_ = pattern;
    std::copy_n(path_.c_str(), path_.size() + 1, g_folder.data());
    for (std::size_t i = 0; i < kFiles.size(); ++i) {
      const std::string file = path_ + "/" + kFiles[i];
      std::copy_n(file.c_str(), file.size() + 1, g_files[i].data());
    }
    also_on_interrupt(remove_on_interrupt);
  }
  ~Folder() {
    also_on_interrupt(nullptr);
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string file(const char* name) const { return path_ + "/" + name; }
  void need_room(double bytes) const {
    struct statvfs disk {};
    const double room =
        ::statvfs(path_.c_str(), &disk) == 0
            ? static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize)
            : bytes;
    if (room < bytes)
      throw Refusal("--engine slepc: " + path_ + " has room for " + words_of_bytes(room) +
                    ", expected " + words_of_bytes(bytes) + ": set TMPDIR to a larger disk");
  }

private:
  std::string path_;
};

/// Starts mpirun in a process group of its own; its standard output comes back.
pid_t start(const std::vector<std::string>& words, const std::string& errors, int& output) {
  std::array<int, 2> pipe{};
  if (::pipe2(pipe.data(), O_CLOEXEC) != 0)
    throw Refusal(std::string("--engine slepc: no pipe: ") + std::strerror(errno));
  std::vector<char*> arguments;
  for (const std::string& word : words)
    arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::setpgid(0, 0);
    ::dup2(pipe[1], STDOUT_FILENO);
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, STDIN_FILENO);
    const int log = ::open(errors.c_str(), O_WRONLY | O_CREAT, 0600);
    ::dup2(log, STDERR_FILENO);
    ::setenv("OPENBLAS_NUM_THREADS", "1", 0);
    ::setenv("OMP_NUM_THREADS", "1", 0);
    if (::geteuid() == 0) { // Open MPI refuses root unless told twice
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
    throw Refusal(std::string("--engine slepc: cannot start mpirun: ") + std::strerror(errno));
  }
  g_child = child;
  return child;
}

/// The solver's own sentence, else the last line that is no ornament.
std::string last_complaint(const std::string& path) {
  std::ifstream file(path);
  std::string last = "no reason given";
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("slepc_solve: "))
      return line.substr(13);
    if (line.find_first_of("abcdefghijklmnopqrstuvwxyz") != std::string::npos)
      last = line;
  }
  return last;
}

} // namespace

void check_slepc() {
  if (::access(solver_path().c_str(), X_OK) != 0)
    throw Refusal("--engine slepc: this modal_fem was built without SLEPc; install Debian's "
                  "libslepc-real-dev and openmpi-bin and build again");
  if (mpirun_path().empty())
    throw Refusal("--engine slepc: there is no mpirun; install Debian's openmpi-bin");
}

Modes slepc_modes(const Mesh& mesh, std::span<const Material> materials, const Matrices& matrices,
                  std::size_t count, int ranks, ProgressLine& progress) {
  const std::size_t n = matrices.dofs();
  const std::vector<double> rigid = rigid_motions(mesh, matrices);
  const std::size_t held =
      static_cast<std::size_t>(std::count(matrices.held.begin(), matrices.held.end(), 1));
  // A few more than asked for, as in find_modes; SLEPc finds no more than there are.
  const std::size_t wanted = std::min(count + 4, n - held - rigid.size() / n);
  const Folder folder;
  // Both matrices, both triangles: 9 + 3 entries of 12 bytes a pair of nodes, and the vectors.
  folder.need_room(2 * 12 * 12. * static_cast<double>(matrices.graph.row.size()) +
                   8. * static_cast<double>(n * (wanted + 16)));
  progress.stage("exporting the matrices", 0);
  write_petsc(folder.file("matrices"), matrices);
  write_petsc_vectors(folder.file("rigid"), rigid, n);

  progress.stage("starting SLEPc", 0);
  int output = -1;
  const pid_t child =
      start({mpirun_path(), "--oversubscribe", "--bind-to", "none", "-n", std::to_string(ranks),
             solver_path(), folder.file("matrices"), folder.file("rigid"), folder.file("values"),
             folder.file("vectors"), std::to_string(wanted), std::to_string(rigid.size() / n),
             format("%.17g", usual_shift(mesh, materials))},
            folder.file("errors"), output);
  double peak = 0;
  {
    std::FILE* lines = ::fdopen(output, "r");
    char line[256], stage[128];
    double share = 0;
    while (std::fgets(line, sizeof line, lines)) {
      if (std::sscanf(line, "stage %lf %127[^\n]", &share, stage) == 2)
        progress.stage("SLEPc: " + std::string(stage), share);
      else
        std::sscanf(line, "peak %lf", &peak);
    }
    std::fclose(lines);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR)
    ;
  g_child = 0;
  if (status != 0)
    throw Refusal("--engine slepc failed: " + last_complaint(folder.file("errors")));
  progress.say(format("%d processes, at most ", ranks) + words_of_bytes(peak) + " each");

  progress.stage("importing the modes", 0);
  Modes modes = import_modes(folder.file("values"), folder.file("vectors"), mesh, matrices, false);
  const std::size_t kept = std::min(count, modes.frequency_hz.size());
  modes.frequency_hz.resize(kept);
  modes.multiplicity.resize(kept);
  modes.residual.resize(kept);
  modes.shapes.resize(kept * n);
  return modes;
}

} // namespace tactus::fem
