#pragma once

/// Watches allocations, locks and system calls of external code (calls.cpp, note_system_call).
namespace tactus::stub {
/// Where the watch needs to be set up: hooks of a sanitizer. Call once.
void install_realtime_watch();
/// Windows: lets a module's imported functions be watched.
void watch_module(void* module);
} // namespace tactus::stub
