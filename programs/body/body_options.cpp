#include "programs/body/body_options.hpp"

#include "fem/io/text.hpp"
#include "programs/body/budget.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace tactus::fem {
namespace {

double unit_of(const std::string& word) {
  const auto* const at = std::find_if(kUnits.begin(), kUnits.end(),
                                      [&](const LengthUnit& u) { return u.name == word; });
  if (at == kUnits.end())
    throw InputError("--unit " + word + ": expected um, mm, cm, m or in");
  return at->metres;
}

/// Applies --young, --poisson, --density and --loss.
void apply_changes(const BodyOptions& options, Material& material) {
  for (const auto& [what, value] : options.changes) {
    if (what == "young")
      material.young_pa[0] = value;
    else if (what == "poisson")
      material.poisson[0] = value;
    else if (what == "density")
      material.density = value;
    else
      material.loss_factor = value;
  }
}

/// One material per region: from --material, where those for all regions come first; else from the
/// file; else none.
std::vector<std::optional<Material>> chosen_materials(const BodyOptions& options,
                                                      const Mesh& mesh) {
  std::vector<std::optional<Material>> chosen = mesh.materials;
  chosen.resize(mesh.regions.size());
  for (const auto& [region, name] : options.materials)
    if (region.empty())
      std::fill(chosen.begin(), chosen.end(), find_material(name));
  for (const auto& [region, name] : options.materials) {
    if (region.empty())
      continue;
    const auto at = std::find(mesh.regions.begin(), mesh.regions.end(), region);
    if (at == mesh.regions.end()) {
      std::string names;
      for (const std::string& r : mesh.regions)
        names += (names.empty() ? "" : ", ") + r;
      throw InputError("--material: region " + region + ": expected one of " + names);
    }
    chosen[static_cast<std::size_t>(at - mesh.regions.begin())] = find_material(name);
  }
  return chosen;
}

std::string underscored(std::string word) {
  std::replace(word.begin(), word.end(), '-', '_');
  return word;
}

} // namespace

std::string BodyOptions::name() const { return std::filesystem::path(body).stem().string(); }

double BodyOptions::unit_of_body() const {
  if (!is_file)
    return unit;
  const double usual = default_unit(body);
  return unit_given && usual > 0 ? unit : usual;
}

double number(const std::string& option, const std::string& word, double low, double high) {
  const auto value = to_number(word);
  if (!value || *value < low || *value > high)
    throw InputError(option + " " + word + ": expected a number in " + format("%g", low) + ".." +
                     format("%g", high));
  return *value;
}

int integer(const std::string& option, const std::string& word, int low, int high) {
  const auto value = to_number(word, low, high);
  if (!value)
    throw InputError(option + " " + word + format(": expected an integer in %d..%d", low, high));
  return *value;
}

BodyReader::BodyReader(BodyOptions& options, const std::vector<std::string>& words,
                       std::span<const ShapeEntry> shapes, const char* program)
    : options_(options), words_(words), program_(program) {
  if (words.empty())
    throw InputError("no body given: expected a shape or a file; see " + program_ + " --help");
  options.body = underscored(words[0]);
  const auto shape = std::find_if(shapes.begin(), shapes.end(),
                                  [&](const ShapeEntry& s) { return s.name == options.body; });
  options.is_file = shape == shapes.end();
  if (!options.is_file)
    shape_ = &*shape;
  else
    options.body = words[0];
  if (options.is_file && options.body.find('.') == std::string::npos)
    throw InputError("unknown shape " + options.body + "; see " + program_ + " --help");
  if (options.body == "board")
    options.default_material = "spruce";
  for (std::size_t i = 1; i + 1 < words.size(); ++i)
    if (words[i] == "--unit") {
      options.unit = unit_of(words[i + 1]);
      options.unit_given = true;
    }
}

bool BodyReader::next() {
  option_ = ++at_;
  return option_ < words_.size();
}

const std::string& BodyReader::value() {
  if (at_ + 1 >= words_.size())
    throw InputError(option() + " needs a value");
  return words_[++at_];
}

double BodyReader::number(double low, double high) {
  return fem::number(option(), value(), low, high);
}

int BodyReader::integer(int low, int high) { return fem::integer(option(), value(), low, high); }

/// The path that an option for a file sets; null for other options.
std::string* BodyReader::output_path() {
  const std::string& name = option();
  if (name == "-o" || name == "--output")
    return &options_.output;
  if (name == "--vtu")
    return &options_.vtu;
  if (name == "--sheet")
    return &options_.sheet;
  return name == "--export-inp" ? &options_.inp : nullptr;
}

// Not split, because it is a table of the options.
void BodyReader::take() {
  const std::string& name = option();
  if (std::string* const path = output_path()) {
    *path = value();
  } else if (name == "--unit") {
    value();
  } else if (name == "--material") {
    const auto& word = value();
    const auto equals = word.find('=');
    if (equals == std::string::npos)
      options_.materials.emplace_back("", word);
    else
      options_.materials.emplace_back(word.substr(0, equals), word.substr(equals + 1));
  } else if (name == "--young") {
    options_.changes["young"] = number(1, 1e13);
  } else if (name == "--poisson") {
    options_.changes["poisson"] = number(-.999, .4999);
  } else if (name == "--density") {
    options_.changes["density"] = number(1e-3, 1e5);
  } else if (name == "--loss") {
    options_.changes["loss"] = number(1e-9, 2);
  } else if (name == "--axes") {
    for (const std::string& cell : split(value(), ','))
      options_.axes.push_back(fem::number(name, cell, -1e9, 1e9));
    if (options_.axes.size() != 6)
      throw InputError("--axes: expected six numbers X1,Y1,Z1,X2,Y2,Z2");
  } else if (name == "--h") {
    options_.choice.h = length(1e-9, 1e9);
  } else if (name == "--layers") {
    options_.choice.layers = integer(1, 200);
  } else if (name == "--grade-concave") {
    options_.choice.grade_concave = true;
  } else if (name == "--no-grade") {
    options_.choice.grade_concave = false;
  } else if (name == "--profile") {
    options_.profile = value();
  } else if (name == "--memory") {
    options_.memory_bytes = read_memory(name, value());
  } else if (name == "--threads") {
    options_.threads = integer(1, 256);
  } else if (name == "--time-limit") {
    options_.time_limit_s = number(1, 1e7);
  } else if (name == "--fillet" && options_.is_file) {
    options_.fillet = length(1e-9, 1e9);
  } else if (name == "--multi") {
    options_.several_parts = true;
  } else if (name == "--only" && options_.is_file) {
    options_.part = value();
  } else if (name == "--remesh") {
    options_.remesh = true;
  } else if (name == "--shrink-wrap" && options_.is_file) {
    const bool given = at_ + 1 < words_.size() && to_number(words_[at_ + 1]);
    options_.shrink_wrap = given ? length(1e-9, 1e9) : -1;
  } else if (name == "--straight") {
    options_.straight = true;
  } else if (name == "--quiet") {
    options_.quiet = true;
  } else {
    take_dimension();
  }
  if (!options_.part.empty() && options_.several_parts)
    throw InputError("--only selects one part and --multi all: expected one of the two");
}

void BodyReader::take_dimension() {
  const std::string key = underscored(option().size() > 2 ? option().substr(2) : option());
  const Dimension* dimension = nullptr;
  if (shape_)
    for (const Dimension& d : shape_->dimensions)
      if (key == d.name)
        dimension = &d;
  if (!dimension)
    throw InputError("unknown option " + option() +
                     (options_.is_file ? "" : " of " + options_.body) + "; see " + program_ +
                     " --help");
  options_.dimensions[key] = (dimension->is_length ? options_.unit : 1) * number(0, 1e9);
}

std::string usage_of_shapes(std::span<const ShapeEntry> shapes) {
  std::string text;
  for (const ShapeEntry& s : shapes) {
    text += format("  %-14s", s.name) + s.description + "\n";
    for (const Dimension& d : s.dimensions) {
      std::string option = d.name;
      std::replace(option.begin(), option.end(), '_', '-');
      text += "                  --" + option +
              (*d.description ? std::string("  ") + d.description : "") + "\n";
    }
  }
  return text + R"(
Lengths are in millimetres, or in --unit um|mm|cm|m|in, in options and in files. A .step file
states its own unit; .msh and .inp files are in metres unless --unit is given.

)";
}

std::string usage_of_material() {
  return R"(Material      --material NAME, or REGION=NAME for a body of several; data/materials.csv lists them
              --young PA --poisson NU --density KG_PER_M3 --loss ETA   change the constants of the (first) material
              --axes X1,Y1,Z1,X2,Y2,Z2   directions 1 (grain) and 2 of an orthotropic material
)";
}

std::string usage_of_mesh() {
  return R"(Mesh          --h SIZE  --layers N  --no-grade  --multi  (allows several parts)
              --only NAME|NUMBER  selects one of a file's separate parts
              --fillet RADIUS  rounds the concave edges of a .step or .brep body
              --remesh  (new triangles for an STL surface)  --straight  (no curved edges)
              --shrink-wrap [SIZE]  a closed skin over a scan or broken surface; gaps
                                    narrower than SIZE (1/25 of the body, or more if
                                    its holes need it) are closed
              --time-limit SECONDS (1200)  time without progress after which reading and
                                       meshing a file stop
)";
}

std::vector<Material> materials_of(const BodyOptions& options, const Mesh& mesh) {
  std::vector<Material> materials;
  const auto chosen = chosen_materials(options, mesh);
  const auto without = std::find(chosen.begin(), chosen.end(), std::nullopt);
  if (without != chosen.end() &&
      std::any_of(chosen.begin(), chosen.end(), [](auto& m) { return m.has_value(); })) {
    const std::string& region = mesh.regions[static_cast<std::size_t>(without - chosen.begin())];
    throw InputError("region " + region + " has no material, although others have one: expected " +
                     "--material " + region + "=NAME, or --material NAME for all");
  }
  for (const auto& material : chosen)
    materials.push_back(material ? *material : find_material(options.default_material));
  for (const auto& [what, value] : options.changes)
    if (!materials[0].isotropic() && (what == "young" || what == "poisson"))
      throw InputError("--" + what + " changes an isotropic material, " + materials[0].name +
                       " is orthotropic");
  apply_changes(options, materials[0]);
  if (!options.axes.empty() &&
      std::all_of(materials.begin(), materials.end(), [](auto& m) { return m.isotropic(); }))
    throw InputError("--axes applies to an orthotropic material, the body has " +
                     names_of_materials(materials));
  if (!options.axes.empty())
    for (Material& m : materials) {
      m.axis_1 = {options.axes[0], options.axes[1], options.axes[2]};
      m.axis_2 = {options.axes[3], options.axes[4], options.axes[5]};
    }
  return materials;
}

std::string names_of_materials(std::span<const Material> materials) {
  std::vector<std::string> names;
  for (const Material& m : materials)
    if (std::find(names.begin(), names.end(), m.name) == names.end())
      names.push_back(m.name);
  std::string text;
  for (const std::string& name : names)
    text += (text.empty() ? "" : ", ") + name;
  return text;
}

void warn_of_unusual_constants(const BodyOptions& options, ProgressLine& progress) {
  BodyOptions without_changes = options;
  without_changes.changes.clear();
  const Material base = first_material(without_changes);
  const auto warn = [&](const char* what, double usual, const char* unit) {
    const auto at = options.changes.find(what);
    if (at != options.changes.end() && std::abs(std::log10(at->second / usual)) > 1.7)
      progress.notify(format("warning: --%s %g: %s has %g; was it meant in %s?", what, at->second,
                             base.name.c_str(), usual, unit));
  };
  warn("young", base.young_pa[0], "Pa");
  warn("density", base.density, "kg/m^3");
}

std::string name_of_unit(double metres) {
  const auto* const at = std::find_if(kUnits.begin(), kUnits.end(),
                                      [&](const LengthUnit& u) { return u.metres == metres; });
  return at == kUnits.end() ? "" : std::string(at->name);
}

std::string format_length(double metres) {
  return metres < 1e-3 ? format("%.3g um", 1e6 * metres)
         : metres < 1  ? format("%.3g mm", 1e3 * metres)
                       : format("%.4g m", metres);
}

void warn_of_unusual_length(const BodyOptions& options, double largest,
                            const std::function<void(const std::string&)>& notify) {
  const std::string unit = name_of_unit(options.unit_of_body());
  if (largest > 20 || largest < 1e-4)
    notify("warning: the body is " + format_length(largest) + " long; are its lengths in " +
           (unit.empty() ? "the unit that the file states?" : unit + "? (--unit um|mm|cm|m|in)"));
}

Material first_material(const BodyOptions& options) {
  Material m = find_material(options.default_material);
  for (const auto& [region, name] : options.materials) {
    m = find_material(name);
    if (!region.empty())
      break;
  }
  apply_changes(options, m);
  return m;
}

LoadChoice load_choice(const BodyOptions& options, ProgressLine& progress) {
  LoadChoice load{.unit = options.unit_given ? options.unit : 0,
                  .h = options.choice.h,
                  .fillet = options.fillet,
                  .shrink_wrap = options.shrink_wrap,
                  .grade_concave = options.choice.grade_concave,
                  .curved = !options.straight,
                  .remesh = options.remesh,
                  .multi = options.several_parts,
                  .part = options.part};
  load.notify = [&progress](const std::string& sentence) { progress.notify(sentence); };
  load.report = [&progress](const std::string& stage, double share) {
    progress.stage(stage, share);
  };
  load.limits.progress_timeout_s = options.time_limit_s;
  return load;
}

void check_readable(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    throw InputError("cannot read " + path + ": no such file");
  if (!std::filesystem::is_regular_file(path, error))
    throw InputError("cannot read " + path + ": expected a regular file");
  if (!std::ifstream(path))
    throw InputError("cannot read " + path + ": permission denied");
}

void describe(const Mesh& mesh, ProgressLine& progress, const std::string& what) {
  const Vec3 size = bounding_box(mesh.nodes).size();
  progress.notify(
      format("%zu elements (%s), %zu nodes, %zu degrees of freedom; %.4g x %.4g x %.4g mm",
             mesh.elements.size(), mesh.element_names().c_str(), mesh.nodes.size(), mesh.dofs(),
             1e3 * size.x, 1e3 * size.y, 1e3 * size.z));
  for (const Element& e : mesh.elements)
    if (is_linear(e.shape)) {
      progress.notify("warning: linear elements (" + mesh.element_names() +
                      ") are too stiff and make " + what + "; use quadratic ones");
      break;
    }
}

} // namespace tactus::fem
