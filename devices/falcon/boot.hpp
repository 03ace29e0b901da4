#pragma once

#include "devices/falcon/link.hpp"

namespace tactus::devices::falcon {

/// True when firmware answers in run mode. Leaves the connection in run mode and sends no force.
[[nodiscard]] bool firmware_runs(Link& link);

/// Greets the boot loader, sends the firmware and checks each byte of the echo; tries again, with
/// growing pauses, for 20 s at most. Returns an empty text once the firmware runs, else a sentence.
[[nodiscard]] std::string upload(Link& link, std::span<const std::uint8_t> firmware);

} // namespace tactus::devices::falcon
