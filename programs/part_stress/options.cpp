#include "programs/part_stress/options.hpp"

#include "fem/io/text.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

/// The shapes of modal_fem and the lift arm, whose dimensions all have defaults (mm).
const std::vector<ShapeEntry>& shapes_of_parts() {
  static const std::vector<ShapeEntry> shapes = [] {
    static const LiftArm arm;
    const auto mm = [](double metres) { return 1e3 * metres; };
    std::vector<ShapeEntry> all{
        {"lift_arm",
         "a tractor's lift arm: a curved plate with three bosses (docs/part_stress.md)",
         {{"length", mm(arm.length), "distance from the hub to the rod eye (380)"},
          {"rise", mm(arm.rise), "rise of the centreline (55)"},
          {"depth", mm(arm.depth), "depth of the plate at mid-length (108)"},
          {"thickness", mm(arm.thickness), "thickness of the plate (22)"},
          {"hub_bore", mm(arm.hub.bore), "(60)"},
          {"hub_diameter", mm(arm.hub.diameter), "(96)"},
          {"hub_width", mm(arm.hub.width), "(62)"},
          {"lift_bore", mm(arm.lift_eye.bore), "bore of the cylinder's eye (30)"},
          {"lift_diameter", mm(arm.lift_eye.diameter), "(56)"},
          {"lift_width", mm(arm.lift_eye.width), "(54)"},
          {"lift_position", arm.lift_position,
           "position of that eye along the centreline, between 0 and 1 (0.46)", false},
          {"rod_bore", mm(arm.rod_eye.bore), "bore of the lift rod's eye (26)"},
          {"rod_diameter", mm(arm.rod_eye.diameter), "(50)"},
          {"rod_width", mm(arm.rod_eye.width), "(50)"},
          {"shoulder", mm(arm.shoulder), "rim of the plate around hub and rod eye (16)"},
          {"boss_fillet", mm(arm.fillet), "(8)"},
          {"slot_width", mm(arm.slot_width), "width of the lightening holes; 0: none (28)"},
          {"web", mm(arm.web), "distance between a boss and a lightening hole (14)"},
          {"edge_radius", mm(arm.edge_radius), "radius that rounds the plate's outline (0)"}}}};
    const auto& swept = known_shapes();
    all.insert(all.end(), swept.begin(), swept.end());
    return all;
  }();
  return shapes;
}

void expect_end(const std::string& option, const std::vector<std::string>& parts, std::size_t count,
                const char* expected) {
  if (parts.size() != count)
    throw InputError(option + ": expected " + expected + " after WHERE, got " +
                     std::to_string(parts.size()) + " parts between colons");
}

SupportOptions read_support(const std::string& option, const std::string& words, double unit) {
  SupportOptions support{option.substr(2) + " " + words, {}};
  auto parts = split(words, ':');
  support.at_region = read_region(option, parts, unit);
  if (option == "--fix") {
    if (!parts.empty()) {
      support.directions = read_directions(option, parts[0]);
      parts.erase(parts.begin());
    }
    expect_end(option, parts, 0, "nothing or directions such as xy");
    return support;
  }
  expect_end(option, parts, 1, "a stiffness N/m or three of them KX,KY,KZ");
  const bool one = parts[0].find(',') == std::string::npos;
  const auto k = read_numbers(option, parts[0], one ? 1 : 3, 1);
  support.stiffness_n_per_m = one ? Vec3{k[0], k[0], k[0]} : Vec3{k[0], k[1], k[2]};
  for (const double stiffness : k)
    if (!(stiffness >= 0))
      throw InputError(option + " " + words + ": expected stiffnesses of 0 N/m or more");
  if (!(length(support.stiffness_n_per_m) > 0))
    throw InputError(option + " " + words + ": expected a stiffness above 0 N/m");
  return support;
}

LoadOptions read_load(const std::string& option, const std::string& words, double unit) {
  using Kind = LoadOptions::Kind;
  LoadOptions load{option == "--traction"   ? Kind::traction
                   : option == "--pressure" ? Kind::pressure
                   : option == "--bolt"     ? Kind::bolt
                   : option == "--point"    ? Kind::point
                                            : Kind::force,
                   option.substr(2) + " " + words,
                   {},
                   {},
                   {}};
  auto parts = split(words, ':');
  if (load.kind == Kind::point) {
    if (parts.size() != 2)
      throw InputError(option + " " + printable(words, 60) + ": expected X,Y,Z:FX,FY,FZ");
    load.point = read_vector(option, parts[0], unit);
    parts.erase(parts.begin());
  } else {
    load.at_region = read_region(option, parts, unit);
  }
  if (load.kind == Kind::pressure) {
    expect_end(option, parts, 1, "a pressure in Pa");
    load.value.x = read_numbers(option, parts[0], 1, 1)[0];
  } else {
    expect_end(option, parts, 1, load.kind == Kind::traction ? "TX,TY,TZ in Pa" : "FX,FY,FZ in N");
    load.value = read_vector(option, parts[0]);
  }
  return load;
}

/// Default supports and loads of the lift arm: the arm is splined to its shaft, the lift rod pulls
/// down, and the cylinder pushes up.
void add_default_loads(PartOptions& options) {
  options.supports.push_back(read_support("--fix", "set:hub", 1));
  options.loads.push_back(read_load("--bolt", "set:rod_eye:0,-12000,0", 1));
  options.loads.push_back(read_load("--bolt", "set:lift_eye:-1000,6000,0", 1));
}

void check_complete(const PartOptions& options) {
  if (options.list_faces || (!options.step.empty() && options.outputs().size() == 1))
    return;
  if (options.is_file)
    check_readable(options.body);
  if (options.supports.empty())
    throw InputError(options.body + ": no supports: expected --fix or --spring");
  if (options.loads.empty() && options.gravity == Vec3{})
    throw InputError(options.body + ": no loads: expected --force, --bolt, --pressure, --traction, "
                                    "--point or --gravity");
}

} // namespace

LiftArm PartOptions::lift_arm() const {
  LiftArm arm;
  const auto take = [&](const char* name, double& value) {
    if (const auto at = dimensions.find(name); at != dimensions.end())
      value = at->second;
  };
  take("length", arm.length);
  take("rise", arm.rise);
  take("depth", arm.depth);
  take("thickness", arm.thickness);
  const auto boss = [&](const std::string& name, LiftArm::Boss& b) {
    take((name + "_bore").c_str(), b.bore);
    take((name + "_diameter").c_str(), b.diameter);
    take((name + "_width").c_str(), b.width);
  };
  boss("hub", arm.hub);
  boss("lift", arm.lift_eye);
  boss("rod", arm.rod_eye);
  take("lift_position", arm.lift_position);
  take("shoulder", arm.shoulder);
  take("boss_fillet", arm.fillet);
  take("slot_width", arm.slot_width);
  take("web", arm.web);
  take("edge_radius", arm.edge_radius);
  check(arm);
  return arm;
}

bool PartOptions::needs_faces() const {
  const auto is_face = [](const Region& at_region) {
    const auto* set = std::get_if<InNodeSet>(&at_region.selection.region);
    return set && at_region.words.starts_with("face:");
  };
  return list_faces ||
         std::any_of(supports.begin(), supports.end(),
                     [&](const SupportOptions& s) { return is_face(s.at_region); }) ||
         std::any_of(loads.begin(), loads.end(),
                     [&](const LoadOptions& l) { return is_face(l.at_region); });
}

std::vector<Output> PartOptions::outputs() const {
  std::vector<Output> all{{"-o", output, 0},
                          {"--vtu", vtu, 0},
                          {"--sheet", sheet, 1e6},
                          {"--export-inp", inp, 0},
                          {"--step", step, 0}};
  std::erase_if(all, [](const Output& o) { return o.path.empty(); });
  return all;
}

// Not split, because it is a table of the options.
PartOptions read_options(const std::vector<std::string>& words) {
  PartOptions options;
  options.default_material = "steel";
  BodyReader reader(options, words, shapes_of_parts(), "part_stress");
  while (reader.next()) {
    const std::string& option = reader.option();
    if (option == "--step") {
      options.step = reader.value();
    } else if (option == "--engine") {
      const std::string& word = reader.value();
      if (word != "cholmod" && word != "petsc")
        throw InputError("--engine " + printable(word, 20) + ": expected cholmod or petsc");
      options.petsc = word == "petsc";
    } else if (option == "--ranks") {
      options.ranks = reader.integer(1, 4096);
    } else if (option == "--list-faces") {
      options.list_faces = true;
    } else if (option == "--fix" || option == "--spring") {
      options.supports.push_back(read_support(option, reader.value(), options.unit));
    } else if (option == "--load" || option == "--force" || option == "--traction" ||
               option == "--pressure" || option == "--bolt" || option == "--point") {
      options.loads.push_back(read_load(option, reader.value(), options.unit));
    } else if (option == "--gravity") {
      options.gravity = read_vector(option, reader.value());
    } else if (option == "--skin") {
      options.skin_edge = reader.length(1e-9, 1e9);
    } else if (option == "--move") {
      Move move;
      const std::string& id = reader.value();
      const auto control = to_number<int>(id);
      if (!control || *control < 0)
        throw InputError("--move " + printable(id, 20) +
                         ": expected ID DX DY DZ, the number of a control point first");
      move.control = *control;
      for (int axis = 0; axis < 3; ++axis)
        move.displacement[axis] = reader.length(-1e9, 1e9);
      options.moves.push_back(move);
    } else if (!options.design.take(reader)) {
      reader.take();
    }
  }
  if (options.ranks > 0 && !options.petsc)
    throw InputError(
        "--ranks sets the number of processes of --engine petsc: expected also --engine petsc");
  if (options.petsc && !options.output.empty())
    throw InputError(
        "-o: the table needs derivatives with respect to every parameter, which --engine petsc "
        "does not compute: expected --vtu, --sheet or --export-inp");
  if (options.ranks == 0)
    options.ranks = 2;
  if (!options.step.empty() && !options.is_lift_arm())
    throw InputError("--step writes the shape lift_arm, not " + options.body);
  if (options.list_faces && !options.is_file && !options.is_lift_arm())
    throw InputError("--list-faces lists the faces of a CAD file, not of " + options.body);
  if (options.is_lift_arm()) {
    (void)options.lift_arm(); // refuses wrong dimensions before any work
    if (options.supports.empty() && options.loads.empty() && options.gravity == Vec3{})
      add_default_loads(options);
  }
  check_complete(options);
  return options;
}

std::string usage() {
  return R"(part_stress BODY [options]      compute the stress of a loaded part and its shape derivatives
part_stress serve FILE.stress.npz [--tolerance T]   solve the part of a file again, by requests on
                                    stdin (docs/part_stress.md)

BODY is a file (.step .stp .brep .stl .obj .msh .inp) or a shape with its dimensions:
)" + usage_of_shapes(shapes_of_parts()) +
         usage_of_material() + R"(Supports      --fix WHERE[:xyz]             fix rigidly
              --spring WHERE:KX,KY,KZ       elastic support, N/m of the whole patch
Loads         --force WHERE:FX,FY,FZ        total force, spread evenly, N (--load is the same)
              --bolt WHERE:FX,FY,FZ         force of a pin on the wall of its hole, N
              --pressure WHERE:PA           pressure, Pa; positive into the body
              --traction WHERE:TX,TY,TZ     force per area, Pa
              --point X,Y,Z:FX,FY,FZ        force on the nearest node of the skin, N
              --gravity GX,GY,GZ            acceleration, m/s^2
)" + usage_of_regions() +
         usage_of_mesh() +
         R"(              --list-faces  list the faces of a CAD file with numbers and positions
)" + usage_of_lattice() +
         R"(              --move ID DX DY DZ    move control point ID and solve again; may be repeated
Work          --threads N (1)  --memory SIZE  memory limit, such as 800M or 4G
              --engine petsc --ranks N  (2)  solve on N processes of mpirun, without derivatives
Output        -o NAME.stress.npz  --skin LENGTH (the mesh's)  edge length of the skin to draw
              --sheet FILE.png  --vtu FILE
              --export-inp FILE  mesh, supports and nodal loads for CalculiX
              --step FILE        the shape lift_arm as a CAD file
              --quiet  show no progress

By default, lift_arm is fixed at its hub, pulled at the rod eye and pushed at the lift eye.
)";
}

} // namespace tactus::fem
