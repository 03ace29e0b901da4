#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// Axis-parallel boxes in a balanced tree, which finds the boxes near a given box in logarithmic
/// time.
class BoxTree {
public:
  explicit BoxTree(std::vector<Box> boxes);

  /// Calls use(index) for each box that is within `distance` (m) of `box` along every axis, until
  /// it returns false.
  template <class Use> void for_each_near(const Box& box, double distance, Use&& use) const {
    std::array<std::size_t, 64> open{};
    std::size_t depth = 0;
    if (!nodes_.empty())
      open[depth++] = 0;
    while (depth > 0) {
      const Node& node = nodes_[open[--depth]];
      if (are_separated(node.box, box, distance))
        continue;
      if (node.right > 0) {
        open[depth++] = node.right;
        open[depth++] = static_cast<std::size_t>(&node - nodes_.data()) + 1;
        continue;
      }
      for (std::size_t i = node.first; i < node.last; ++i)
        if (!are_separated(boxes_[order_[i]], box, distance) && !use(order_[i]))
          return;
    }
  }

private:
  struct Node {
    Box box;
    std::size_t first, last; ///< positions in order_
    std::size_t right;       ///< index of the right child, 0 for a leaf; the left child follows its
                             ///< parent
  };
  static bool are_separated(const Box& a, const Box& b, double distance) noexcept {
    return a.low.x > b.high.x + distance || b.low.x > a.high.x + distance ||
           a.low.y > b.high.y + distance || b.low.y > a.high.y + distance ||
           a.low.z > b.high.z + distance || b.low.z > a.high.z + distance;
  }
  void build(std::size_t first, std::size_t last);

  std::vector<Box> boxes_;
  std::vector<std::size_t> order_;
  std::vector<Node> nodes_;
};

} // namespace tactus::fem
