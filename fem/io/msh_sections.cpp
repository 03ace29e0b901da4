#include "fem/io/msh_sections.hpp"

#include "fem/io/msh_scanner.hpp"
#include "fem/io/text.hpp"

#include <array>
#include <cstdlib>
#include <limits>
#include <set>

namespace tactus::fem {
namespace {

constexpr int kMinInt = std::numeric_limits<int>::min() + 1, // so that its magnitude is an int too
    kMaxInt = std::numeric_limits<int>::max();

class Reader {
public:
  Reader(const std::string& path, std::string bytes) : file_(path, std::move(bytes)) {}

  MshSections read() {
    for (std::string_view name; !(name = file_.next_section()).empty();) {
      const std::string section(name);
      if (section == "Comments") {
        file_.skip_section();
        continue;
      }
      if (version_ == 0 && section != "MeshFormat")
        file_.refuse("$" + section, "$MeshFormat before it");
      if (!read_section(section)) {
        if (out_.passed_over.size() < 200)
          out_.passed_over += (out_.passed_over.empty() ? "$" : ", $") + printable(section, 40);
        file_.skip_section();
        continue;
      }
      if (!seen_.insert(section).second)
        file_.refuse("$" + section, "one such section");
      file_.end_section();
      if (section == "MeshFormat" && binary_)
        file_.set_binary(byte_swapped_, word_);
    }
    if (version_ == 0)
      file_.refuse("the file ends", "$MeshFormat");
    return std::move(out_);
  }

private:
  bool read_section(const std::string& name) {
    if (name == "MeshFormat")
      read_format();
    else if (name == "PhysicalNames")
      read_names();
    else if (name == "Entities" && version_ == 4)
      read_entities();
    else if (name == "PartitionedEntities")
      file_.refuse("a partitioned mesh", "a mesh saved as one part");
    else if (name == "Nodes" || (name == "ParametricNodes" && version_ == 2))
      version_ == 4 ? read_nodes_4() : read_nodes_2(name == "ParametricNodes");
    else if (name == "Elements")
      version_ == 4 ? read_elements_4() : read_elements_2();
    else
      return false;
    return true;
  }

  void read_format() {
    const MshScanner::AsText as_text(file_);
    const double version = file_.real("a version of the format");
    if (version >= 2 && version < 2.3)
      version_ = 2;
    else if (version == 4.1)
      version_ = 4;
    else
      file_.refuse(format("version %g", version), "version 2.2 or 4.1 (gmsh saves both)");
    binary_ = file_.integer("0 for text or 1 for binary", 0, 1) == 1;
    const auto word = static_cast<std::size_t>(file_.integer("a size of numbers in bytes", 4, 8));
    if (word != 8 && !(version_ == 4 && word == 4))
      file_.refuse(std::to_string(word),
                   version_ == 4 ? "4 or 8 bytes a number" : "8 bytes a number");
    if (!binary_)
      return;
    if (!file_.line().empty())
      file_.refuse("more on the line", "the end of the line");
    const std::uint32_t one = file_.raw_word();
    if (one != 1 && one != 0x01000000)
      file_.refuse(format("the bytes %08x", one), "the number 1 in one order of bytes");
    byte_swapped_ = one != 1;
    word_ = word;
  }

  void read_names() {
    const MshScanner::AsText as_text(file_); // also in binary files
    const std::size_t count = file_.count("a number of names", 4, 8);
    for (std::size_t i = 0; i < count; ++i) {
      const int dimension = file_.integer("a dimension", 0, 3);
      const int tag = file_.integer("a tag of a physical group", kMinInt, kMaxInt);
      const std::string_view rest = file_.line();
      if (rest.size() < 2 || rest.front() != '"' || rest.back() != '"')
        file_.refuse(printable(rest, 60), "a name in quotation marks");
      const std::string_view name = rest.substr(1, rest.size() - 2);
      if (printable(name, name.size()) != name)
        file_.refuse(printable(name, 60), "a name without control characters");
      out_.group_names[{dimension, std::abs(tag)}] = name;
    }
  }

  void read_entities() {
    std::array<std::size_t, 4> counts{};
    for (std::size_t d = 0; d < 4; ++d)
      counts[d] = file_.count("a number of entities", d == 0 ? 5 : 8, d == 0 ? 32 : 60);
    for (std::size_t d = 0; d < 4; ++d)
      for (std::size_t i = 0; i < counts[d]; ++i) {
        const int dimension = static_cast<int>(d);
        const int tag = file_.integer("a tag of an entity", kMinInt, kMaxInt);
        for (int k = 0; k < (d == 0 ? 3 : 6); ++k)
          file_.real("a coordinate of an entity");
        auto& groups = out_.groups_of_entity[{dimension, tag}];
        const std::size_t physical = file_.count("a number of physical groups", 1, 4);
        for (std::size_t p = 0; p < physical; ++p)
          groups.push_back(std::abs(file_.integer("a tag of a physical group", kMinInt, kMaxInt)));
        const std::size_t bounds = d == 0 ? 0 : file_.count("a number of bounding entities", 1, 4);
        for (std::size_t b = 0; b < bounds; ++b)
          file_.integer("a tag of an entity", kMinInt, kMaxInt);
      }
  }

  void add_node(std::uint64_t tag) {
    out_.node_tags.push_back(tag);
    Vec3 p;
    for (int k = 0; k < 3; ++k)
      p[k] = file_.real("a coordinate");
    out_.nodes.push_back(p);
  }

  void read_nodes_2(bool parametric) {
    const std::size_t count = head_2("a number of nodes", 4, 28);
    for (std::size_t i = 0; i < count; ++i) {
      add_node(static_cast<std::uint64_t>(file_.integer("a node's number", 0, kMaxInt)));
      if (!parametric)
        continue;
      const int dimension = file_.integer("a dimension", 0, 3);
      file_.integer("a tag of an entity", kMinInt, kMaxInt);
      for (int k = 0; k < (dimension == 3 ? 0 : dimension); ++k)
        file_.real("a parameter");
    }
  }

  void read_nodes_4() {
    const std::size_t blocks = file_.count("a number of blocks", 4, 12 + file_.word());
    const std::size_t all = file_.count("a number of nodes", 4, 24 + file_.word());
    file_.tag("the lowest tag");
    file_.tag("the highest tag");
    for (std::size_t b = 0; b < blocks; ++b) {
      const int dimension = file_.integer("a dimension", 0, 3);
      file_.integer("a tag of an entity", kMinInt, kMaxInt);
      const int parameters = file_.integer("0 or 1, whether parametric", 0, 1) * dimension;
      const std::size_t count = file_.count("a number of nodes", 4, 24 + file_.word());
      if (count > all - out_.nodes.size())
        file_.refuse(std::to_string(count) + " nodes in a block",
                     std::to_string(all) + " in all blocks");
      std::vector<std::uint64_t> tags(count);
      for (std::uint64_t& tag : tags)
        tag = file_.tag("a node's tag");
      for (const std::uint64_t tag : tags) {
        add_node(tag);
        for (int k = 0; k < parameters; ++k)
          file_.real("a parameter");
      }
    }
    if (out_.nodes.size() != all)
      file_.refuse(std::to_string(out_.nodes.size()) + " nodes in the blocks",
                   std::to_string(all) + " as the section says");
  }

  /// Reads the count of a section of MSH 2, which is a line of text even in binary files.
  std::size_t head_2(const char* what, std::size_t numbers, std::size_t bytes) {
    const bool binary = file_.binary();
    const MshScanner::AsText as_text(file_);
    // The byte limit depends on the form in which the numbers follow.
    const std::size_t count = file_.count(what, binary ? (bytes + 1) / 2 : numbers, bytes);
    if (binary && !file_.line().empty())
      file_.refuse("more on the line", "the end of the line");
    return count;
  }

  const GmshElement& type_of(int number) {
    const GmshElement* const type = gmsh_element(number);
    if (!type)
      file_.refuse("element type " + std::to_string(number), "a type of gmsh's elements");
    if (type->dimension == 3 && !type->shape)
      file_.refuse(
          std::string("a ") + type->name + " (gmsh's type " + std::to_string(number) + ")",
          "tetrahedra of 4 or 10 nodes, hexahedra of 8 or 20, prisms of 6 or 15, or pyramids of 5");
    return *type;
  }

  void add_element(std::uint64_t tag, const GmshElement& type, int entity, int physical) {
    out_.elements.push_back({tag, &type, entity, physical, out_.uses.size()});
    for (int i = 0; i < type.nodes; ++i)
      out_.uses.push_back(
          version_ == 4 ? file_.tag("a node's tag")
                        : static_cast<std::uint64_t>(file_.integer("a node's number", 0, kMaxInt)));
  }

  /// Tags of an element of MSH 2: physical group, entity, then partitions.
  std::array<int, 2> tags_2(int count) {
    std::array<int, 2> groups{0, 1};
    for (int t = 0; t < count; ++t) {
      const int tag = file_.integer("a tag", kMinInt, kMaxInt);
      if (t < 2)
        groups[static_cast<std::size_t>(t)] = tag;
    }
    return {std::abs(groups[0]), groups[1]};
  }

  void read_elements_2() {
    const std::size_t count = head_2("a number of elements", 4, 8);
    constexpr const char* kTags = "a number of tags";
    std::size_t done = 0;
    while (done < count) {
      if (!file_.binary()) {
        const int tag = file_.integer("an element's number", 0, kMaxInt);
        const GmshElement& type = type_of(file_.integer("an element type", 1, kMaxInt));
        const auto [physical, entity] = tags_2(file_.integer(kTags, 0, 1 << 20));
        add_element(static_cast<std::uint64_t>(tag), type, entity, physical);
        ++done;
        continue;
      }
      const GmshElement& type = type_of(file_.integer("an element type", 1, kMaxInt));
      const int block = file_.integer("a number of elements in a block", 1, kMaxInt);
      const int tags = file_.integer(kTags, 0, 1 << 20);
      if (static_cast<std::size_t>(block) > count - done)
        file_.refuse(std::to_string(block) + " elements in a block",
                     std::to_string(count) + " in all blocks");
      for (int i = 0; i < block; ++i, ++done) {
        const int tag = file_.integer("an element's number", 0, kMaxInt);
        const auto [physical, entity] = tags_2(tags);
        add_element(static_cast<std::uint64_t>(tag), type, entity, physical);
      }
    }
  }

  void read_elements_4() {
    const std::size_t blocks = file_.count("a number of blocks", 4, 12 + file_.word());
    const std::size_t all = file_.count("a number of elements", 2, 2 * file_.word());
    file_.tag("the lowest tag");
    file_.tag("the highest tag");
    for (std::size_t b = 0; b < blocks; ++b) {
      const int dimension = file_.integer("a dimension", 0, 3);
      const int entity = file_.integer("a tag of an entity", kMinInt, kMaxInt);
      const GmshElement& type = type_of(file_.integer("an element type", 1, kMaxInt));
      if (type.dimension != dimension)
        file_.refuse(std::string("a ") + type.name + " in an entity of dimension " +
                         std::to_string(dimension),
                     "dimension " + std::to_string(type.dimension));
      const auto nodes = static_cast<std::size_t>(type.nodes);
      const std::size_t count =
          file_.count("a number of elements", 1 + nodes, (1 + nodes) * file_.word());
      if (count > all - out_.elements.size())
        file_.refuse(std::to_string(count) + " elements in a block",
                     std::to_string(all) + " in all blocks");
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint64_t tag = file_.tag("an element's tag");
        add_element(tag, type, entity, 0);
      }
    }
    if (out_.elements.size() != all)
      file_.refuse(std::to_string(out_.elements.size()) + " elements in the blocks",
                   std::to_string(all) + " as the section says");
  }

  MshScanner file_;
  MshSections out_;
  std::set<std::string> seen_;
  int version_ = 0; ///< 2 or 4
  bool binary_ = false, byte_swapped_ = false;
  std::size_t word_ = 8;
};

} // namespace

MshSections read_msh_sections(const std::string& path, std::string bytes) {
  return Reader(path, std::move(bytes)).read();
}

} // namespace tactus::fem
