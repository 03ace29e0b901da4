#pragma once
#include "fem/io/load.hpp"

namespace tactus::fem {

/// A connected body in a file that may contain several.
struct Part {
  std::string name;
  double volume = 0; ///< m^3
  Box box;           ///< m
};

/// Indices of the parts that become the body:
/// - if `choice.part` is given, the part with that name or number (from one);
/// - with `choice.multi`, all parts of at least 1e-4 of the largest part's volume;
/// - else the largest part, if the others together have less than 1 % of its volume, or each less
///   than 1e-4. Refuses several bodies, naming number, name, size and position of each.
/// Parts that are left out are reported.
[[nodiscard]] std::vector<std::size_t> chosen_parts(const std::vector<Part>&, const LoadChoice&);

} // namespace tactus::fem
