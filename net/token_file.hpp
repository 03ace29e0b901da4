#pragma once

#include <string>

namespace tactus::net {

/// A token is the text of a file without the end of its line, 16 to 1024 bytes.
struct TokenFile {
  std::string token;
  std::string error;           ///< one sentence if the token cannot be used
  bool open_to_others = false; ///< other users of this machine may read it
};
[[nodiscard]] TokenFile read_token_file(const std::string& path);

} // namespace tactus::net
