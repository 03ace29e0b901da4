// Written by bench/reed_bores/bells.py; geometry and sources are there.
// Poles in rad/s at 20 deg C; see termination.hpp.
#include "core/reed/termination.hpp"

#include <array>

namespace tactus::reed {
namespace {

// clang-format off
constexpr std::array<Termination, 1> kTrumpet{{
    {0, -1, 0.05,
     {{{true, -834.529937, 2089.7841, -1.11763721, -0.728757686},
       {true, -1100.98813, 4211.32512, -0.530067196, -1.28266356},
       {true, -1559.36858, 6183.70951, 1.50124112, -1.7719784},
       {true, -1443.03248, 7360.10218, 0.429474372, 1.30472572},
       {true, -760.798366, 9430.99294, -0.104155041, 0.0962157592},
       {false, -11.3565209, -299.005646, 0.00740505191, 0.0277766894}}},
     {{{true, -688.38138, 2276.83252, 0.00510186763, 0.00179528868},
       {true, -538.593923, 4549.16938, 0.00202683619, -0.00134932323},
       {true, -5101.97199, 5503.58705, 0.219399171, 0.187306045},
       {false, -1708.83713, -57636.7958, 0.0106713204, -0.0752333375}}}},
}};
constexpr std::array<Termination, 1> kTrombone{{
    {0, -1, 0.05,
     {{{true, -512.11149, 1480.94829, -1.07787477, -0.331651744},
       {true, -589.944977, 2866.10288, -0.533599776, -0.561532683},
       {true, -585.867117, 4164.53839, -0.00116395379, -0.449730416},
       {true, -491.017395, 5462.83262, 0.136067639, -0.130395948},
       {true, -321.305665, 6836.06447, 0.0549299359, -0.0044880015},
       {false, -41.5613818, -3525.18825, 0.0163037376, 3.8089039}}},
     {{{true, -468.661767, 1641.63344, 0.00564093165, 0.00104300654},
       {true, -339.372335, 3230.45192, 0.00103731657, -0.00210164997},
       {true, -3301.15758, 3311.90133, 0.1933277, 0.254732225},
       {false, -1683.93971, -75114.1298, 0.0475241886, -0.0854577809}}}},
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
