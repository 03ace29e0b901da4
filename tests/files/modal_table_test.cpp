// Modal tables as files: every array in its place, what a table may say, and every damage a
// sentence.
#include "files/tables.hpp"
#include "tests/approx.hpp"
#include "tests/files/modal_members.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <cstdint>
#include <ctime>
#include <limits>
#include <string>
#include <utility>
#include <vector>

using namespace tactus;
using namespace tactus::modal;
using namespace tactus::test;
using files::read_modal_table;

namespace {

using Doubles = std::vector<double>;
using Floats = std::vector<float>;
using Integers = std::vector<std::int32_t>;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();

std::string refusal_of(const std::string& file) {
  ModalTable table;
  table.body_name = "as it was";
  const std::string refusal = read_modal_table(bytes_of(file), table);
  if (!refusal.empty())
    CHECK(table.body_name == "as it was");
  return refusal;
}

std::string refusal_with(const Change& change) {
  auto members = small_table();
  change(members);
  return refusal_of(archive(members));
}

ModalTable table_with(const Change& change) {
  auto members = small_table();
  change(members);
  ModalTable table;
  REQUIRE(read_modal_table(bytes_of(archive(members)), table) == "");
  return table;
}

Change description(const std::string& more) {
  return meta(R"({"format":"modal-table","version":"1.0")" + more + "}");
}

/// A sphere's multipoles and those in bands.
void add_multipoles(std::vector<Member>& members) {
  Floats band(40);
  for (std::size_t i = 0; i < band.size(); ++i)
    band[i] = static_cast<float>(i);
  for (const Change& add :
       {array("mp_lmax", Integers{1, 0}, {2}),
        array("mp_off", std::vector<std::int64_t>{0, 4, 5}, {3}),
        array("mp_center", Doubles{.1, .2, .3}, {3}), array("mp_rref", Doubles{.4}, {}),
        array("mp_band_freq", Doubles{100, 200, 400, 800}, {4}),
        array("mp_band_lmax", Integers{0, 1}, {2}),
        array("mp_band_off", std::vector<std::int64_t>{0, 1, 5}, {3})})
    add(members);
  members.push_back({"mp_coef", "<c8", {5}, raw(Floats{0, 1, 2, 3, 4, 5, 6, 7, 8, 9})});
  members.push_back({"mp_band_coef", "<c8", {20}, raw(band)});
}

} // namespace

TEST_CASE("every array of a table comes to its own place, with its units") {
  auto members = small_table();
  array("com", Doubles{.02, .025, .03})(members);
  array("inertia", Doubles{3e-4, 1e-5, 2e-5, 1e-5, 4e-4, 3e-5, 2e-5, 3e-5, 5e-4})(members);
  Floats velocity;
  for (int i = 0; i < 24; ++i)
    velocity.push_back(static_cast<float>(i));
  for (const Change& add :
       {array("raw_v", velocity, {2, 3, 4}),
        array("raw_xyz", Doubles{1, 2, 3, 4, 5, 6, 7, 8, 9}, {3, 3}),
        array("raw_hit", Doubles{10, 11, 12, 13, 14, 15}, {2, 3}),
        array("raw_ds", Doubles{.1, .2, .3}, {3}), array("raw_fs", Doubles{96000}, {}),
        array("weather", Doubles{1}, {})}) // which nobody knows
    add(members);
  add_multipoles(members);
  ModalTable table;
  REQUIRE(read_modal_table(bytes_of(archive(members)), table) == "");
  CHECK(table.modes() == 2);
  CHECK(table.vertices() == 4);
  CHECK(table.frequency_hz == Doubles{440, 1000});
  CHECK(table.shape_at(0, 1) == Vec3{0, 2, 0});
  CHECK(table.shape_at(1, 3) == Vec3{-1, 1, 0});
  CHECK(table.free);
  CHECK(table.mass_kg == 0.2);
  CHECK(table.body_name == "four corners");
  CHECK(table.material.youngs_modulus_pa == 7e10);
  CHECK(table.material.poisson == .3);
  CHECK(table.material.density_kg_per_m3 == 2700);
  CHECK(table.loss_factor == Doubles{1e-3, 2e-3});
  CHECK(table.centre_of_mass_m == Vec3{.02, .025, .03});
  CHECK(table.inertia_kg_m2[0] == Vec3{3e-4, 1e-5, 2e-5});
  CHECK(table.inertia_kg_m2[1] == Vec3{1e-5, 4e-4, 3e-5});
  CHECK(table.inertia_kg_m2[2] == Vec3{2e-5, 3e-5, 5e-4});
  CHECK(norm(table.vertex_m[2] - Vec3{0, .1, 0}) < 1e-8);
  REQUIRE(table.triangle.size() == 4);
  CHECK(table.triangle[3] == std::array<std::int32_t, 3>{1, 2, 3});
  const RawTable& r = table.raw;
  CHECK(r.hits == 2);
  CHECK(r.points == 3);
  CHECK(r.samples == 4);
  CHECK(r.sample_rate_hz == 96000);
  CHECK(r.velocity_m_per_s[23] == 23);
  CHECK(r.position_m[1] == Vec3{4, 5, 6});
  CHECK(r.hit_m[1] == Vec3{13, 14, 15});
  CHECK(r.area_m2 == Doubles{.1, .2, .3});
  const MultipoleTable& m = table.multipoles;
  CHECK(m.centre == Vec3{.1, .2, .3});
  CHECK(m.reference_radius_m == .4);
  CHECK(m.highest_degree == Integers{1, 0});
  CHECK(m.offset == std::vector<std::int64_t>{0, 4, 5});
  CHECK(m.coefficients[3] == std::complex<float>(6, 7));
  CHECK(m.band.frequency_hz == Doubles{100, 200, 400, 800});
  CHECK(m.band.highest_degree == Integers{0, 1});
  CHECK(m.band.offset == std::vector<std::int64_t>{0, 1, 5});
  CHECK(m.band.coefficients[19] == std::complex<float>(38, 39));
  // Without coefficients at several scales there is one, the mode's own frequency.
  CHECK(m.scales == Doubles{1});
}

TEST_CASE("arrays that may be left out or given instead of others") {
  const ModalTable decaying = table_with(array("alpha", Doubles{3, 4}, {2}));
  CHECK(decaying.decay_rate == Doubles{3, 4});
  CHECK(decaying.loss_factor.empty()); // a decay rate is the more exact of the two
  CHECK(table_with(array("alpha_rad", Doubles{3, 4}, {2})).radiation_decay_rate == Doubles{3, 4});
  CHECK(table_with(array("dlnf_dnu", Doubles{-3, 4}, {2})).poisson_slope == Doubles{-3, 4});
  CHECK(table_with(array("resid", Doubles{1e-9, -1e-9, 0, 2e-9}, {4})).residual_compliance ==
        Floats{1e-9F, 0, 0, 2e-9F});
  CHECK(table_with(without("eta")).loss_factor == Doubles{0, 0}); // nothing said: none
  const ModalTable alone = table_with([](auto& members) {
    std::erase_if(members, [](const Member& m) { return m.name != "meta" && m.name != "freq"; });
  });
  CHECK(alone.modes() == 2); // it rings with unit gain
  CHECK(alone.shape.empty());
}

TEST_CASE("big-endian numbers, columns first and other widths are converted") {
  const ModalTable table = table_with([](auto& members) {
    Member& freq = named(members, "freq");
    freq.type = ">f8";
    for (std::size_t i = 0; i < freq.data.size(); i += 8)
      std::reverse(freq.data.begin() + static_cast<std::ptrdiff_t>(i),
                   freq.data.begin() + static_cast<std::ptrdiff_t>(i + 8));
    named(members, "xyz").fortran = true;
    named(members, "xyz").data = raw(Floats{0, .1F, 0, 0, 0, 0, .1F, 0, 0, 0, 0, .1F});
    array("tri", std::vector<std::int64_t>{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})(members);
  });
  CHECK(table.frequency_hz[0] == 440);
  CHECK(table.vertex_m[2].y == approx(0.1));
  CHECK(table.vertex_m[3].z == approx(0.1));
  CHECK(table.triangle[1] == std::array<std::int32_t, 3>{0, 1, 3});
}

TEST_CASE("a table's description: what holds it, its material, the air") {
  for (const char* free : {"", R"(,"bc":"free")", R"(,"bc":"free-free")", R"(,"bc":null)",
                           R"(,"bc":[])", R"(,"bc":{})", R"(,"bc":"")"}) {
    CAPTURE(free);
    CHECK(table_with(description(free)).free);
  }
  for (const char* held : {R"(,"bc":"clamped")", R"(,"bc":["edge"])", R"(,"bc":{"nodes":3})",
                           R"(,"bc":1)", R"(,"bc":true)"}) {
    CAPTURE(held);
    CHECK(!table_with(description(held)).free);
  }
  CHECK(table_with(description(R"(,"bc":"clamped")")).boundary == "clamped");
  CHECK(table_with(description(R"(,"bc":["edge"])")).boundary == "held");
  const ModalTable steel = table_with(
      description(R"(,"material":[{"name":"steel","E":2e11,"nu":0.29,"rho":7800},{"E":1}],)"
                  R"("air":{"rho":1.2,"c":340})"));
  CHECK(steel.material.name == "steel");
  CHECK(steel.material.youngs_modulus_pa == 2e11);
  CHECK(steel.material.poisson == .29);
  CHECK(steel.material.density_kg_per_m3 == 7800);
  CHECK(steel.air_density_kg_per_m3 == 1.2);
  CHECK(steel.sound_speed_m_per_s == 340);
  // Wood, its grain along y and its rings along z: a contact meets the modulus along its normal.
  const modal::Material wood =
      table_with(description(R"(,"material":{"E":[12e9,2.2e9,1e9],"G":[0.36e9,0.9e9,1.3e9],)"
                             R"("nu":[0.66,0.46,0.36],"axis_1":[0,2,0],"axis_2":[0,1,1]})"))
          .material;
  CHECK(wood.youngs_modulus_pa == 12e9);
  CHECK(wood.modulus_along({0, 1, 0}) == approx(12e9));
  CHECK(wood.modulus_along({0, 0, -1}) == approx(2.2e9));
  CHECK(wood.modulus_along({1, 0, 0}) == approx(1e9));
  const double h = std::sqrt(.5); // 4/E(45 degrees) = 1/E1 + 1/E2 - 2 nu12/E1 + 1/G12
  CHECK(4 / wood.modulus_along({0, h, h}) ==
        approx(1 / 12e9 + 1 / 2.2e9 - 2 * .36 / 12e9 + 1 / 1.3e9));
  const ModalTable plain = table_with(description(R"(,"material":{"name":"x"})"));
  CHECK(plain.material.poisson == .3);
  CHECK(plain.material.youngs_modulus_pa == 0);
  CHECK(plain.air_density_kg_per_m3 == 1.184);
  for (const char* wrong :
       {R"(,"material":{"E":-1})", R"(,"material":{"rho":-1})", R"(,"material":{"nu":0.5})",
        R"(,"material":{"nu":-1})", R"(,"air":{"rho":0})", R"(,"air":{"rho":1e4})",
        R"(,"air":{"c":1})", R"(,"air":{"c":1e5})", R"(,"material":{"E":[1,2,3]})",
        R"(,"material":{"E":[1,2],"G":[1,1,1],"nu":[0,0,0]})", R"(,"material":{"E":"stiff"})",
        R"(,"material":{"E":[1,1,1],"G":[1,1,1],"nu":[0.9,0.9,0]})",
        R"(,"material":{"E":[1,1,1],"G":[1,1,1],"nu":[0,0,0],"axis_1":[1,0,0],"axis_2":[1,0,0]})"})
    mentions(refusal_with(description(wrong)), {"not possible"});
  CHECK(refusal_with(description(R"(,"material":{"nu":0.499})")) == "");
  CHECK(refusal_with(description(R"(,"material":{"nu":-0.999})")) == "");
}

TEST_CASE("numbers of a table are held within what a body can be, and arrays that cannot be right "
          "are refused by name") {
  Floats far(12, 0), shape(24, 0), largest_shape = shape, too_far = far;
  far[5] = 9999, too_far[5] = -10001;
  largest_shape[20] = -1e6F, shape[20] = 1.01e6F;
  for (const Change& good :
       {array("freq", Doubles{440, 1e8}), array("freq", Doubles{440, 440}),
        array("eta", Doubles{0, 2}), array("mass", Doubles{9e8}), array("xyz", far),
        array("phi", largest_shape), array("alpha", Doubles{3, 1e9}, {2}),
        array("inertia", Doubles{1, 1, 0, 1, 3, 0, 0, 0, 1})})
    CHECK(refusal_with(good) == "");
  struct Wrong {
    Change change;
    const char* word;
  };
  const Wrong wrong[] = {
      {meta("{not json"), "JSON"},
      {meta(R"({"format":"modal-table","version":"2.0"})"), "version"},
      {meta(R"({"format":"shopping list"})"), "not a modal table"},
      {array("freq", Doubles{}, {0}), "no modes"},
      {array("freq", Doubles{1000, 440}), "ascend"},
      {array("freq", Doubles{0, 440}), "ascend"},
      {array("freq", Doubles{440, 1.01e8}), "freq"},
      {array("freq", Doubles{440, kNan}), "not a finite number"},
      {array("freq", Doubles{440, std::numeric_limits<double>::infinity()}), "not a finite number"},
      {array("freq", Doubles(20001, 440), {20001}), "20000"},
      {array("freq", Doubles{1, 2, 3}, {3}), "shape"},
      {array("freq", Doubles{1, 2}, {3}), "bytes long"},
      {[](auto& m) { named(m, "freq").type = "<U4"; }, "type"},
      {[](auto& m) { named(m, "freq").type = "<c16", named(m, "freq").shape = {1}; }, "wrong type"},
      {without("freq"), "'freq' is missing"},
      {without("xyz"), "'xyz' is missing"},
      {array("eta", Doubles{0, 2.1}), "eta"},
      {array("eta", Doubles{-.1, 0}), "eta"},
      {array("alpha", Doubles{3, 1.1e9}, {2}), "alpha"},
      {array("alpha", Doubles{-1, 4}, {2}), "alpha"},
      {array("mass", Doubles{1.1e9}), "mass"},
      {array("mass", Doubles{0}), "mass"},
      {array("mass", Doubles{-1}), "mass"},
      {array("inertia", Doubles(9, -1)), "inertia"},
      {array("inertia", Doubles{1, 2, 0, 2, 3, 0, 0, 0, 1}), "inertia"},
      {array("xyz", too_far), "metres"},
      {array("phi", shape), "phi"},
      {array("phi", Floats(24, 0)), "zero"},
      {array("phi", Floats(24, kNanF)), "not a finite number"},
      {array("phi", Floats(24, 1), {2, 3, 4}), "shape"},
      {array("tri", Integers{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 4}),
       "triangle 3 has a corner 4 of 4"},
      {array("tri", Integers{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, -1}), "corner"},
      {array("raw_v", Floats(6, 1), {1, 2, 3}), "raw_"},
      {[](auto& m) { add_multipoles(m), array("mp_rref", Doubles{0}, {})(m); },
       "mp_rref: expected"}};
  for (const Wrong& one : wrong)
    mentions(refusal_with(one.change), {one.word});
}

TEST_CASE("what is no archive, or a damaged one, is refused with a sentence") {
  const std::string good = archive(small_table());
  mentions(refusal_of(""), {"not an .npz"});
  mentions(refusal_of("this is a text, no archive at all, and not even a short one"),
           {"not an .npz"});
  mentions(refusal_of(good.substr(0, good.size() / 2)), {"damaged"});
  mentions(refusal_of(std::string(22, '\0')), {});
  std::string changed = good;
  changed[200] = static_cast<char>(changed[200] ^ 1);
  mentions(refusal_of(changed), {"checksum"});
  std::vector<std::pair<std::string, std::string>> files;
  for (const Member& m : small_table())
    files.emplace_back(m.name + ".npy", npy(m));
  mentions(refusal_of(zip(files, 8)), {"savez"});
  for (const char* path : {"../meta.npy", "/etc/meta.npy"}) {
    auto outside = files;
    outside[0].first = path;
    mentions(refusal_of(zip(outside)), {"plain name"});
  }
  auto twice = files, no_array = files;
  twice.push_back(files[1]);
  mentions(refusal_of(zip(twice)), {"twice"});
  no_array[1].second = "nothing of NumPy's";
  mentions(refusal_of(zip(no_array)), {"NumPy"});
}

TEST_CASE("a size that overflows is refused before anything is allocated") {
  const std::clock_t begin = std::clock(); // of the processor
  constexpr int kBits = std::numeric_limits<std::size_t>::digits;
  constexpr auto kQuarter = std::size_t{1} << (kBits - 2);
  mentions(refusal_with(array("xyz", Floats{}, {kQuarter, kQuarter})), {"too large"});
  mentions(refusal_with(array("xyz", Floats{}, {kQuarter >> 8, 3})), {"bytes long"});
  CHECK(std::clock() - begin < CLOCKS_PER_SEC);
}

TEST_CASE("a description of more than a megabyte is refused before it is parsed") {
  mentions(refusal_with(meta("{\"format\":\"modal-table\",\"version\":\"1\",\"x\":[" +
                             std::string(1u << 20, ' ') + "]}")),
           {"meta", "at most 1048576"});
}

TEST_CASE("multipoles must fit their own tables") {
  CHECK(refusal_with(add_multipoles) == "");
  struct Wrong {
    Change change;
    const char* word;
  };
  const auto shorter = [](const char* name, std::size_t count) {
    return [=](auto& members) {
      named(members, name).shape = {count};
      named(members, name).data.resize(8 * count);
    };
  };
  const auto nan_at = [](const char* name, std::ptrdiff_t byte) {
    return [=](auto& members) {
      const auto nan = raw(Floats{kNanF});
      std::copy(nan.begin(), nan.end(), named(members, name).data.begin() + byte);
    };
  };
  for (const Wrong& one :
       {Wrong{array("mp_off", std::vector<std::int64_t>{0, 5, 5}), "multipoles"},
        {shorter("mp_coef", 4), "mp_coef"},
        {array("mp_band_off", std::vector<std::int64_t>{0, 4, 5}), "mp_band_off"},
        {array("mp_band_freq", Doubles{100, 400, 200, 800}), "mp_band_freq"},
        {shorter("mp_band_coef", 19), "mp_band_coef"},
        {nan_at("mp_coef", 8), "not a finite number"}, // the real part
        {nan_at("mp_coef", 12), "not a finite number"},
        {nan_at("mp_band_coef", 8), "not a finite number"},
        {nan_at("mp_band_coef", 12), "not a finite number"}})
    mentions(refusal_with([&](auto& members) {
               add_multipoles(members);
               one.change(members);
             }),
             {one.word});
}

TEST_CASE("a table's shape parameters are read, and refused by name and shape") {
  auto sound = small_table();
  for (const Change& add :
       {array("control_points", Doubles{0, 0, 0, .1, 0, 0}, {2, 3}),
        array("parameters", Doubles{0, 1, -.01, .02, 1, 0, -.03, .04, 1, 2, -.05, .06}, {3, 4}),
        array("trust", Doubles{.005}, {}), array("domega2_dp", Doubles{1, 2, 3, 4, 5, 6}, {3, 2})})
    add(sound);
  ModalTable table;
  REQUIRE(read_modal_table(bytes_of(archive(sound)), table) == "");
  const ShapeSensitivity& read = table.sensitivity;
  REQUIRE(read.parameters() == 3);
  CHECK(read.shape.control_point_m[1] == Vec3{.1, 0, 0});
  CHECK(read.shape.parameters[1].control_point == 1);
  CHECK(read.shape.parameters[2].axis == 2);
  CHECK(read.shape.parameters[0].low_m == -.01);
  CHECK(read.shape.parameters[0].high_m == .02);
  CHECK(read.shape.trust_m == .005);
  CHECK(read.eigenvalue_slope == Doubles{1, 2, 3, 4, 5, 6});

  struct Wrong {
    const char* name;
    Doubles numbers;
    std::vector<std::size_t> shape;
    std::vector<std::string> words;
  };
  const Wrong wrong[] = {{"domega2_dp", {1, 2, 3, 4}, {2, 2}, {"(2, 2)", "(3, 2)"}},
                         {"domega2_dp", {1, 2, 3, 4, 5, kNan}, {3, 2}, {"finite"}},
                         {"control_points", {0, 0, 0, 1}, {2, 2}, {"(2, 2)"}},
                         {"control_points", {0, 0, 0, 1e5, 0, 0}, {2, 3}, {"metres"}},
                         {"parameters", {2, 1, -1, 1}, {1, 4}, {"control point 2", "0..1"}},
                         {"parameters", {0, 3, -1, 1}, {1, 4}, {"axis 3"}},
                         {"parameters", {0, 1, 1, 2}, {1, 4}, {"bounds 1..2"}},
                         {"parameters", {0, 1, -1, 1, 0, 1, -1, 1}, {2, 4}, {"twice"}},
                         {"parameters", {}, {0, 4}, {"1..6"}},
                         {"trust", {0}, {}, {"more than 0"}}};
  for (const Wrong& one : wrong) {
    auto members = sound;
    array(one.name, one.numbers, one.shape)(members);
    ModalTable unchanged;
    const std::string refusal = read_modal_table(bytes_of(archive(members)), unchanged);
    CHECK(unchanged.frequency_hz.empty());
    mentions(refusal, {one.name});
    for (const std::string& word : one.words)
      mentions(refusal, {word});
  }
}
