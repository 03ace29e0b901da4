#include "net/host_messages.hpp"

#include "core/declaration_text.hpp"
#include "net/token_file.hpp"

#include <utility>

namespace tactus::net {

std::string text_of(const Atom& atom) {
  return atom.is_word ? std::string(atom.word) : number_text(atom.number);
}

std::optional<std::string> read_token(const Atom& file, Host& host) {
  const std::string name = text_of(file), found = host.find_file(name);
  TokenFile read = read_token_file(found.empty() ? name : found);
  if (!read.error.empty()) {
    host.error("token: " + read.error);
    return {};
  }
  if (read.open_to_others)
    host.log("token: other users of this machine can read the file: chmod 600 it");
  return std::move(read.token);
}

} // namespace tactus::net
