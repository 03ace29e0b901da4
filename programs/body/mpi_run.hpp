#pragma once
#include "programs/body/progress.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace tactus::fem {

/// A solver program in the folder of the running program, started by mpirun.
struct MpiEngine {
  const char* option;   ///< the user's option, such as "--engine slepc"
  const char* program;  ///< name of its file, such as "slepc_solve"
  const char* library;  ///< its library, such as "SLEPc"
  const char* packages; ///< Debian's packages, such as "libslepc-real-dev"
};

/// A process with fewer nodes of the mesh would only wait for its neighbours.
inline constexpr std::size_t kMinNodesPerProcess = 50;
/// Refuses so many processes that one would have fewer nodes than this, and more than four
/// processes for each core of this machine. Open MPI's own list of machines lifts the second limit.
void check_ranks(int ranks, std::size_t nodes);

/// Refuses if mpirun or the solver program is missing, and names the Debian packages.
void check_engine(const MpiEngine&);

/// One run of a solver under mpirun. Its input and output files are in a private folder in $TMPDIR
/// (or /tmp), which is always removed, also after an interrupt. mpirun's own settings
/// (OMPI_MCA_...) select the machines; $TMPDIR must then be on a disk that they share. Only one run
/// may exist at a time.
class MpiRun {
public:
  /// `files`: all files that may be created in the folder.
  MpiRun(const MpiEngine&, std::span<const char* const> files);
  ~MpiRun();
  MpiRun(const MpiRun&) = delete;
  MpiRun& operator=(const MpiRun&) = delete;

  /// The path of a file in the folder.
  [[nodiscard]] std::string file(const char* name) const { return folder_ + "/" + name; }
  /// Refuses if the folder's disk has less space.
  void require_disk_space(double bytes) const;
  /// Runs the program on `ranks` processes with these arguments. It shows the lines "stage SHARE
  /// NAME" of the program's standard output and passes the others to `on_line`. Refuses if the
  /// program fails or a process dies, with the program's own sentence ("PROGRAM: ..." on its
  /// standard error) or mpirun's.
  void run(int ranks, const std::vector<std::string>& arguments, ProgressLine& progress,
           const std::function<void(const char* line)>& on_line) const;

private:
  MpiEngine engine_;
  std::string folder_;
};

} // namespace tactus::fem
