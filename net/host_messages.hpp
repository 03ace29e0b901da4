#pragma once

#include "core/object.hpp"

#include <optional>
#include <string>

/// Functions shared by the patch objects that use the network.
namespace tactus::net {

/// The atom's word, or the shortest text of its number.
[[nodiscard]] std::string text_of(const Atom& atom);

/// Reads the token from the file that the message `token FILE` names: beside the patch, in the
/// search path or by its own path. Logs it if other users may read the file. If the file holds no
/// token, reports one error and returns nullopt.
[[nodiscard]] std::optional<std::string> read_token(const Atom& file, Host& host);

} // namespace tactus::net
