// Whether the motion of an island stays in a plane.
#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/world/faults.hpp"
#include "engine/world/flat.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/special_surface.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {
namespace {

constexpr Real kAside = 1e-9;  // tolerance for a push out of the plane: rounding

/// An island in the plane: its bodies, by slot.
struct Flat {
  const World& world;
  std::vector<bool> own;

  bool is_own(Entity e) const {
    const std::uint32_t slot = world.bodies.slot(e);
    return slot != kNoSlot && own[slot];
  }
  Pose pose_of(Entity e) const {
    const Body* b = world.bodies.find(e);
    return b ? b->pose : Pose{};
  }
};

/// The fault of the body alone: its motion, its pushes, its shapes.
std::string body_fault(const World& world, std::uint32_t slot) {
  const Entity e = world.bodies.owners()[slot];
  const Body& body = world.bodies.values()[slot];
  if (std::string why = flat_fault(body); !why.empty()) return why;
  if (body.gravity_scale != 0)
    if (std::string why = flat_fault(world.gravity); !why.empty()) return why;
  if (const Force* f = world.forces.find(e))
    if (std::abs(f->force.z) > kAside * glm::length(f->force) ||
        std::hypot(f->torque.x, f->torque.y) > kAside * glm::length(f->torque))
      return "is pushed out of the xy plane";
  const Collision* collision = world.collisions.find(e);
  const Shapes* shapes = collision ? world.shapes.find(e) : nullptr;
  if (collision && has_special_surface(*collision))
    return "has a moving surface, rolling or spinning friction";
  if (shapes && !std::all_of(shapes->list.begin(), shapes->list.end(),
                             [&](const Shape& s) { return has_section(s, body.pose.rotation); }))
    return "has a shape without a planar section of discs and polygons";
  return {};
}

std::string link_fault(const Flat& flat, std::uint32_t slot) {
  const Link& link = flat.world.links.values()[slot];
  if (!flat.is_own(link.a) && !flat.is_own(link.b)) return {};
  if (std::string why = flat_fault(link.joint, flat.pose_of(link.a), flat.pose_of(link.b));
      !why.empty())
    return "has a joint that " + why;
  for (const auto& [body, anchor] :
       {std::pair{link.a, link.joint.anchor_a}, {link.b, link.joint.anchor_b}})
    if (const KinematicPath* path = flat.world.paths.find(body))
      if (std::string why = flat_fault(link.joint, *path, anchor); !why.empty())
        return "has a joint that " + why;
  if (const JointDrive* drive = flat.world.joint_drives.find(flat.world.links.owners()[slot])) {
    if (!drive->exact)
      return "has a joint with a joint drive, which the planar solver does not support";
    if (std::string why = flat_drive_fault(link.joint, drive->motion.travels, flat.pose_of(link.a));
        !why.empty())
      return "has a joint that " + why;
  }
  for (const Feature f : features_of(link.joint))
    if (!knows(Solver::planar, f))
      return std::string("has a joint with ") + name_of(f) +
             ", which the planar solver does not support";
  return {};
}

/// The fault of ties other than joints.
std::string tie_fault(const Flat& flat) {
  const World& w = flat.world;
  for (const Cable& c : w.cables.values()) {
    const bool runs_over = std::any_of(c.guides.begin(), c.guides.end(),
                                       [&](const CableGuide& g) { return flat.is_own(g.body); });
    if (runs_over || flat.is_own(c.a) || flat.is_own(c.b))
      return "hangs on a cable, which the planar solver does not support";
  }
  for (const SurfaceContact& c : w.surface_contacts.values())
    if (flat.is_own(c.a) || flat.is_own(c.b)) {
      if (const Feature f = feature_of(c); !knows(Solver::planar, f))
        return std::string("has ") + name_of(f) + ", which the planar solver does not support";
      if (std::string why = flat_fault(c, flat.pose_of(c.a), flat.pose_of(c.b)); !why.empty())
        return why;
    }
  for (const Pin& p : w.pins.values())
    if (flat.is_own(p.body) && p.kind != PinKind::exact)
      return "hangs on a spring pin, which the planar solver does not support";
  return {};
}

/// Whether a fixed or kinematic collider that the island may touch has no planar section.
bool meets_what_has_none(const Flat& flat) {
  const World& w = flat.world;
  for (std::size_t i = 0; i < w.collisions.size(); ++i) {
    const Entity e = w.collisions.owners()[i];
    const Body* b = w.bodies.find(e);
    const Shapes* shapes = w.shapes.find(e);
    if (!b || !shapes || b->motion == Motion::dynamic || w.collisions.values()[i].sensor) continue;
    for (const Shape& s : shapes->list)
      if (!has_section(s, b->pose.rotation)) return true;
  }
  return false;
}

}  // namespace

std::string plane_fault(const World& world, Entity body) {
  const std::uint32_t slot = world.bodies.slot(body);
  if (slot == kNoSlot || world.bodies.values()[slot].motion != Motion::dynamic)
    return "is not a dynamic body";
  Flat flat{world, std::vector<bool>(world.bodies.size(), false)};
  for (const IslandPlan& island : find_islands(world))
    if (std::find(island.slots.begin(), island.slots.end(), slot) != island.slots.end())
      for (const std::uint32_t of : island.slots) flat.own[of] = true;
  bool is_solid = false;
  for (std::uint32_t i = 0; i < world.bodies.size(); ++i) {
    if (!flat.own[i]) continue;
    if (std::string why = body_fault(world, i); !why.empty()) return why;
    is_solid = is_solid || world.collisions.find(world.bodies.owners()[i]);
  }
  for (std::uint32_t i = 0; i < world.links.size(); ++i)
    if (std::string why = link_fault(flat, i); !why.empty()) return why;
  if (std::string why = tie_fault(flat); !why.empty()) return why;
  if (is_solid && meets_what_has_none(flat))
    return "may touch a shape without a planar section of discs and polygons";
  return {};
}

}  // namespace pantin::detail
