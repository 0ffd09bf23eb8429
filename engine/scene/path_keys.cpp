// Keys of paths, from the list of their kinds.
#include <array>
#include <string>
#include <vector>

#include "engine/scene/keys.hpp"
#include "engine/world/kinematic_path.hpp"

namespace pantin::detail {
namespace {

using namespace rows;

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

/// All sets of keys, and what their views refer to.
struct Table {
  std::vector<std::string_view> names;
  std::string any_of, complaint;
  std::vector<std::string> others;
  std::vector<Exclusive> exclusive;
  std::array<AnyOf, 1> needs;
  std::array<Beside, 1> beside{
      {{"loop", "keyframes",
        "found \"loop\" without \"keyframes\", expected it with them only: other paths repeat by "
        "themselves"}}};
  std::vector<std::vector<Key>> keys;
  std::vector<KeySet> sets;  // of "path", then of the kinds that are objects

  template <class... Kinds>
  explicit Table(const std::variant<Kinds...>*) {
    keys.push_back({reference("body", kKinematicBody, "A body whose motion is kinematic.")
                        .needed(kKinematicBody)});
    keys.reserve(sizeof...(Kinds) + 1);
    (add<Kinds>(), ...);
    keys.front().push_back(
        flag("loop", "Repeat the path for all times; the last key must be the first pose again.")
            .or_else(false));
    join();
    const KeySet path{.what = "path",
                      .about =
                          "The path of a kinematic body, in the frame of the scene or "
                          "prefab.",
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
    } else {  // a list of what is called like one of it
      keys.front().push_back(
          objects(Path::name, Path::name.substr(0, Path::name.size() - 1), Path::about));
    }
  }

  /// A path is of one kind.
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

}  // namespace

std::span<const KeySet> path_key_sets() { return table().sets; }

}  // namespace pantin::detail
