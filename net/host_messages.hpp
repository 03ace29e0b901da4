#pragma once

#include "core/object.hpp"

#include <optional>
#include <string>

/// Functions shared by the patch objects that use the network.
namespace tactus::net {

/// A word, or a number's shortest text.
[[nodiscard]] std::string text_of(const Atom& atom);

/// The token in the file that the message `token FILE` names, beside the patch, in the search path
/// or by its own path. Tells the host when other users may read the file; nothing, and one error
/// at the host, when it holds no token.
[[nodiscard]] std::optional<std::string> read_token(const Atom& file, Host& host);

} // namespace tactus::net
