#include "engine/scene/build/build.hpp"

#include <algorithm>

#include "engine/scene/build/build_context.hpp"
#include "engine/scene/build/group_builder.hpp"
#include "engine/world/surface_start.hpp"

namespace pantin::detail {
namespace {

BuildCount count_of(const BuiltScene& built) {
  BuildCount count;
  count.bodies = static_cast<Real>(built.bodies.size());
  count.links = static_cast<Real>(built.links() + built.events.size());
  std::size_t parts = 0, name_bytes = 0;
  for (const BuiltBody& b : built.bodies) parts += b.mass_properties->shapes.size();
  for (const BuiltPath& d : built.paths) parts += parts_of(d.path);
  for (const BuiltJoint& j : built.joints) parts += j.drive ? j.drive->keys.size() : 0;
  const auto add_names = [&](const auto& items) {
    for (const auto& x : items) name_bytes += x.name.size();
  };
  add_names(built.bodies), add_names(built.joints), add_names(built.gears);
  add_names(built.cables), add_names(built.pins), add_names(built.surface_joints);
  add_names(built.belts);
  count.parts = static_cast<Real>(parts), count.name_bytes = static_cast<Real>(name_bytes);
  return count;
}

}  // namespace

void BuildCount::add(const BuildCount& other, Real times) {
  bodies += times * other.bodies, links += times * other.links, parts += times * other.parts;
  copies += times * other.copies, name_bytes += times * other.name_bytes;
}

BuildContext::BuildContext(const Recipe& r, BuildMessages& m, const SceneLimits& l)
    : recipe(r),
      messages(m),
      limits(l),
      poll(l.is_cancelled),
      built_(r.prefabs.size()),
      states_(r.prefabs.size(), State::unknown) {
  for (const PrefabName& known : recipe.prefab_names)
    number_of_.try_emplace({known.scope, known.name}, known.prefab);
}

void BuildContext::tell_of_cycle(std::uint32_t which, const ElementId& at,
                                 std::string_view member) {
  std::string way;
  for (auto it = std::find(open_.begin(), open_.end(), which); it != open_.end(); ++it)
    way += recipe.prefabs[*it].name + " -> ";
  const std::string& name = recipe.prefabs[which].name;
  messages.error(at, member,
                 "found " + quoted_name(name) +
                     ", expected a prefab that does not contain itself (" + way + name + ")");
}

void BuildContext::build(std::uint32_t which) {
  states_[which] = State::open;
  open_.push_back(which);
  const std::size_t errors_before = messages.errors();
  BuiltPrefab& built = built_[which];
  built.built = build_group(*this, recipe.prefabs[which], which + 1);
  built.count = count_of(built.built);
  open_.pop_back();
  states_[which] = messages.errors() == errors_before ? State::done : State::broken;
}

const BuiltPrefab* BuildContext::prefab(const std::string& name, const ElementId& at,
                                        std::string_view member) {
  if (name.empty()) return nullptr;  // the reader has reported it
  const std::uint32_t scope = at.group == 0 ? recipe.top.scope : recipe.prefabs[at.group - 1].scope;
  const auto known = number_of_.find({scope, name});
  if (known == number_of_.end()) {
    std::vector<std::string_view> names;
    if (messages.hints().any_left())
      for (const PrefabName& other : recipe.prefab_names)
        if (other.scope == scope) names.push_back(other.name);
    messages.error(at, member,
                   "found " + quoted_name(name) + ", expected the name of a prefab" +
                       messages.hints().of(name, names));
    return nullptr;
  }
  return known->second == kNoPrefab ? nullptr : built(known->second, at, member);
}

const BuiltPrefab* BuildContext::built(std::uint32_t which, const ElementId& at,
                                       std::string_view member) {
  const std::string& name = recipe.prefabs[which].name;
  if (states_[which] == State::open) {
    tell_of_cycle(which, at, member);
    return nullptr;
  }
  if (states_[which] == State::unknown) {
    if (open_.size() >= limits.depth) {
      messages.error(at, member,
                     "found " + quoted_name(name) + ", expected prefabs nested at most " +
                         std::to_string(limits.depth) + " deep");
      return nullptr;
    }
    build(which);
  }
  return states_[which] == State::done ? &built_[which] : nullptr;
}

namespace {

/// Applies "poses". The contacts of surfaces that have moved are found again.
void place_at_poses(BuiltScene& whole) {
  std::vector<bool> moved(whole.bodies.size(), false);
  for (const BuiltPose& p : whole.poses)
    whole.bodies[p.body].body.pose = p.pose, moved[p.body] = true;
  const auto has_moved = [&](std::uint32_t body) { return body != kWorldBody && moved[body]; };
  for (BuiltSurfaceJoint& joint : whole.surface_joints) {
    if (!has_moved(joint.a) && !has_moved(joint.b)) continue;
    joint.contact.known = false;
    joint.apart = place_surfaces(joint.contact, {whole.pose_of(joint.a), whole.pose_of(joint.b)});
  }
}

/// Reports bilateral surfaces that are not in contact, and places of contact that are uncertain.
void check_contacts(const BuiltScene& whole, Start start, BuildMessages& messages) {
  for (const BuiltSurfaceJoint& joint : whole.surface_joints) {
    const PairPoses poses{whole.pose_of(joint.a), whole.pose_of(joint.b)};
    if (joint.apart.empty()) {
      if (const std::string doubt = doubt_of_place(joint.contact, poses); !doubt.empty())
        messages.warn(joint.at, "uncertain contact",
                      "surface joint " + quoted_name(joint.name) + ": " + doubt);
      continue;
    }
    SurfaceContact open = joint.contact;
    open.lifts = true;
    // Apart, and neither conforming nor with inner sides towards one another.
    const bool is_open =
        place_surfaces(open, poses).empty() && joint.apart.find("within ") != std::string::npos;
    if (is_open && start == Start::anywhere) continue;
    messages.error(joint.at, "",
                   joint.apart + (is_open ? "; `pantin assemble` brings bodies together" : ""));
  }
}

}  // namespace

BuiltScene build_scene(const Recipe& recipe, BuildMessages& messages, const SceneLimits& limits,
                       Start start) {
  BuildContext context(recipe, messages, limits);
  // Unused prefabs are checked too.
  for (std::uint32_t i = 0; i < recipe.prefabs.size(); ++i)
    context.built(i, {ElementKind::group, i + 1, 0}, "name");
  BuiltScene whole = build_group(context, recipe.top, 0);
  // Joints and cables were measured at rest; now each body is placed at the start of its path, or
  // at its pose.
  for (const BuiltPath& d : whole.paths) whole.bodies[d.body].body.pose = pose_at(d.path, 0);
  place_at_poses(whole);
  check_contacts(whole, start, messages);
  check_free({whole, recipe.nets}, recipe.top.free, messages);
  return whole;
}

}  // namespace pantin::detail
