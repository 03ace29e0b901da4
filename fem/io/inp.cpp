#include "fem/io/inp.hpp"

#include "fem/io/inp_materials.hpp"
#include "fem/io/text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>

namespace tactus::fem {
namespace {

constexpr std::array<std::string_view, kShapes> kInpTypes{"C3D4",  "C3D10", "C3D8", "C3D20",
                                                          "C3D15", "C3D6",  "C3D5"};

/// The shape with that number of nodes; letters after it select an integration rule, which is
/// ignored (C3D8R).
std::optional<Shape> shape_of(std::string_view type) {
  for (std::size_t i = 0; i < kShapes; ++i) {
    const std::string name = lower(kInpTypes[i]);
    if (type.starts_with(name) &&
        type.find_first_not_of("rimhtsx", name.size()) == std::string_view::npos)
      return static_cast<Shape>(i);
  }
  return std::nullopt;
}

/// Plane, shell, membrane and line elements. Meshers write such elements for the skin, besides the
/// solids.
bool carries_no_volume(std::string_view type) {
  constexpr std::array<std::string_view, 14> kNames{
      "cps", "cpe", "cax", "s3", "s4", "s6", "s8", "m3d", "sfm", "t2d", "t3d", "b21", "b31", "b32"};
  return std::any_of(kNames.begin(), kNames.end(),
                     [&](std::string_view name) { return type.starts_with(name); });
}

/// Keywords of the analysis other than steps (conditions, output requests), and properties that
/// linear modes and stresses do not use.
bool is_of_analysis(const std::string& keyword) {
  static const std::set<std::string> kNames{
      "amplitude",       "boundary",          "conductivity", "creep",      "elementoutput",
      "elfile",          "elprint",           "expansion",    "fileformat", "filter",
      "heading",         "initialconditions", "nodefile",     "nodeoutput", "nodeprint",
      "output",          "physicalconstants", "plastic",      "preprint",   "restart",
      "sectioncontrols", "specificheat",      "surface",      "timepoints", "transform"};
  return kNames.contains(keyword);
}

/// A set with the spelling of its first occurrence; names in a file are case-insensitive.
struct InpSet {
  std::string name;
  std::vector<int> members; ///< indices; -1 for an element without volume
};
using InpSets = std::map<std::string, InpSet>;

InpSet& set_named(InpSets& sets, const std::string& name) {
  InpSet& set = sets[lower(name)];
  if (set.name.empty())
    set.name = name;
  return set;
}

/// The meaning of numbers and names in the file, or in an instance, whose names begin with "NAME.".
struct InpScope {
  std::string prefix;
  std::map<int, int> node_of, element_of; ///< not hashed, because the numbers are untrusted
};

/// Moves by `shift`, then turns by `angle` about the line through `from` along `axis`, as Abaqus
/// does.
struct Placement {
  Vec3 shift{}, from{}, axis{0, 0, 1};
  double angle = 0;
  /// Rodrigues' formula.
  [[nodiscard]] Vec3 turned(const Vec3& v) const {
    return std::cos(angle) * v + std::sin(angle) * cross(axis, v) +
           (1 - std::cos(angle)) * dot(axis, v) * axis;
  }
  [[nodiscard]] Vec3 placed(const Vec3& p) const {
    return angle == 0 ? p + shift : from + turned(p + shift - from);
  }
};

constexpr std::size_t kMaxInstances = 1000; // limited, because each instance reads its part again

/// Reads the file line by line into a mesh. The last keyword decides how data lines are read.
class InpReader {
public:
  InpReader(const std::string& path, double unit)
      : lines_(path), materials_(lines_, unit), unit_(unit) {
    mesh_.regions.clear();
  }

  [[nodiscard]] Mesh read(const std::function<void(const std::string&)>& notify) {
    while (lines_.next()) {
      if (lines_.is_keyword())
        begin(lines_.keyword());
      else if (!block_)
        lines_.refuse(printable(lines_.text(), 60) + ", expected a keyword such as *NODE");
      else if (block_->add)
        (this->*block_->add)();
      else if (block_ != &kPassedOver)
        lines_.refuse(printable(lines_.text(), 60) + ": expected no data of " + keyword_.words);
    }
    end_element();
    if (scope_ != &file_)
      lines_.refuse("the file ends in *INSTANCE, expected *END INSTANCE");
    if (mesh_.elements.empty())
      throw InputError(lines_.path() + " holds no volume element: expected C3D10, C3D15 or C3D20");
    assign_regions();
    for (auto& [key, set] : node_sets_)
      mesh_.node_sets[set.name] = std::move(set.members);
    drop_unused_nodes(mesh_);
    if (notify)
      report(notify);
    return std::move(mesh_);
  }

private:
  /// How a keyword is read: its allowed parameters, and the functions for the keyword and for each
  /// of its data lines.
  struct Block {
    std::vector<std::string> parameters;
    void (InpReader::*begin)() = nullptr;
    void (InpReader::*add)() = nullptr;
  };
  static const Block kPassedOver; ///< for keywords of the analysis
  static const std::map<std::string, Block>& blocks() {
    static const std::map<std::string, Block> all{
        {"node", {{"nset"}, nullptr, &InpReader::add_node}},
        {"element", {{"type", "elset"}, &InpReader::begin_elements, &InpReader::add_to_element}},
        {"nset",
         {{"nset", "elset", "generate", "unsorted", "internal", "instance"},
          &InpReader::begin_node_set,
          &InpReader::add_to_node_set}},
        {"elset",
         {{"elset", "generate", "unsorted", "internal", "instance"},
          &InpReader::begin_element_set,
          &InpReader::add_to_element_set}},
        {"part", {{"name"}, &InpReader::keep_part, nullptr}},
        {"assembly", {{"name"}, nullptr, nullptr}},
        {"endassembly", {}},
        {"instance", {{"name", "part"}, &InpReader::begin_instance, &InpReader::add_placement}},
        {"endinstance", {{}, &InpReader::read_part, nullptr}},
        {"material", {{"name"}, &InpReader::begin_material, nullptr}},
        {"elastic", {{"type"}, &InpReader::begin_elastic, &InpReader::add_elastic}},
        {"density", {{}, nullptr, &InpReader::add_density}},
        {"damping", {{"alpha", "beta", "structural"}, &InpReader::begin_damping, nullptr}},
        {"orientation",
         {{"name", "system", "definition"},
          &InpReader::begin_orientation,
          &InpReader::add_orientation}},
        {"solidsection",
         {{"elset", "material", "orientation", "controls"},
          &InpReader::begin_section,
          &InpReader::add_thickness}}};
    return all;
  }

  void begin(InpKeyword keyword) {
    end_element();
    keyword_ = std::move(keyword);
    if (keyword_.name == "step")
      in_step_ = true;
    const auto known = blocks().find(keyword_.name);
    if ((in_step_ && keyword_.name != "include" && keyword_.name != "modelchange") ||
        is_of_analysis(keyword_.name)) {
      block_ = &kPassedOver;
      if (keyword_.name != "heading" && keyword_.name != "endstep")
        passed_over_.try_emplace(keyword_.name, Counted{keyword_.words, keyword_.line});
      in_step_ = in_step_ && keyword_.name != "endstep";
      return;
    }
    if (known == blocks().end())
      lines_.refuse(
          keyword_.words +
              " is not supported: expected nodes, elements, sets, materials, *SOLID SECTION, *PART "
              "and *INSTANCE, in one file without *INCLUDE",
          keyword_.line);
    block_ = &known->second;
    for (const auto& [name, value] : keyword_.parameters)
      if (std::find(block_->parameters.begin(), block_->parameters.end(), name) ==
          block_->parameters.end())
        lines_.refuse(keyword_.words + ": " + printable(name, 40) + " is not supported",
                      keyword_.line);
    if (placing_ && keyword_.name != "endinstance")
      lines_.refuse(keyword_.words + " in *INSTANCE: expected only its placement", keyword_.line);
    within_ = scope_;
    if (keyword_.has("instance")) {
      const auto named = instances_.find(lower(keyword_.value("instance")));
      if (named == instances_.end())
        lines_.refuse("unknown instance " + printable(keyword_.value("instance"), 60),
                      keyword_.line);
      within_ = &named->second;
    }
    if (block_->begin)
      (this->*block_->begin)();
  }

  /// Stores a part's lines, which are read for each instance of the part, under the instance's
  /// name.
  void keep_part() {
    if (scope_ != &file_)
      lines_.refuse(keyword_.words + " in an instance", keyword_.line);
    const std::string name = lower(keyword_.value("name"));
    if (name.empty())
      lines_.refuse(keyword_.words + ": expected NAME=", keyword_.line);
    if (!parts_.try_emplace(name, lines_.keep_until("endpart", keyword_)).second)
      lines_.refuse("part " + printable(name, 60) + " is defined twice", keyword_.line);
    unused_parts_.insert(name);
  }
  void begin_instance() {
    const std::string name = keyword_.value("name"), part = lower(keyword_.value("part"));
    part_ = parts_.find(part);
    if (name.empty() || part_ == parts_.end())
      lines_.refuse(keyword_.words + ": expected NAME= and PART= of a part before it",
                    keyword_.line);
    if (scope_ != &file_ || instances_.size() >= kMaxInstances)
      lines_.refuse(keyword_.words +
                        format(": expected %zu instances at most, none in another", kMaxInstances),
                    keyword_.line);
    const auto [at, added] = instances_.try_emplace(lower(name));
    if (!added)
      lines_.refuse("instance " + printable(name, 60) + " is defined twice", keyword_.line);
    at->second.prefix = name + ".";
    scope_ = &at->second;
    unused_parts_.erase(part);
    placement_ = {};
    placing_ = true;
    placement_lines_ = 0;
  }
  void add_placement() {
    const auto cells = lines_.cells();
    std::array<double, 7> x{};
    const std::size_t expected = ++placement_lines_ == 1 ? 3 : 7;
    if (placement_lines_ > 2 || cells.size() != expected)
      lines_.refuse(printable(lines_.text(), 60) +
                    ", expected a line with the shift x,y,z and a line with two points and an "
                    "angle in degrees to turn by");
    std::transform(cells.begin(), cells.end(), x.begin(),
                   [this](const std::string& cell) { return lines_.number(cell); });
    if (expected == 3) {
      placement_.shift = unit_ * Vec3{x[0], x[1], x[2]};
      return;
    }
    const Vec3 axis = Vec3{x[3], x[4], x[5]} - Vec3{x[0], x[1], x[2]};
    if (!(length(axis) > 0))
      lines_.refuse(printable(lines_.text(), 60) + ": expected two points of the axis");
    placement_.from = unit_ * Vec3{x[0], x[1], x[2]};
    placement_.axis = (1 / length(axis)) * axis;
    placement_.angle = x[6] * std::numbers::pi / 180;
  }
  /// *END INSTANCE: the part's lines are read now, followed by a second *END INSTANCE, which ends
  /// the instance.
  void read_part() {
    if (scope_ == &file_)
      lines_.refuse(keyword_.words + " without *INSTANCE", keyword_.line);
    if (placing_) {
      lines_.read_again({{"*END INSTANCE", keyword_.line}});
      lines_.read_again(part_->second);
      materials_.turn_by([placement = placement_](const Vec3& v) { return placement.turned(v); });
    } else {
      materials_.turn_by({});
      scope_ = &file_;
      placement_ = {};
    }
    placing_ = false;
  }
  /// Adds the instance's prefix to a name defined in the part.
  void scope_parameter(const char* parameter) {
    if (keyword_.has(parameter) && !keyword_.value(parameter).empty())
      keyword_.parameters[parameter] = scope_->prefix + keyword_.value(parameter);
  }

  [[nodiscard]] int node(int id) const {
    const auto at = within_->node_of.find(id);
    if (at == within_->node_of.end())
      lines_.refuse("node " + std::to_string(id) + " is not defined");
    return at->second;
  }
  [[nodiscard]] int element(int id) const {
    const auto at = within_->element_of.find(id);
    if (at == within_->element_of.end())
      lines_.refuse("element " + std::to_string(id) + " is not defined");
    return at->second;
  }
  [[nodiscard]] int id(const std::string& cell) const {
    const auto value = to_number<int>(cell);
    if (!value)
      lines_.refuse(printable(cell, 60) + " is not an integer");
    return *value;
  }

  void add_node() {
    const auto cells = lines_.cells();
    if (cells.size() != 4)
      lines_.refuse(printable(lines_.text(), 60) + ", expected number,x,y,z");
    Vec3 p;
    for (int k = 0; k < 3; ++k)
      p[k] = unit_ * lines_.number(cells[static_cast<std::size_t>(k) + 1]);
    p = placement_.placed(p);
    if (!scope_->node_of.try_emplace(id(cells[0]), static_cast<int>(mesh_.nodes.size())).second)
      lines_.refuse("node " + cells[0] + " is defined twice");
    if (keyword_.has("nset"))
      set_named(node_sets_, scope_->prefix + keyword_.value("nset"))
          .members.push_back(static_cast<int>(mesh_.nodes.size()));
    mesh_.nodes.push_back(p);
  }

  void begin_elements() {
    const std::string type = lower(keyword_.value("type"));
    shape_ = shape_of(type);
    if (!shape_ && !carries_no_volume(type))
      lines_.refuse(keyword_.words + " TYPE=" + printable(keyword_.value("type"), 40) +
                        ": expected C3D4, C3D5, C3D6, C3D8, C3D10, C3D15, C3D20 or a variant",
                    keyword_.line);
    if (!shape_)
      flat_.try_emplace(type, Counted{keyword_.value("type"), keyword_.line});
    continued_ = false;
  }
  void add_to_element() {
    for (const std::string& cell : lines_.cells())
      pending_.push_back(id(cell));
    if (!shape_) { // a comma at the end continues the element on the next line
      continued_ = lines_.text().ends_with(',');
      if (!continued_)
        end_flat_element();
      return;
    }
    const auto needed = static_cast<std::size_t>(node_count(*shape_)) + 1;
    if (pending_.size() > needed)
      lines_.refuse("element " + std::to_string(pending_[0]) + " has more than " +
                    std::to_string(needed - 1) + " nodes");
    if (pending_.size() < needed)
      return;
    std::vector<int> nodes;
    for (std::size_t i = 1; i < needed; ++i)
      nodes.push_back(node(pending_[i]));
    define_element(static_cast<int>(mesh_.elements.size()));
    add_uncollapsed(nodes);
  }
  /// CalculiX has no pyramid. A brick with repeated nodes is read as a pyramid, wedge or
  /// tetrahedron.
  void add_uncollapsed(const std::vector<int>& n) {
    const bool brick = *shape_ == Shape::hex8;
    const bool apex = brick && n[4] == n[5] && n[5] == n[6] && n[6] == n[7];
    const bool edge = brick && n[2] == n[3] && n[6] == n[7];
    if (apex && edge)
      mesh_.add(Shape::tet4, std::array{n[0], n[1], n[2], n[4]});
    else if (apex)
      mesh_.add(Shape::pyramid5, std::array{n[0], n[1], n[2], n[3], n[4]});
    else if (edge)
      mesh_.add(Shape::wedge6, std::array{n[0], n[1], n[2], n[4], n[5], n[6]});
    else
      mesh_.add(*shape_, n);
  }
  void end_flat_element() {
    ++flat_.at(lower(keyword_.value("type"))).count;
    define_element(-1);
  }
  void define_element(int index) {
    const int number = pending_[0];
    pending_.clear();
    if (!scope_->element_of.try_emplace(number, index).second)
      lines_.refuse("element " + std::to_string(number) + " is defined twice");
    const std::string name = keyword_.value("elset"),
                      set = name.empty() ? name : scope_->prefix + name;
    if (!set.empty())
      set_named(element_sets_, set).members.push_back(index);
    if (index >= 0)
      elements_.push_back({number, set});
  }
  void end_element() {
    if (!pending_.empty())
      lines_.refuse("element " + std::to_string(pending_[0]) + " ends early");
  }

  void begin_node_set() {
    members_ = &begin_set(node_sets_, "nset");
    const std::string elements = keyword_.value("elset");
    if (elements.empty())
      return;
    for (const int e : members_of(element_sets_, elements))
      if (e >= 0)
        for (const int n : mesh_.nodes_of(mesh_.elements[static_cast<std::size_t>(e)]))
          members_->push_back(n);
    limit_sets(members_->size());
  }
  void begin_element_set() { members_ = &begin_set(element_sets_, "elset"); }
  std::vector<int>& begin_set(InpSets& sets, const char* parameter) {
    if (keyword_.value(parameter).empty())
      lines_.refuse(keyword_.words + ": expected a name, " + parameter + "=", keyword_.line);
    return set_named(sets, scope_->prefix + keyword_.value(parameter)).members;
  }
  void add_to_node_set() {
    add_to_set(node_sets_, [this](int number) { return node(number); });
  }
  void add_to_element_set() {
    add_to_set(element_sets_, [this](int number) { return element(number); });
  }
  /// Adds numbers, names of sets or, with GENERATE, a range of first, last and step.
  template <class Find> void add_to_set(const InpSets& sets, Find&& find) {
    const auto cells = lines_.cells();
    const std::size_t before = members_->size();
    if (keyword_.has("generate")) {
      const int step = cells.size() == 3 ? id(cells[2]) : 1;
      if (cells.size() < 2 || cells.size() > 3 || step < 1)
        lines_.refuse(printable(lines_.text(), 60) + ", expected first,last,step");
      for (std::int64_t i = id(cells[0]), last = id(cells[1]); i <= last; i += step)
        members_->push_back(find(static_cast<int>(i)));
    } else {
      for (const std::string& cell : cells)
        if (to_number<int>(cell)) {
          members_->push_back(find(id(cell)));
        } else {
          const std::vector<int> named = members_of(sets, cell); // a copy, since the set may
                                                                 // contain itself
          members_->insert(members_->end(), named.begin(), named.end());
        }
    }
    limit_sets(members_->size() - before);
  }
  [[nodiscard]] std::vector<int> members_of(const InpSets& sets, const std::string& name) const {
    const auto at = sets.find(lower(within_->prefix + name));
    if (at == sets.end())
      lines_.refuse("unknown set " + printable(name, 60));
    return at->second.members;
  }
  /// A line with a range or a set's name is short, so without a limit a small file could request
  /// any amount of memory.
  void limit_sets(std::size_t added) {
    in_sets_ += added;
    if (in_sets_ > 1000 + 100 * mesh_.nodes.size())
      lines_.refuse(std::to_string(in_sets_) + " entries in sets, expected at most " +
                    std::to_string(1000 + 100 * mesh_.nodes.size()) + " (a hundred for each node)");
  }

  void begin_material() { materials_.begin_material(keyword_); }
  void begin_elastic() { materials_.begin_elastic(keyword_); }
  void add_elastic() { materials_.add_elastic(); }
  void add_density() { materials_.add_density(); }
  void begin_damping() { materials_.begin_damping(keyword_); }
  void begin_orientation() {
    scope_parameter("name");
    materials_.begin_orientation(keyword_);
  }
  void add_orientation() { materials_.add_orientation(); }
  void begin_section() {
    scope_parameter("elset");
    scope_parameter("orientation");
    materials_.begin_section(keyword_);
  }
  void add_thickness() { materials_.add_thickness(); }

  /// The section of each element; -1 if it has none.
  [[nodiscard]] std::vector<int> sections_of_elements() const {
    std::vector<int> sections(mesh_.elements.size(), -1);
    int number = 0;
    for (const InpMaterials::Section& section : materials_.sections()) {
      const auto set = element_sets_.find(lower(section.elements));
      if (set == element_sets_.end())
        lines_.refuse("unknown element set " + printable(section.elements, 60), section.line);
      for (const int e : set->second.members) {
        if (e < 0)
          lines_.refuse("a section of elements without volume, expected C3D elements in " +
                            section.elements,
                        section.line);
        int& of = sections[static_cast<std::size_t>(e)];
        if (of >= 0 && of != number)
          lines_.refuse("element " + std::to_string(elements_[static_cast<std::size_t>(e)].number) +
                            " already has a section",
                        section.line);
        of = number;
      }
      ++number;
    }
    return sections;
  }

  /// An element without ELSET in *ELEMENT belongs to the smallest set that contains it.
  void take_sets_as_names() {
    std::vector<const InpSet*> smallest_last;
    for (const auto& [key, set] : element_sets_)
      smallest_last.push_back(&set);
    std::stable_sort(smallest_last.begin(), smallest_last.end(),
                     [](auto* a, auto* b) { return a->members.size() > b->members.size(); });
    std::vector<const InpSet*> named(elements_.size(), nullptr);
    for (const InpSet* set : smallest_last)
      for (const int e : set->members)
        if (e >= 0)
          named[static_cast<std::size_t>(e)] = set;
    for (std::size_t e = 0; e < elements_.size(); ++e)
      if (elements_[e].set.empty() && named[e])
        elements_[e].set = named[e]->name;
  }

  void assign_regions() {
    take_sets_as_names();
    const std::vector<int> section = sections_of_elements();
    std::map<std::string, std::set<int>> sections_in;
    for (std::size_t e = 0; e < elements_.size(); ++e)
      sections_in[lower(elements_[e].set)].insert(section[e]);
    std::map<std::pair<std::string, int>, int> region_of;
    for (std::size_t e = 0; e < elements_.size(); ++e) {
      const std::string key = lower(elements_[e].set);
      const auto [at, added] =
          region_of.try_emplace({key, section[e]}, static_cast<int>(mesh_.regions.size()));
      mesh_.elements[e].region = at->second;
      if (added)
        add_region(elements_[e].set, section[e], sections_in[key].size() > 1);
    }
    if (materials_.sections().empty())
      mesh_.materials.clear();
  }
  /// Adds a region. Its name is the section's ELSET, or its own ELSET if the section is divided
  /// into several regions.
  void add_region(const std::string& set, int section, bool divided) {
    const bool has_section = section >= 0;
    const auto& all = materials_.sections();
    std::string name = set;
    if (has_section && (divided || set.empty()))
      name = all[static_cast<std::size_t>(section)].elements;
    if (name.empty())
      name = "body";
    const std::string stem = name;
    for (int copy = 2;
         std::find(mesh_.regions.begin(), mesh_.regions.end(), name) != mesh_.regions.end(); ++copy)
      name = stem + "_" + std::to_string(copy);
    mesh_.regions.push_back(name);
    mesh_.materials.emplace_back();
    if (has_section)
      mesh_.materials.back() = materials_.material_of(all[static_cast<std::size_t>(section)]);
  }

  /// Reports the contents of the file, besides the mesh, that are used and those that are ignored.
  void report(const std::function<void(const std::string&)>& notify) const {
    for (std::size_t r = 0; r < mesh_.materials.size(); ++r)
      if (const auto& m = mesh_.materials[r])
        notify("region " + mesh_.regions[r] + ": material " + m->name +
               format(" of the file, %.4g Pa, %.4g kg/m^3, ", m->young_pa[0], m->density) +
               (m->loss_factor > 0
                    ? format("loss factor %g", m->loss_factor)
                    : format("damping %g 1/s and %g s", m->rayleigh_a, m->rayleigh_b)));
    for (const auto& [type, flat] : flat_)
      notify(format("%d elements of %s (line %d) have no volume and are ignored", flat.count,
                    flat.words.c_str(), flat.line));
    for (const std::string& part : unused_parts_)
      notify("part " + printable(part, 60) + " has no *INSTANCE and is ignored");
    std::string names;
    for (const auto& [name, at] : passed_over_)
      names += (names.empty() ? "" : ", ") + at.words + " (line " + std::to_string(at.line) + ")";
    if (!names.empty())
      notify("ignored in the file, since options set supports and loads: " + names);
  }

  struct Numbered {
    int number;
    std::string set; ///< set of *ELEMENT
  };
  struct Counted {
    std::string words;
    int line = 0, count = 0;
  };

  InpLines lines_;
  InpMaterials materials_;
  double unit_; ///< metres per unit of the file
  Mesh mesh_;
  InpScope file_;
  std::map<std::string, InpScope> instances_; ///< by name in lower case, as parts_
  std::map<std::string, InpLines::Kept> parts_;
  std::set<std::string> unused_parts_;
  std::map<std::string, InpLines::Kept>::const_iterator part_; ///< part of the last instance
  InpScope* scope_ = &file_;                                   ///< scope of definitions
  const InpScope* within_ = &file_;                            ///< scope of references
  Placement placement_;                                        ///< placement of the instance being
                                                               ///< read
  bool placing_ = false;
  int placement_lines_ = 0;
  std::vector<Numbered> elements_; ///< elements with volume
  InpSets node_sets_, element_sets_;
  InpKeyword keyword_;
  const Block* block_ = nullptr;
  bool in_step_ = false, continued_ = false;
  std::optional<Shape> shape_;          ///< shape of *ELEMENT; empty without volume
  std::vector<int> pending_;            ///< an element's numbers may run over several lines
  std::vector<int>* members_ = nullptr; ///< members of the set being read
  std::size_t in_sets_ = 0;
  std::map<std::string, Counted> flat_, passed_over_; ///< by type and by keyword
};

const InpReader::Block InpReader::kPassedOver{};

} // namespace

std::string_view inp_type(Shape shape) noexcept {
  return kInpTypes[static_cast<std::size_t>(shape)];
}

Mesh read_inp(const std::string& path, double unit,
              const std::function<void(const std::string&)>& notify) {
  return InpReader(path, unit).read(notify);
}

} // namespace tactus::fem
