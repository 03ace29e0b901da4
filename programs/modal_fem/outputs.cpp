#include "programs/modal_fem/outputs.hpp"

#include "fem/io/words.hpp"
#include "programs/modal_fem/budget.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace tactus::fem {
namespace {

namespace fs = std::filesystem;

struct Output {
  const char* option;
  std::string path;
  double bytes = 0;
};

/// What each output takes. Text: 45 bytes a node, 7 a number of a shape's component or node.
std::vector<Output> outputs(const Order& order, const MeshSize& mesh) {
  const double vertices = mesh.skin_triangles / 2;
  const double modes = std::min(static_cast<double>(order.modes), mesh.dofs());
  const double corners = mesh.nodes_on_planes < 1 ? 10 : 20;
  std::vector<Output> all{
      {"-o", order.output,
       12 * vertices * (modes + 1) + 12 * mesh.skin_triangles +
           (order.residual ? 4 * vertices : 0)},
      {"--csv", order.csv, 80 * modes},
      {"--vtu", order.vtu,
       mesh.nodes * (40 + 33 * std::min(modes, 20.0)) + mesh.elements * (10 + 7 * corners)},
      {"--sheet", order.sheet, 1e6},
      {"--export-inp", order.inp, 70 * mesh.nodes + mesh.elements * (10 + 8 * corners)},
      {"--export-petsc", order.petsc, 12 * (18 + 6) * mesh.node_pairs},
  };
  std::erase_if(all, [](const Output& o) { return o.path.empty(); });
  return all;
}

fs::path folder_of(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return folder.empty() ? "." : folder;
}

} // namespace

void check_output(const std::string& option, const std::string& path) {
  const std::string who = option + " " + path;
  const fs::path folder = folder_of(path);
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw Refusal(who + ": there is no folder " + folder.string());
  if (fs::path(path).filename().empty() || fs::is_directory(path, error))
    throw Refusal(who + " is a folder, expected the name of a file in it");
  if (fs::exists(path, error) && !fs::is_regular_file(path, error))
    throw Refusal(who +
                  " is a device or pipe, expected a file: outputs appear complete or not at all");
  if (fs::exists(path, error) && ::access(path.c_str(), W_OK) != 0)
    throw Refusal(who + ": cannot write: " + std::strerror(errno));
  // The file is written beside its place and renamed: that must be possible, and is tried.
  std::string trial = path + ".pXXXXXX"; // as long as .partial
  const int file = ::mkstemp(trial.data());
  if (file < 0)
    throw Refusal(who + ": cannot write: " + std::strerror(errno));
  ::close(file);
  ::unlink(trial.c_str());
}

void check_outputs(const Order& order) {
  const auto all = outputs(order, {});
  const auto same = [](const std::string& a, const std::string& b) {
    return fs::weakly_canonical(fs::absolute(a)) == fs::weakly_canonical(fs::absolute(b));
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    check_output(all[i].option, all[i].path);
    if (order.is_file && same(all[i].path, order.body))
      throw Refusal(std::string(all[i].option) + " " + all[i].path + " is the body's own file");
    for (std::size_t j = 0; j < i; ++j)
      if (same(all[i].path, all[j].path))
        throw Refusal(std::string(all[j].option) + " and " + all[i].option +
                      " name the same file " + all[i].path);
  }
}

void check_room(const Order& order, const MeshSize& mesh) {
  for (const Output& out : outputs(order, mesh)) {
    struct statvfs disk {};
    if (::statvfs(folder_of(out.path).c_str(), &disk) != 0)
      continue; // the write itself will tell
    const double room = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
    if (out.bytes > room)
      throw TooLarge(std::string(out.option) + " " + out.path + " would take " +
                     words_of_bytes(out.bytes) + ", the disk has room for " + words_of_bytes(room));
  }
}

} // namespace tactus::fem
