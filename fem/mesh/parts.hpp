#pragma once
#include "fem/io/load.hpp"

namespace tactus::fem {

/// A connected piece of a file's content.
struct Part {
  std::string name;
  double volume = 0; ///< m^3
  Box box;           ///< m
};

/// Which parts become the body, by their index. The one that `choice.part` names or counts (from
/// one); with `choice.multi` all but crumbs below 1e-4 of the largest; else the only one beside
/// debris: pieces that together hold less than 1 % of its volume, which is reported. Refuses
/// several bodies with number, name, size and position of each.
[[nodiscard]] std::vector<std::size_t> chosen_parts(const std::vector<Part>&, const LoadChoice&);

} // namespace tactus::fem
