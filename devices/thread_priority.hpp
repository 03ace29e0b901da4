#pragma once

namespace tactus::devices {

/// Of a thread between the servo and a device: above the servo's, so that what the servo wrote goes
/// out at once.
constexpr int kDeviceThreadPriority = 61;

/// First-in-first-out real-time scheduling for the calling thread if the system allows it, else
/// nothing.
void raise_thread_priority(int priority) noexcept;

} // namespace tactus::devices
