#pragma once
#include "fem/modes/modes.hpp"
#include "programs/body/progress.hpp"

namespace tactus::fem {

/// Refuses if mpirun or this build's SLEPc program is missing, and names the Debian packages.
void check_slepc();

/// Computes the same modes as find_modes(), by SLEPc with MUMPS on `ranks` processes of mpirun. It
/// exports K, M and the rigid motions into a private folder in $TMPDIR (or /tmp), imports the
/// results, and always removes the folder. mpirun's own settings (OMPI_MCA_...) select the
/// machines; $TMPDIR must then be on a disk that they share. Refuses with one sentence if a step
/// fails.
[[nodiscard]] Modes slepc_modes(const Mesh&, std::span<const Material>, const Matrices&,
                                std::size_t count, int ranks, ProgressLine&);

} // namespace tactus::fem
