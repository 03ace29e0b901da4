#include "fem/io/vtu.hpp"

#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"

#include <cmath>

namespace tactus::fem {
namespace {

/// The text with XML escapes, for an attribute.
std::string attribute(const std::string& text) {
  std::string out;
  for (const char c : printable(text, 200))
    out += c == '"'   ? "&quot;"
           : c == '&' ? "&amp;"
           : c == '<' ? "&lt;"
           : c == '>' ? "&gt;"
                      : std::string(1, c);
  return out;
}

void check(const std::string& path, const VtuField& field, std::size_t count,
           const char* location) {
  if (field.components == 0 || field.values.size() != field.components * count)
    throw InputError(path + ": field " + field.name +
                     format(" has %zu numbers, expected %zu for each of %zu %s",
                            field.values.size(), field.components, count, location));
  for (const double value : field.values)
    if (!std::isfinite(value))
      throw InputError(path + ": field " + field.name + ": not a finite number");
}

void write_field(SafeFile& file, const VtuField& field) {
  file.write("<DataArray type=\"Float32\" Name=\"" + attribute(field.name) +
             format("\" NumberOfComponents=\"%zu\" format=\"ascii\">\n", field.components));
  for (std::size_t i = 0; i < field.values.size(); i += field.components) {
    std::string line;
    for (std::size_t c = 0; c < field.components; ++c)
      line += format(c ? " %.7g" : "%.7g", field.values[i + c]);
    file.write(line + "\n");
  }
  file.write("</DataArray>\n");
}

} // namespace

void write_vtu(const std::string& path, const Mesh& mesh, std::span<const VtuField> at_nodes,
               std::span<const VtuField> in_elements) {
  for (const VtuField& field : at_nodes)
    check(path, field, mesh.nodes.size(), "nodes");
  for (const VtuField& field : in_elements)
    check(path, field, mesh.elements.size(), "elements");
  SafeFile file(path);
  file.write("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
             "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n");
  file.write(format("<Piece NumberOfPoints=\"%zu\" NumberOfCells=\"%zu\">\n<Points>\n"
                    "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n",
                    mesh.nodes.size(), mesh.elements.size()));
  for (const Vec3& p : mesh.nodes)
    file.write(format("%.9g %.9g %.9g\n", p.x, p.y, p.z));
  file.write("</DataArray>\n</Points>\n<Cells>\n"
             "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n");
  for (const Element& e : mesh.elements) {
    std::string line;
    for (const int node : mesh.nodes_of(e))
      line += std::to_string(node) + ' ';
    file.write(line + "\n");
  }
  file.write("</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n");
  std::size_t end = 0;
  for (const Element& e : mesh.elements)
    file.write(std::to_string(end += static_cast<std::size_t>(node_count(e.shape))) + "\n");
  file.write("</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n");
  for (const Element& e : mesh.elements)
    file.write(std::to_string(vtk_type(e.shape)) + "\n");
  file.write("</DataArray>\n</Cells>\n<CellData>\n"
             "<DataArray type=\"Int32\" Name=\"region\" format=\"ascii\">\n");
  for (const Element& e : mesh.elements)
    file.write(std::to_string(e.region) + "\n");
  file.write("</DataArray>\n");
  for (const VtuField& field : in_elements)
    write_field(file, field);
  file.write("</CellData>\n<PointData>\n");
  for (const VtuField& field : at_nodes)
    write_field(file, field);
  file.write("</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
  file.commit();
}

} // namespace tactus::fem
