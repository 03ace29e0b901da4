#include "externals/modal_impact~/table_worker.hpp"

#include "externals/modal_impact~/units.hpp"
#include "files/file_bytes.hpp"
#include "files/tables.hpp"

#include <cstddef>
#include <exception>
#include <string_view>
#include <utility>
#include <vector>

namespace tactus::modal {
namespace {

/// On failure returns null and sets `refusal`.
std::shared_ptr<const LoadedTable> read(const TableFile& file, std::string& refusal) {
  std::vector<std::byte> bytes;
  ModalTable table;
  refusal = files::read_file(file.path, bytes);
  if (refusal.empty())
    refusal = files::read_modal_table(bytes, table);
  return refusal.empty() ? std::make_shared<const LoadedTable>(std::move(table)) : nullptr;
}

} // namespace

std::string TableJob::radiation_refusal(const LoadedTable& table, Radiation radiation,
                                        Radiation instead) {
  const auto name = [](Radiation r) {
    return std::string(modal_impact::kRadiations[static_cast<std::size_t>(r)]);
  };
  const std::string_view missing = missing_arrays(table, radiation);
  return missing.empty() ? std::string()
                         : "radiation " + name(radiation) + ": the table has no arrays " +
                               std::string(missing) + "; using " + name(instead);
}

bool TableJob::next(const Request& request, Tables& changed, std::string& subject,
                    std::string& refusal) {
  if (std::exchange(body_seen_, request.body.number) != request.body.number) {
    subject = "load " + request.body.name + ": ";
    changed.body = read(request.body, refusal);
    changed.in_use.body = request.body;
    changed.in_use.solved = 0;
  } else if (std::exchange(board_seen_, request.board.number) != request.board.number) {
    subject = "board " + request.board.name + ": ";
    changed.board = request.board.path.empty() ? nullptr : read(request.board, refusal);
    changed.in_use.board = request.board;
    changed.board_displacement_m = request.board_displacement_m;
  } else if (std::exchange(solved_seen_, request.solved_number) != request.solved_number &&
             request.solved_body == changed.in_use.body.number) {
    subject = "resolve: ";
    changed.body = request.solved;
    changed.in_use.solved = request.solved_number;
  } else {
    return false;
  }
  return true;
}

/// Returns an empty text, or why the tables cannot be joined.
std::string TableJob::join(Tables changed) {
  if (!changed.body)
    return "no body is loaded: send load NAME first";
  if (!changed.board)
    changed.both = changed.body;
  else if (std::string refusal = LoadedTable::refusal(*changed.body, *changed.board);
           !refusal.empty())
    return refusal;
  else if (tables_.body && changed.body->follows(*tables_.body)) // a new shape of the same body on
                                                                 // the same board
    changed.both = std::make_shared<const LoadedTable>(changed.body, *tables_.both);
  else
    changed.both = std::make_shared<const LoadedTable>(changed.body, changed.board,
                                                       changed.board_displacement_m);
  tables_ = std::move(changed);
  return {};
}

/// Each call handles one table; the last call builds the model.
double TableJob::work(const Request& request, Turn<Answer>& turn) {
  std::string subject, refusal;
  try {
    if (Tables changed = tables_; next(request, changed, subject, refusal)) {
      if (refusal.empty())
        refusal = join(std::move(changed));
      if (!refusal.empty())
        turn.say(subject + refusal);
      return kDueNow;
    }
  } catch (const std::exception&) { // bad_alloc, or the length_error of a container
    turn.say(subject + "not enough memory");
    return kDueNow;
  }
  if (!tables_.both)
    return kNever;
  BodySettings settings = request.settings;
  if (request.shaped_body != tables_.in_use.body.number)
    settings.shape_displacement_m.clear();
  const Radiation usual = BodySettings().radiation;
  refusal = radiation_refusal(*tables_.both, settings.radiation, usual);
  if (!refusal.empty())
    settings.radiation = usual;
  if (std::exchange(radiation_refusal_, refusal) != refusal && !refusal.empty())
    turn.say(refusal);
  turn.hand_over(
      {tables_.in_use, tables_.both, std::make_unique<BodyModel>(tables_.both, settings)});
  return kNever;
}

} // namespace tactus::modal
