#include "programs/body/body_options.hpp"
#include "programs/body/output_files.hpp"
#include "programs/modal_fem/raw.hpp"

#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"
#include "fem/mesh/mesh.hpp"
#include "files/npz.hpp"
#include "files/tables.hpp"

#include <cstdio>
#include <numbers>

namespace tactus::fem {
namespace {

std::vector<double> numbers(const std::string& option, const std::string& words, std::size_t count,
                            double scale) {
  std::vector<double> out;
  for (const std::string& cell : split(words, ',')) {
    const auto value = to_number(cell);
    if (!value || std::abs(*value) > 1e15)
      throw InputError(option + " " + words + ": expected " + std::to_string(count) + " numbers");
    out.push_back(scale * *value);
  }
  if (out.size() != count)
    throw InputError(option + " " + words + ": expected " + std::to_string(count) + " numbers");
  return out;
}

double within(const std::string& option, const std::string& word, double low, double high) {
  const double value = numbers(option, word, 1, 1)[0];
  if (!(value >= low && value <= high))
    throw InputError(option + " " + word + ": expected a number in " + format("%g", low) + ".." +
                     format("%g", high));
  return value;
}

Vec3 direction(const std::string& word) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      const std::string name{static_cast<char>('x' + axis)};
      if (word == (sign > 0 ? "+" : "-") + name || (sign > 0 && word == name)) {
        Vec3 v{};
        v[axis] = sign;
        return v;
      }
    }
  throw InputError("--side " + word + ": expected +x, -x, +y, -y, +z or -z");
}

struct RawOptions {
  RawSettings settings;
  std::string input, output;
};

RawOptions read_raw_options(const std::vector<std::string>& words) {
  RawOptions options;
  auto& [settings, input, output] = options;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& option = words[i];
    const auto value = [&]() -> const std::string& {
      if (i + 1 >= words.size())
        throw InputError(option + " needs a value");
      return words[++i];
    };
    if (option == "-o" || option == "--output") {
      output = value();
    } else if (option == "--hit") {
      const auto p = numbers(option, value(), 3, 1e-3);
      settings.hit_m.push_back({p[0], p[1], p[2]});
    } else if (option == "--grid") {
      const std::string& word = value();
      if (word != "full" && word != "ring")
        throw InputError("--grid " + word + ": expected full or ring");
      settings.ring = word == "ring";
    } else if (option == "--ring-angle") {
      settings.ring_angle_rad = within(option, value(), -360, 360) * std::numbers::pi / 180;
    } else if (option == "--points") {
      const std::string& word = value();
      settings.points =
          word == "all" ? 0 : static_cast<std::size_t>(integer(option, word, 2, 1000000));
    } else if (option == "--side") {
      settings.side = direction(value());
    } else if (option == "--seconds") {
      settings.seconds = within(option, value(), 1e-4, 600);
    } else if (option == "--rate") {
      settings.sample_rate = within(option, value(), 1000, 1e6);
    } else if (option == "--impulse") {
      settings.impulse_n_s = within(option, value(), 1e-12, 1e6);
    } else if (option == "--striker") {
      const auto p = numbers(option, value(), 4, 1);
      if (!(p[0] > 0 && p[1] > 0 && p[2] > 0 && p[3] > -1 && p[3] < .5))
        throw InputError("--striker: expected KG,RADIUS_MM,E_PA above 0 and NU between -1 and 0.5");
      settings.striker.mass_kg = p[0];
      settings.striker.radius_m = 1e-3 * p[1];
      settings.striker.youngs_modulus_pa = p[2];
      settings.striker.poisson = p[3];
    } else if (input.empty() && option.substr(0, 1) != "-") {
      input = option;
    } else {
      throw InputError("unknown option " + option + " of raw; see modal_fem --help");
    }
  }
  if (input.empty() || output.empty())
    throw InputError("raw needs a table and -o NAME.modal.npz");
  check_output("-o", output);
  if (settings.ring && settings.points == 0)
    throw InputError("--points all: expected a number for rings");
  return options;
}

/// The arrays of a table except those whose names begin with raw_, which are recomputed.
NpzWriter copy_without_raw(const std::string& input, std::span<const std::byte> bytes) {
  files::NpzFile archive;
  if (const std::string refusal = archive.open(bytes); !refusal.empty())
    throw InputError(input + ": " + refusal);
  NpzWriter npz;
  for (const files::NpzArray& a : archive.arrays()) {
    if (a.name.starts_with("raw_"))
      continue; // recomputed
    if (a.big_endian || a.fortran_order)
      throw InputError(input + ": array " + a.name +
                       " is big-endian or in Fortran order: save it little-endian in C order");
    const std::string kind =
        (a.item_bytes == 1 ? "|" : "<") + std::string(1, a.kind) + std::to_string(a.item_bytes);
    npz.add_bytes(a.name, kind.c_str(), a.bytes, a.shape);
  }
  return npz;
}

} // namespace

int run_raw(const std::vector<std::string>& words) {
  const auto [settings, input, output] = read_raw_options(words);
  const std::string text = read_bytes(input);
  const auto bytes = std::as_bytes(std::span(text));
  modal::ModalTable table;
  if (const std::string refusal = files::read_modal_table(bytes, table); !refusal.empty())
    throw InputError(input + ": " + refusal);
  const modal::RawTable raw = make_raw(table, settings);

  NpzWriter npz = copy_without_raw(input, bytes);
  const auto flat = [](const std::vector<Vec3>& hit_positions) {
    std::vector<float> out;
    for (const Vec3& p : hit_positions)
      for (int i = 0; i < 3; ++i)
        out.push_back(static_cast<float>(p[i]));
    return out;
  };
  npz.add("raw_v", raw.velocity_m_per_s, {raw.hits, raw.points, raw.samples});
  npz.add("raw_xyz", flat(raw.position_m), {raw.points, 3});
  npz.add("raw_ds", raw.area_m2, {raw.points});
  npz.add("raw_hit", flat(raw.hit_m), {raw.hits, 3});
  npz.add("raw_fs", std::span(&raw.sample_rate_hz, 1), {});
  write_npz(output, npz);
  std::printf("%zu strike positions, %zu points, %zu samples at %g Hz: %.1f MB\n", raw.hits,
              raw.points, raw.samples, raw.sample_rate_hz,
              4e-6 * static_cast<double>(raw.velocity_m_per_s.size()));
  return 0;
}

std::string raw_usage() {
  return R"(
modal_fem raw TABLE.modal.npz --hit X,Y,Z ... -o OUT.modal.npz
              add the surface velocities after impacts (AudioHaptics' tables) to a table
              --hit X,Y,Z  mm, once for each point   --side +z  the faces that radiate
              --grid full|ring  --ring-angle DEGREES  --points N|all (200)
              --seconds S (0.5)  --rate HZ (44100)
              --striker KG,RADIUS_MM,E_PA,NU at 1 m/s (a steel ball of 6 mm)  or  --impulse N_S
)";
}

} // namespace tactus::fem
