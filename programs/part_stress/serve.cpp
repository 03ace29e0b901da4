#include "programs/part_stress/serve.hpp"

#include "core/stress/serve_protocol.hpp"
#include "core/table/json.hpp"
#include "core/table/npz.hpp"
#include "fem/io/file_bytes.hpp"
#include "fem/io/mesh_bytes.hpp"
#include "fem/io/words.hpp"
#include "programs/body/body_order.hpp"
#include "programs/part_stress/part.hpp"

#include <bit>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <poll.h>
#include <unistd.h>

namespace tactus::fem {

using stress::ServeHeader;
using stress::ServeKind;
using stress::ServeMethod;
using stress::ServeReady;
using stress::StressAnswer;

namespace {

static_assert(std::endian::native == std::endian::little, "messages are copied as they lie");

/// What the table says of how it was made.
struct Source {
  Mesh mesh;
  PartOrder order;
};

Source read_source(const std::string& path) {
  const std::string bytes = read_bytes(path);
  table::NpzFile archive;
  if (const std::string refusal = archive.open(std::as_bytes(std::span(bytes))); !refusal.empty())
    throw Refusal(path + ": " + refusal);
  const auto text = [&](const char* name) {
    const table::NpzArray* array = archive.find(name);
    if (!array || array->item_bytes != 1)
      throw Refusal(path + " has no array of bytes '" + name +
                    "', expected a table of part_stress");
    return std::string_view(reinterpret_cast<const char*>(array->bytes.data()),
                            array->bytes.size());
  };
  table::Json meta;
  if (!table::read_json(text("meta"), meta))
    throw Refusal(path + ": array 'meta' is not JSON");
  if (meta.text_or("format", "") != "stress-table")
    throw Refusal(path + " is no stress table: expected one of part_stress");
  const table::Json* command = meta.find("command");
  std::vector<std::string> words;
  if (command)
    for (const table::Json& word : command->list)
      words.push_back(word.text);
  if (words.empty())
    throw Refusal(path + " does not say how it was made: expected 'command' in its meta");
  try {
    Source source{mesh_from_bytes(text("mesh")), read_order(words)};
    check(source.mesh);
    return source;
  } catch (const Refusal& refusal) {
    throw Refusal(path + ": " + refusal.what());
  }
}

/// Reads `size` bytes; how many came before the end.
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

class Message {
public:
  explicit Message(ServeKind kind) { header_.kind = static_cast<std::uint32_t>(kind); }
  template <class T> void add(const T& value) { append(&value, sizeof value); }
  void add(std::span<const double> values) { append(values.data(), values.size_bytes()); }
  void add(std::span<const float> values) { append(values.data(), values.size_bytes()); }
  void add_singles(std::span<const double> values) {
    const std::vector<float> rounded(values.begin(), values.end());
    add(std::span<const float>(rounded));
  }
  void add_text(const std::string& text) { append(text.data(), text.size()); }
  void send() {
    header_.size = bytes_.size();
    std::fwrite(&header_, sizeof header_, 1, stdout);
    std::fwrite(bytes_.data(), 1, bytes_.size(), stdout);
    if (std::fflush(stdout) != 0)
      throw Refusal("the answer cannot be written to stdout: its reader is gone");
  }

private:
  void append(const void* from, std::size_t size) {
    bytes_.append(static_cast<const char*>(from), size);
  }
  ServeHeader header_;
  std::string bytes_;
};

void refuse(const std::string& sentence) {
  Message message(ServeKind::refused);
  message.add_text(sentence);
  message.send();
}

/// One request: moves the nodes, solves there, answers. Whether a new factor would pay before the
/// next one. Refuses by exception.
bool answer(Reanalysis& part, std::span<const char> request, std::size_t parameters) {
  const std::size_t expected = 2 * sizeof(std::uint32_t) + parameters * sizeof(double);
  if (request.size() != expected)
    throw Refusal(format("a request to solve has %zu bytes, expected %zu: method, flag and %zu "
                         "parameters",
                         request.size(), expected, parameters));
  std::uint32_t method = 0, flags = 0;
  std::memcpy(&method, request.data(), sizeof method);
  std::memcpy(&flags, request.data() + sizeof method, sizeof flags);
  if (method > 2 || flags > (stress::kWithDerivatives | stress::kKeepFactor))
    throw Refusal(
        format("a request to solve has method %u and flags %u, expected 0 to 2 and 0 to 3", method,
               flags));
  const bool derivatives = (flags & stress::kWithDerivatives) != 0;
  std::vector<double> wanted(parameters);
  if (parameters > 0)
    std::memcpy(wanted.data(), request.data() + 2 * sizeof(std::uint32_t),
                parameters * sizeof(double));
  const auto begun = std::chrono::steady_clock::now();
  const ValidStep step = part.move_to(wanted);
  StressUpdate update;
  if (derivatives) {
    part.rebase();
    update.method = Method::refactor;
    update.von_mises.assign(part.base_von_mises().begin(), part.base_von_mises().end());
    update.max_shear.assign(part.base_max_shear().begin(), part.base_max_shear().end());
  } else {
    update = method == static_cast<std::uint32_t>(ServeMethod::chosen) ? part.solve()
             : method == static_cast<std::uint32_t>(ServeMethod::pcg)
                 ? part.solve(Method::pcg)
                 : part.solve(Method::refactor);
  }
  StressAnswer fixed;
  fixed.method = update.method == Method::pcg ? static_cast<std::uint32_t>(ServeMethod::pcg)
                                              : static_cast<std::uint32_t>(ServeMethod::refactor);
  fixed.iterations = static_cast<std::uint32_t>(update.iterations);
  fixed.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  fixed.fraction = step.fraction;
  fixed.residual = std::isfinite(update.residual) ? update.residual : 0;
  Message message(ServeKind::stress);
  message.add(fixed);
  message.add(part.parameters());
  message.add_singles(update.von_mises);
  message.add_singles(update.max_shear);
  if (derivatives) {
    message.add(std::span<const float>(part.sensitivity().von_mises));
    message.add(std::span<const float>(part.sensitivity().max_shear));
  }
  message.send();
  return update.wants_factor && (flags & stress::kKeepFactor) == 0;
}

/// Whether the next request has begun to arrive, or stdin has ended.
bool request_waits() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  return ::poll(&input, 1, 0) != 0;
}

/// Between two requests nobody waits: the next one is preconditioned from this shape.
void refactor(Reanalysis& part) {
  Refactorisation job = part.refactorisation();
  job.run();
  part.adopt(std::move(job));
}

constexpr std::uint64_t kMaxRequestBytes = 1 << 20;

} // namespace

int serve(const std::vector<std::string>& words) {
  if (words.size() != 1 && (words.size() != 3 || words[1] != "--tolerance"))
    throw Refusal("serve: expected one file, NAME.stress.npz, and perhaps --tolerance T");
  const double tolerance =
      words.size() == 3 ? number("serve --tolerance", words[2], 1e-14, 0.1) : 1e-6;
  set_solver_threads(1); // its dense blocks are small: threads would wait for each other
  Source source = read_source(words[0]);
  const StaticModel model = model_of(source.order, source.mesh);
  const DesignSpace space = design_space_of(source.order.design, source.mesh);
  const std::size_t parameters = space.parameters.size();
  Reanalysis part(source.mesh, model, space.velocities, {.tolerance = tolerance});
  {
    Message ready(ServeKind::ready);
    const CostModel& cost = part.cost();
    ready.add(ServeReady{source.mesh.elements.size(), parameters, cost.product, cost.solve,
                         cost.assembly + cost.factor});
    ready.send();
  }
  for (;;) {
    ServeHeader header;
    const std::size_t got = read_fully(&header, sizeof header);
    if (got == 0)
      return 0;
    const auto broken = [](const std::string& sentence) {
      refuse(sentence);
      std::fprintf(stderr, "part_stress: %s\n", sentence.c_str());
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
    if (const std::size_t came = read_fully(request.data(), request.size()); came < header.size)
      return broken(
          format("the stream ends after %zu of a message's %zu bytes", came, request.size()));
    if (header.kind == static_cast<std::uint32_t>(ServeKind::quit))
      return 0;
    try {
      if (header.kind != static_cast<std::uint32_t>(ServeKind::solve))
        throw Refusal(format("a message of kind %u, expected 1 (solve) or 2 (quit)", header.kind));
      if (answer(part, request, parameters) && !request_waits())
        refactor(part);
    } catch (const Refusal& refusal) {
      refuse(refusal.what());
    }
  }
}

} // namespace tactus::fem
