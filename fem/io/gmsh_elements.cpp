#include "fem/io/gmsh_elements.hpp"

#include <algorithm>
#include <iterator>

namespace tactus::fem {
namespace {

// gmsh numbers mid-edge nodes in another order than fem/element/shape.cpp.
constexpr GmshElement kElements[]{
    {1, "2-node line", 1, 2},
    {2, "3-node triangle", 2, 3},
    {3, "4-node quadrangle", 2, 4},
    {4, "4-node tetrahedron", 3, 4, Shape::tet4, {0, 1, 2, 3}},
    {5, "8-node hexahedron", 3, 8, Shape::hex8, {0, 1, 2, 3, 4, 5, 6, 7}},
    {6, "6-node prism", 3, 6, Shape::wedge6, {0, 1, 2, 3, 4, 5}},
    {7, "5-node pyramid", 3, 5, Shape::pyramid5, {0, 1, 2, 3, 4}},
    {8, "3-node line", 1, 3},
    {9, "6-node triangle", 2, 6},
    {10, "9-node quadrangle", 2, 9},
    {11, "10-node tetrahedron", 3, 10, Shape::tet10, {0, 1, 2, 3, 4, 5, 6, 7, 9, 8}},
    {12, "27-node hexahedron", 3, 27},
    {13, "18-node prism", 3, 18},
    {14, "14-node pyramid", 3, 14},
    {15, "point", 0, 1},
    {16, "8-node quadrangle", 2, 8},
    {17, "20-node hexahedron", 3, 20, Shape::hex20, {0,  1, 2,  3,  4,  5,  6,  7,  8,  11,
                                                     13, 9, 16, 18, 19, 17, 10, 12, 14, 15}},
    {18,
     "15-node prism",
     3,
     15,
     Shape::wedge15,
     {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11}},
    {19, "13-node pyramid", 3, 13},
    {20, "9-node triangle", 2, 9},
    {21, "10-node triangle", 2, 10},
    {22, "12-node triangle", 2, 12},
    {23, "15-node triangle", 2, 15},
    {24, "15-node triangle of order 5", 2, 15},
    {25, "21-node triangle", 2, 21},
    {26, "4-node line", 1, 4},
    {27, "5-node line", 1, 5},
    {28, "6-node line", 1, 6},
    {29, "20-node tetrahedron", 3, 20},
    {30, "35-node tetrahedron", 3, 35},
    {31, "56-node tetrahedron", 3, 56},
    {36, "16-node quadrangle", 2, 16},
    {37, "25-node quadrangle", 2, 25},
    {38, "36-node quadrangle", 2, 36},
    {90, "40-node prism", 3, 40},
    {91, "75-node prism", 3, 75},
    {92, "64-node hexahedron", 3, 64},
    {93, "125-node hexahedron", 3, 125},
};

} // namespace

const GmshElement* gmsh_element(int type) noexcept {
  const auto* const end = std::end(kElements);
  const auto* const at = std::find_if(std::begin(kElements), end,
                                      [&](const GmshElement& e) { return e.type == type; });
  return at == end ? nullptr : at;
}

} // namespace tactus::fem
