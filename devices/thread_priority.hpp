#pragma once

namespace tactus::devices {

/// How the system schedules a thread.
enum class Scheduling { kRealTime, kNice, kOther };

/// Real-time priorities, 1 to 99. A thread that passes the servo's forces to a device runs above
/// the servo, so that a written force is sent at once.
constexpr int kServoPriority = 60, kDeviceThreadPriority = 61;

/// Raises the priority of the calling thread: SCHED_FIFO at `priority` if the system allows it,
/// else a lower nice value, else the default scheduling with a short timer slack. On Windows it
/// takes the highest priority of a normal program and returns kNice.
Scheduling raise_thread_priority(int priority) noexcept;

} // namespace tactus::devices
