// Modal tables as files: every array in its place, and every damage a sentence.
#include "files/modal_table.hpp"
#include "tests/approx.hpp"
#include "tests/files/modal_members.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <ctime>
#include <functional>
#include <limits>
#include <random>

using namespace tactus;
using namespace tactus::modal;
using namespace tactus::test;
using files::read_modal_table;

namespace {

std::string refusal_of(const std::string& file) {
  ModalTable table;
  table.body_name = "as it was";
  const std::string refusal = read_modal_table(bytes_of(file), table);
  if (!refusal.empty())
    CHECK(table.body_name == "as it was");
  return refusal;
}

std::string refusal_with(const std::function<void(std::vector<Member>&)>& change) {
  auto members = small_table();
  change(members);
  return refusal_of(archive(members));
}

bool contains(const std::string& sentence, std::string_view word) {
  CAPTURE(sentence);
  const bool found = sentence.find(word) != std::string::npos;
  CHECK_MESSAGE(found, "expected: ", word);
  return found;
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

} // namespace

TEST_CASE("a sound table is read with its units and its shapes") {
  ModalTable table;
  REQUIRE(read_modal_table(bytes_of(archive(small_table())), table).empty());
  CHECK(table.modes() == 2);
  CHECK(table.vertices() == 4);
  CHECK(table.triangle.size() == 4);
  CHECK(table.frequency_hz[1] == 1000);
  CHECK(table.shape_at(0, 1) == Vec3{0, 2, 0});
  CHECK(table.shape_at(1, 3) == Vec3{-1, 1, 0});
  CHECK(table.free);
  CHECK(table.material.density_kg_per_m3 == 2700);
  CHECK(table.mass_kg == 0.2);
}

TEST_CASE("every array of a table comes to its own place") {
  auto members = small_table();
  named(members, "com").data = raw(std::vector<double>{.02, .025, .03});
  named(members, "inertia").data =
      raw(std::vector<double>{3e-4, 1e-5, 2e-5, 1e-5, 4e-4, 3e-5, 2e-5, 3e-5, 5e-4});
  members.push_back({"raw_v", "<f4", {2, 3, 4}, [] {
                       std::vector<float> v;
                       for (int i = 0; i < 24; ++i)
                         v.push_back(static_cast<float>(i));
                       return raw(v);
                     }()});
  members.push_back(
      {"raw_xyz", "<f8", {3, 3}, raw(std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9})});
  members.push_back({"raw_hit", "<f8", {2, 3}, raw(std::vector<double>{10, 11, 12, 13, 14, 15})});
  members.push_back({"raw_ds", "<f8", {3}, raw(std::vector<double>{.1, .2, .3})});
  members.push_back({"raw_fs", "<f8", {}, raw(std::vector<double>{96000})});
  const auto add = [&](const char* name, const char* type, std::vector<std::size_t> shape,
                       std::string data) {
    members.push_back({name, type, shape, data});
  };
  add("mp_lmax", "<i4", {2}, raw(std::vector<std::int32_t>{1, 0}));
  add("mp_off", "<i8", {3}, raw(std::vector<std::int64_t>{0, 4, 5}));
  add("mp_center", "<f8", {3}, raw(std::vector<double>{.1, .2, .3}));
  add("mp_rref", "<f8", {}, raw(std::vector<double>{.4}));
  add("mp_coef", "<c8", {5}, raw(std::vector<float>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  add("mp_band_freq", "<f8", {4}, raw(std::vector<double>{100, 200, 400, 800}));
  add("mp_band_lmax", "<i4", {2}, raw(std::vector<std::int32_t>{0, 1}));
  add("mp_band_off", "<i8", {3}, raw(std::vector<std::int64_t>{0, 1, 5}));
  std::vector<float> band(40);
  for (std::size_t i = 0; i < band.size(); ++i)
    band[i] = static_cast<float>(i);
  add("mp_band_coef", "<c8", {20}, raw(band));
  ModalTable table;
  REQUIRE(read_modal_table(bytes_of(archive(members)), table) == "");
  CHECK(table.body_name == "four corners");
  CHECK(table.material.youngs_modulus_pa == 7e10);
  CHECK(table.material.poisson == .3);
  CHECK(table.loss_factor == std::vector<double>{1e-3, 2e-3});
  CHECK(table.centre_of_mass_m == Vec3{.02, .025, .03});
  CHECK(table.inertia_kg_m2[0] == Vec3{3e-4, 1e-5, 2e-5});
  CHECK(table.inertia_kg_m2[1] == Vec3{1e-5, 4e-4, 3e-5});
  CHECK(table.inertia_kg_m2[2] == Vec3{2e-5, 3e-5, 5e-4});
  CHECK(norm(table.vertex_m[2] - Vec3{0, .1, 0}) < 1e-8);
  CHECK(table.triangle[3] == std::array<std::int32_t, 3>{1, 2, 3});
  const RawTable& r = table.raw;
  CHECK(r.hits == 2);
  CHECK(r.points == 3);
  CHECK(r.samples == 4);
  CHECK(r.sample_rate_hz == 96000);
  CHECK(r.velocity_m_per_s[23] == 23);
  CHECK(r.position_m[1] == Vec3{4, 5, 6});
  CHECK(r.hit_m[1] == Vec3{13, 14, 15});
  CHECK(r.area_m2 == std::vector<double>{.1, .2, .3});
  const MultipoleTable& m = table.multipoles;
  CHECK(m.centre == Vec3{.1, .2, .3});
  CHECK(m.reference_radius_m == .4);
  CHECK(m.highest_degree == std::vector<std::int32_t>{1, 0});
  CHECK(m.offset == std::vector<std::int64_t>{0, 4, 5});
  CHECK(m.coefficients[3] == std::complex<float>(6, 7));
  CHECK(m.band.frequency_hz == std::vector<double>{100, 200, 400, 800});
  CHECK(m.band.highest_degree == std::vector<std::int32_t>{0, 1});
  CHECK(m.band.offset == std::vector<std::int64_t>{0, 1, 5});
  CHECK(m.band.coefficients[19] == std::complex<float>(38, 39));
  // Without coefficients at several scales there is one, the mode's own frequency.
  CHECK(m.scales == std::vector<double>{1});
}

TEST_CASE("big-endian numbers, columns first and other widths are converted") {
  auto members = small_table();
  auto& freq = named(members, "freq");
  freq.type = ">f8";
  for (std::size_t i = 0; i < freq.data.size(); i += 8)
    std::reverse(freq.data.begin() + static_cast<std::ptrdiff_t>(i),
                 freq.data.begin() + static_cast<std::ptrdiff_t>(i + 8));
  auto& xyz = named(members, "xyz");
  xyz.fortran = true;
  xyz.data = raw(std::vector<float>{0, .1F, 0, 0, 0, 0, .1F, 0, 0, 0, 0, .1F});
  auto& tri = named(members, "tri");
  tri.type = "<i8";
  tri.data = raw(std::vector<std::int64_t>{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
  ModalTable table;
  REQUIRE(read_modal_table(bytes_of(archive(members)), table) == "");
  CHECK(table.frequency_hz[0] == 440);
  CHECK(table.vertex_m[2].y == approx(0.1));
  CHECK(table.vertex_m[3].z == approx(0.1));
  CHECK(table.triangle[1] == std::array<std::int32_t, 3>{0, 1, 3});
}

TEST_CASE("frequencies alone make a table that rings with unit gain") {
  auto members = small_table();
  std::erase_if(members, [](const Member& m) { return m.name != "meta" && m.name != "freq"; });
  ModalTable table;
  CHECK(read_modal_table(bytes_of(archive(members)), table).empty());
  CHECK(table.shape.empty());
}

TEST_CASE("arrays that nobody knows are left aside") {
  CHECK(refusal_with([](auto& m) { named(m, "weather").data = raw(std::vector<double>{1}); }) ==
        "");
}

TEST_CASE("what is no archive, or a damaged one, is refused with a sentence") {
  const std::string good = archive(small_table());
  contains(refusal_of(""), "not an .npz");
  contains(refusal_of("this is a text, no archive at all, and not even a short one"),
           "not an .npz");
  contains(refusal_of(good.substr(0, good.size() / 2)), "cut off");
  std::string damaged = good;
  damaged[200] = static_cast<char>(damaged[200] ^ 1);
  contains(refusal_of(damaged), "checksum");
  std::vector<std::pair<std::string, std::string>> files;
  for (const Member& m : small_table())
    files.emplace_back(m.name + ".npy", npy(m));
  contains(refusal_of(zip(files, 8)), "savez");
  auto outside = files;
  outside[0].first = "../meta.npy";
  contains(refusal_of(zip(outside)), "plain name");
  outside[0].first = "/etc/meta.npy";
  contains(refusal_of(zip(outside)), "plain name");
  auto twice = files;
  twice.push_back(files[1]);
  contains(refusal_of(zip(twice)), "twice");
  auto no_array = files;
  no_array[1].second = "nothing of NumPy's";
  contains(refusal_of(zip(no_array)), "NumPy");
  CHECK(refusal_of(std::string(22, '\0')) != "");
}

TEST_CASE("arrays that cannot be right are refused by name") {
  contains(refusal_with([](auto& m) {
             named(m, "meta").data = "{not json";
             named(m, "meta").shape = {9};
           }),
           "JSON");
  contains(refusal_with([](auto& m) {
             auto& meta = named(m, "meta");
             meta.data = R"({"format":"modal-table","version":"2.0"})";
             meta.shape = {meta.data.size()};
           }),
           "version");
  contains(refusal_with([](auto& m) {
             auto& meta = named(m, "meta");
             meta.data = R"({"format":"shopping list"})";
             meta.shape = {meta.data.size()};
           }),
           "no modal table");
  const auto freq = [](std::vector<double> f) {
    return [f](auto& m) {
      named(m, "freq").data = raw(f);
      named(m, "freq").shape = {f.size()};
    };
  };
  contains(refusal_with(freq({})), "no modes");
  contains(refusal_with(freq({1000, 440})), "ascend");
  contains(refusal_with(freq({-1, 440})), "ascend");
  contains(refusal_with(freq({440, kNan})), "not finite");
  contains(refusal_with(freq({440, std::numeric_limits<double>::infinity()})), "not finite");
  contains(refusal_with(freq(std::vector<double>(20001, 440))), "20000");
  contains(refusal_with(freq({1, 2, 3})), "shape");
  contains(refusal_with([](auto& m) {
             named(m, "freq").type = "<c16";
             named(m, "freq").shape = {1};
           }),
           "wrong kind");
  contains(refusal_with([](auto& m) { named(m, "freq").type = "<U4"; }), "type");
  contains(refusal_with([](auto& m) { named(m, "freq").shape = {3}; }), "bytes long");
  contains(refusal_with([](auto& m) { named(m, "phi").shape = {2, 3, 4}; }), "shape");
  contains(refusal_with([](auto& m) { named(m, "phi").data = raw(std::vector<float>(24, 0)); }),
           "zero");
  contains(refusal_with([](auto& m) {
             named(m, "phi").data =
                 raw(std::vector<float>(24, std::numeric_limits<float>::quiet_NaN()));
           }),
           "not finite");
  contains(refusal_with([](auto& m) { named(m, "tri").data[4] = 9; }), "corner");
  contains(refusal_with([](auto& m) { named(m, "tri").data[3] = static_cast<char>(0x80); }),
           "corner");
  contains(refusal_with([](auto& m) { named(m, "mass").data = raw(std::vector<double>{0}); }),
           "mass");
  contains(
      refusal_with([](auto& m) { named(m, "inertia").data = raw(std::vector<double>(9, -1)); }),
      "inertia");
  contains(refusal_with([](auto& m) {
             named(m, "eta").data = raw(std::vector<double>{-1, 0});
           }),
           "eta");
  contains(refusal_with([](auto& m) { std::erase_if(m, [](auto& x) { return x.name == "xyz"; }); }),
           "'xyz' is missing");
  contains(
      refusal_with([](auto& m) { std::erase_if(m, [](auto& x) { return x.name == "freq"; }); }),
      "'freq' is missing");
}

TEST_CASE("a size that overflows is refused before anything is allocated") {
  const std::clock_t begin = std::clock(); // of the processor
  contains(refusal_with([](auto& m) {
             named(m, "xyz").shape = {std::size_t{1} << 62, std::size_t{1} << 62};
           }),
           "more elements");
  contains(refusal_with([](auto& m) {
             named(m, "xyz").shape = {std::size_t{1} << 50, 3};
           }),
           "bytes long");
  CHECK(std::clock() - begin < CLOCKS_PER_SEC);
}

TEST_CASE("multipoles and raw velocities must fit their own tables") {
  const auto with_multipoles = [](auto& m) {
    m.push_back({"mp_lmax", "<i4", {2}, raw(std::vector<std::int32_t>{1, 0})});
    m.push_back({"mp_off", "<i8", {3}, raw(std::vector<std::int64_t>{0, 4, 5})});
    m.push_back({"mp_center", "<f8", {3}, raw(std::vector<double>{0, 0, 0})});
    m.push_back({"mp_rref", "<f8", {}, raw(std::vector<double>{0.1})});
    m.push_back({"mp_coef", "<c8", {5}, raw(std::vector<float>(10, 1))});
  };
  CHECK(refusal_with(with_multipoles) == "");
  contains(refusal_with([&](auto& m) {
             with_multipoles(m);
             named(m, "mp_off").data[8] = 5;
           }),
           "multipoles");
  contains(refusal_with([&](auto& m) {
             with_multipoles(m);
             named(m, "mp_coef").shape = {4};
             named(m, "mp_coef").data.resize(32);
           }),
           "mp_coef");
  const auto with_band = [&](auto& m) {
    with_multipoles(m);
    m.push_back({"mp_band_freq", "<f8", {4}, raw(std::vector<double>{100, 200, 400, 800})});
    m.push_back({"mp_band_lmax", "<i4", {2}, raw(std::vector<std::int32_t>{0, 1})});
    m.push_back({"mp_band_off", "<i8", {3}, raw(std::vector<std::int64_t>{0, 1, 5})});
    m.push_back({"mp_band_coef", "<c8", {20}, raw(std::vector<float>(40, 1))});
  };
  CHECK(refusal_with(with_band) == "");
  contains(refusal_with([&](auto& m) {
             with_band(m);
             named(m, "mp_band_off").data[8] = 4;
           }),
           "mp_band_off");
  contains(refusal_with([&](auto& m) {
             with_band(m);
             named(m, "mp_band_freq").data = raw(std::vector<double>{100, 400, 200, 800});
           }),
           "mp_band_freq");
  contains(refusal_with([&](auto& m) {
             with_band(m);
             named(m, "mp_band_coef").shape = {19};
             named(m, "mp_band_coef").data.resize(152);
           }),
           "mp_band_coef");
  for (const char* name : {"mp_coef", "mp_band_coef"})
    for (const std::ptrdiff_t part : {0, 1}) { // real, imaginary
      const std::string refusal = refusal_with([&](auto& m) {
        with_band(m);
        const auto nan = raw(std::vector<float>{std::numeric_limits<float>::quiet_NaN()});
        std::copy(nan.begin(), nan.end(), named(m, name).data.begin() + 8 + 4 * part);
      });
      contains(refusal, name);
      contains(refusal, "not finite");
    }
  contains(refusal_with([&](auto& m) {
             m.push_back({"raw_v", "<f4", {1, 2, 3}, raw(std::vector<float>(6, 1))});
           }),
           "raw_");
}

TEST_CASE("twenty thousand damaged files crash nothing and keep the old table") {
  const std::string good = archive(small_table());
  std::mt19937 random(3);
  ModalTable table;
  std::size_t refused = 0;
  for (int round = 0; round < 20000; ++round) {
    const std::string bad = damaged(good, random);
    refused += read_modal_table(bytes_of(bad), table).empty() ? 0 : 1;
  }
  CHECK(refused > 15000);
}

TEST_CASE("damage behind right checksums is found, too") {
  std::mt19937 random(4);
  for (int round = 0; round < 20000; ++round) {
    auto members = small_table();
    Member& m = members[random() % members.size()];
    if (!m.data.empty())
      for (unsigned n = 1 + random() % 8; n-- > 0;)
        m.data[random() % m.data.size()] = static_cast<char>(random());
    if (random() % 3 == 0 && !m.shape.empty())
      m.shape[random() % m.shape.size()] = random() % 6;
    ModalTable table;
    if (!read_modal_table(bytes_of(archive(members)), table).empty())
      continue;
    for (const double f : table.frequency_hz)
      CHECK((f > 0 && std::isfinite(f)));
    for (const float x : table.shape)
      CHECK(std::isfinite(x));
    for (const auto& t : table.triangle)
      for (const std::int32_t v : t)
        CHECK((v >= 0 && static_cast<std::size_t>(v) < table.vertices()));
  }
}
