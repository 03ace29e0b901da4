#include "programs/part_stress/serve.hpp"

#include "core/serve/part_stress.hpp"
#include "fem/io/text.hpp"
#include "programs/body/body_options.hpp"
#include "programs/body/serve.hpp"
#include "programs/part_stress/part.hpp"

#include <chrono>
#include <cmath>
#include <cstring>
#include <poll.h>
#include <unistd.h>

namespace tactus::fem {

using serve::ServeKind;
using serve::ServeMethod;
using serve::ServeReady;
using serve::StressAnswer;

namespace {

std::vector<float> singles(std::span<const double> values) {
  return {values.begin(), values.end()};
}

/// Handles one request: moves the nodes, solves and answers. Returns whether a new factorisation
/// before the next request would save time. Throws InputError if it refuses the request.
bool answer(Reanalysis& part, std::span<const char> request, const DesignSpace& space) {
  const std::size_t parameters = space.parameters.size();
  const std::size_t expected = 2 * sizeof(std::uint32_t) + parameters * sizeof(double);
  if (request.size() != expected)
    throw InputError(format("a request to solve has %zu bytes, expected %zu: method, flag and %zu "
                            "parameters",
                            request.size(), expected, parameters));
  std::uint32_t method = 0, flags = 0;
  std::memcpy(&method, request.data(), sizeof method);
  std::memcpy(&flags, request.data() + sizeof method, sizeof flags);
  if (method > 2 || flags > (serve::kWithDerivatives | serve::kKeepFactor))
    throw InputError(format("a request to solve has method %u and flags %u, expected 0..2 and 0..3",
                            method, flags));
  const bool derivatives = (flags & serve::kWithDerivatives) != 0;
  std::vector<double> requested(parameters);
  if (parameters > 0)
    std::memcpy(requested.data(), request.data() + 2 * sizeof(std::uint32_t),
                parameters * sizeof(double));
  space.check_within_bounds(requested);
  const auto start_time = std::chrono::steady_clock::now();
  const ValidStep step = part.move_to(requested);
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
  fixed.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_time).count();
  fixed.fraction = step.fraction;
  fixed.residual = std::isfinite(update.residual) ? update.residual : 0;
  ServeMessage message(ServeKind::stress);
  message.add(fixed);
  message.add(part.parameters());
  message.add(std::span<const float>(singles(update.von_mises)));
  message.add(std::span<const float>(singles(update.max_shear)));
  if (derivatives) {
    message.add(std::span<const float>(part.sensitivity().von_mises));
    message.add(std::span<const float>(part.sensitivity().max_shear));
  }
  message.send();
  return update.refactor_recommended && (flags & serve::kKeepFactor) == 0;
}

/// Whether the next request has begun to arrive, or stdin has ended.
bool request_waits() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  return ::poll(&input, 1, 0) != 0;
}

/// Factorises the present shape while no request waits; the next solve is preconditioned by it.
void refactor(Reanalysis& part) {
  try {
    Refactorisation job = part.refactorisation();
    job.run();
    part.adopt(std::move(job));
  } catch (const InputError&) { // the old factor stays; the answer has been sent
  }
}

} // namespace

int serve(const std::vector<std::string>& words) {
  if (words.size() != 1 && (words.size() != 3 || words[1] != "--tolerance"))
    throw InputError("serve: expected one file, NAME.stress.npz, optionally --tolerance T");
  const double tolerance =
      words.size() == 3 ? number("serve --tolerance", words[2], 1e-14, 0.1) : 1e-6;
  set_solver_threads(1); // the dense blocks are small, so threads would only wait for each other
  const ServedPart source = read_served_part(words[0], "stress-table", "part_stress");
  const PartOptions options = read_served_options(words[0], source.command, read_options);
  const StaticModel model = model_of(options, source.mesh);
  const DesignSpace space = design_space_of(options.design, source.mesh);
  const std::size_t parameters = space.parameters.size();
  Reanalysis part(source.mesh, model, space.velocities, {.tolerance = tolerance});
  {
    ServeMessage ready(ServeKind::ready);
    const CostModel& cost = part.cost();
    ready.add(ServeReady{source.mesh.elements.size(), parameters, cost.product, cost.solve,
                         cost.assembly + cost.factor});
    ready.send();
  }
  return serve_requests("part_stress", [&](std::span<const char> request) {
    if (answer(part, request, space) && !request_waits())
      refactor(part);
  });
}

} // namespace tactus::fem
