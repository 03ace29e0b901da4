#pragma once

namespace tactus::phantom {

/// Base of objects that may hold a real device. If the host's program ends without deleting its
/// objects, let_go() is called for each of them before the process ends.
class LiveConnection {
public:
  /// Starts to bring the force to zero and to close the device, in other threads. Does not wait.
  virtual void let_go() noexcept = 0;

protected:
  LiveConnection();
  ~LiveConnection();
  LiveConnection(const LiveConnection&) = delete;
  LiveConnection& operator=(const LiveConnection&) = delete;
};

} // namespace tactus::phantom
