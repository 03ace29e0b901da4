#pragma once

namespace tactus::phantom {

/// Registers the driver `net`, a device behind a server of the haptic protocol. Does nothing in a
/// build without sockets.
void add_net_driver() noexcept;

} // namespace tactus::phantom
