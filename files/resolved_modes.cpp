#include "files/tables.hpp"

#include "core/declaration_text.hpp"
#include "core/serve/modal_fem.hpp"

#include <bit>
#include <cstring>
#include <utility>

namespace tactus::files {
namespace {

static_assert(std::endian::native == std::endian::little, "messages are copied byte by byte");

} // namespace

std::string read_resolved_modes(std::span<const std::byte> payload, const modal::ModalTable& before,
                                modal::ResolvedModes& resolved) {
  serve::ModesAnswer fixed;
  if (payload.size() < sizeof fixed)
    return "an answer has " + std::to_string(payload.size()) + " bytes: expected " +
           std::to_string(sizeof fixed) + " or more";
  std::memcpy(&fixed, payload.data(), sizeof fixed);
  payload = payload.subspan(sizeof fixed);
  if (!(fixed.seconds >= 0 && fixed.seconds < 1e6) || !(fixed.fraction >= 0 && fixed.fraction <= 1))
    return "an answer took " + number_text(fixed.seconds) + " s for the fraction " +
           number_text(fixed.fraction) + " of the move: expected 0..1e+06 s and 0..1";
  if (fixed.shares > payload.size() / sizeof(modal::ModeShare))
    return "an answer has " + std::to_string(fixed.shares) + " shares: expected at most " +
           std::to_string(payload.size() / sizeof(modal::ModeShare));
  modal::ResolvedModes read;
  read.seconds = fixed.seconds;
  read.fraction = fixed.fraction;
  read.share.resize(static_cast<std::size_t>(fixed.shares));
  if (!read.share.empty())
    std::memcpy(read.share.data(), payload.data(), read.share.size() * sizeof(modal::ModeShare));
  std::string refusal =
      read_modal_table(payload.subspan(read.share.size() * sizeof(modal::ModeShare)), read.table);
  if (!refusal.empty())
    return refusal;
  if (refusal = modal::complete_resolved_modes(before, read); !refusal.empty())
    return refusal;
  resolved = std::move(read);
  return {};
}

} // namespace tactus::files
