#include "tools/pantin/joint_source.hpp"

#include <fmt/format.h>

#include "engine/base/utf8.hpp"
#include "engine/scene/build/mirror.hpp"

namespace pantin::program {

using namespace detail;

namespace {

/// Looks for a joint in a scene file.
class Search {
 public:
  explicit Search(const JsonDocument& json) : json_(json) {}

  /// In the scene or in a prefab.
  JointSource in_group(NodeId group, std::string_view name) const {
    for (const NodeId joint : items(group, {"joints"}))
      if (name_of_joint(joint) == name) return of_object(joint);
    for (const NodeId chain : items(group, {"generators", "chains"}))
      if (const std::string_view own = text(chain, "name"); is_of_chain(name, own)) {
        JointSource found = of_object(chain);
        found.shared = fmt::format("all joints of the chain {}", printable(own));
        return found;
      }
    for (const std::vector<std::string_view>& list : kCopies)
      for (const NodeId copies : items(group, list))
        if (const std::string_view own = text(copies, "name");
            name.starts_with(own) && name.substr(own.size()).starts_with('/'))
          return in_copies(copies, name.substr(own.size() + 1),
                           list.size() > 1 ? Copies::numbered : Copies::one);
    return {.missing = "found in no list of the file"};
  }

  /// The same, or the joint of which it is a mirror image.
  JointSource in_group_or_image(NodeId group, std::string_view name) const {
    JointSource found = in_group(group, name);
    if (found.missing.empty()) return found;
    JointSource original = in_group(group, mirrored_name(std::string(name)));
    if (!original.missing.empty()) return found;
    if (original.shared.empty()) original.shared = "its mirror image";
    original.is_image = !original.is_image;
    return original;
  }

 private:
  /// Whether a number stands between the name of copies and those of their members.
  enum class Copies : std::uint8_t { one, numbered };
  inline static const std::vector<std::vector<std::string_view>> kCopies = {
      {"instances"}, {"generators", "grids"}, {"generators", "rings"}};

  std::string_view text(NodeId object, std::string_view key) const {
    const NodeId node =
        json_[object].kind == JsonKind::object ? json_.member(object, key) : kNoNode;
    return node == kNoNode || json_[node].kind != JsonKind::string ? std::string_view()
                                                                   : json_[node].text;
  }

  /// The objects of a list below an object.
  std::vector<NodeId> items(NodeId at, const std::vector<std::string_view>& keys) const {
    std::vector<NodeId> found;
    for (const std::string_view key : keys) {
      if (json_[at].kind != JsonKind::object) return found;
      at = json_.member(at, key);
      if (at == kNoNode) return found;
    }
    if (json_[at].kind != JsonKind::array) return found;
    for (NodeId item = json_[at].first_child; item != kNoNode; item = json_[item].next)
      if (json_[item].kind == JsonKind::object) found.push_back(item);
    return found;
  }

  std::string name_of_joint(NodeId joint) const {
    const std::string_view own = text(joint, "name");
    if (!own.empty()) return std::string(own);
    return std::string(text(joint, "a")) + "-" + std::string(text(joint, "b"));
  }

  /// Whether a name is one of the joints of a chain: CHAIN/top, CHAIN/0-1, CHAIN/end.
  static bool is_of_chain(std::string_view name, std::string_view chain) {
    if (chain.empty() || !name.starts_with(chain)) return false;
    const std::string_view rest = name.substr(chain.size());
    return rest.starts_with('/') && rest.find('/', 1) == std::string_view::npos;
  }

  /// With its classes, each of which may name another, and the defaults.
  JointSource of_object(NodeId object) const {
    JointSource found{.objects = {object}};
    constexpr int kMostClasses = 64;  // a circle of them is an error of the scene
    std::string_view name = text(object, "class");
    for (int i = 0; i < kMostClasses && !name.empty(); ++i) {
      NodeId next = kNoNode;
      for (const NodeId one : items(0, {"classes"}))
        if (text(one, "name") == name) next = one;
      if (next == kNoNode) break;
      add_joint_of(next, found);
      name = text(next, "class");
    }
    if (const NodeId defaults = json_.member(0, "defaults"); defaults != kNoNode)
      add_joint_of(defaults, found);
    return found;
  }

  void add_joint_of(NodeId object, JointSource& to) const {
    if (json_[object].kind != JsonKind::object) return;
    if (const NodeId joint = json_.member(object, "joint"); joint != kNoNode)
      to.objects.push_back(joint);
  }

  /// A member of an instance, or, behind a number, of a grid or a ring.
  JointSource in_copies(NodeId copies, std::string_view rest, Copies which) const {
    if (which == Copies::numbered) {
      const std::size_t slash = rest.find('/');
      if (slash == std::string_view::npos) return {.missing = "found in no list of the file"};
      rest.remove_prefix(slash + 1);
    }
    const std::string_view name = text(copies, "prefab");
    for (const NodeId prefab : items(0, {"prefabs"})) {
      if (text(prefab, "name") != name) continue;
      if (const std::string_view file = text(prefab, "file"); !file.empty())
        return {.missing = fmt::format("it is in {}: open that file", printable(file))};
      // A mirrored copy exchanges the sides in all names.
      const bool is_mirrored = !text(copies, "mirror").empty();
      const std::string own(is_mirrored ? mirrored_name(std::string(rest)) : std::string(rest));
      JointSource found = in_group_or_image(prefab, own);
      found.is_image = found.is_image != is_mirrored;
      if (found.missing.empty() && !found.is_shared_by_prefab) {
        found.is_shared_by_prefab = true;  // of the innermost prefab, where the value stands
        found.shared = fmt::format("all copies of the prefab {}{}{}", printable(name),
                                   found.shared.empty() ? "" : ", ", found.shared);
      }
      return found;
    }
    return {.missing = "its prefab is not in the file"};
  }

  const JsonDocument& json_;
};

}  // namespace

NodeId JointSource::value(const JsonDocument& json, std::string_view key) const {
  for (const NodeId object : objects) {
    if (json[object].kind != JsonKind::object) continue;
    if (const NodeId node = json.member(object, key); node != kNoNode) return node;
  }
  return kNoNode;
}

std::string_view JointSource::text(const JsonDocument& json, std::string_view key) const {
  const NodeId node = value(json, key);
  return node == kNoNode || json[node].kind != JsonKind::string ? std::string_view()
                                                                : json[node].text;
}

JointSource source_of_joint(const JsonDocument& json, std::string_view name) {
  return Search(json).in_group_or_image(0, name);
}

}  // namespace pantin::program
