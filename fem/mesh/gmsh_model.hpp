#pragma once
#include "fem/io/words.hpp"
#include "fem/mesh/mesh.hpp"

#include <gmsh.h>

namespace tactus::fem {

/// gmsh from initialize() to finalize(), its errors as refusals.
class Session {
public:
  Session() {
    gmsh::initialize(0, nullptr, false); // no ~/.gmshrc, no ~/.gmsh-options
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("General.NumThreads", 1);
    gmsh::option::setNumber("Mesh.RandomSeed", 1);
    gmsh::logger::start();
  }
  ~Session() { gmsh::finalize(); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  template <class Work> auto run(const std::string& what, Work&& work) {
    try {
      return work();
    } catch (const Refusal&) {
      throw;
    } catch (const std::exception& error) {
      throw Refusal(what + ": " + complaint(error.what()));
    } catch (...) {
      throw Refusal(what + ": " + complaint("gmsh failed"));
    }
  }

private:
  /// gmsh's last error, or what is known otherwise.
  static std::string complaint(std::string reason) {
    std::vector<std::string> log;
    gmsh::logger::get(log);
    for (const std::string& line : log)
      if (line.starts_with("Error"))
        reason = line;
    return reason;
  }
};

/// gmsh's volume elements, nodes and names as a mesh of ours; its lengths times `unit`.
[[nodiscard]] Mesh take_over(double unit);

/// Model curves where the body turns inward. Compares the two facets at each mesh edge on a curve:
/// where the far corner of one rises above the outward plane of the other, the angle is concave.
[[nodiscard]] std::vector<double> concave_curves();

/// A size for a body nobody gave one for, from its largest side, its volume over its skin (half a
/// wall's thickness), and the skin: 6000 triangles or so, some 60 thousand unknowns, are enough.
[[nodiscard]] double natural_size(double largest, double volume, double skin);

/// Element sizes: h everywhere, finer towards these curves.
void set_sizes(double h, const std::vector<double>& concave);

/// Second order, sides curved where no element turns inside out: else optimised, else straight.
[[nodiscard]] Mesh make_quadratic(bool curved, double unit);

} // namespace tactus::fem
