// Modal tables as files: the limits of what a table may say.
#include "files/modal_table.hpp"
#include "tests/approx.hpp"
#include "tests/files/modal_members.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::files::read_modal_table;

namespace {

std::string refusal_of(std::vector<Member> members) {
  ModalTable table;
  return read_modal_table(bytes_of(archive(members)), table);
}

/// The small table with numbers of an array in place of its own.
template <class T> std::string refusal_with(const char* name, const std::vector<T>& numbers) {
  auto members = small_table();
  named(members, name).data = raw(numbers);
  return refusal_of(members);
}

ModalTable table_with_meta(const std::string& more) {
  auto members = small_table();
  Member& meta = named(members, "meta");
  meta.data = R"({"format":"modal-table","version":"1.0")" + more + "}";
  meta.shape = {meta.data.size()};
  ModalTable table;
  CHECK(read_modal_table(bytes_of(archive(members)), table) == "");
  return table;
}

std::string meta_refusal(const std::string& more) {
  auto members = small_table();
  Member& meta = named(members, "meta");
  meta.data = R"({"format":"modal-table","version":"1.0")" + more + "}";
  meta.shape = {meta.data.size()};
  return refusal_of(members);
}

} // namespace

TEST_CASE("a table's description: what holds it, its material, the air") {
  for (const char* free : {"", R"(,"bc":"free")", R"(,"bc":"free-free")", R"(,"bc":null)",
                           R"(,"bc":[])", R"(,"bc":{})", R"(,"bc":"")"}) {
    CAPTURE(free);
    CHECK(table_with_meta(free).free);
  }
  for (const char* held : {R"(,"bc":"clamped")", R"(,"bc":["edge"])", R"(,"bc":{"nodes":3})",
                           R"(,"bc":1)", R"(,"bc":true)"}) {
    CAPTURE(held);
    CHECK(!table_with_meta(held).free);
  }
  CHECK(table_with_meta(R"(,"bc":"clamped")").boundary == "clamped");
  CHECK(table_with_meta(R"(,"bc":["edge"])").boundary == "held");
  const ModalTable steel =
      table_with_meta(R"(,"material":[{"name":"steel","E":2e11,"nu":0.29,"rho":7800},{"E":1}],)"
                      R"("air":{"rho":1.2,"c":340})");
  CHECK(steel.material.name == "steel");
  CHECK(steel.material.youngs_modulus_pa == 2e11);
  CHECK(steel.material.poisson == .29);
  CHECK(steel.material.density_kg_per_m3 == 7800);
  CHECK(steel.air_density_kg_per_m3 == 1.2);
  CHECK(steel.sound_speed_m_per_s == 340);
  const ModalTable plain = table_with_meta(R"(,"material":{"name":"x"})");
  CHECK(plain.material.poisson == .3);
  CHECK(plain.material.youngs_modulus_pa == 0);
  CHECK(plain.air_density_kg_per_m3 == 1.184);
  for (const char* wrong :
       {R"(,"material":{"E":-1})", R"(,"material":{"rho":-1})", R"(,"material":{"nu":0.5})",
        R"(,"material":{"nu":-1})", R"(,"air":{"rho":0})", R"(,"air":{"rho":1e4})",
        R"(,"air":{"c":1})", R"(,"air":{"c":1e5})"}) {
    CAPTURE(wrong);
    CHECK(meta_refusal(wrong).find("cannot exist") != std::string::npos);
  }
  CHECK(meta_refusal(R"(,"material":{"nu":0.499})") == "");
  CHECK(meta_refusal(R"(,"material":{"nu":-0.999})") == "");
}

TEST_CASE("numbers of a table are held within what a body can be") {
  using Numbers = std::vector<double>;
  CHECK(refusal_with("freq", Numbers{440, 1e8}) == "");
  CHECK(refusal_with("freq", Numbers{440, 440}) == "");
  CHECK(refusal_with("freq", Numbers{440, 1.01e8}) != "");
  CHECK(refusal_with("freq", Numbers{0, 440}) != "");
  CHECK(refusal_with("eta", Numbers{0, 2}) == "");
  CHECK(refusal_with("eta", Numbers{0, 2.1}) != "");
  CHECK(refusal_with("eta", Numbers{-.1, 0}) != "");
  CHECK(refusal_with("mass", Numbers{9e8}) == "");
  CHECK(refusal_with("mass", Numbers{1.1e9}) != "");
  CHECK(refusal_with("mass", Numbers{-1}) != "");
  CHECK(refusal_with("inertia", Numbers{1, 2, 0, 2, 3, 0, 0, 0, 1}) != "");
  CHECK(refusal_with("inertia", Numbers{1, 1, 0, 1, 3, 0, 0, 0, 1}) == "");
  auto members = small_table();
  const auto with = [&](const char* name, std::vector<std::size_t> shape, const Numbers& numbers) {
    auto changed = members;
    Member& m = named(changed, name);
    m.shape = shape;
    m.data = raw(numbers);
    ModalTable table;
    const std::string refusal = read_modal_table(bytes_of(archive(changed)), table);
    return std::pair(refusal, table);
  };
  CHECK(with("alpha", {2}, {3, 1e9}).first == "");
  CHECK(with("alpha", {2}, {3, 1.1e9}).first != "");
  CHECK(with("alpha", {2}, {-1, 4}).first != "");
  const ModalTable decaying = with("alpha", {2}, {3, 4}).second;
  CHECK(decaying.decay_rate == Numbers{3, 4});
  CHECK(decaying.loss_factor.empty()); // a decay rate is the more exact of the two
  CHECK(with("alpha_rad", {2}, {3, 4}).second.radiation_decay_rate == Numbers{3, 4});
  CHECK(with("dlnf_dnu", {2}, {-3, 4}).second.poisson_slope == Numbers{-3, 4});
  CHECK(with("resid", {4}, {1e-9, -1e-9, 0, 2e-9}).second.residual_compliance ==
        std::vector<float>{1e-9F, 0, 0, 2e-9F});
  // Places, shapes and corners.
  std::vector<float> far(12, 0);
  far[5] = 9999;
  CHECK(refusal_with("xyz", far) == "");
  far[5] = -10001;
  CHECK(refusal_with("xyz", far).find("metres") != std::string::npos);
  std::vector<float> shape(24, 0);
  shape[20] = -1e6F;
  CHECK(refusal_with("phi", shape) == "");
  shape[20] = 1.01e6F;
  CHECK(refusal_with("phi", shape) != "");
  std::vector<std::int32_t> corners{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 4};
  CHECK(refusal_with("tri", corners).find("triangle 3 has a corner 4 of 4") != std::string::npos);
  corners[11] = -1;
  CHECK(refusal_with("tri", corners) != "");
  // Where nothing is said of losses there are none.
  std::erase_if(members, [](const Member& m) { return m.name == "eta"; });
  ModalTable table;
  CHECK(read_modal_table(bytes_of(archive(members)), table) == "");
  CHECK(table.loss_factor == Numbers{0, 0});
}
