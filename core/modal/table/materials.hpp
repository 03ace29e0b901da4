#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace tactus::modal {

/// Density, elasticity and damping of a material, from handbooks. Damping is either a loss factor
/// eta, alpha = omega eta/2, or Rayleigh's two terms, alpha = (a + b omega^2)/2. Real bodies are
/// damped more, by their mounts and the air.
struct MaterialPreset {
  std::string_view name;
  double density_kg_per_m3, youngs_modulus_pa, poisson;
  double loss_factor; ///< 0: Rayleigh's terms
  double rayleigh_a_per_s, rayleigh_b_s;
};

/// Elasticity: Kaye & Laby. Loss factors: Cremer, Heckl & Ungar, Structure-Borne Sound, table 4.3.
/// Rayleigh's terms of glass, ceramic, wood and plastics: Wang & James, KleinPAT (2019), table 4.
inline constexpr std::array kMaterialPresets{
    MaterialPreset{"aluminium", 2700, 70.3e9, 0.33, 1e-4, 0, 0},
    MaterialPreset{"steel", 7850, 200e9, 0.29, 0, 5, 3e-8},
    MaterialPreset{"iron", 8000, 210e9, 0.28, 0, 5, 1e-7},
    MaterialPreset{"brass", 8500, 104e9, 0.37, 8e-4, 0, 0},
    MaterialPreset{"bronze", 8800, 110e9, 0.34, 4e-4, 0, 0},
    MaterialPreset{"copper", 8940, 125e9, 0.34, 2e-3, 0, 0},
    MaterialPreset{"lead", 11340, 16e9, 0.44, 2e-2, 0, 0},
    MaterialPreset{"glass", 2600, 62e9, 0.20, 0, 1, 1e-7},
    MaterialPreset{"ceramic", 2700, 72e9, 0.19, 0, 6, 1e-7},
    MaterialPreset{"wood", 750, 11e9, 0.25, 0, 60, 2e-6},
    MaterialPreset{"plastic", 1070, 1.4e9, 0.35, 0, 30, 1e-6},
    MaterialPreset{"polycarbonate", 1190, 2.4e9, 0.37, 0, 0.5, 4e-7},
    MaterialPreset{"rubber", 1100, 0.05e9, 0.49, 0.1, 0, 0},
};

/// The preset of this name, if there is one.
[[nodiscard]] constexpr std::optional<MaterialPreset>
find_material(std::string_view name) noexcept {
  for (const MaterialPreset& preset : kMaterialPresets)
    if (preset.name == name)
      return preset;
  return std::nullopt;
}

} // namespace tactus::modal
