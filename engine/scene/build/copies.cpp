#include <algorithm>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/scene/build/group_builder.hpp"
#include "engine/scene/build/place.hpp"

namespace pantin::detail {
namespace {

/// A pose moved by a rigid motion; a pure translation keeps rotations bit for bit.
Pose placed(const Pose& by, const Pose& pose) {
  if (by.rotation == kIdentity) return {by.position + pose.position, pose.rotation};
  return compose(by, pose);
}

}  // namespace

/// One copy of a prefab.
struct GroupBuilder::Copy {
  const BuiltScene& part;  // already mirrored
  const InstanceRecipe& instance;
  std::string prefix;  // of names
  Pose at;
  Real ahead;                        // s, time shift of paths and drives
  std::uint32_t world = kWorldBody;  // the body that its "world" is
};

void GroupBuilder::add_instance(Element<InstanceRecipe> e) {
  const InstanceRecipe& instance = e.recipe;
  if (const BuiltPrefab* prefab = of_instances_[e.id.index])
    copy({part_of(instance, *prefab, e.id), instance, instance.name + "/", pose_of(instance, e.id),
          instance.time_offset, world_of(instance, e.id)});
}

/// The pose of an instance or a grid in the frame of the group.
Pose GroupBuilder::pose_of(const InstanceRecipe& instance, const ElementId& id) {
  if (!instance.parent) return instance.pose;
  const auto parent = body(*instance.parent, id, "parent");
  if (!parent) return instance.pose;
  const BuiltBody& on = made_.bodies[*parent];
  const Pose own = on.mass_properties->is_moved
                       ? compose(on.body.pose, inverse(on.mass_properties->centre))
                       : on.body.pose;
  return compose(own, instance.pose);
}

/// The body to which ties of a copy to "world" go.
std::uint32_t GroupBuilder::world_of(const InstanceRecipe& instance, const ElementId& id) {
  if (!instance.world) return kWorldBody;
  return body_or_world(*instance.world, id, "world").value_or(kWorldBody);
}

void GroupBuilder::add_grid(Element<GridRecipe> e) {
  const GridRecipe& grid = e.recipe;
  const BuiltPrefab* prefab = of_grids_[e.id.index];
  if (!prefab) return;
  int copies = 0;
  const Pose middle = pose_of(grid.each, e.id);
  const BuiltScene& part = part_of(grid.each, *prefab, e.id);
  const std::uint32_t world = world_of(grid.each, e.id);
  const auto add = [&](const Pose& at) {
    copy({part, grid.each, grid.each.name + "/" + std::to_string(copies) + "/", at,
          copies * grid.each.time_offset, world});
    ++copies;
  };
  if (grid.is_ring) {
    const bool is_full = grid.angle == 360 || grid.angle == -360;
    const Real gaps = std::max(grid.count[0] - (is_full ? 0 : 1), 1);
    for (int k = 0; k < grid.count[0]; ++k) {
      const Quat turn =
          from_rotation_vector(kPi / 180 * grid.angle * k / gaps * glm::normalize(grid.axis));
      add(compose(middle, {turn * grid.arm, turn}));
    }
    return;
  }
  for (int y = 0; y < grid.count[1]; ++y)
    for (int z = 0; z < grid.count[2]; ++z)
      for (int x = 0; x < grid.count[0]; ++x) {
        const Vec3 from_middle(x - (grid.count[0] - 1) / 2.0, y - (grid.count[1] - 1) / 2.0,
                               z - (grid.count[2] - 1) / 2.0);
        add({to_world(middle, from_middle * grid.spacing), middle.rotation});
      }
}

/// The prefab of an instance: as it is, or its mirror image.
const BuiltScene& GroupBuilder::part_of(const InstanceRecipe& instance, const BuiltPrefab& prefab,
                                        const ElementId& id) {
  if (!instance.mirror) return prefab.built;
  if (!prefab.built.paths.empty())
    messages_.error(
        id, "mirror",
        "found a mirror image of " + quoted_name(instance.prefab) +
            ", which has paths, expected a prefab without paths, which cannot be mirrored");
  if (!prefab.built.belts.empty())
    messages_.error(
        id, "mirror",
        "found a mirror image of " + quoted_name(instance.prefab) +
            ", which has belts, expected a prefab without belts, which cannot be mirrored");
  image_ = mirrored(prefab.built, {{*instance.mirror, 0}}, context_.images);
  for (const BuiltBody& body : image_.bodies)
    if (const auto kind = unmirrored(*body.mass_properties)) {
      messages_.error(id, "mirror",
                      "found a mirror image of " + quoted_name(instance.prefab) + ", whose " +
                          quoted_name(body.name) + " has a " + std::string(name_of(*kind)) +
                          ", expected a prefab without one: it cannot be mirrored");
      break;
    }
  return image_;
}

void GroupBuilder::copy(const Copy& how) {
  context_.poll();
  const FirstPlaces places = sizes();
  const auto first = static_cast<std::uint32_t>(places.bodies);
  const auto first_joint = static_cast<std::uint32_t>(places.joints);
  const auto moved_place = [&](std::uint32_t body) {
    return body == kWorldBody ? how.world : first + body;
  };
  // The prefab's frame as seen from its world.
  const Pose at =
      how.world == kWorldBody ? how.at : compose(inverse(made_.pose_of(how.world)), how.at);
  const auto moved_anchor = [&](std::uint32_t body, Vec3 anchor) {
    return body == kWorldBody ? to_world(at, anchor) : anchor;
  };
  const auto moved_axes = [&](std::uint32_t body, Quat axes) {
    return body == kWorldBody ? glm::normalize(at.rotation * axes) : axes;
  };
  for (const BuiltBody& b : how.part.bodies) {
    BuiltBody p = b;
    p.name.insert(0, how.prefix);
    p.body.pose = placed(how.at, b.body.pose);
    p.body.velocity = how.at.rotation * b.body.velocity;
    p.body.angular_velocity = how.at.rotation * b.body.angular_velocity;
    if (how.instance.solver) p.solver = &*how.instance.solver;
    add(std::move(p));
  }
  for (const BuiltJoint& j : how.part.joints) {
    BuiltJoint& p = made_.joints.emplace_back(j);
    p.name.insert(0, how.prefix);
    p.a = moved_place(j.a), p.b = moved_place(j.b);
    p.joint.anchor_a = moved_anchor(j.a, j.joint.anchor_a);
    p.joint.anchor_b = moved_anchor(j.b, j.joint.anchor_b);
    p.joint.frames.set(moved_axes(j.a, j.joint.frames.a()), moved_axes(j.b, j.joint.frames.b()));
    if (j.drive) p.drive = shifted(*j.drive, how.ahead);
  }
  for (const BuiltGear& r : how.part.gears)
    made_.gears.push_back(
        {how.prefix + r.name, r.at, first_joint + r.first, first_joint + r.second, r.ratio});
  for (const BuiltBelt& belt : how.part.belts) copy_belt(how, belt, first);
  for (const BuiltSurfaceJoint& s : how.part.surface_joints) {
    BuiltSurfaceJoint& p = made_.surface_joints.emplace_back(s);
    p.name.insert(0, how.prefix);
    p.a = moved_place(s.a), p.b = moved_place(s.b);
    if (s.a == kWorldBody) p.contact.on_a.pose = compose(at, s.contact.on_a.pose);
    if (s.b == kWorldBody) p.contact.on_b.pose = compose(at, s.contact.on_b.pose);
  }
  for (const BuiltCable& s : how.part.cables) {
    BuiltCable& p = made_.cables.emplace_back(s);
    p.name.insert(0, how.prefix);
    p.a = moved_place(s.a), p.b = moved_place(s.b);
    p.joint.anchor_a = moved_anchor(s.a, s.joint.anchor_a);
    p.joint.anchor_b = moved_anchor(s.b, s.joint.anchor_b);
    for (BuiltGuide& g : p.guides) {
      g.guide.anchor = moved_anchor(g.body, g.guide.anchor);
      if (g.body == kWorldBody) g.guide.axis = glm::normalize(at.rotation * g.guide.axis);
      g.body = moved_place(g.body);
    }
  }
  for (const BuiltPin& p : how.part.pins) {
    made_.pins.push_back(
        {how.prefix + p.name, p.at, moved_place(p.body), p.pin, moved_place(p.to)});
    if (p.to == kWorldBody) made_.pins.back().pin.target = to_world(at, p.pin.target);
  }
  for (const BuiltPath& d : how.part.paths)
    made_.paths.push_back({d.at, moved_place(d.body), shifted(moved(d.path, how.at), how.ahead)});
  copy_events(how, places);
}

/// Lays the belt again, since its plane may rotate with the copy.
void GroupBuilder::copy_belt(const Copy& how, const BuiltBelt& belt, std::uint32_t first) {
  BuiltBelt& p = made_.belts.emplace_back(belt);
  p.name.insert(0, how.prefix);
  std::vector<Pose> poses;
  for (std::uint32_t& body : p.bodies) body += first, poses.push_back(made_.pose_of(body));
  lay_belt(p.belt, poses), p.laid = poses;
  if ((how.at.rotation * Vec3(0, 0, 1)).z < 1 - 1e-12)
    messages_.error(belt.at, "",
                    "found a belt in a prefab whose copy \"" + how.instance.name +
                        "\" is rotated out of the xy plane, expected a rotation about z only");
}

GroupBuilder::FirstPlaces GroupBuilder::sizes() const {
  return {made_.bodies.size(), made_.joints.size(), made_.gears.size(), made_.cables.size(),
          made_.pins.size()};
}

/// Copies the events, in the frame of the copy.
void GroupBuilder::copy_events(const Copy& how, const FirstPlaces& first) {
  const auto first_of = [&](EventObject object) {
    switch (object) {
      case EventObject::body:
        return first.bodies;
      case EventObject::joint:
        return first.joints;
      case EventObject::gear:
        return first.gears;
      case EventObject::cable:
        return first.cables;
      case EventObject::pin:
        return first.pins;
      case EventObject::none:
        break;
    }
    return std::size_t(0);
  };
  for (const BuiltEvent& e : how.part.events) {
    BuiltEvent& placed = made_.events.emplace_back(e);
    placed.on += static_cast<std::uint32_t>(first_of(e.object));
    each_event_key(placed.event, [&]<class T>(const EventKey& key, T& member) {
      if constexpr (std::is_same_v<T, Vec3>) {
        if (key.form == EventForm::direction || key.form == EventForm::axial)
          member = how.at.rotation * member;
        if (key.form == EventForm::point) member = to_world(how.at, member);
      }
    });
  }
}

}  // namespace pantin::detail
