#pragma once
#include "fem/modes/modes.hpp"
#include "programs/body/progress.hpp"

namespace tactus::fem {

/// Refuses, naming the Debian packages, when mpirun or this build's SLEPc program is missing.
void check_slepc();

/// The same modes as find_modes(), from SLEPc with MUMPS on `ranks` processes of mpirun: exports K,
/// M and the rigid motions into a private folder in $TMPDIR (or /tmp), imports the results, and
/// always removes the folder. mpirun's own settings (OMPI_MCA_...) select the machines; $TMPDIR
/// must then be on a disk that they share. Refuses with one sentence if a step fails.
[[nodiscard]] Modes slepc_modes(const Mesh&, std::span<const Material>, const Matrices&,
                                std::size_t count, int ranks, ProgressLine&);

} // namespace tactus::fem
