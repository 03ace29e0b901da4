#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace tactus::net {

/// Length of a token, the secret that a client must present, bytes.
inline constexpr std::size_t kMinToken = 16, kMaxToken = 1024;

/// True if both texts are equal. The time that this takes depends only on the length of `given`.
[[nodiscard]] bool equal_in_constant_time(std::string_view expected,
                                          std::string_view given) noexcept;

/// Locks out for 10 s a peer that has failed three times. Peers are distinguished by their address;
/// if more peers fail at the same time than the table holds, the peers without an entry are locked
/// out together.
class LockOut {
public:
  static constexpr int kMaxFailures = 3;
  static constexpr double kLocked_s = 10, kExpiry_s = 60;

  [[nodiscard]] bool locked(std::string_view peer, double now_s) const noexcept;
  void fail(std::string_view peer, double now_s);
  void succeed(std::string_view peer) noexcept;

private:
  struct Entry {
    std::string peer;
    int failures = 0; ///< 0 if the entry is free
    double last_s = 0;
  };
  [[nodiscard]] static bool expired(const Entry& entry, double now_s) noexcept;
  [[nodiscard]] static bool locks(const Entry& entry, double now_s) noexcept;

  std::array<Entry, 64> entries_{};
  Entry overflow_{}; ///< entry of all peers for which the table has no room
};

} // namespace tactus::net
