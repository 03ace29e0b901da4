#pragma once

namespace tactus::phantom {

/// Joins the driver `net` to the others: a device behind a server of the haptic protocol. Nothing
/// happens in a build without sockets.
void add_net_driver() noexcept;

} // namespace tactus::phantom
