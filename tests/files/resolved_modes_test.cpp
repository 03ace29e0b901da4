// Answers of modal_fem about a body in another shape: what is read, kept and refused.
#include "core/modal/table/resolved_modes.hpp"
#include "core/serve/modal_fem.hpp"
#include "files/tables.hpp"
#include "tests/approx.hpp"
#include "tests/files/modal_members.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

using namespace tactus;
using namespace tactus::modal;
using namespace tactus::test;
using files::read_modal_table;

namespace {

template <class T> void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

using Doubles = std::vector<double>;

std::vector<Member> solved_table() {
  std::vector<Member> members = small_table();
  for (const Change& add :
       {array("control_points", Doubles{.1, 0, 0}, {1, 3}),
        array("parameters", Doubles{0, 1, -.01, .01}, {1, 4}), array("trust", Doubles{.002}, {}),
        array("domega2_dp", Doubles{1e6, 2e6}, {1, 2})})
    add(members);
  return members;
}
/// As solved anew 3 mm further.
std::vector<Member> moved_table() {
  std::vector<Member> members = solved_table();
  array("displacement", Doubles{.003}, {1})(members);
  return members;
}

std::string answer(const std::vector<ModeShare>& shares, std::vector<Member> members,
                   double fraction = 1) {
  std::string bytes;
  append(bytes, serve::ModesAnswer{.5, fraction, shares.size()});
  for (const ModeShare& s : shares)
    append(bytes, s);
  return bytes + archive(members);
}

ModalTable table_before() {
  ModalTable table;
  REQUIRE(read_modal_table(bytes_of(archive(solved_table())), table).empty());
  return table;
}

std::string refusal_of(const std::string& bytes, const ModalTable& before, ResolvedModes& read) {
  return files::read_resolved_modes(bytes_of(bytes), before, read);
}

} // namespace

TEST_CASE("an answer is read, and keeps what was not solved anew") {
  ModalTable before = table_before();
  before.radiation_decay_rate = {3, 5};
  before.residual_compliance.assign(before.vertices(), 1e-9F);
  before.multipoles.highest_degree = {0, 1};
  before.multipoles.offset = {0, 1, 5};
  before.multipoles.scales = {1};
  before.multipoles.coefficients = {{1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}};
  before.multipoles.reference_radius_m = .1;
  auto members = moved_table();
  ResolvedModes read;
  const std::string bytes = answer({{0, 1, -1}, {1, 0, .6}}, members, .5);
  CHECK(bytes.size() <= max_answer_bytes(before));
  REQUIRE(refusal_of(bytes, before, read) == "");
  CHECK(read.fraction == .5);
  CHECK(read.seconds == .5);
  CHECK(read.table.sensitivity.solved_at(0) == .003);
  CHECK(read.table.radiation_decay_rate == Doubles{.36 * 5, 3});
  CHECK(read.table.residual_compliance == before.residual_compliance);
  CHECK(read.table.multipoles.highest_degree == std::vector<std::int32_t>{1, 0});
  CHECK(read.table.multipoles.offset == std::vector<std::int64_t>{0, 4, 5});
  CHECK(read.table.multipoles.coefficients[0] == std::complex<float>(.6F * 2, 0));
  CHECK(read.table.multipoles.coefficients[4] == std::complex<float>(-1, 0));
  // From there on the frequencies are those of the table at 3 mm.
  const Doubles there{.003}, back{0};
  for (const double f : frequency_factors(read.table.sensitivity, read.table.frequency_hz, there))
    CHECK(f == 1);
  const double omega = 2 * std::numbers::pi * 440;
  CHECK(frequency_factors(read.table.sensitivity, read.table.frequency_hz, back)[0] ==
        approx(std::exp(-.5 * 1e6 * .003 / (omega * omega))).epsilon(1e-12));
}

TEST_CASE("an answer that cannot be is one sentence and changes nothing") {
  ModalTable before = table_before();
  auto members = moved_table();
  const auto changed = [&](const Change& change) {
    auto other = members;
    change(other);
    return other;
  };
  std::string many = answer({}, members);
  const std::uint64_t huge = ~std::uint64_t{0} / 16 + 2;
  std::memcpy(many.data() + 16, &huge, sizeof huge);
  const double nan = std::nan("");
  ResolvedModes read;
  for (const auto& one : std::vector<std::pair<std::string, std::string>>{
           {"", "0 bytes"},
           {answer({}, members).substr(0, 200), ""},
           {answer({{2, 0, 1}}, members), "share of mode 2"},
           {answer({{0, 7, 1}}, members), "in mode 7"},
           {answer({{0, 0, 1.5}}, members), "is 1.5"},
           {answer({{0, 0, nan}}, members), "expected -1..1"},
           {answer({{0, 0, .9}, {0, 1, .9}}, members), "sum to 1.62"},
           {answer({{0, 0, .9}, {1, 0, .9}}, members), "sum to 1.62"},
           {answer({}, members, 2), "of the move"},
           {answer({}, members, nan), "of the move"},
           {answer({}, changed(without("displacement"))), "shape parameters"},
           {answer({}, changed(without("domega2_dp"))), "shape parameters"},
           {answer({}, changed(array("displacement", Doubles{.02}))), "displacement"},
           {answer({}, changed(without("phi"))), "vertices"},
           {many, "shares"}}) {
    mentions(refusal_of(one.first, before, read), {one.second});
    CHECK(read.table.modes() == 0);
  }
}

TEST_CASE("damaged answers are refused, or what is read keeps its bounds") {
  constexpr int kRounds = 1000;
  ModalTable before = table_before();
  const std::vector<ModeShare> share{{0, 1, -1}, {1, 0, .6}};
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  std::size_t refused = 0, taken = 0;
  for (int i = 0; i < kRounds; ++i) {
    auto members = moved_table();
    // Every second time an array changes under a checksum that is right; else any byte of all.
    const bool inside = below(2) == 0;
    if (inside) {
      std::string& data = members[1 + below(members.size() - 1)].data;
      data[below(data.size())] = static_cast<char>(below(256));
    }
    std::string bytes = answer(share, members);
    for (std::size_t n = inside ? 0 : 1 + below(3); n > 0; --n)
      bytes[below(below(2) ? bytes.size() : 60)] = static_cast<char>(below(256));
    if (below(8) == 0)
      bytes.resize(below(bytes.size()));
    ResolvedModes read;
    const std::string refusal = refusal_of(bytes, before, read);
    if (!refusal.empty()) {
      ++refused;
      continue;
    }
    ++taken;
    bool bounded = read.fraction >= 0 && read.fraction <= 1;
    for (const ModeShare& s : read.share)
      bounded = bounded && s.before < before.modes() && s.now < read.table.modes() &&
                std::abs(s.share) <= 1.000001;
    REQUIRE(bounded);
  }
  CHECK(refused > kRounds / 20);
  CHECK(taken > kRounds / 200);
}
