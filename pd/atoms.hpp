#pragma once

#include "core/object.hpp"

#include <vector>

#include <m_pd.h>

/// Converts between Pd's atoms and the core's.
namespace tactus::pd {

/// Words point to Pd's symbols, which live as long as Pd.
[[nodiscard]] std::vector<Atom> to_atoms(int count, const t_atom* atoms);
[[nodiscard]] std::vector<t_atom> to_pd_atoms(std::span<const Atom> atoms);

} // namespace tactus::pd
