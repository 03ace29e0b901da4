#pragma once

#include "core/geometry/surface.hpp"
#include "core/modal/radiation/radiation.hpp"
#include "core/modal/table/modal_table.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace tactus::modal {

/// A table and the data derived from it alone; shared by all models of the body. It may combine two
/// bodies in one list of modes: a body and the board on which it lies.
struct LoadedTable {
  ModalTable table;
  Surface surface;
  RadiatingSurface radiating; ///< surface of one body; if there are two, each part has its own
  /// The table's shapes [V][K][3], vertex by vertex, so that a hit reads three vertices and not all
  /// modes' surfaces; `table.shape` is empty. Empty: unit gain.
  std::vector<float> shape;

  explicit LoadedTable(ModalTable read);
  /// The same body in another shape, solved again: `share` relates the modes of `before` to those
  /// of the new table. The new table must have the triangles of `before`, and no board.
  LoadedTable(ModalTable solved, const LoadedTable& before, std::vector<ModeShare> share);
  /// Combines both. The modes are in order of frequency, each with its shape on its own body and
  /// zero on the other. The body's vertices and triangles come first, then those of the board,
  /// displaced by this vector, m, in the body's axes. Mass, inertia, material, air and shape
  /// parameters are those of the body. `refusal()` must be empty. Memory: 12 bytes for every mode
  /// of both at every vertex of both, besides the two tables.
  LoadedTable(std::shared_ptr<const LoadedTable> body, std::shared_ptr<const LoadedTable> board,
              const Vec3& displacement_m);
  /// The body solved again on the same board: the new body must follow the body of `before`.
  LoadedTable(const std::shared_ptr<const LoadedTable>& body, const LoadedTable& before);
  LoadedTable(const LoadedTable&) = delete; // `radiating` points to `surface`
  LoadedTable& operator=(const LoadedTable&) = delete;

  /// Reason why `body` cannot lie on `board`; else empty.
  [[nodiscard]] static std::string refusal(const LoadedTable& body, const LoadedTable& board);

  struct Part {
    std::shared_ptr<const LoadedTable> loaded;
    Vec3 displacement_m{};
    std::size_t first_vertex = 0, first_triangle = 0;
    std::vector<std::size_t> mode; ///< index in `table` of each of its own modes
  };
  std::vector<Part> parts;                ///< the body and the board; empty: one body
  std::vector<std::uint8_t> part_of_mode; ///< empty: one body
  static constexpr std::size_t kBoard = 1;

  /// The body alone: without its board if it has one.
  [[nodiscard]] const LoadedTable& body() const noexcept {
    return parts.empty() ? *this : *parts[0].loaded;
  }
  /// True if this is the body of `other` in another shape: positions given by triangle and weights
  /// of its corners are the same material points, and modes continue by `share`.
  [[nodiscard]] bool follows(const LoadedTable& other) const noexcept {
    return predecessor_ == other.serial_;
  }
  std::vector<ModeShare> share; ///< shares from the table that this table follows; empty: it
                                ///< follows none
  [[nodiscard]] std::size_t part_of_triangle(std::size_t triangle) const noexcept {
    return !parts.empty() && triangle >= parts[kBoard].first_triangle ? kBoard : 0;
  }
  [[nodiscard]] bool is_board_mode(std::size_t mode) const noexcept {
    return !part_of_mode.empty() && part_of_mode[mode] == kBoard;
  }
  /// The point of a part's surface nearest to a position in metres, in the tables' size.
  [[nodiscard]] SurfacePoint nearest_on(std::size_t part, const Vec3& point_m) const noexcept;

private:
  void order_shapes();
  [[nodiscard]] static std::uint64_t next_serial() noexcept;

  std::uint64_t serial_ = next_serial(), predecessor_ = 0; ///< 0: none
};

} // namespace tactus::modal
