#include "fem/mesh/box_tree.hpp"

#include <algorithm>
#include <numeric>

namespace tactus::fem {

BoxTree::BoxTree(std::vector<Box> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  nodes_.reserve(boxes_.size());
  if (!boxes_.empty())
    build(0, boxes_.size());
}

void BoxTree::build(std::size_t first, std::size_t last) {
  constexpr std::size_t kLeaf = 4;
  Box whole = boxes_[order_[first]];
  for (std::size_t i = first + 1; i < last; ++i)
    for (int k = 0; k < 3; ++k) {
      whole.low[k] = std::min(whole.low[k], boxes_[order_[i]].low[k]);
      whole.high[k] = std::max(whole.high[k], boxes_[order_[i]].high[k]);
    }
  const std::size_t self = nodes_.size();
  nodes_.push_back({whole, first, last, 0});
  if (last - first <= kLeaf)
    return;
  const Vec3 size = whole.size();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::size_t middle = first + (last - first) / 2;
  const auto begin = order_.begin();
  std::nth_element(begin + static_cast<std::ptrdiff_t>(first),
                   begin + static_cast<std::ptrdiff_t>(middle),
                   begin + static_cast<std::ptrdiff_t>(last), [&](std::size_t a, std::size_t b) {
                     const double p = boxes_[a].low[axis] + boxes_[a].high[axis],
                                  q = boxes_[b].low[axis] + boxes_[b].high[axis];
                     return p != q ? p < q : a < b; // the same tree on every run
                   });
  build(first, middle);
  nodes_[self].right = nodes_.size();
  build(middle, last);
}

} // namespace tactus::fem
