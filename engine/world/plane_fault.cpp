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

/// Islands that are asked about, by the slots of their bodies.
struct Flat {
  const World& world;
  std::vector<std::uint32_t> island;  // kNoSlot: of none

  std::uint32_t island_of(Entity e) const {
    const std::uint32_t slot = world.bodies.slot(e);
    return slot == kNoSlot ? kNoSlot : island[slot];
  }
  Pose pose_of(Entity e) const {
    const Body* b = world.bodies.find(e);
    return b ? b->pose : Pose{};
  }
};

const Collision* collision_of(const World& world, Entity e) {
  const Collision* c = world.collisions.find(e);
  return c && !c->sensor ? c : nullptr;
}

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
  const Collision* collision = collision_of(world, e);
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
    if (std::string why = flat_drive_fault(link.joint, drive->motion, flat.pose_of(link.a));
        !why.empty())
      return "has a joint that " + why;
  }
  for (const Feature f : features_of(link.joint))
    if (!knows(Solver::planar, f))
      return std::string("has a joint with ") + name_of(f) +
             ", which the planar solver does not support";
  return {};
}

/// Calls `note` with islands and the faults of ties other than joints.
template <class Note>
void note_ties(const Flat& flat, const Note& note) {
  const World& w = flat.world;
  for (const Cable& c : w.cables.values()) {
    const auto fault = [] {
      return std::string("hangs on a cable, which the planar solver does not support");
    };
    note(flat.island_of(c.a), fault), note(flat.island_of(c.b), fault);
    for (const CableGuide& g : c.guides) note(flat.island_of(g.body), fault);
  }
  for (const SurfaceContact& c : w.surface_contacts.values()) {
    const auto fault = [&] {
      if (const Feature f = feature_of(c); !knows(Solver::planar, f))
        return std::string("has ") + name_of(f) + ", which the planar solver does not support";
      return flat_fault(c, flat.pose_of(c.a), flat.pose_of(c.b));
    };
    note(flat.island_of(c.a), fault), note(flat.island_of(c.b), fault);
  }
  for (const Pin& p : w.pins.values())
    if (p.kind != PinKind::exact)
      note(flat.island_of(p.body), [] {
        return std::string("hangs on a spring pin, which the planar solver does not support");
      });
}

/// Whether a fixed or kinematic collider has no planar section.
bool meets_what_has_none(const World& w) {
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

std::vector<std::string> plane_faults(const World& world, std::span<const IslandPlan> islands) {
  Flat flat{world, std::vector<std::uint32_t>(world.bodies.size(), kNoSlot)};
  for (std::uint32_t i = 0; i < islands.size(); ++i)
    for (const std::uint32_t slot : islands[i].slots) flat.island[slot] = i;
  std::vector<std::string> faults(islands.size());
  const auto note = [&](std::uint32_t island, auto&& fault) {
    if (island != kNoSlot && faults[island].empty()) faults[island] = fault();
  };
  std::vector<bool> is_solid(islands.size(), false);
  for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot) {
    const std::uint32_t island = flat.island[slot];
    note(island, [&] { return body_fault(world, slot); });
    if (island != kNoSlot && collision_of(world, world.bodies.owners()[slot]))
      is_solid[island] = true;
  }
  for (std::uint32_t i = 0; i < world.links.size(); ++i) {
    const Link& link = world.links.values()[i];
    const std::uint32_t a = flat.island_of(link.a), b = flat.island_of(link.b);
    note(a, [&] { return link_fault(flat, i); });
    if (b != a) note(b, [&] { return link_fault(flat, i); });
  }
  note_ties(flat, note);
  const bool meets = meets_what_has_none(world);
  for (std::uint32_t i = 0; i < islands.size(); ++i)
    if (meets && is_solid[i])
      note(i, [] {
        return std::string("may touch a shape without a planar section of discs and polygons");
      });
  return faults;
}

std::string plane_fault(const World& world, Entity body) {
  const std::uint32_t slot = world.bodies.slot(body);
  if (slot == kNoSlot || world.bodies.values()[slot].motion != Motion::dynamic)
    return "is not a dynamic body";
  for (const IslandPlan& island : find_islands(world))
    if (std::binary_search(island.slots.begin(), island.slots.end(), slot))
      return plane_faults(world, {&island, 1}).front();
  return {};
}

}  // namespace pantin::detail
