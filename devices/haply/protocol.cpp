#include "devices/haply/protocol.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>

namespace tactus::devices::haply {
namespace {

using Json = nlohmann::json;

/// Null when there is no such member.
const Json* member(const Json& object, const char* name) {
  if (!object.is_object())
    return nullptr;
  const auto found = object.find(name);
  return found != object.end() ? &*found : nullptr;
}

std::string text(const Json& object, const char* name) {
  const Json* value = member(object, name);
  return value && value->is_string() ? value->get<std::string>() : std::string();
}

std::optional<double> number(const Json& object, const char* name) {
  const Json* value = member(object, name);
  if (!value || !value->is_number())
    return {};
  const double answer = value->get<double>();
  return std::isfinite(answer) ? std::optional(answer) : std::nullopt;
}

std::optional<bool> read_bool(const Json& object, const char* name) {
  const Json* value = member(object, name);
  return value && value->is_boolean() ? std::optional(value->get<bool>()) : std::nullopt;
}

std::optional<Vec3> vector(const Json* object) {
  if (!object)
    return {};
  const auto x = number(*object, "x"), y = number(*object, "y"), z = number(*object, "z");
  return x && y && z ? std::optional(Vec3{*x, *y, *z}) : std::nullopt;
}

std::optional<Vec3> placed(const Json& state, const char* name) {
  const auto v = vector(member(state, name));
  return v ? std::optional(to_project(*v)) : std::nullopt;
}

/// Parts that the service omits have the values of the identity.
std::optional<Transform> placement(const Json* object) {
  if (!object || !object->is_object())
    return {};
  Transform placed;
  if (const auto position = vector(member(*object, "position")))
    placed.pose.position = to_project(*position);
  if (const auto scale = vector(member(*object, "scale")))
    placed.scale = {scale->x, scale->z, scale->y};
  if (const Json* rotation = member(*object, "rotation")) {
    const Vec3 axis = to_project(vector(rotation).value_or(Vec3{}));
    placed.pose.rotation = {number(*rotation, "w").value_or(1), axis.x, axis.y, axis.z};
  }
  return placed;
}

DeviceState device_state(const Json& device) {
  DeviceState seen;
  seen.id = text(device, "device_id");
  if (const Json* config = member(device, "config")) {
    seen.type = text(*config, "type");
    seen.firmware = text(*config, "extended_firmware_version");
    seen.preset = text(*config, "preset");
    seen.mount = placement(member(*config, "mount"));
    if (const Json* basis = member(*config, "basis"))
      seen.basis = text(*basis, "permutation");
  }
  if (const Json* state = member(device, "state")) {
    seen.position = placed(*state, "cursor_position");
    seen.velocity = placed(*state, "cursor_velocity");
    seen.workspace = placement(member(*state, "transform"));
  }
  if (const Json* status = member(device, "status"))
    seen.calibrated = read_bool(*status, "calibrated");
  return seen;
}

/// Axis times angle of a unit quaternion, in the project frame.
std::optional<Vec3> rotation(const Json* orientation) {
  const auto v = vector(orientation);
  const auto w = orientation ? number(*orientation, "w") : std::nullopt;
  if (!v || !w)
    return {};
  const double sine = norm(*v);
  if (!(sine > 1e-12))
    return Vec3{};
  const Vec3 axis = *v * ((*w < 0 ? -1.0 : 1.0) / sine);
  return to_project(axis * (2 * std::atan2(sine, std::abs(*w))));
}

void read_grip(const Json& grip, Message& message) {
  const Json* state = member(grip, "state");
  if (!state)
    return;
  message.rotation = rotation(member(*state, "orientation"));
  if (const auto pressed = read_bool(*state, "button"))
    message.buttons = *pressed ? 1u : 0u;
  const Json* buttons = member(*state, "buttons");
  if (!buttons || !buttons->is_object())
    return;
  constexpr std::array<const char*, 3> names{"a", "b", "c"};
  std::uint32_t mask = 0;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (read_bool(*buttons, names[i]).value_or(false))
      mask |= 1u << i;
  message.buttons = mask;
}

} // namespace

std::optional<Message> parse(std::string_view source) {
  const Json root = Json::parse(source.begin(), source.end(), nullptr, false);
  if (!root.is_object())
    return {};
  Message message;
  if (const Json* list = member(root, "inverse3"); list && list->is_array())
    for (const Json& device : *list)
      message.devices.push_back(device_state(device));
  for (const char* kind : {"wireless_verse_grip", "verse_grip"}) {
    const Json* list = member(root, kind);
    if (list && list->is_array() && !list->empty() && !message.rotation)
      read_grip(list->front(), message);
  }
  return message;
}

namespace {

Json device_message(std::string_view device_id, const Vec3& force_n, ForceKey key) {
  const Vec3 f = to_service(force_n);
  const Json force{{"x", f.x}, {"y", f.y}, {"z", f.z}};
  Json command{{"vector", force}};
  if (key == ForceKey::kBoth)
    command["values"] = force;
  return {{"device_id", device_id}, {"commands", {{"set_cursor_force", command}}}};
}

Json message_of(Json device) {
  Json message;
  message["inverse3"].push_back(std::move(device));
  return message;
}

} // namespace

std::string force_message(std::string_view device_id, const Vec3& force_n, ForceKey key) {
  return message_of(device_message(device_id, force_n, key)).dump();
}

std::string first_message(std::string_view device_id) {
  Json device = device_message(device_id, {}, ForceKey::kBoth);
  device["configure"]["preset"]["preset"] = kPreset;
  Json message = message_of(std::move(device));
  Json& configure = message["session"]["configure"];
  configure["profile"]["name"] = "tactus";
  configure["basis"]["permutation"] = kBasis;
  return message.dump();
}

std::string status_request(std::string_view device_id, bool basis) {
  Json message = message_of(device_message(device_id, {}, ForceKey::kBoth));
  message["session"]["force_render_full_state"] = Json::object();
  if (basis)
    message["session"]["configure"]["basis"]["permutation"] = kBasis;
  return message.dump();
}

} // namespace tactus::devices::haply
