#pragma once

namespace tactus::phantom {

/// Whoever holds a real device. A host may end without deleting its objects; what is registered is
/// let go then, before the process is gone.
class LiveConnection {
public:
  /// Force to zero, device closed, no thread left.
  virtual void let_go() noexcept = 0;

protected:
  LiveConnection();
  ~LiveConnection();
  LiveConnection(const LiveConnection&) = delete;
  LiveConnection& operator=(const LiveConnection&) = delete;
};

} // namespace tactus::phantom
