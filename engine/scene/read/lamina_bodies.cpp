// Laminas and their fingers as bodies of a World.
#include "engine/scene/read/lamina_bodies.hpp"

#include <algorithm>
#include <span>

#include "engine/modes/outline.hpp"
#include "engine/scene/build/build.hpp"
#include "engine/world/lamina.hpp"
#include "engine/world/lamina_shapes.hpp"
#include "engine/world/timed_event.hpp"

namespace pantin::detail {

using modes::Vec2;

namespace {

Vec3 spatial(Vec2 v) { return {v.x, v.y, 0}; }

LaminaLook look_of(const LaminaPlan& lamina, std::uint32_t material) {
  return {modes::extent(lamina.outline), material};
}
FingerTip tip_of(const FingerPlan& f) { return {spatial(f.normal), f.flat}; }

/// Corners relative to the mass centre.
std::vector<Vec3> about_centre(const LaminaPlan& lamina, std::span<const Vec2> corners) {
  std::vector<Vec3> about;
  for (const Vec2 corner : corners) about.push_back(spatial(corner - lamina.centre));
  return about;
}

BodyRecipe lamina_body(const LaminaPlan& lamina, const SolverSettings& how,
                       std::uint32_t material) {
  BodyRecipe body;
  body.name = lamina.name, body.is_lamina = true;
  BodyMassProperties& m = body.mass_properties;
  m.mass = lamina.mass;
  m.inertia = plate_inertia(about_centre(lamina, lamina.outline), lamina.mass);
  m.centre.position = spatial(lamina.centre),
  m.is_moved = lamina.centre.x != 0 || lamina.centre.y != 0;
  std::vector<std::vector<Vec3>> pieces;
  for (const auto& piece : modes::convex_pieces(lamina.outline))
    pieces.push_back(about_centre(lamina, piece));
  m.shapes = plate_shapes(pieces, look_of(lamina, material));
  body.solver = how;
  body.solver->solver = Solver::quasistatic;
  body.collision = lamina_collision();
  return body;
}

BodyRecipe finger_body(const LaminaPlan& lamina, const FingerPlan& f, std::uint32_t material) {
  const LaminaLook look = look_of(lamina, material);
  BodyRecipe body;
  body.name = body_name(lamina, f), body.body.motion = Motion::kinematic, body.is_finger = true;
  body.pose.position = spatial(f.point) - finger_arm(tip_of(f), look);
  body.mass_properties.shapes.push_back(finger_shape(tip_of(f), look));
  body.collision = finger_collision(f.slide);
  return body;
}

LaminaFinger finger_of(const LaminaPlan& lamina, const FingerPlan& f, Entity body) {
  LaminaFinger finger;
  finger.body = body;
  finger.normal = spatial(f.normal);
  finger.point = finger_arm(tip_of(f), look_of(lamina, 0));
  finger.flat = f.flat, finger.roll = f.roll, finger.slide = f.slide;
  for (const Waypoint& w : f.path) finger.path.push_back({w.time, spatial(w.at)});
  return finger;
}

}  // namespace

void add_lamina_bodies(const LaminaPlan& lamina, const SolverSettings& how,
                       const LaminaParts& out) {
  const auto material = static_cast<std::uint32_t>(out.materials.size());
  out.materials.push_back({"", {0.58, 0.32, 0.11}, 0.6, 0});
  out.materials.push_back({"", {0.03, 0.13, 0.43}, 0.4, 0});
  out.bodies.push_back(lamina_body(lamina, how, material));
  for (const FingerPlan& f : lamina.fingers)
    out.bodies.push_back(finger_body(lamina, f, material + 1));
}

void add_laminas(const std::vector<LaminaPlan>& laminas, World& world) {
  for (const LaminaPlan& plan : laminas) {
    if (!is_body(plan)) continue;
    const Entity body = world.find(plan.name);
    Lamina lamina;
    lamina.outline = about_centre(plan, plan.outline);
    for (const FingerPlan& f : plan.fingers)
      lamina.fingers.push_back(finger_of(plan, f, world.find(body_name(plan, f))));
    laminas_of(world).add(body, std::move(lamina));
    const Vec3 pull = spatial(plan.force) - plan.mass * Vec3(world.gravity.x, world.gravity.y, 0);
    if (pull == Vec3(0) && plan.torque == 0) continue;
    add_event(world, {PushEvent{.body = body, .force = pull, .torque = {0, 0, plan.torque}}});
  }
}

void check_laminas(const BuiltScene& built, const std::vector<Solver>& solvers,
                   BuildMessages& messages) {
  const auto is_slow = [&](std::uint32_t body) {
    return built.is_dynamic(body) && solvers[body] == Solver::quasistatic;
  };
  for (std::uint32_t i = 0; i < built.bodies.size(); ++i)
    if (const BuiltBody& b = built.bodies[i]; is_slow(i) && !b.is_lamina)
      messages.error(
          b.at, "",
          "found body \"" + b.name +
              "\" solved by \"quasistatic\", expected another solver: it supports laminas only");
  const auto tell = [&](const ElementId& at, const std::string& what, std::uint32_t a,
                        std::uint32_t b) {
    if (is_slow(a) || is_slow(b))
      messages.error(
          at, "",
          "found " + what +
              " on a lamina, expected none: its solver \"quasistatic\" supports fingers only");
  };
  for (const BuiltPath& p : built.paths)
    if (built.bodies[p.body].is_finger)
      messages.error(p.at, "body",
                     "found \"" + built.bodies[p.body].name +
                         "\", expected no finger of a lamina: fingers move by their \"velocity\" "
                         "or \"waypoints\"");
  for (const BuiltJoint& j : built.joints) tell(j.at, "joint \"" + j.name + "\"", j.a, j.b);
  for (const BuiltCable& c : built.cables) tell(c.at, "cable \"" + c.name + "\"", c.a, c.b);
  for (const BuiltPin& p : built.pins) tell(p.at, "pin \"" + p.name + "\"", p.body, p.to);
}

}  // namespace pantin::detail
