#include "core/contact/excited_body.hpp"

#include <algorithm>
#include <cmath>

/// Advances a body with several islands of contacts by a sample. Each island has steps of its own
/// length. First all modes advance freely by a sample. Then each island starts from the state
/// before the sample and overwrites the modes that it moves.
namespace tactus::contact {
namespace {

constexpr std::size_t kContactWork = 64; // number of multiplications that take as long as a
                                         // contact's law

bool contiguous(std::span<const std::uint32_t> modes) noexcept {
  return !modes.empty() && modes.back() - modes.front() + 1 == modes.size();
}

void scatter(std::span<const std::uint32_t> modes, const double* from, ModeArray& to) noexcept {
  for (std::size_t k = 0; k < modes.size(); ++k)
    to[modes[k]] = from[k];
}

/// Copies the values of the modes to the lanes after the first `skip` lanes; all other lanes get
/// the value `elsewhere`.
void gather_lanes(std::span<const std::uint32_t> modes, std::size_t skip, const double* from,
                  double elsewhere, std::span<double> lanes) noexcept {
  double* const destination = lanes.data() + skip;
  std::fill(lanes.data(), destination, elsewhere);
  if (contiguous(modes))
    std::copy_n(from + modes.front(), modes.size(), destination);
  else
    std::transform(modes.begin(), modes.end(), destination,
                   [&](std::uint32_t k) { return from[k]; });
  std::fill(destination + modes.size(), lanes.data() + lanes.size(), elsewhere);
}

} // namespace

/// Divides all exciters in use into islands, and lists the single contacts.
void ExcitedBody::find_islands_in_use() noexcept {
  sorted_.clear();
  for (std::size_t i = 0; i < exciters_.size(); ++i)
    if (exciters_[i].kind != Exciter::Kind::kNone)
      sorted_.push_back(i);
  used_ = sorted_.size();
  point_modes_.divide(sorted_, in_use_);
  sorted_.clear();
  single_.clear();
  sleep_until_.assign(in_use_.size(), 0);
  for (std::size_t k = 0; k < in_use_.size(); ++k) {
    const std::span<const std::size_t> slots = in_use_.slots(k);
    for (const std::size_t i : slots)
      island_of_[i] = k;
    const bool single = used_ > 1 && slots.size() == 1 && in_use_.modes(k).size() <= kFewModes;
    std::vector<std::size_t>& list = single ? single_ : sorted_;
    list.insert(list.end(), slots.begin(), slots.end());
  }
}

/// Checks whether the near contacts are one island whose modes lie close together. If so, it is
/// solved in the body's own arrays.
void ExcitedBody::find_range() noexcept {
  const std::size_t padded = body_.padded();
  one_range_ = range_known_ = true;
  range_first_ = 0;
  range_end_ = padded;
  const bool all_move = std::none_of(near_slots_.begin(), near_slots_.end(),
                                     [this](std::size_t i) { return point_modes_[i].empty(); });
  const bool one_moves_all =
      std::any_of(near_slots_.begin(), near_slots_.end(),
                  [this](std::size_t i) { return point_modes_[i].size() == active_modes_; });
  if (near_ == 0 || (all_move && one_moves_all))
    return;
  std::span<const std::uint32_t> modes = point_modes_[near_slots_[0]];
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

void ExcitedBody::divide() noexcept {
  if (islands_valid_)
    return;
  point_modes_.divide(near_slots_, islands_);
  islands_valid_ = true;
  packed_.clear();
}

bool ExcitedBody::is_single(std::size_t island) const noexcept {
  return islands_[island].slots == 1 && islands_[island].modes <= kFewModes;
}

/// Assigns each island its part of the packed arrays.
void ExcitedBody::assign_packed_ranges() noexcept {
  std::size_t at = 0, shapes_at = 0, block_at = 0;
  packed_.clear();
  for (std::size_t k = 0; k < islands_.size(); ++k) {
    const std::span<const std::uint32_t> modes = islands_.modes(k);
    const std::size_t count = islands_[k].slots,
                      skip = contiguous(modes) ? modes.front() % kModeLanes : 0,
                      lanes = is_single(k) ? 0 : whole_lanes(skip + modes.size()),
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

/// Prepares an island as if no other modes existed: gathers its modes contiguously. If they are
/// contiguous in the body and `in_body` is true (the body's arrays hold the state before the
/// sample), the state stays in the body's arrays. Modes of other islands in the same group of lanes
/// then have the pole 1 and no force, so that nothing changes them.
ExcitedBody::Group ExcitedBody::pack(std::size_t island, std::size_t level_index,
                                     bool in_body) noexcept {
  Packed& p = packed_[island];
  const std::span<const std::size_t> slots = islands_.slots(island);
  const std::span<const std::uint32_t> modes = islands_.modes(island);
  const auto gather = [&](double* part, const double* from, double elsewhere) {
    gather_lanes(modes, p.skip, from, elsewhere, {part, p.lanes});
  };
  shapes_.clear();
  for (std::size_t c = 0; c < slots.size(); ++c)
    shapes_.push_back(packed_shapes_.data() + p.shapes_at + c * p.lanes);
  ModalBody::Level& to = packed_level_;
  p.in_body = in_body && contiguous(modes);
  const std::size_t first = p.in_body ? modes.front() - p.skip : 0;
  const Group group{slots,
                    {p.in_body ? body_.real.data() + first : packed_real_.data() + p.at,
                     p.in_body ? body_.imaginary.data() + first : packed_imaginary_.data() + p.at,
                     to.pole_real.data() + p.at, to.pole_imaginary.data() + p.at,
                     to.response_real.data() + p.at, to.response_imaginary.data() + p.at,
                     to.mean_real.data() + p.at, to.mean_imaginary.data() + p.at,
                     to.mobility.data() + p.at, packed_decay_over_omega_.data() + p.at, p.lanes},
                    p.skip + modes.size(),
                    level_index};
  system_.select(p.block);
  if (!p.ready) {
    gather(packed_decay_over_omega_.data() + p.at, body_.decay_over_omega.data(), 0);
    for (std::size_t c = 0; c < slots.size(); ++c)
      gather(packed_shapes_.data() + p.shapes_at + c * p.lanes, point_shape_[slots[c]].data(), 0);
  }
  if (!p.ready || p.level != level_index) {
    const ModalBody::Level& from = body_.level(level_index);
    gather(to.pole_real.data() + p.at, from.pole_real.data(), 1);
    gather(to.pole_imaginary.data() + p.at, from.pole_imaginary.data(), 0);
    gather(to.response_real.data() + p.at, from.response_real.data(), 0);
    gather(to.response_imaginary.data() + p.at, from.response_imaginary.data(), 0);
    gather(to.mean_real.data() + p.at, from.mean_real.data(), 0);
    gather(to.mean_imaginary.data() + p.at, from.mean_imaginary.data(), 0);
    gather(to.mobility.data() + p.at, from.mobility.data(), 0);
    couple(group);
    if (slots.size() == 1)
      p.point = make_point_view(group.modes, shapes_[0], packed_points_.from(p.at));
    p.level = level_index;
    p.ready = true;
    p.predicted = false;
  }
  if (!p.in_body) {
    gather(packed_real_.data() + p.at, from_real_, 0);
    gather(packed_imaginary_.data() + p.at, from_imaginary_, 0);
  }
  return group;
}

std::size_t ExcitedBody::island_level(std::size_t island) const noexcept {
  std::size_t level = min_level_;
  for (const std::size_t i : islands_.slots(island))
    level = std::max(level, exciters_[i].level);
  return level;
}

std::size_t ExcitedBody::island_work(std::size_t island) const noexcept {
  const Islands::Island& k = islands_[island];
  return k.slots == 1 ? kContactWork + 2 * k.modes : work(k.slots, k.modes);
}

/// The finest level, up to `level`, whose steps together take at most share_ multiplications, if
/// one step takes `work`.
std::size_t ExcitedBody::affordable_level(std::size_t work, std::size_t level) const noexcept {
  while (level > 0 && (work << level) > share_)
    --level;
  return level;
}

/// Limits the work of a sample to kMaxWork for all fine steps together. While the sum exceeds
/// kMaxWork, the islands that take most of it get coarser steps. The result does not depend on the
/// islands' order.
void ExcitedBody::distribute_work() noexcept {
  share_ = kMaxWork;
  if (std::all_of(near_slots_.begin(), near_slots_.end(),
                  [&](std::size_t i) { return std::max(min_level_, exciters_[i].level) == 0; }) &&
      std::all_of(single_at_level_.begin() + 1, single_at_level_.end(),
                  [](std::size_t n) { return n == 0; }))
    return; // no contact needs fine steps
  share_ = 2 * kMaxWork;
  std::size_t sum = 0;
  do {
    share_ /= 2;
    sum = 0;
    for (std::size_t level = 1; level < kLevels; ++level)
      if (const std::size_t fine = affordable_level(kContactWork, level); fine > 0)
        sum += single_at_level_[level] * (kContactWork << fine);
    for (std::size_t k = 0; k < islands_.size(); ++k)
      if (const std::size_t fine = affordable_level(island_work(k), island_level(k)); fine > 0)
        sum += island_work(k) << fine;
  } while (sum > kMaxWork && share_ > kContactWork);
}

void ExcitedBody::step_islands() noexcept {
  ringing_ = true;
  predicted_ = coupled_ = false;
  divide();
  if (packed_.empty())
    assign_packed_ranges();
  distribute_work();
  std::size_t moved = pressed_.size(); // modes of the islands
  for (const std::size_t i : single_near_)
    moved += few_[i].count;
  for (std::size_t k = 0; k < islands_.size(); ++k)
    moved += islands_[k].modes;
  from_real_ = body_.real.data();
  from_imaginary_ = body_.imaginary.data();
  const bool all_move = moved == active_modes_;
  if (!all_move) {
    const std::size_t padded = body_.padded();
    std::copy_n(from_real_, padded, before_real_.data());
    std::copy_n(from_imaginary_, padded, before_imaginary_.data());
    from_real_ = before_real_.data();
    from_imaginary_ = before_imaginary_.data();
    ring(0, padded);
  }
  islands_predicted_ = islands_predicted_ && clock_ % kFlushPeriod != 1;
  level_ = coarse_count_ = 0;
  const std::span<const std::size_t> near = single_near_;
  step_pressed(); // appends contacts that end to single_near_, after the range `near`
  for (const std::size_t i : near) {
    const std::size_t level =
        affordable_level(kContactWork, std::max(min_level_, exciters_[i].level));
    level_ = std::max(level_, level);
    if (level > 0 || !step_single_impact(i))
      step_single(i, level);
  }
  for (std::size_t k = 0; k < islands_.size(); ++k) {
    const std::size_t level = affordable_level(island_work(k), island_level(k));
    level_ = std::max(level_, level);
    if (is_single(k)) {
      step_single(islands_.slots(k)[0], level);
      continue;
    }
    const Group group = pack(k, level, all_move);
    if (Packed& p = packed_[k]; group.slots.size() == 1) {
      p.predicted = p.predicted && islands_predicted_;
      step_only_contact(group.slots[0], group.modes, p.point, p.prediction, p.predicted, level);
    } else {
      step_coupled(group);
    }
    if (packed_[k].in_body)
      continue;
    const std::span<const std::uint32_t> modes = islands_.modes(k);
    scatter(modes, group.modes.real + packed_[k].skip, body_.real);
    scatter(modes, group.modes.imaginary + packed_[k].skip, body_.imaginary);
  }
  islands_predicted_ = true;
  gather_pressed();
}

} // namespace tactus::contact
