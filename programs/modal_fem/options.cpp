#include "programs/modal_fem/options.hpp"

#include "fem/io/text.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

/// Parses PLACE[:xyz] or, for springs, PLACE:STIFFNESS[:xyz].
FixedRegion read_fixed_region(const std::string& option, const std::string& words, double unit) {
  FixedRegion fixed_region;
  fixed_region.words = option.substr(2) + " " + words;
  auto parts = split(words, ':');
  if (parts.size() > 1 && parts[0] == "set") {
    fixed_region.set = parts[1];
    parts.erase(parts.begin());
  } else if (parts[0].size() > 2 && parts[0][1] == '=' && parts[0][0] >= 'x' &&
             parts[0][0] <= 'z') {
    fixed_region.plane = parts[0][0] - 'x';
    fixed_region.level = unit * number(option, parts[0].substr(2), -1e9, 1e9);
  } else {
    const auto cells = split(parts[0], ',');
    if (cells.size() != 4)
      throw InputError(option + " " + words + ": expected X,Y,Z,RADIUS, x=LEVEL or set:NAME");
    for (int k = 0; k < 3; ++k)
      fixed_region.centre[k] = unit * number(option, cells[static_cast<std::size_t>(k)], -1e9, 1e9);
    fixed_region.radius = unit * number(option, cells[3], 0, 1e9);
  }
  std::size_t next = 1;
  if (option == "--spring") {
    if (parts.size() < 2)
      throw InputError("--spring " + words + ": expected a stiffness in N/m after a colon");
    fixed_region.stiffness = number(option, parts[next++], 1e-6, 1e15);
  }
  if (parts.size() > next) {
    fixed_region.directions = {};
    for (const char c : parts[next]) {
      if (c < 'x' || c > 'z')
        throw InputError(option + " " + words + ": expected directions such as x, yz or xyz");
      fixed_region.directions[static_cast<std::size_t>(c - 'x')] = true;
    }
  }
  return fixed_region;
}

} // namespace

// Not split, because it is a table of the options.
ModalOptions read_options(const std::vector<std::string>& words) {
  ModalOptions options;
  BodyReader reader(options, words, known_shapes(), "modal_fem");
  while (reader.next()) {
    const std::string& option = reader.option();
    if (option == "--csv") {
      options.csv = reader.value();
    } else if (option == "--export-petsc") {
      options.petsc = reader.value();
    } else if (option == "--import-modes") {
      options.import_values = reader.value();
      options.import_vectors = reader.value();
    } else if (option == "--modes") {
      options.modes = static_cast<std::size_t>(reader.integer(1, 20000));
    } else if (option == "--fix" || option == "--spring") {
      options.fixed_regions.push_back(read_fixed_region(option, reader.value(), options.unit));
    } else if (option == "--engine") {
      const std::string& word = reader.value();
      if (word != "cholmod" && word != "slepc")
        throw InputError("--engine " + word + ": expected cholmod or slepc");
      options.slepc = word == "slepc";
    } else if (option == "--ranks") {
      options.ranks = reader.integer(1, 4096);
    } else if (option == "--radiation") {
      const std::string& word = reader.value();
      if (word != "body" && word != "none")
        throw InputError("--radiation " + word + ": expected body or none");
      options.radiation = word == "body";
    } else if (option == "--acoustic-triangles") {
      options.acoustic_triangles = static_cast<std::size_t>(reader.integer(20, 20000));
    } else if (option == "--ratios") {
      options.ratios.clear();
      for (const std::string& cell : split(reader.value(), ','))
        options.ratios.push_back(number(option, cell, .1, 10));
      if (options.ratios.size() > 33 ||
          !std::is_sorted(options.ratios.begin(), options.ratios.end()) ||
          std::adjacent_find(options.ratios.begin(), options.ratios.end()) != options.ratios.end())
        throw InputError("--ratios: expected up to 33 ascending numbers, such as 0.5,0.7,1,1.4,2");
      if (std::find(options.ratios.begin(), options.ratios.end(), 1.0) == options.ratios.end())
        throw InputError("--ratios: expected 1, the unchanged body, among them");
    } else if (option == "--air") {
      const auto cells = split(reader.value(), ',');
      if (cells.size() != 2)
        throw InputError("--air: expected DENSITY,SPEED in kg/m^3 and m/s");
      options.air_density = number(option, cells[0], 1e-3, 1e4);
      options.sound_speed = number(option, cells[1], 10, 1e4);
    } else if (option == "--tolerance") {
      options.tolerance = .01 * reader.number(0, 100);
      options.tolerance_given = true;
    } else if (option == "--residual") {
      options.residual = true;
    } else if (!options.design.take(reader)) {
      reader.take();
    }
  }
  if (options.ranks > 0 && !options.slepc)
    throw InputError(
        "--ranks sets the number of processes of --engine slepc: expected also --engine slepc");
  return options;
}

std::string usage() {
  std::string text =
      R"(modal_fem BODY [options]      compute the modes of a solid body, a table for modal_impact~

BODY is a file (.step .stp .brep .stl .obj .msh .inp) or a shape with its dimensions:
)";
  text += usage_of_shapes(known_shapes()) + usage_of_material();
  text +=
      R"(Supports      --fix PLACE[:xyz]          fix rigidly; PLACE is X,Y,Z,RADIUS or x=LEVEL or set:NAME
              --spring PLACE:N_PER_M[:xyz]
)" + usage_of_mesh();
  return text +
         R"(              --tolerance PERCENT (0.2)  refine the mesh until each mode's estimated error is
                               smaller; 0: keep the first mesh, as with --h and --layers
Modes         --modes N (40)  a last group of nearly equal frequencies is kept whole
              --threads N (1)
              --engine slepc --ranks N  (2)  factorise on N processes of mpirun
              --memory SIZE  memory limit, such as 800M or 4G (half of the free memory)
              --residual  static compliance of the skin beyond these modes, for contacts
Sound         --radiation body         outgoing waves of each mode (boundary elements) and their
                                       radiation damping
              --acoustic-triangles N (2000)  --air DENSITY,SPEED (1.184,346.1)
              --ratios R1,R2,...       waves also at these multiples of the frequencies, for a body
                                       whose E or rho will be changed
)" + usage_of_lattice() +
         R"(Output        -o NAME.modal.npz  --csv FILE  --vtu FILE  --sheet FILE.png
              --export-inp FILE  the same mesh and supports for CalculiX
              --export-petsc FILE  K and M in PETSc's binary form
              --import-modes VALUES VECTORS  read the modes of a SLEPc run instead of solving
              --quiet  show no progress
)";
}

} // namespace tactus::fem
