#include "programs/body/serve.hpp"

#include "fem/io/mesh_bytes.hpp"
#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"
#include "files/json.hpp"
#include "files/npz.hpp"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <unistd.h>

namespace tactus::fem {

using serve::ServeHeader;
using serve::ServeKind;

namespace {

static_assert(std::endian::native == std::endian::little, "messages are copied byte by byte");

constexpr std::uint64_t kMaxRequestBytes = 1 << 20;

/// Reads `size` bytes; returns the number of bytes read before the end of the input.
std::size_t read_fully(void* into, std::size_t size) {
  std::size_t got = 0;
  while (got < size) {
    const ssize_t count = ::read(STDIN_FILENO, static_cast<char*>(into) + got, size - got);
    if (count < 0 && errno == EINTR)
      continue;
    if (count <= 0)
      break;
    got += static_cast<std::size_t>(count);
  }
  return got;
}

void refuse(const std::string& sentence) {
  ServeMessage message(ServeKind::refused);
  message.add_text(sentence);
  message.send();
}

} // namespace

ServedPart read_served_part(const std::string& path, const std::string& format_name,
                            const std::string& program) {
  ServedPart part;
  part.bytes = read_bytes(path);
  files::NpzFile archive;
  if (const std::string refusal = archive.open(std::as_bytes(std::span(part.bytes)));
      !refusal.empty())
    throw InputError(path + ": " + refusal);
  const auto text = [&](const char* name) {
    const files::NpzArray* array = archive.find(name);
    if (!array || array->item_bytes != 1)
      throw InputError(path + " has no byte array '" + name + "', expected a table of " + program);
    return std::string_view(reinterpret_cast<const char*>(array->bytes.data()),
                            array->bytes.size());
  };
  files::Json meta;
  if (!files::read_json(text("meta"), meta))
    throw InputError(path + ": array 'meta' is not JSON");
  if (meta.text_or("format", "") != format_name) {
    std::string words = format_name;
    std::replace(words.begin(), words.end(), '-', ' ');
    throw InputError(path + " is not a " + words + ": expected one of " + program);
  }
  if (const files::Json* command = meta.find("command"))
    for (const files::Json& word : command->list)
      part.command.push_back(word.text);
  if (part.command.empty())
    throw InputError(path +
                     " does not state the command that made it: expected 'command' in its meta");
  try {
    part.mesh = mesh_from_bytes(text("mesh"));
    check(part.mesh);
  } catch (const InputError& refusal) {
    throw InputError(path + ": " + refusal.what());
  }
  return part;
}

void ServeMessage::send() {
  header_.size = bytes_.size();
  std::fwrite(&header_, sizeof header_, 1, stdout);
  std::fwrite(bytes_.data(), 1, bytes_.size(), stdout);
  if (std::fflush(stdout) != 0)
    throw InputError("cannot write the answer to stdout: its reader has closed it");
}

int serve_requests(const char* program, const std::function<void(std::span<const char>)>& answer) {
  for (;;) {
    ServeHeader header;
    const std::size_t got = read_fully(&header, sizeof header);
    if (got == 0)
      return 0;
    const auto broken = [program](const std::string& sentence) {
      refuse(sentence);
      std::fprintf(stderr, "%s: %s\n", program, sentence.c_str());
      return 1;
    };
    if (got < sizeof header)
      return broken(
          format("the stream ends after %zu of a header's %zu bytes", got, sizeof header));
    if (header.magic != ServeHeader::kMagic)
      return broken(
          format("a message begins with %08x, expected %08x", header.magic, ServeHeader::kMagic));
    if (header.size > kMaxRequestBytes)
      return broken(format("a message of %llu bytes, expected at most %llu",
                           static_cast<unsigned long long>(header.size),
                           static_cast<unsigned long long>(kMaxRequestBytes)));
    std::vector<char> request(header.size);
    if (const std::size_t received = read_fully(request.data(), request.size());
        received < header.size)
      return broken(
          format("the stream ends after %zu of a message's %zu bytes", received, request.size()));
    if (header.kind == static_cast<std::uint32_t>(ServeKind::quit))
      return 0;
    try {
      if (header.kind != static_cast<std::uint32_t>(ServeKind::solve))
        throw InputError(
            format("a message of kind %u, expected 1 (solve) or 2 (quit)", header.kind));
      answer(request);
    } catch (const InputError& refusal) {
      refuse(refusal.what());
    }
  }
}

} // namespace tactus::fem
