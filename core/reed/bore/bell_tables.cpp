// Written by bench/reed_bores/bells.py; geometry and sources are there.
// Poles in rad/s at 20 deg C; see termination.hpp.
#include "core/reed/bore/termination.hpp"

#include <array>

namespace tactus::reed {
namespace {

// clang-format off
constexpr std::array<Termination, 1> kTrumpet{{
    {0, -1, 0.05,
     {{{true, -566.013442, 1544.10508, -1.14934392, -0.494796811},
       {true, -742.718981, 3075.11294, -1.06099868, -0.841859717},
       {true, -1947.44983, 4393.26178, 3.527359, -1.30251052},
       {true, -766.473421, 4757.61128, -0.963986386, 0.0254741143},
       {true, -456.251418, 6307.81997, -0.138417228, 0.00153810713},
       {false, -8.54429361, -224.226022, 0.00800339199, 0.0314012826}}},
     {{{true, -436.287555, 1620.27114, 0.00261120841, 0.00223093167},
       {true, -339.395075, 3142.70493, 0.00175357081, 0.000365374129},
       {true, -4097.00373, 4738.2403, 0.227124912, 0.161217067},
       {false, -965.662289, -48915.8787, 0.00403450868, -0.105920502}}}},
}};
constexpr std::array<Termination, 1> kTrombone{{
    {0, -1, 0.1,
     {{{true, -399.952, 1099.14034, -0.949455605, -0.636481205},
       {true, -513.915164, 2170.04202, -0.425791328, -1.00605534},
       {true, -638.068696, 3216.05183, 0.370985551, -1.27465568},
       {true, -774.767321, 3977.2499, 1.17380431, 0.418072617},
       {true, -423.424499, 4842.1588, -0.0884009171, 0.195669744},
       {false, -6.21685486, -150.617407, 0.00791878186, 0.0285830849}}},
     {{{true, -307.651729, 1180.00314, 0.0023479061, 0.00153482079},
       {true, -230.53496, 2256.58048, 0.00140033801, 0.000198578162},
       {true, -3070.93208, 3485.39858, 0.215264006, 0.16397242},
       {false, -641.088201, -61129.1656, 0.00343042753, -0.109691156}}}},
}};
// clang-format on

} // namespace

std::span<const Termination> bells(BoreEnd end) noexcept {
  switch (end) {
  case BoreEnd::kTrumpet:
    return kTrumpet;
  case BoreEnd::kTrombone:
    return kTrombone;
  default:
    return {};
  }
}

} // namespace tactus::reed
