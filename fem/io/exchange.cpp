#include "fem/io/exchange.hpp"

#include "fem/io/inp.hpp"
#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"
#include "fem/modes/rigid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

namespace tactus::fem {
namespace {

std::string ids(std::span<const int> nodes, std::size_t a_line) {
  std::string text;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    text += std::to_string(nodes[i] + 1) + (i + 1 == nodes.size() ? "\n"
                                            : (i + 1) % a_line    ? ","
                                                                  : ",\n");
  return text;
}

std::string elastic(const Material& m) {
  if (m.isotropic())
    return format("*ELASTIC\n%.12g,%.12g\n", m.young_pa[0], m.poisson[0]);
  return format("*ELASTIC,TYPE=ENGINEERING "
                "CONSTANTS\n%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n%.12g\n",
                m.young_pa[0], m.young_pa[1], m.young_pa[2], m.poisson[2], m.poisson[1],
                m.poisson[0], m.shear_pa[2], m.shear_pa[1], m.shear_pa[0]);
}

void put_big(std::string& out, std::uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i)
    out += static_cast<char>(value >> (8 * i) & 255);
}

constexpr std::uint32_t kMatrixClass = 1211216, kVectorClass = 1211214;

void write_body(SafeFile& file, const Mesh& mesh, std::span<const Material> materials) {
  for (const Element& e : mesh.elements)
    if (e.shape == Shape::pyramid5)
      throw InputError("pyramids cannot be written: CalculiX has no such element");
  file.write("*NODE,NSET=NALL\n");
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    file.write(format("%zu,%.13e,%.13e,%.13e\n", i + 1, mesh.nodes[i].x, mesh.nodes[i].y,
                      mesh.nodes[i].z));
  for (int shape = 0; shape < static_cast<int>(kShapes); ++shape)
    for (std::size_t r = 0; r < mesh.regions.size(); ++r) {
      bool first = true;
      for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        const Element& element = mesh.elements[e];
        if (static_cast<int>(element.shape) != shape || element.region != static_cast<int>(r))
          continue;
        if (first)
          file.write("*ELEMENT,TYPE=" + std::string(inp_type(element.shape)) +
                     format(",ELSET=R%zu\n", r));
        first = false;
        std::vector<int> line{static_cast<int>(e)};
        for (const int n : mesh.nodes_of(element))
          line.push_back(n);
        file.write(ids(line, 12));
      }
    }
  for (std::size_t r = 0; r < mesh.regions.size(); ++r) {
    const Material& m = materials[r];
    file.write(format("*MATERIAL,NAME=M%zu\n", r) + elastic(m) +
               format("*DENSITY\n%.12g\n", m.density) +
               (m.loss_factor > 0
                    ? format("*DAMPING,STRUCTURAL=%.12g\n", m.loss_factor)
                    : format("*DAMPING,ALPHA=%.12g,BETA=%.12g\n", m.rayleigh_a, m.rayleigh_b)));
    if (!m.isotropic())
      file.write(format("*ORIENTATION,NAME=O%zu\n%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n", r,
                        m.axis_1.x, m.axis_1.y, m.axis_1.z, m.axis_2.x, m.axis_2.y, m.axis_2.z));
    file.write(format("*SOLID SECTION,ELSET=R%zu,MATERIAL=M%zu", r, r) +
               (m.isotropic() ? "\n" : format(",ORIENTATION=O%zu\n", r)));
  }
}

} // namespace

void write_inp(const std::string& path, const Mesh& mesh, std::span<const Material> materials,
               std::span<const Support> supports, std::size_t modes) {
  SafeFile file(path);
  write_body(file, mesh, materials);
  for (const Support& s : supports) {
    if (s.stiffness_n_per_m > 0)
      throw InputError("springs cannot be written to " + path +
                       ": CalculiX' springs need elements");
    file.write("*BOUNDARY\n");
    for (const int n : s.nodes)
      for (std::size_t i = 0; i < 3; ++i)
        if (s.directions[i])
          file.write(format("%d,%zu\n", n + 1, i + 1));
  }
  file.write(format("*STEP\n*FREQUENCY\n%zu\n*NODE FILE\nU\n*END STEP\n", modes));
  file.commit();
}

void write_static_inp(const std::string& path, const Mesh& mesh, const StaticModel& model) {
  if (!model.springs.empty())
    throw InputError("springs cannot be written to " + path + ": CalculiX' springs need elements");
  SafeFile file(path);
  write_body(file, mesh, model.materials);
  file.write("*STEP\n*STATIC\n*BOUNDARY\n");
  for (const FixedPatch& patch : model.fixed)
    for (const int n : patch.nodes)
      for (std::size_t i = 0; i < 3; ++i)
        if (patch.directions[i])
          file.write(format("%d,%zu,%zu,%.13e\n", n + 1, i + 1, i + 1,
                            patch.displacement_m[static_cast<int>(i)]));
  file.write("*CLOAD\n");
  const std::vector<double> f = load_vector(mesh, model.materials, model.loads);
  for (std::size_t i = 0; i < f.size(); ++i)
    if (f[i] != 0)
      file.write(format("%zu,%zu,%.13e\n", i / 3 + 1, i % 3 + 1, f[i]));
  file.write("*NODE FILE\nU\n*EL FILE\nS\n*NODE PRINT,NSET=NALL\nU\n");
  for (std::size_t r = 0; r < mesh.regions.size(); ++r)
    file.write(format("*EL PRINT,ELSET=R%zu\nS\n", r));
  file.write("*END STEP\n");
  file.commit();
}

void write_petsc(const std::string& path, const Matrices& m) {
  SafeFile file(path);
  const std::size_t n = m.dofs(), nodes = m.graph.node_count();
  // Both triangles by rows: for every node, the pairs in which it is the row or the column.
  struct Pair {
    std::size_t column, at;
    bool transposed;
  };
  std::vector<std::vector<Pair>> rows(nodes);
  for (std::size_t c = 0; c < nodes; ++c)
    for (auto k = static_cast<std::size_t>(m.graph.start[c]);
         k < static_cast<std::size_t>(m.graph.start[c + 1]); ++k) {
      const auto r = static_cast<std::size_t>(m.graph.row[k]);
      if (r != c)
        rows[c].push_back({r, k, true});
      rows[r].push_back({c, k, false});
    }
  for (auto& row : rows)
    std::sort(row.begin(), row.end(),
              [](const Pair& a, const Pair& b) { return a.column < b.column; });
  for (const bool mass : {false, true}) {
    if (mass && m.mass.empty())
      break;
    std::string counts, columns, values;
    std::uint64_t entries = 0;
    for (std::size_t r = 0; r < nodes; ++r)
      for (std::size_t i = 0; i < 3; ++i) {
        std::uint64_t in_row = 0;
        for (const Pair& p : rows[r])
          for (std::size_t j = 0; j < 3; ++j) {
            if (mass && i != j)
              continue;
            const bool diagonal = p.column == r && i == j;
            const bool constrained = m.constrained[3 * r + i] || m.constrained[3 * p.column + j];
            if (constrained && !diagonal)
              continue;
            const double k = m.stiffness[9 * p.at + (p.transposed ? 3 * j + i : 3 * i + j)];
            const double value = constrained ? (mass ? 0.0 : 1.0) : mass ? m.mass[p.at] : k;
            put_big(columns, 3 * p.column + j, 4);
            put_big(values, std::bit_cast<std::uint64_t>(value), 8);
            ++in_row;
          }
        put_big(counts, in_row, 4);
        entries += in_row;
      }
    if (entries > 0x7FFFFFFF)
      throw InputError("the matrix has more entries than PETSc's 32-bit files can hold");
    std::string head;
    put_big(head, kMatrixClass, 4);
    put_big(head, n, 4);
    put_big(head, n, 4);
    put_big(head, entries, 4);
    for (const std::string* part : {&head, &counts, &columns, &values})
      file.write(*part);
  }
  file.commit();
}

void write_petsc_vectors(const std::string& path, std::span<const double> vectors,
                         std::size_t size) {
  SafeFile file(path);
  for (std::size_t first = 0; first < vectors.size(); first += size) {
    std::string text;
    put_big(text, kVectorClass, 4);
    put_big(text, size, 4);
    for (const double x : vectors.subspan(first, size))
      put_big(text, std::bit_cast<std::uint64_t>(x), 8);
    file.write(text);
  }
  file.commit();
}

namespace {

/// Reads all PETSc vectors of a file, one after the other.
std::vector<std::vector<double>> read_vectors(const std::string& path) {
  const std::string bytes = read_bytes(path, std::uint64_t{1} << 40);
  const auto big = [&](std::size_t at, std::size_t size) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
  };
  std::vector<std::vector<double>> vectors;
  for (std::size_t at = 0; at < bytes.size();) {
    if (bytes.size() - at < 8 || big(at, 4) != kVectorClass)
      throw InputError(path + " has no PETSc vector at byte " + std::to_string(at));
    const std::size_t size = big(at + 4, 4);
    at += 8;
    if (size > (bytes.size() - at) / 8)
      throw InputError(path + " is damaged: it ends within a vector");
    std::vector<double>& vector = vectors.emplace_back(size);
    for (double& x : vector) {
      x = std::bit_cast<double>(big(at, 8));
      at += 8;
    }
  }
  return vectors;
}

} // namespace

std::vector<double> read_petsc_vector(const std::string& path, std::size_t size) {
  auto vectors = read_vectors(path);
  if (vectors.size() != 1 || vectors[0].size() != size)
    throw InputError(path + " holds " + std::to_string(vectors.size()) + " vectors of " +
                     std::to_string(vectors.empty() ? 0 : vectors[0].size()) +
                     " numbers, expected 1 of " + std::to_string(size));
  return std::move(vectors[0]);
}

Modes import_modes(const std::string& values_path, const std::string& vectors_path,
                   const Mesh& mesh, const Matrices& m, bool rigid_among_them) {
  const auto values = read_vectors(values_path), vectors = read_vectors(vectors_path);
  const std::size_t n = m.dofs(), rigid = rigid_motions(mesh, m).size() / n;
  if (values.size() != 1 || values[0].size() < vectors.size())
    throw InputError(values_path + " has fewer values than " + vectors_path + " has vectors");
  std::vector<std::size_t> order(vectors.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = i;
    if (vectors[i].size() != n)
      throw InputError(vectors_path + ": vector " + std::to_string(i + 1) + " has " +
                       std::to_string(vectors[i].size()) + " entries, expected " +
                       std::to_string(n) + " for the mesh");
    for (const double x : vectors[i])
      if (!std::isfinite(x))
        throw InputError(vectors_path + ": vector " + std::to_string(i + 1) +
                         ": not a finite number");
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return values[0][a] < values[0][b]; });
  const std::size_t left_out = rigid_among_them ? rigid : 0;
  if (order.size() <= left_out)
    throw InputError(vectors_path + " has " + std::to_string(order.size()) +
                     " vectors, expected more than the " + std::to_string(left_out) +
                     " rigid motions");
  Modes modes;
  modes.rigid = rigid;
  for (std::size_t k = left_out; k < order.size(); ++k)
    modes.shapes.insert(modes.shapes.end(), vectors[order[k]].begin(), vectors[order[k]].end());
  modes.frequency_hz.resize(order.size() - left_out);
  sort_by_quotient(m, modes);
  make_canonical(mesh, modes);
  const double residual = *std::max_element(modes.residual.begin(), modes.residual.end());
  if (residual > 1e-3)
    throw InputError("the imported vectors are not modes of this body: residual " +
                     format("%.2g", residual) + ", expected below 0.001");
  return modes;
}

} // namespace tactus::fem
