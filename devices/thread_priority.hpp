#pragma once

namespace tactus::devices {

/// How the system schedules a thread.
enum class Scheduling { kRealTime, kNice, kOther };

/// Of the thread that steps the servo, and of one between the servo and a device: above it, so that
/// what the servo wrote goes out at once.
constexpr int kServoPriority = 60, kDeviceThreadPriority = 61;

/// For the calling thread: first-in-first-out real-time scheduling if the system allows it, else a
/// better nice value, else what everybody has, but with wake-ups that are not put off.
Scheduling raise_thread_priority(int priority) noexcept;

} // namespace tactus::devices
