// Bodies whose surfaces touch.
#include <pantin/joints.hpp>

#include "engine/geometry/shape_skin.hpp"
#include "engine/pantin/detail/findings.hpp"
#include "engine/world/surface_start.hpp"

namespace pantin {

using namespace detail;

namespace {

/// The surface of one side in its body's mass-centre frame. False: there is none.
bool place_side(const World& world, Entity body, const std::optional<Shape>& given,
                ContactSurface& to) {
  if (given) {
    const Pose* origin = world.origins.find(body);
    to.skin = skin_of(*given), to.pose = origin ? compose(*origin, given->local) : given->local;
    return to.skin != nullptr;
  }
  const Shapes* shapes = world.shapes.find(body);
  for (std::size_t i = 0; shapes && i < shapes->list.size(); ++i) {
    to.skin = skin_of(shapes->list[i]), to.pose = shapes->list[i].local;
    if (to.skin) return true;
  }
  return false;
}

}  // namespace

Result<Entity> add_to(World& world, const SurfaceJoint& described) {
  Findings findings(world, "SurfaceJoint", described.name);
  findings.bodies(described.a, described.b);
  findings.known({{Feature::surface_contact}}, {described.a, described.b});
  if (!findings.ok()) return findings.take();
  SurfaceContact c;
  c.a = described.a, c.b = described.b;
  c.motion = described.motion, c.lifts = described.may_lift, c.on_rim = described.on_rim;
  constexpr const char* kSmooth = "a sphere, an ellipsoid, a cylinder, a plane or a NURBS shape";
  if (!place_side(world, c.a, described.surface_a, c.on_a))
    findings.add("surface_a", "no smooth shape", kSmooth);
  if (!place_side(world, c.b, described.surface_b, c.on_b))
    findings.add("surface_b", "no smooth shape", kSmooth);
  if (!findings.ok()) return findings.take();
  const std::string why = place_surfaces(c, {world.bodies[c.a].pose, world.bodies[c.b].pose});
  if (why.empty()) return world.add_surface_contact(c, described.name);
  return Error{"SurfaceJoint" + (described.name.empty() ? "" : " '" + described.name + "'") + ": " +
               why};
}

std::optional<SurfaceTouch> surface_touch(const World& world, Entity joint) {
  const SurfaceContact* c = world.surface_contacts.find(joint);
  if (!c) return std::nullopt;
  return SurfaceTouch{c->touches, c->point, c->normal, c->force, c->gap};
}

}  // namespace pantin
