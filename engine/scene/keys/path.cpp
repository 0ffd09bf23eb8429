// Keys of paths, from the list of their kinds, and the reading of a path of any kind.
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;

using P = PathRecipe;

constexpr Key kKeyframe[] = {
    number<&Keyframe::time>("time", "s", kTime, "When.").needed("a time in seconds"),
    vector<&Keyframe::pose, &Pose::position>("position", "m", "Default: where the body starts.")
        .without_default(),
    row("rotation", ValueType::quaternion, "",
        "Quaternion [x, y, z, w]. Default: as the body starts."),
    kRotationDeg,
};

constexpr Key kPose[] = {
    needed_reference<&PoseRecipe::body>("body", "the name of a body",
                                        "Any body of the scene: also \"chain/0\" or "
                                        "\"instance/body\"."),
    kPosition.to<&PoseRecipe::pose>(),
    kRotation,
    kRotationDeg,
};

constexpr Key kFreeNumber[] = {
    needed_reference<&FreeRecipe::of>(
        "of", "a path such as \"joints/3/length\"",
        "joints/WHICH/KEY with the key length (of a distance), pitch (of a screw), anchor_a, "
        "anchor_b, axis_a or "
        "axis_b; cables/WHICH/KEY with length, anchor_a, anchor_b or over/NUMBER/radius; "
        "gears/WHICH/ratio; belts/WHICH/pulleys/NUMBER/radius. WHICH is a number, from 0, or a "
        "name. Of named surfaces and curves of surface joints: surfaces/NAME/points/I/J, "
        "surfaces/NAME/faces/F/weights/I/J, curves/NAME/points/I."),
    number<&FreeRecipe::least>("min", "", kAnyNumber, "Least value of a quantity of one number."),
    number<&FreeRecipe::most>("max", "", kAnyNumber, "Greatest value of such a quantity."),
};

constexpr std::string_view kKinematicBody = "the name of a kinematic body";

struct Ignore {
  void operator()(const PathKey&, auto&) const {}
};
template <class Path>
concept HasNumbers = requires(Path path) {
  Path::scene_keys(path, Ignore{});
};

Key key_of(const PathKey& from) {
  Key key = row(from.key, ValueType::vector, from.unit, from.about).once(from.old);
  switch (from.form) {
    case PathForm::vector:
      break;
    case PathForm::angles:
      key.range = kDegrees;
      break;
    case PathForm::vector_or_number:
      key.type = ValueType::vector_or_number;
      break;
    case PathForm::not_negative:
      key.range = kNotNegative;
      [[fallthrough]];
    case PathForm::number:
      key.type = ValueType::number;
  }
  return key;
}

/// All sets of keys, with storage for the text that their views refer to.
struct Table {
  std::vector<std::string_view> names;
  std::string any_of, complaint;
  std::vector<std::string> others;
  std::vector<Exclusive> exclusive;
  std::array<AnyOf, 1> needs;
  std::array<Beside, 1> beside{{{"loop", "keyframes",
                                 "found \"loop\" without \"keyframes\", expected it with them "
                                 "only: other paths are periodic"}}};
  std::vector<std::vector<Key>> keys;
  std::vector<KeySet> sets;  // of "path", then of the kinds that are objects

  template <class... Kinds>
  explicit Table(const std::variant<Kinds...>*) {
    keys.push_back(
        {needed_reference<&P::body>("body", kKinematicBody, "A body whose motion is kinematic.")});
    keys.reserve(sizeof...(Kinds) + 1);
    (add<Kinds>(), ...);
    keys.front().push_back(
        flag("loop", "Repeat the path forever; the last key must equal the first pose.")
            .or_else(false));
    join();
    const KeySet path{.what = "path",
                      .about = "The path of a kinematic body, in the frame of the scene or prefab.",
                      .keys = keys.front(),
                      .exclusive = exclusive,
                      .any_of = needs,
                      .beside = beside};
    sets.insert(sets.begin(), path);
  }
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

  template <class Path>
  void add() {
    names.push_back(Path::name);
    if constexpr (HasNumbers<Path>) {
      keys.front().push_back(object(Path::name, Path::name, Path::about));
      std::vector<Key>& own = keys.emplace_back();
      Path path;
      Path::scene_keys(path, [&](const PathKey& key, auto&) { own.push_back(key_of(key)); });
      sets.push_back({Path::name, Path::about, own});
    } else {  // a list of objects named like one of its members
      keys.front().push_back(
          objects(Path::name, Path::name.substr(0, Path::name.size() - 1), Path::about));
    }
  }

  /// A path has exactly one kind.
  void join() {
    complaint = "found no \"" + std::string(names.front()) + "\", expected ";
    others.resize(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string name(names[i]);
      any_of += (i > 0 ? " " : "") + name;
      complaint += (i == 0 ? "\"" : i + 1 == names.size() ? " or \"" : ", \"") + name + "\"";
      for (std::size_t k = i + 1; k < names.size(); ++k)
        others[i] += (others[i].empty() ? "" : " ") + std::string(names[k]);
      if (!others[i].empty()) exclusive.push_back({names[i], others[i]});
    }
    needs[0] = {any_of, complaint};
  }
};

const Table& table() {
  static const Table made(static_cast<const PathKinds*>(nullptr));
  return made;
}

/// A missing position or rotation follows from the start of the body.
std::optional<Keyframe> read_key(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "keyframe");
  Keyframe key{std::numeric_limits<Real>::quiet_NaN(), {Vec3(kLeftOpen), kIdentity}};
  read_rows(reading, from, key);
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
    from.error_value(Keyframes::name,
                     path.loop ? "two keyframes or more for a loop" : "one keyframe or more");
}

/// A kind whose values are the members of an object.
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

constinit const KeySet keys::keyframe{"keyframe", "A pose at a time.", kKeyframe};

constinit const KeySet keys::pose{"pose", "The pose of a body at the start.", kPose};

constinit const KeySet keys::free_number{
    "free_number",
    "A number that assembly may change, within bounds; a text stands for one without bounds.",
    kFreeNumber};

std::span<const KeySet> path_key_sets() { return table().sets; }

bool read_members(const Reading& reading, const Reader& from, PoseRecipe& pose) {
  return read_rows(reading, from, pose);
}

bool read_members(const Reading& reading, const Reader& from, PathRecipe& path) {
  const bool is_whole = read_rows(reading, from, path);
  read_curve(reading, from, path.path.curve);
  if (!from.has(Keyframes::name)) from.flag("loop");
  return is_whole;
}

}  // namespace pantin::detail
