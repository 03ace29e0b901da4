#include "core/contact/touched_body.hpp"

#include <algorithm>
#include <cmath>

/// Contacts that share no mode: each island of them in steps of its own. All modes ring once a
/// sample; an island goes on from the state before the sample and writes the modes that it moves.
namespace tactus::contact {
namespace {

constexpr std::size_t kContactWork = 64; // products that take as long as one contact's law

bool in_a_row(std::span<const std::uint32_t> modes) noexcept {
  return !modes.empty() && modes.back() - modes.front() + 1 == modes.size();
}

void scatter(std::span<const std::uint32_t> modes, const double* from, ModeArray& to) noexcept {
  for (std::size_t k = 0; k < modes.size(); ++k)
    to[modes[k]] = from[k];
}

} // namespace

/// Who may ever touch a mode that another touches.
void TouchedBody::divide_in_use() noexcept {
  sorted_.clear();
  for (std::size_t i = 0; i < exciters_.size(); ++i)
    if (exciters_[i].kind != Exciter::Kind::kNone)
      sorted_.push_back(i);
  used_ = sorted_.size();
  place_modes_.divide(sorted_, in_use_);
  sorted_.clear();
  lone_.clear();
  wakes_at_.assign(in_use_.size(), 0);
  for (std::size_t k = 0; k < in_use_.size(); ++k) {
    const std::span<const std::size_t> slots = in_use_.slots(k);
    for (const std::size_t i : slots)
      community_[i] = k;
    const bool lone = used_ > 1 && slots.size() == 1 && in_use_.modes(k).size() <= kFewModes;
    std::vector<std::size_t>& list = lone ? lone_ : sorted_;
    list.insert(list.end(), slots.begin(), slots.end());
  }
}

/// Are those near one island, on modes that lie close together? It is then solved in place.
void TouchedBody::find_range() noexcept {
  const std::size_t padded = body_.padded();
  one_range_ = range_known_ = true;
  range_first_ = 0;
  range_end_ = padded;
  const bool all_move = std::none_of(close_.begin(), close_.end(),
                                     [this](std::size_t i) { return place_modes_[i].empty(); });
  const bool one_moves_all = std::any_of(close_.begin(), close_.end(), [this](std::size_t i) {
    return place_modes_[i].size() == sounding_;
  });
  if (near_ == 0 || (all_move && one_moves_all))
    return;
  std::span<const std::uint32_t> modes = place_modes_[close_[0]];
  if (near_ > 1) {
    divide();
    one_range_ = islands_.size() == 1;
    modes = islands_.modes(0);
  }
  const std::size_t first = modes.empty() ? 0 : modes.front() / kModeLanes * kModeLanes;
  const std::size_t end = modes.empty() ? 0 : whole_lanes(modes.back() + 1);
  one_range_ = one_range_ && end - first <= 2 * whole_lanes(modes.size());
  if (one_range_ && 2 * (end - first) <= padded) {
    range_first_ = first;
    range_end_ = end;
  }
}

void TouchedBody::divide() noexcept {
  if (divided_)
    return;
  place_modes_.divide(close_, islands_);
  divided_ = true;
  packed_.clear();
}

bool TouchedBody::few(std::size_t island) const noexcept {
  return islands_[island].slots == 1 && islands_[island].modes <= kFewModes;
}

/// Where in the packed arrays each island has its part.
void TouchedBody::lay_out() noexcept {
  std::size_t at = 0, shapes_at = 0, block_at = 0;
  packed_.clear();
  for (std::size_t k = 0; k < islands_.size(); ++k) {
    const std::span<const std::uint32_t> modes = islands_.modes(k);
    const std::size_t count = islands_[k].slots,
                      skip = in_a_row(modes) ? modes.front() % kModeLanes : 0,
                      lanes = few(k) ? 0 : whole_lanes(skip + modes.size()),
                      stride = whole_lanes(count);
    Packed island;
    island.at = at;
    island.skip = skip;
    island.lanes = lanes;
    island.shapes_at = shapes_at;
    island.block = {islands_[k].first_slot, block_at, stride};
    packed_.push_back(island);
    at += lanes;
    shapes_at += count * lanes;
    block_at += count * stride;
  }
}

/// An island in arrays of its own: its modes in a row, as if no others were there. Modes that lie
/// in a row in the body, too, stay there: where lanes are shared with others, these have a turn of
/// 1 and no force, so that nothing moves them. `in_body`: the body's states are those before the
/// sample.
TouchedBody::Group TouchedBody::pack(std::size_t island, std::size_t level_index,
                                     bool in_body) noexcept {
  Packed& p = packed_[island];
  const std::span<const std::size_t> slots = islands_.slots(island);
  const std::span<const std::uint32_t> modes = islands_.modes(island);
  const auto gather = [&](double* part, const double* from, double elsewhere) {
    double* const own = part + p.skip;
    std::fill(part, own, elsewhere);
    if (in_a_row(modes))
      std::copy_n(from + modes.front(), modes.size(), own);
    else
      std::transform(modes.begin(), modes.end(), own, [&](std::uint32_t k) { return from[k]; });
    std::fill(own + modes.size(), part + p.lanes, elsewhere);
  };
  shapes_.clear();
  for (std::size_t c = 0; c < slots.size(); ++c)
    shapes_.push_back(packed_shapes_.data() + p.shapes_at + c * p.lanes);
  ModalBody::Level& to = packed_level_;
  p.in_body = in_body && in_a_row(modes);
  const std::size_t first = p.in_body ? modes.front() - p.skip : 0;
  const Group group{slots,
                    {p.in_body ? body_.real.data() + first : packed_real_.data() + p.at,
                     p.in_body ? body_.imaginary.data() + first : packed_imaginary_.data() + p.at,
                     to.turn_real.data() + p.at, to.turn_imaginary.data() + p.at,
                     to.response_real.data() + p.at, to.response_imaginary.data() + p.at,
                     to.mean_real.data() + p.at, to.mean_imaginary.data() + p.at,
                     to.mobility.data() + p.at, packed_slowing_.data() + p.at, p.lanes},
                    p.skip + modes.size(),
                    has_outer_ ? packed_outer_.data() + p.at : nullptr,
                    level_index};
  system_.select(p.block);
  if (!p.ready) {
    gather(packed_slowing_.data() + p.at, body_.slowing.data(), 0);
    for (std::size_t c = 0; c < slots.size(); ++c)
      gather(packed_shapes_.data() + p.shapes_at + c * p.lanes, place_[slots[c]].data(), 0);
  }
  if (!p.ready || p.level != level_index) {
    const ModalBody::Level& from = body_.level(level_index);
    gather(to.turn_real.data() + p.at, from.turn_real.data(), 1);
    gather(to.turn_imaginary.data() + p.at, from.turn_imaginary.data(), 0);
    gather(to.response_real.data() + p.at, from.response_real.data(), 0);
    gather(to.response_imaginary.data() + p.at, from.response_imaginary.data(), 0);
    gather(to.mean_real.data() + p.at, from.mean_real.data(), 0);
    gather(to.mean_imaginary.data() + p.at, from.mean_imaginary.data(), 0);
    gather(to.mobility.data() + p.at, from.mobility.data(), 0);
    couple(group);
    if (slots.size() == 1)
      p.place = look_from(group.modes, shapes_[0], packed_places_.from(p.at));
    p.level = level_index;
    p.ready = true;
    p.foreseen = false;
  }
  if (!p.in_body) {
    gather(packed_real_.data() + p.at, from_real_, 0);
    gather(packed_imaginary_.data() + p.at, from_imaginary_, 0);
  }
  if (has_outer_)
    gather(packed_outer_.data() + p.at, outer_.data(), 0);
  return group;
}

std::size_t TouchedBody::island_level(std::size_t island) const noexcept {
  std::size_t level = least_level_;
  for (const std::size_t i : islands_.slots(island))
    level = std::max(level, exciters_[i].level);
  return level;
}

std::size_t TouchedBody::island_work(std::size_t island) const noexcept {
  const Islands::Island& k = islands_[island];
  return k.slots == 1 ? kContactWork + 2 * k.modes : work(k.slots, k.modes);
}

/// The finest steps that an island gets whose step takes this work.
std::size_t TouchedBody::granted(std::size_t work, std::size_t level) const noexcept {
  while (level > 0 && (work << level) > share_)
    --level;
  return level;
}

/// Bounds the work of a sample: all fine steps together take kMaxWork, and as long as they want
/// more, the dearest islands get coarser ones. None depends on their order.
void TouchedBody::share_work() noexcept {
  share_ = kMaxWork;
  if (std::all_of(close_.begin(), close_.end(),
                  [&](std::size_t i) { return std::max(least_level_, exciters_[i].level) == 0; }) &&
      std::all_of(lone_at_.begin() + 1, lone_at_.end(), [](std::size_t n) { return n == 0; }))
    return; // nobody wants any
  share_ = 2 * kMaxWork;
  std::size_t sum = 0;
  do {
    share_ /= 2;
    sum = 0;
    for (std::size_t level = 1; level < kLevels; ++level)
      if (const std::size_t fine = granted(kContactWork, level); fine > 0)
        sum += lone_at_[level] * (kContactWork << fine);
    for (std::size_t k = 0; k < islands_.size(); ++k)
      if (const std::size_t fine = granted(island_work(k), island_level(k)); fine > 0)
        sum += island_work(k) << fine;
  } while (sum > kMaxWork && share_ > kContactWork);
}

void TouchedBody::touch_islands() noexcept {
  sounds_ = true;
  foreseen_ = coupled_ = false;
  divide();
  if (packed_.empty())
    lay_out();
  share_work();
  std::size_t moved = pressed_.size(); // modes of the islands
  for (const std::size_t i : lone_near_)
    moved += few_[i].count;
  for (std::size_t k = 0; k < islands_.size(); ++k)
    moved += islands_[k].modes;
  from_real_ = body_.real.data();
  from_imaginary_ = body_.imaginary.data();
  const bool all_move = moved == sounding_;
  if (!all_move) {
    const std::size_t padded = body_.padded();
    std::copy_n(from_real_, padded, before_real_.data());
    std::copy_n(from_imaginary_, padded, before_imaginary_.data());
    from_real_ = before_real_.data();
    from_imaginary_ = before_imaginary_.data();
    ring(0, padded);
  }
  islands_foreseen_ = islands_foreseen_ && !has_outer_ && clock_ % kTidyEvery != 1;
  level_ = quiet_ = 0;
  const std::span<const std::size_t> near = lone_near_;
  touch_pressed(); // those that end now are added behind
  for (const std::size_t i : near) {
    const std::size_t level = granted(kContactWork, std::max(least_level_, exciters_[i].level));
    level_ = std::max(level_, level);
    if (level > 0 || !press_lone(i))
      touch_lone(i, level);
  }
  for (std::size_t k = 0; k < islands_.size(); ++k) {
    const std::size_t level = granted(island_work(k), island_level(k));
    level_ = std::max(level_, level);
    if (few(k)) {
      touch_lone(islands_.slots(k)[0], level);
      continue;
    }
    const Group group = pack(k, level, all_move);
    if (Packed& p = packed_[k]; group.slots.size() == 1 && !has_outer_) {
      p.foreseen = p.foreseen && islands_foreseen_;
      touch_alone(group.slots[0], group.modes, p.place, p.foresight, p.foreseen, level);
    } else {
      touch_many(group);
    }
    if (packed_[k].in_body)
      continue;
    const std::span<const std::uint32_t> modes = islands_.modes(k);
    scatter(modes, group.modes.real + packed_[k].skip, body_.real);
    scatter(modes, group.modes.imaginary + packed_[k].skip, body_.imaginary);
  }
  islands_foreseen_ = !has_outer_;
  gather_pressed();
}

} // namespace tactus::contact
