#pragma once

#include "core/reed/instrument/parameters.hpp"

#include <optional>
#include <span>
#include <string_view>

namespace tactus::reed {

/// A named set of parameters.
struct Preset {
  std::string_view name;
  Parameters parameters;
};

/// clarinet, sax, oboe (blown closed), trumpet, trombone, voice (blown open), syrinx (swinging).
[[nodiscard]] std::span<const Preset> presets() noexcept;

[[nodiscard]] std::optional<Parameters> find_preset(std::string_view name) noexcept;

} // namespace tactus::reed
