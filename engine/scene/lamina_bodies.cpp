// Laminas and their fingers as bodies of a World.
#include "engine/scene/lamina_bodies.hpp"

#include <algorithm>
#include <cmath>

#include "engine/geometry/surface.hpp"
#include "engine/modes/outline.hpp"
#include "engine/scene/build.hpp"
#include "engine/world/lamina.hpp"
#include "engine/world/timed_event.hpp"

namespace pantin::detail {

using modes::Vec2;

namespace {

// Sizes beside the outline's extent: radius of a finger, thickness of all, length of a flat finger.
constexpr Real kFinger = 0.02, kThick = 0.04, kFlat = 3;

Vec3 spatial(Vec2 v) { return {v.x, v.y, 0}; }

/// About the mass centre and z, of a plate of even thickness, kg m^2.
Real inertia_of(const LaminaPlan& lamina) {
  Real sum = 0;
  const std::vector<Vec2>& o = lamina.outline;
  for (std::size_t i = 0; i < o.size(); ++i) {
    const Vec2 p = o[i] - lamina.centre, q = o[(i + 1) % o.size()] - lamina.centre;
    sum += cross(p, q) * (dot(p, p) + dot(p, q) + dot(q, q)) / 12;
  }
  return lamina.mass * sum / modes::area(o);
}

std::vector<Shape> plate_of(const LaminaPlan& lamina, std::uint32_t material) {
  const Real thick = kThick * modes::extent(lamina.outline);
  std::vector<Shape> shapes;
  for (const auto& piece : modes::convex_pieces(lamina.outline)) {
    std::vector<Vec3> points;
    for (const Vec2 c : piece)
      for (const Real z : {-thick / 2, thick / 2})
        points.push_back(spatial(c - lamina.centre) + Vec3(0, 0, z));
    auto hull = make_hull(points);
    if (!hull) continue;  // too thin to be drawn
    Shape& shape = shapes.emplace_back();
    shape.kind = ShapeKind::hull, shape.material = material, shape.surface = *hull;
  }
  return shapes;
}

BodyRecipe lamina_body(const LaminaPlan& lamina, const SolverSettings& how,
                       std::uint32_t material) {
  BodyRecipe body;
  body.name = lamina.name, body.is_lamina = true;
  BodyMassProperties& m = body.mass_properties;
  const Real inertia = inertia_of(lamina);
  m.mass = lamina.mass, m.inertia = {inertia / 2, inertia / 2, inertia};
  m.centre.position = spatial(lamina.centre),
  m.is_moved = lamina.centre.x != 0 || lamina.centre.y != 0;
  m.shapes = plate_of(lamina, material);
  body.solver = how;
  body.solver->solver = Solver::quasistatic;
  body.collision = Collision{.friction = 1, .others = false, .self = false};
  return body;
}

/// Friction of a pair is the root of the product: it is the finger's, and that of sliding.
BodyRecipe finger_body(const LaminaPlan& lamina, const FingerPlan& f, std::uint32_t material) {
  const Real size = modes::extent(lamina.outline);
  BodyRecipe body;
  body.name = body_name(lamina, f), body.body.motion = Motion::kinematic, body.is_finger = true;
  body.pose.position = spatial(f.point - kFinger * size * f.normal);
  Shape shape;
  shape.material = material;
  if (f.flat) {
    shape.kind = ShapeKind::box;
    shape.size = Vec3(kFinger, kFlat / 2, kThick / 2) * size;
    const Real half = std::atan2(f.normal.y, f.normal.x) / 2;
    shape.local.rotation = Quat(std::cos(half), 0, 0, std::sin(half));
  } else {
    shape.size = Vec3(kFinger * size, 0, 0);
  }
  body.mass_properties.shapes.push_back(shape);
  body.collision = Collision{.friction = f.slide * f.slide, .others = false, .self = false};
  return body;
}

LaminaFinger finger_of(const LaminaPlan& lamina, const FingerPlan& f, Entity body) {
  LaminaFinger finger;
  finger.body = body;
  finger.normal = spatial(f.normal);
  finger.point = kFinger * modes::extent(lamina.outline) * finger.normal;
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
    for (const Vec2 corner : plan.outline) lamina.outline.push_back(spatial(corner - plan.centre));
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
      messages.error(b.at, "",
                     "found body \"" + b.name +
                         "\" solved by \"quasistatic\", expected another solver: it moves laminas "
                         "only");
  const auto tell = [&](const ElementId& at, const std::string& what, std::uint32_t a,
                        std::uint32_t b) {
    if (is_slow(a) || is_slow(b))
      messages.error(at, "",
                     "found " + what +
                         " on a lamina, expected none: its solver \"quasistatic\" knows fingers "
                         "only");
  };
  for (const BuiltPath& p : built.paths)
    if (built.bodies[p.body].is_finger)
      messages.error(p.at, "body",
                     "found \"" + built.bodies[p.body].name +
                         "\", expected no finger of a lamina: those move by their \"velocity\" or "
                         "\"waypoints\"");
  for (const BuiltJoint& j : built.joints) tell(j.at, "joint \"" + j.name + "\"", j.a, j.b);
  for (const BuiltCable& c : built.cables) tell(c.at, "cable \"" + c.name + "\"", c.a, c.b);
  for (const BuiltPin& p : built.pins) tell(p.at, "pin \"" + p.name + "\"", p.body, p.to);
}

}  // namespace pantin::detail
