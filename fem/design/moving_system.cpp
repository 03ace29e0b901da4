#include "fem/design/moving_system.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

/// If more than this fraction of the elements moved, all elements are assembled, because a partial
/// update also integrates the neighbours of moved elements again.
constexpr double kFullAssemblyShare = 0.7;

} // namespace

MovingSystem::MovingSystem(const Mesh& mesh, const StaticModel& model, StaticSystem& system)
    : laws_(elastic_laws(mesh, model.materials)), positions_(mesh, system.matrices.graph),
      first_(mesh.nodes.size() + 1, 0), around_(mesh.connectivity.size()), nodes_(mesh.nodes),
      changed_pair_(system.matrices.graph.row.size(), 0), element_state_(mesh.elements.size(), 0) {
  for (const int n : mesh.connectivity)
    ++first_[static_cast<std::size_t>(n) + 1];
  for (std::size_t i = 0; i + 1 < first_.size(); ++i)
    first_[i + 1] += first_[i];
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    for (const int n : mesh.nodes_of(mesh.elements[e]))
      around_[next[static_cast<std::size_t>(n)]++] = e;
  if (!model.springs.empty()) {
    Matrices& m = system.matrices;
    assemble_stiffness(mesh, model.materials, -1, m);
    elements_alone_ = m.stiffness;
    add_springs(mesh, model.springs, m);
  }
}

std::size_t MovingSystem::update(const Mesh& mesh, const StaticModel& model, StaticSystem& system) {
  enum : std::uint8_t { unchanged, adjacent, moved };
  Matrices& m = system.matrices;
  std::size_t changed = 0;
  for (std::size_t n = 0; n < nodes_.size(); ++n)
    if (nodes_[n] != mesh.nodes[n])
      for (std::size_t k = first_[n]; k < first_[n + 1]; ++k) {
        changed += element_state_[around_[k]] != moved;
        element_state_[around_[k]] = moved;
      }
  if (changed == 0)
    return 0;
  nodes_ = mesh.nodes;
  auto& stiffness = elements_alone_.empty() ? m.stiffness : elements_alone_;
  std::size_t integrated = 0;
  const auto add = [&](std::size_t e, std::span<const std::uint8_t> only) {
    add_element_stiffness(mesh, e, laws_[static_cast<std::size_t>(mesh.elements[e].region)],
                          positions_, stiffness, only);
    ++integrated;
  };
  if (static_cast<double>(changed) >
      kFullAssemblyShare * static_cast<double>(mesh.elements.size())) {
    std::fill(stiffness.begin(), stiffness.end(), 0.0);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
      add(e, {});
  } else {
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
      if (element_state_[e] != moved)
        continue;
      for (const std::int32_t position : positions_.of(e)) {
        const auto pair = static_cast<std::size_t>(std::abs(position)) - 1;
        changed_pair_[pair] = 1;
        std::fill_n(stiffness.begin() + static_cast<std::ptrdiff_t>(9 * pair), 9, 0.0);
      }
      for (const int n : mesh.nodes_of(mesh.elements[e]))
        for (std::size_t k = first_[static_cast<std::size_t>(n)];
             k < first_[static_cast<std::size_t>(n) + 1]; ++k)
          if (element_state_[around_[k]] == unchanged)
            element_state_[around_[k]] = adjacent;
    }
    // In element order, so that the sums are bit-equal to those of a full assembly.
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
      if (element_state_[e] != unchanged)
        add(e, changed_pair_);
    std::fill(changed_pair_.begin(), changed_pair_.end(), std::uint8_t{0});
  }
  std::fill(element_state_.begin(), element_state_.end(), std::uint8_t{unchanged});
  if (!elements_alone_.empty()) {
    m.stiffness = elements_alone_;
    add_springs(mesh, model.springs, m);
  }
  system.load = load_vector(mesh, model.materials, model.loads);
  return integrated;
}

double MovingSystem::bytes() const noexcept {
  return static_cast<double>(positions_.bytes() + 8 * (first_.size() + around_.size()) +
                             sizeof(Vec3) * nodes_.size() + 8 * elements_alone_.size() +
                             changed_pair_.size() + element_state_.size());
}

} // namespace tactus::fem
