#pragma once

#include "core/modal/body/body_model.hpp"
#include "files/worker.hpp"

#include <cstdint>
#include <memory>
#include <string>

namespace tactus::modal {

/// A table's file and the number of the request that named it, 0 if there is none.
struct TableFile {
  std::string path, name; ///< as the user wrote it
  std::uint64_t number = 0;
};

/// The table files of the current body.
struct TablesInUse {
  TableFile body, board;    ///< the board's path is empty if there is none
  std::uint64_t solved = 0; ///< number of the solution for the body's shape; 0 if as read
};

/// Reads tables and builds the model of a body. A table that cannot be read is reported once, and
/// the previous tables stay in use.
class TableJob {
public:
  struct Request {
    TableFile body, board;
    Vec3 board_displacement_m{}; ///< in the body's axes
    /// Another shape of the body with the number `solved_body`; replaces the body's table unless
    /// null.
    std::shared_ptr<const LoadedTable> solved;
    std::uint64_t solved_body = 0, solved_number = 0;
    BodySettings settings;
    std::uint64_t shaped_body = 0; ///< number of the body that `settings` displaces
  };
  struct Answer {
    TablesInUse in_use;
    std::shared_ptr<const LoadedTable> table;
    std::unique_ptr<BodyModel> model;
  };
  static constexpr const char* kOutOfMemory = "not enough memory: the body sounds on as before";

  double work(const Request& request, Turn<Answer>& turn);
  /// The reason why a table does not support the requested radiation; empty if it does. `instead`:
  /// the radiation that is used in its place.
  [[nodiscard]] static std::string radiation_refusal(const LoadedTable& table, Radiation radiation,
                                                     Radiation instead);

private:
  struct Tables {
    TablesInUse in_use;
    std::shared_ptr<const LoadedTable> body, board, both;
    Vec3 board_displacement_m{};
  };
  /// Starts the next change: sets `changed` and the subject of its error text. False if nothing is
  /// requested.
  [[nodiscard]] bool next(const Request& request, Tables& changed, std::string& subject,
                          std::string& refusal);
  [[nodiscard]] std::string join(Tables changed);

  Tables tables_;
  std::uint64_t body_seen_ = 0, board_seen_ = 0, solved_seen_ = 0; ///< numbers of the last handled
                                                                   ///< requests
  std::string radiation_refusal_;                                  ///< as last reported
};

using TableWorker = Worker<TableJob>;

} // namespace tactus::modal
