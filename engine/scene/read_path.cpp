// The path of a kinematic body, of whatever kind.
#include <limits>
#include <string>

#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

/// What is absent follows from where the body starts.
std::optional<Keyframe> read_key(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "keyframe");
  Keyframe key;
  key.time = from.number("time", std::numeric_limits<Real>::quiet_NaN());
  key.pose.position = from.vec("position", Vec3(kLeftOpen));
  key.pose.rotation = from.rotation(Quat(kLeftOpen, kLeftOpen, kLeftOpen, kLeftOpen));
  if (std::isnan(key.time)) return std::nullopt;
  return key;
}

void read_kind(const Reading& reading, const Reader& from, Keyframes& path) {
  path.loop = from.flag("loop");
  const std::vector<NodeId> nodes = from.items(Keyframes::name);
  for (NodeId node : nodes) {
    const auto key = read_key(reading, node);
    if (!key) continue;
    if (!path.keys.empty() && !(key->time > path.keys.back().time))
      reading.diagnostics.error(node, "found time " + written(key->time) + " after " +
                                          written(path.keys.back().time) +
                                          ", expected a later one");
    path.keys.push_back(*key);
  }
  const std::size_t least = path.loop ? 2 : 1;
  if (nodes.size() < least)
    reading.diagnostics.error_value(
        from.find(Keyframes::name),
        path.loop ? "two keyframes or more for a loop" : "one keyframe or more");
}

/// A kind whose numbers are the members of an object.
template <class Path>
void read_kind(const Reading& reading, const Reader& outer, Path& path) {
  const Reader from = reading.open(outer.find(Path::name), Path::name);
  Path::scene_keys(path, [&](const PathKey& key, auto& value) {
    if (!from.has(key.key)) return;
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, Vec3>)
      value =
          key.scale * (key.form == PathForm::vector_or_number ? from.vec_or_number(key.key, value)
                                                              : from.vec(key.key, value));
    else
      value = key.scale * from.number(key.key, value);
  });
}

template <class... Kinds>
void read_curve(const Reading& reading, const Reader& from, std::variant<Kinds...>& curve) {
  const auto read = [&]<class Path>(Path path) {
    if (!from.has(Path::name)) return;
    read_kind(reading, from, path);
    curve = std::move(path);
  };
  (read(Kinds{}), ...);
}

}  // namespace

std::optional<PathRecipe> read_path(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "path");
  PathRecipe path;
  const auto body = from.reference("body");
  read_curve(reading, from, path.path.curve);
  if (!from.has(Keyframes::name)) from.flag("loop");
  if (!body) return std::nullopt;
  path.body = *body;
  return path;
}

}  // namespace pantin::detail
