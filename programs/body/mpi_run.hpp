#pragma once
#include "programs/body/progress.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace tactus::fem {

/// A solver program in the folder of the running program, started by mpirun.
struct MpiEngine {
  const char* option;   ///< how the user chose it, "--engine slepc"
  const char* program;  ///< its file, "slepc_solve"
  const char* library;  ///< what it is built with, "SLEPc"
  const char* packages; ///< Debian's, "libslepc-real-dev"
};

/// A process with fewer nodes of the mesh would only wait for its neighbours.
inline constexpr std::size_t kMinNodesPerProcess = 50;
/// Refuses more processes than have so many nodes each, or than four for each core of this machine;
/// Open MPI's own list of machines lifts the second limit.
void check_ranks(int ranks, std::size_t nodes);

/// Refuses, naming the Debian packages, when mpirun or the solver program is missing.
void check_engine(const MpiEngine&);

/// One run of a solver under mpirun: a private folder in $TMPDIR (or /tmp) for the files that go in
/// and out, which is removed whatever happens, interrupts included. mpirun's own settings
/// (OMPI_MCA_...) choose the machines; $TMPDIR must then lie on a disk they share. One at a time.
class MpiRun {
public:
  /// `files`: all files that may be created in the folder.
  MpiRun(const MpiEngine&, std::span<const char* const> files);
  ~MpiRun();
  MpiRun(const MpiRun&) = delete;
  MpiRun& operator=(const MpiRun&) = delete;

  /// The path of a file in the folder.
  [[nodiscard]] std::string file(const char* name) const { return folder_ + "/" + name; }
  /// Refuses when the folder's disk has less room.
  void require_disk_space(double bytes) const;
  /// Runs the program on `ranks` processes with these arguments. Lines "stage SHARE NAME" of its
  /// standard output are shown; `on_line` gets the others. Refuses when it fails or a process dies,
  /// with the program's own sentence
  /// ("PROGRAM: ..." on its standard error) or mpirun's.
  void run(int ranks, const std::vector<std::string>& arguments, ProgressLine& progress,
           const std::function<void(const char* line)>& on_line) const;

private:
  MpiEngine engine_;
  std::string folder_;
};

} // namespace tactus::fem
