#include "net/token_file.hpp"

#include "files/utf8_path.hpp"
#include "net/token.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

namespace tactus::net {

TokenFile read_token_file(const std::string& path) {
  TokenFile read;
  namespace fs = std::filesystem;
  std::error_code failed;
  const fs::file_status status = fs::status(utf8_path(path), failed);
  std::ifstream file;
  if (!failed && fs::is_regular_file(status)) // opening a FIFO would block
    file.open(utf8_path(path), std::ios::binary);
  if (!file.is_open()) {
    read.error = "the token file " + path + " cannot be read: check its path and permissions";
    return read;
  }
  std::string text(kMaxToken + 3, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r'))
    text.pop_back();
  if (text.size() < kMinToken || text.size() > kMaxToken || text.find('\0') != text.npos) {
    read.error = "the token file " + path + " holds " + std::to_string(text.size()) +
                 " bytes: expected 16..1024; openssl rand -hex 16 > FILE makes one";
    return read;
  }
  read.token = std::move(text);
  read.open_to_others =
      (status.permissions() & (fs::perms::group_read | fs::perms::others_read)) != fs::perms::none;
  return read;
}

} // namespace tactus::net
