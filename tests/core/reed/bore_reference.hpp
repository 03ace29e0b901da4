// Written by bench/reed_bores/reference.py, by finite elements.
#pragma once

#include "core/reed/termination.hpp"

#include <array>
#include <string_view>

namespace tactus::reed::test {

/// Peaks of the input impedance of a bore with its holes, below the lattice's cut-off.
struct BoreReference {
  BoreEnd end;
  int key;
  double length; // of the line, m
  struct Peak {
    double hz, level; // dB over the input's Z_0
  };
  std::array<Peak, 5> peaks; // 0 Hz: no more
};

inline constexpr BoreReference kBoreReference[]{
    {BoreEnd::kClarinet, 50, 0.564629235, {{{136.614, 31.222}, {411.290, 26.174}, {680.209, 23.224}, {933.679, 19.410}, {1159.946, 14.102}}}},
    {BoreEnd::kClarinet, 51, 0.531816517, {{{151.606, 31.327}, {457.196, 26.340}, {758.428, 23.553}, {1029.168, 16.577}, {1173.699, 8.273}}}},
    {BoreEnd::kClarinet, 54, 0.444020531, {{{180.984, 31.984}, {545.923, 27.021}, {908.363, 24.452}, {1267.231, 21.901}}}},
    {BoreEnd::kClarinet, 57, 0.370193201, {{{214.313, 32.573}, {645.475, 27.546}, {1070.793, 24.732}, {1473.761, 21.076}}}},
    {BoreEnd::kClarinet, 60, 0.308112064, {{{253.395, 33.105}, {761.433, 27.963}, {1255.134, 24.689}}}},
    {BoreEnd::kClarinet, 63, 0.255908259, {{{299.098, 33.565}, {895.475, 28.219}, {1451.789, 23.044}}}},
    {BoreEnd::kClarinet, 66, 0.212010266, {{{352.346, 33.935}, {1048.287, 28.208}}}},
    {BoreEnd::kClarinet, 70, 0.16414667, {{{436.737, 34.252}, {1276.852, 27.320}}}},
    {BoreEnd::kSaxophone, 47, 1.17049049, {{{122.582, 19.276}, {249.845, 22.290}, {381.821, 22.070}, {516.161, 20.045}, {649.640, 15.296}}}},
    {BoreEnd::kSaxophone, 50, 0.94925847, {{{146.914, 21.318}, {302.338, 23.723}, {465.095, 22.914}, {630.862, 20.347}}}},
    {BoreEnd::kSaxophone, 54, 0.708041062, {{{188.240, 23.939}, {394.717, 25.351}, {613.440, 23.657}}}},
    {BoreEnd::kSaxophone, 58, 0.516586679, {{{243.478, 26.437}, {524.330, 26.701}}}},
    {BoreEnd::kSaxophone, 62, 0.364629235, {{{317.146, 28.729}, {705.465, 27.776}}}},
    {BoreEnd::kSaxophone, 66, 0.244020531, {{{424.199, 30.715}}}},
    {BoreEnd::kSaxophone, 70, 0.14829334, {{{596.028, 32.116}}}},
    {BoreEnd::kOboe, 58, 0.616586679, {{{215.044, 14.477}, {435.841, 17.676}, {662.872, 17.695}, {893.534, 16.288}, {1125.743, 14.325}}}},
    {BoreEnd::kOboe, 62, 0.464629235, {{{297.185, 18.444}, {612.154, 21.127}, {941.620, 20.619}, {1276.720, 18.549}}}},
    {BoreEnd::kOboe, 66, 0.344020531, {{{375.612, 20.898}, {786.580, 22.745}, {1216.259, 21.373}}}},
    {BoreEnd::kOboe, 70, 0.24829334, {{{478.785, 23.084}, {1023.385, 23.805}}}},
    {BoreEnd::kOboe, 74, 0.172314617, {{{618.788, 24.888}, {1342.147, 23.543}}}},
    {BoreEnd::kOboe, 78, 0.112010266, {{{817.259, 26.034}}}},
};

/// The same with any state of the holes.
struct FingeredReference {
  BoreEnd end;
  std::string_view holes; // from the reed down: c closed, o open, h half, q three quarters covered
  double length; // of the line, m
  std::array<BoreReference::Peak, 5> peaks;
};

inline constexpr FingeredReference kFingeredReference[]{
    {BoreEnd::kClarinet, "cccccccccccccccccccc", 0.564629235, {{{136.614, 31.222}, {411.290, 26.174}, {680.209, 23.224}, {933.679, 19.410}, {1159.946, 14.102}}}},
    {BoreEnd::kClarinet, "cccccccccccccccchooo", 0.444020531, {{{178.040, 31.718}, {536.966, 26.758}, {892.711, 24.176}, {1245.970, 21.259}}}},
    {BoreEnd::kClarinet, "ccccccccccqooooooooo", 0.308112064, {{{245.042, 32.579}, {736.431, 27.464}, {1214.149, 24.355}}}},
    {BoreEnd::kClarinet, "ccccchohohohohohohoh", 0.225806314, {{{324.596, 33.230}, {964.172, 27.418}, {1420.623, 7.557}}}},
    {BoreEnd::kClarinet, "ccccccccoccooooooooo", 0.272314617, {{{272.957, 33.014}, {808.484, 27.285}, {1272.573, 22.073}}}},
    {BoreEnd::kClarinet, "ccccccccoccccooooooo", 0.272314617, {{{266.171, 32.625}, {763.789, 25.628}, {1108.035, 20.605}}}},
    {BoreEnd::kClarinet, "ccccccocccoooooooooo", 0.240422718, {{{298.045, 33.001}, {865.143, 26.531}, {1301.405, 21.315}}}},
    {BoreEnd::kClarinet, "cccccccccccocccooooo", 0.327622623, {{{230.731, 32.483}, {681.806, 26.640}, {1048.763, 20.420}, {1337.913, 21.049}}}},
    {BoreEnd::kClarinet, "cccccccccccchccccooo", 0.34829334, {{{206.462, 31.219}, {598.443, 24.840}, {895.213, 20.789}, {1125.960, 2.614}, {1208.334, 20.300}}}},
    {BoreEnd::kClarinet, "ccccccccccccocococcc", 0.34829334, {{{222.495, 32.539}, {663.940, 26.843}, {788.488, 2.452}, {1085.977, 22.247}, {1264.087, 1.922}}}},
    {BoreEnd::kClarinet, "cccccccococooooooooo", 0.255908259, {{{290.881, 33.230}, {862.377, 27.449}, {1345.143, 20.724}}}},
    {BoreEnd::kClarinet, "cccccccccccccoccccco", 0.370193201, {{{205.429, 32.036}, {590.889, 24.586}, {786.087, 17.671}, {1063.013, 18.558}, {1176.519, 7.408}}}},
    {BoreEnd::kClarinet, "ccccccccccoccccccccc", 0.308112064, {{{231.727, 31.617}, {473.715, 14.000}, {731.630, 25.517}, {953.569, 13.541}, {1203.915, 14.917}}}},
    {BoreEnd::kClarinet, "cccccccccccccccccooc", 0.471612628, {{{170.599, 31.750}, {514.276, 26.747}, {850.427, 23.420}, {1012.112, 0.696}, {1207.296, 20.578}}}},
};

/// Standard fingerings with the register vent open.
inline constexpr BoreReference kVentedReference[]{
    {BoreEnd::kClarinet, 50, 0.564629235, {{{196.477, 21.810}, {425.947, 26.616}, {680.915, 23.751}, {934.919, 18.640}, {1163.957, 12.937}}}},
    {BoreEnd::kClarinet, 53, 0.471612628, {{{233.188, 24.109}, {524.007, 27.609}, {859.274, 23.843}, {1214.216, 18.985}}}},
    {BoreEnd::kClarinet, 56, 0.393395296, {{{264.703, 25.854}, {613.933, 28.032}, {1018.047, 23.720}, {1414.370, 20.953}}}},
    {BoreEnd::kClarinet, 59, 0.327622623, {{{299.716, 27.521}, {721.223, 28.081}, {1201.051, 23.589}}}},
    {BoreEnd::kClarinet, 62, 0.272314617, {{{338.833, 29.105}, {849.408, 27.818}, {1400.586, 22.919}}}},
};

} // namespace tactus::reed::test
