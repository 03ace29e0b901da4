#include "externals/phantom/scene/named_scene.hpp"

#include "core/declaration_text.hpp"
#include "core/text.hpp"
#include "externals/phantom/scene/scene_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactus::phantom {
namespace {

constexpr double kLast = std::numeric_limits<double>::infinity();
constexpr Range kStiffness{"k", "N/m", 0, 1e5};

bool is_mesh(const haptic::Body& body) {
  return std::holds_alternative<haptic::MeshSurface>(body.shape);
}

} // namespace

NamedScene::Entry* NamedScene::find(const Atom& name) noexcept {
  const std::string text = text_of(name);
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& e) { return e.name == text; });
  return found == entries_.end() ? nullptr : &*found;
}

void NamedScene::remember_removed(const Entry& entry) {
  removed_.push_back({entry.body.key, entry.name, entry.is_number});
  if (removed_.size() > kMaxRemoved)
    removed_.pop_front();
}

std::string NamedScene::handle(Words words, const Host& host) {
  const Words rest = words.subspan(1);
  std::string refusal;
  if (is(words[0], "add"))
    refusal = add(rest, host);
  else if (is(words[0], "mat"))
    refusal = set_material(rest);
  else if (is(words[0], "move"))
    refusal = move(rest);
  else if (is(words[0], "del"))
    refusal = remove(rest);
  else if (is(words[0], "load"))
    refusal = load(rest, host);
  else if (is(words[0], "tool"))
    refusal = set_tool(rest);
  else if (is(words[0], "k")) {
    double k[1] = {};
    refusal = read_numbers(rest, {{kStiffness}}, k);
    if (refusal.empty())
      material_.stiffness_n_per_m = k[0];
  } else {
    return expected("scene", words[0], "add, mat, move, del, tool, k or load");
  }
  return refusal.empty() ? refusal : "scene " + text_of(words[0]) + ": " + refusal;
}

std::string NamedScene::add(Words words, const Host& host) {
  if (words.size() < 2)
    return "expected a name and a shape";
  ShapeChoice choice = choose_shape(words.subspan(1), host);
  if (!choice.refusal.empty())
    return std::move(choice.refusal);
  Entry* old = find(words[0]);
  Entry entry{text_of(words[0]), !words[0].is_word, {}, {}};
  entry.body.key = ++keys_;
  entry.body.shape = std::move(choice.shape);
  entry.body.pose = choice.pose;
  entry.body.material = material_;
  for (const Atom& word : words.subspan(1))
    entry.description += (entry.description.empty() ? "" : " ") + text_of(word);
  const auto same = std::count_if(entries_.begin(), entries_.end(), [&](const Entry& e) {
    return &e != old && is_mesh(e.body) == is_mesh(entry.body);
  });
  const std::size_t max = is_mesh(entry.body) ? kMaxMeshes : kMaxSolids;
  if (static_cast<std::size_t>(same) >= max)
    return std::to_string(max + 1) + (is_mesh(entry.body) ? " meshes" : " bodies") +
           ": expected at most " + std::to_string(max);
  if (old) {
    remember_removed(*old);
    *old = std::move(entry);
  } else {
    entries_.push_back(std::move(entry));
  }
  return {};
}

std::string NamedScene::set_material(Words words) {
  constexpr Range ranges[] = {kStiffness, {"b", "N s/m", 0, 1000}, {"mu", "", 0, 10}};
  Entry* entry = words.empty() ? nullptr : find(words[0]);
  if (!entry)
    return (words.empty() ? "" : text_of(words[0])) + ": no such body";
  const std::size_t given = words.size() - 1;
  if (given < 1 || given > 3)
    return "expected k, b and mu";
  double v[3] = {0, entry->body.material.damping_n_s_per_m, entry->body.material.friction};
  if (std::string refusal = read_numbers(words.subspan(1), std::span(ranges, given), v);
      !refusal.empty())
    return refusal;
  entry->body.material = {v[0], v[1], v[2]};
  return {};
}

std::string NamedScene::move(Words words) {
  constexpr Range ranges[] = {
      millimetres("x"), millimetres("y"), millimetres("z"), {"time", "ms", 0, 1e5}};
  Entry* entry = words.empty() ? nullptr : find(words[0]);
  if (!entry)
    return (words.empty() ? "" : text_of(words[0])) + ": no such body";
  double v[4] = {};
  const std::size_t count = words.size() > 4 ? 4 : 3;
  if (std::string refusal = read_numbers(words.subspan(1), std::span(ranges, count), v);
      !refusal.empty())
    return refusal;
  entry->body.pose.position = metres(v);
  entry->body.glide_s = v[3] * 1e-3;
  return {};
}

std::string NamedScene::remove(Words words) {
  if (words.size() != 1)
    return "expected a name or all";
  if (is(words[0], "all")) {
    for (const Entry& entry : entries_)
      remember_removed(entry);
    entries_.clear();
    return {};
  }
  const Entry* entry = find(words[0]);
  if (!entry)
    return text_of(words[0]) + ": no such body";
  remember_removed(*entry);
  entries_.erase(entries_.begin() + (entry - entries_.data()));
  return {};
}

std::string NamedScene::set_tool(Words words) {
  constexpr Range kRadius{"radius", "mm", 0, kMaxTool_mm};
  double mm[1] = {};
  if (std::string refusal = read_numbers(words, {{kRadius}}, mm); !refusal.empty())
    return refusal;
  if (mm[0] > 0 && mm[0] < kMinTool_mm)
    return "radius " + number_text(mm[0]) + " mm: expected 0 (a point) or " +
           number_text(kMinTool_mm) + ".." + number_text(kMaxTool_mm) + " mm";
  tool_radius_m_ = mm[0] * 1e-3;
  return {};
}

std::string NamedScene::load(Words words, const Host& host) {
  NamedScene changed = *this;
  std::string refusal =
      handle_file(words, "scene", host, [&](Words line) { return changed.handle(line, host); });
  if (refusal.empty())
    *this = std::move(changed);
  return refusal;
}

std::unique_ptr<const haptic::Scene> NamedScene::snapshot() const {
  auto scene = std::make_unique<haptic::Scene>();
  scene->tool_radius_m = tool_radius_m_;
  std::vector<const Entry*> ordered;
  for (const Entry& entry : entries_)
    ordered.push_back(&entry);
  const auto rank = [](const Entry* entry) { // names that are words come last
    return entry->is_number ? to_number(entry->name).value_or(kLast) : kLast;
  };
  std::stable_sort(ordered.begin(), ordered.end(),
                   [&](const Entry* a, const Entry* b) { return rank(a) < rank(b); });
  scene->bodies.reserve(ordered.size());
  for (const Entry* entry : ordered)
    scene->bodies.push_back(entry->body);
  return scene;
}

Atom NamedScene::name_of(std::uint64_t key) const noexcept {
  const auto atom = [](const std::string& name, bool is_number) {
    return is_number ? Atom(to_number(name).value_or(kLast)) : Atom(std::string_view(name));
  };
  for (const Entry& entry : entries_)
    if (entry.body.key == key)
      return atom(entry.name, entry.is_number);
  for (const RemovedBody& gone : removed_)
    if (gone.key == key)
      return atom(gone.name, gone.is_number);
  return Atom("-");
}

NamedScene::NamedMaximum NamedScene::max_of(double haptic::Material::*property) const {
  NamedMaximum found;
  for (const Entry& entry : entries_)
    if (entry.body.material.*property > found.value)
      found = {entry.name, entry.body.material.*property};
  return found;
}

void NamedScene::dump(Host& host) const {
  if (tool_radius_m_ > 0)
    host.info({"scene", "tool", tool_radius_m_ * 1e3});
  for (const Entry& entry : entries_) {
    const haptic::Material& m = entry.body.material;
    const Vec3 p = entry.body.pose.position * 1e3;
    host.info({"scene", "add", std::string_view(entry.name), std::string_view(entry.description)});
    host.info({"scene", "move", std::string_view(entry.name), p.x, p.y, p.z});
    host.info({"scene", "mat", std::string_view(entry.name), m.stiffness_n_per_m,
               m.damping_n_s_per_m, m.friction});
  }
}

} // namespace tactus::phantom
