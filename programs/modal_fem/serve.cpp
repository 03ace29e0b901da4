#include "programs/modal_fem/serve.hpp"

#include "core/modal/table/modal_table.hpp"
#include "core/serve/modal_fem.hpp"
#include "fem/design/valid_step.hpp"
#include "fem/io/text.hpp"
#include "fem/mesh/surface.hpp"
#include "fem/modes/mode_match.hpp"
#include "files/tables.hpp"
#include "programs/body/serve.hpp"
#include "programs/modal_fem/run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>

namespace tactus::fem {
namespace {

constexpr double kSameFrequency = 1e-6; // relative difference for the same matrices on another
                                        // machine
constexpr double kSameShape = .99;      // cosine of the angle between two mode shapes

/// A table's body, solved at any shape.
class ServedBody {
public:
  explicit ServedBody(const std::string& path)
      : path_(path), part_(read_served_part(path, "modal-table", "modal_fem --lattice")),
        options_(read_served_options(path, part_.command, read_options)),
        materials_(materials_of(options_, part_.mesh)),
        supports_(supports_of(options_, part_.mesh)),
        space_(design_space_of(options_.design, part_.mesh)) {
    if (const std::string refusal =
            files::read_modal_table(std::as_bytes(std::span(part_.bytes)), table_);
        !refusal.empty())
      throw InputError(path_ + ": " + refusal);
    if (table_.sensitivity.parameters() != parameters())
      throw InputError(path_ + format(" has %zu shape parameters, expected %zu as in the command",
                                      table_.sensitivity.parameters(), parameters()));
    options_.modes = table_.modes(); // may exceed the number in its command, to complete a group
    set_solver_threads(options_.threads);
  }

  [[nodiscard]] std::size_t parameters() const { return space_.parameters.size(); }
  [[nodiscard]] const modal::ModalTable& table() const { return table_; }

  void answer(std::span<const char> request) {
    const auto start_time = std::chrono::steady_clock::now();
    const std::size_t bytes = parameters() * sizeof(double);
    if (request.size() != 2 * bytes)
      throw InputError(
          format("a request to solve has %zu bytes, expected %zu: twice %zu parameters",
                 request.size(), 2 * bytes, parameters()));
    std::vector<double> requested(parameters()), matched(parameters());
    std::memcpy(requested.data(), request.data(), bytes);
    std::memcpy(matched.data(), request.data() + bytes, bytes);
    for (const auto* shape : {&requested, &matched})
      space_.check_within_bounds(*shape);
    if (!latest_ || latest_->displacement != matched)
      latest_ = solve_at(matched);
    Shape now = solve_at(requested);
    const auto shares =
        match_modes(*now.body.matrices, latest_->body.modes.shapes, now.body.modes.shapes);
    latest_ = std::move(now);
    serve::ModesAnswer fixed;
    fixed.fraction = latest_->fraction;
    fixed.shares = shares.size();
    const std::string bytes_of_table = table_bytes(table_of(options_, latest_->body, ""));
    fixed.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_time).count();
    ServeMessage message(serve::ServeKind::modes);
    message.add(fixed);
    for (const ModeMatch& match : shares)
      message.add(modal::ModeShare{static_cast<std::uint32_t>(match.before),
                                   static_cast<std::uint32_t>(match.now), match.share});
    message.add_text(bytes_of_table);
    message.send();
  }

private:
  struct Shape {
    std::vector<double> displacement; ///< displacement reached, m
    double fraction = 1;
    Solved body;
  };

  [[nodiscard]] Shape solve_at(std::vector<double> requested) const {
    Shape shape;
    Mesh mesh = part_.mesh;
    auto nodes = moved_nodes(mesh.nodes, space_.velocities, requested);
    shape.fraction = valid_step(mesh, nodes).fraction;
    if (shape.fraction < 1) {
      for (double& p : requested)
        p *= shape.fraction;
      nodes = moved_nodes(mesh.nodes, space_.velocities, requested);
    }
    mesh.nodes = std::move(nodes);
    shape.body = solve_moved(options_, std::move(mesh), materials_, supports_, space_, requested);
    const bool is_table_shape =
        std::all_of(requested.begin(), requested.end(), [](double p) { return p == 0; });
    shape.displacement = std::move(requested);
    if (is_table_shape)
      compare_with_table(shape.body);
    return shape;
  }

  /// The shares in the first answer refer to the table's modes, so these must equal the modes found
  /// here.
  void compare_with_table(const Solved& body) const {
    const auto& found = body.modes.frequency_hz;
    if (found.size() != table_.modes())
      throw InputError(
          path_ + format(" has %zu modes, its own shape has %zu", table_.modes(), found.size()));
    const Surface skin = surface_of(body.mesh);
    if (skin.node.size() != table_.vertices())
      throw InputError(path_ + format(" has %zu vertices, its mesh has %zu", table_.vertices(),
                                      skin.node.size()));
    const std::size_t n = body.mesh.dofs();
    for (std::size_t k = 0; k < found.size(); ++k) {
      if (!(std::abs(found[k] / table_.frequency_hz[k] - 1) <= kSameFrequency))
        throw InputError(path_ +
                         format(": mode %zu has %.9g Hz in the table, %.9g Hz at the table's own "
                                "shape: expected the unchanged file that modal_fem wrote",
                                k + 1, table_.frequency_hz[k], found[k]));
      double both = 0, own = 0, here = 0;
      for (std::size_t v = 0; v < skin.node.size(); ++v) {
        const Vec3 written = table_.shape_at(k, v);
        for (int axis = 0; axis < 3; ++axis) {
          const double a = written[axis];
          const double b = body.modes.shapes[k * n + 3 * static_cast<std::size_t>(skin.node[v]) +
                                             static_cast<std::size_t>(axis)];
          both += a * b;
          own += a * a;
          here += b * b;
        }
      }
      if (!(both >= kSameShape * std::sqrt(own * here)))
        throw InputError(path_ +
                         format(": the mode shape of mode %zu in the table differs from that at "
                                "the table's own shape: expected the unchanged file that modal_fem "
                                "wrote",
                                k + 1));
    }
  }

  std::string path_;
  ServedPart part_;
  ModalOptions options_;
  std::vector<Material> materials_;
  std::vector<Support> supports_;
  DesignSpace space_;
  modal::ModalTable table_;
  std::optional<Shape> latest_;
};

} // namespace

int serve(const std::vector<std::string>& words) {
  if (words.size() != 1)
    throw InputError("serve: expected one file, NAME.modal.npz");
  ServedBody body(words[0]);
  {
    ServeMessage ready(serve::ServeKind::ready);
    ready.add(serve::ModesReady{body.table().modes(), body.table().vertices(), body.parameters()});
    ready.send();
  }
  return serve_requests("modal_fem", [&](std::span<const char> request) { body.answer(request); });
}

} // namespace tactus::fem
