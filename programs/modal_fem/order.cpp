#include "programs/modal_fem/order.hpp"

#include "fem/io/words.hpp"
#include "programs/modal_fem/budget.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

double unit_of(const std::string& word) {
  static const std::map<std::string, double> units{
      {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}, {"in", 25.4e-3}, {"um", 1e-6}};
  const auto at = units.find(word);
  if (at == units.end())
    throw Refusal("--unit " + word + ": expected um, mm, cm, m or in");
  return at->second;
}

double number(const std::string& option, const std::string& word, double low, double high) {
  const auto value = to_number(word);
  if (!value || *value < low || *value > high)
    throw Refusal(option + " " + word + ": expected a number from " + format("%g", low) + " to " +
                  format("%g", high));
  return *value;
}

/// PLACE[:xyz] or, for springs, PLACE:STIFFNESS[:xyz]
Place read_place(const std::string& option, const std::string& words, double unit) {
  Place place;
  place.words = option.substr(2) + " " + words;
  auto parts = split(words, ':');
  if (parts.size() > 1 && parts[0] == "set") {
    place.set = parts[1];
    parts.erase(parts.begin());
  } else if (parts[0].size() > 2 && parts[0][1] == '=' && parts[0][0] >= 'x' &&
             parts[0][0] <= 'z') {
    place.plane = parts[0][0] - 'x';
    place.level = unit * number(option, parts[0].substr(2), -1e9, 1e9);
  } else {
    const auto cells = split(parts[0], ',');
    if (cells.size() != 4)
      throw Refusal(option + " " + words + ": expected X,Y,Z,RADIUS, x=LEVEL or set:NAME");
    for (int k = 0; k < 3; ++k)
      place.centre[k] = unit * number(option, cells[static_cast<std::size_t>(k)], -1e9, 1e9);
    place.radius = unit * number(option, cells[3], 0, 1e9);
  }
  std::size_t next = 1;
  if (option == "--spring") {
    if (parts.size() < 2)
      throw Refusal("--spring " + words + ": expected a stiffness in N/m after a colon");
    place.stiffness = number(option, parts[next++], 1e-6, 1e15);
  }
  if (parts.size() > next) {
    place.directions = {};
    for (const char c : parts[next]) {
      if (c < 'x' || c > 'z')
        throw Refusal(option + " " + words + ": expected directions out of x, y and z");
      place.directions[static_cast<std::size_t>(c - 'x')] = true;
    }
  }
  return place;
}

} // namespace

Order read_order(const std::vector<std::string>& words) {
  Order order;
  if (words.empty())
    throw Refusal("which body? a shape or a file; modal_fem --help lists them");
  order.body = words[0];
  std::replace(order.body.begin(), order.body.end(), '-', '_');
  const auto& shapes = known_shapes();
  const auto shape = std::find_if(shapes.begin(), shapes.end(),
                                  [&](const ShapeEntry& s) { return s.name == order.body; });
  order.is_file = shape == shapes.end();
  if (order.is_file) {
    order.body = words[0];
    if (order.body.find('.') == std::string::npos)
      throw Refusal("no shape is called " + order.body + "; modal_fem --help lists them");
  }
  for (std::size_t i = 1; i + 1 < words.size(); ++i) // lengths depend on it, wherever it stands
    if (words[i] == "--unit") {
      order.unit = unit_of(words[i + 1]);
      order.unit_given = true;
    }
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& option = words[i];
    const auto value = [&]() -> const std::string& {
      if (i + 1 >= words.size())
        throw Refusal(option + " needs a value");
      return words[++i];
    };
    if (option == "--unit") {
      value();
    } else if (option == "-o" || option == "--output") {
      order.output = value();
    } else if (option == "--csv") {
      order.csv = value();
    } else if (option == "--vtu") {
      order.vtu = value();
    } else if (option == "--sheet") {
      order.sheet = value();
    } else if (option == "--export-inp") {
      order.inp = value();
    } else if (option == "--export-petsc") {
      order.petsc = value();
    } else if (option == "--import-modes") {
      order.import_values = value();
      order.import_vectors = value();
    } else if (option == "--material") {
      const auto& word = value();
      const auto equals = word.find('=');
      if (equals == std::string::npos)
        order.materials.emplace_back("", word);
      else
        order.materials.emplace_back(word.substr(0, equals), word.substr(equals + 1));
    } else if (option == "--young") {
      order.changes["young"] = number(option, value(), 1, 1e13);
    } else if (option == "--poisson") {
      order.changes["poisson"] = number(option, value(), -.999, .4999);
    } else if (option == "--density") {
      order.changes["density"] = number(option, value(), 1e-3, 1e5);
    } else if (option == "--loss") {
      order.changes["loss"] = number(option, value(), 1e-9, 2);
    } else if (option == "--axes") {
      for (const std::string& cell : split(value(), ','))
        order.axes.push_back(number(option, cell, -1e9, 1e9));
      if (order.axes.size() != 6)
        throw Refusal("--axes: expected six numbers X1,Y1,Z1,X2,Y2,Z2");
    } else if (option == "--modes") {
      order.modes = static_cast<std::size_t>(number(option, value(), 1, 20000));
    } else if (option == "--h") {
      order.choice.h = order.unit * number(option, value(), 1e-9, 1e9);
    } else if (option == "--layers") {
      order.choice.layers = static_cast<int>(number(option, value(), 1, 200));
    } else if (option == "--grade-concave") {
      order.choice.grade_concave = true;
    } else if (option == "--no-grade") {
      order.choice.grade_concave = false;
    } else if (option == "--fix" || option == "--spring") {
      order.places.push_back(read_place(option, value(), order.unit));
    } else if (option == "--profile") {
      order.profile = value();
    } else if (option == "--engine") {
      if (const std::string& word = value(); word != "cholmod" && word != "slepc")
        throw Refusal("--engine " + word + ": expected cholmod or slepc");
      order.slepc = words[i] == "slepc";
    } else if (option == "--ranks") {
      order.ranks = static_cast<int>(number(option, value(), 1, 4096));
    } else if (option == "--memory") {
      order.memory_bytes = read_memory(option, value());
    } else if (option == "--threads") {
      order.threads = static_cast<int>(number(option, value(), 1, 256));
    } else if (option == "--time-limit") {
      order.time_limit_s = number(option, value(), 1, 1e7);
    } else if (option == "--radiation") {
      if (const std::string& word = value(); word != "body" && word != "none")
        throw Refusal("--radiation " + word + ": expected body or none");
      order.radiation = words[i] == "body";
    } else if (option == "--acoustic-triangles") {
      order.acoustic_triangles = static_cast<std::size_t>(number(option, value(), 20, 20000));
    } else if (option == "--ratios") {
      order.ratios.clear();
      for (const std::string& cell : split(value(), ','))
        order.ratios.push_back(number(option, cell, .1, 10));
      if (order.ratios.size() > 33 || !std::is_sorted(order.ratios.begin(), order.ratios.end()) ||
          std::adjacent_find(order.ratios.begin(), order.ratios.end()) != order.ratios.end())
        throw Refusal("--ratios: expected up to 33 ascending numbers, such as 0.5,0.7,1,1.4,2");
      if (std::find(order.ratios.begin(), order.ratios.end(), 1.0) == order.ratios.end())
        throw Refusal("--ratios: expected 1, the body as it is, among them");
    } else if (option == "--air") {
      const auto cells = split(value(), ',');
      if (cells.size() != 2)
        throw Refusal("--air: expected DENSITY,SPEED in kg/m^3 and m/s");
      order.air_density = number(option, cells[0], 1e-3, 1e4);
      order.sound_speed = number(option, cells[1], 10, 1e4);
    } else if (option == "--tolerance") {
      order.tolerance = .01 * number(option, value(), 0, 100);
      order.tolerance_given = true;
    } else if (option == "--fillet" && order.is_file) {
      order.fillet = order.unit * number(option, value(), 1e-9, 1e9);
    } else if (option == "--residual") {
      order.residual = true;
    } else if (option == "--multi") {
      order.several_parts = true;
    } else if (option == "--only" && order.is_file) {
      order.part = value();
    } else if (option == "--remesh") {
      order.remesh = true;
    } else if (option == "--shrink-wrap" && order.is_file) {
      const bool given = i + 1 < words.size() && to_number(words[i + 1]);
      order.shrink_wrap = given ? order.unit * number(option, value(), 1e-9, 1e9) : -1;
    } else if (option == "--straight") {
      order.straight = true;
    } else if (option == "--quiet") {
      order.quiet = true;
    } else if (!order.shape.take(option, value, order.unit)) {
      std::string key = option.size() > 2 ? option.substr(2) : option;
      std::replace(key.begin(), key.end(), '-', '_');
      const bool known =
          !order.is_file && std::any_of(shape->dimensions.begin(), shape->dimensions.end(),
                                        [&](const Dimension& d) { return key == d.name; });
      if (!known)
        throw Refusal("unknown option " + option + (order.is_file ? "" : " of " + order.body) +
                      "; modal_fem --help lists them");
      const auto d = std::find_if(shape->dimensions.begin(), shape->dimensions.end(),
                                  [&](const Dimension& x) { return key == x.name; });
      order.dimensions[key] = (d->is_length ? order.unit : 1) * number(option, value(), 0, 1e9);
    }
  }
  if (!order.part.empty() && order.several_parts)
    throw Refusal("--only takes one part, --multi all: expected one of them");
  if (order.ranks > 0 && !order.slepc)
    throw Refusal("--ranks is the number of processes of --engine slepc, which is not chosen");
  return order;
}

std::string usage() {
  std::string text =
      R"(modal_fem BODY [options]      the modes of a solid body, as a table that modal_impact~ plays

BODY is a file (.step .stp .brep .stl .obj .msh .inp) or a shape with its dimensions:
)";
  for (const ShapeEntry& s : known_shapes()) {
    text += format("  %-14s", s.name) + s.meaning + "\n";
    for (const Dimension& d : s.dimensions) {
      std::string option = d.name;
      std::replace(option.begin(), option.end(), '_', '-');
      text += "                  --" + option + (*d.meaning ? std::string("  ") + d.meaning : "") +
              "\n";
    }
  }
  return text + R"(
Lengths are in millimetres, or in --unit um|mm|cm|m|in.

Material      --material NAME, or REGION=NAME for a body of several; data/materials.csv lists them
              --young PA --poisson NU --density KG_PER_M3 --loss ETA   change the (first) material
              --axes X1,Y1,Z1,X2,Y2,Z2   directions 1 (grain) and 2 of an orthotropic material
Supports      --fix PLACE[:xyz]          hold rigidly; PLACE is X,Y,Z,RADIUS or x=LEVEL or set:NAME
              --spring PLACE:N_PER_M[:xyz]
Mesh          --h SIZE  --layers N  --no-grade  --multi  (several parts)
              --only NAME|NUMBER  one of a file's separate parts
              --fillet RADIUS  rounds the concave edges of a .step or .brep body
              --remesh (renew an STL's triangles)  --straight  (no curved sides)
              --shrink-wrap [SIZE]  a closed skin over a scan or broken surface; gaps
                                    narrower than SIZE (1/25 of the body) are closed
              --time-limit SECONDS (1200)  stop reading and meshing a file after so long
                                       without progress
              --tolerance PERCENT (0.2)  the mesh is refined until each mode's estimated error is
                               below; 0: the first mesh stays, as with --h and --layers
Modes         --modes N (40)  --threads N (1)
              --engine slepc --ranks N  (2)  the factor on N processes of mpirun
              --memory SIZE  refuse work that takes more, such as 800M or 4G (half of what is free)
              --residual  also how far the skin yields beyond these modes, for contacts
Sound         --radiation body         outgoing waves of each mode (boundary elements) and the
                                       damping that sound takes from it
              --acoustic-triangles N (2000)  --air DENSITY,SPEED (1.184,346.1)
              --ratios R1,R2,...       also at these multiples of the frequencies, for a body
                                       whose E or rho will be changed
Shape         --lattice NX NY NZ (3 3 3)  also how the frequencies follow a lattice of control points
              --box X1,Y1,Z1,X2,Y2,Z2 (the body's)  what it spans
              --degree DX DY DZ (3, or one less than the points)
              --controls ID,ID,...  control points that may move (all that keep the body whole)
              --directions xyz      in which they may
              --range LENGTH (half a spacing)  bounds of each coordinate
              --trust LENGTH (a tenth of the box)  moves for which the derivatives serve
Output        -o NAME.modal.npz  --csv FILE  --vtu FILE  --sheet FILE.png
              --export-inp FILE  the same mesh and supports for CalculiX
              --export-petsc FILE  K and M in PETSc's binary form
              --import-modes VALUES VECTORS  take modes from a SLEPc run instead of solving
              --quiet  no progress
)";
}

} // namespace tactus::fem
