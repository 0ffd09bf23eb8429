#include "tools/pantin/view_acts.hpp"

#ifdef PANTIN_HAS_VIEW
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <pantin/measure.hpp>
#include <pantin/shapes.hpp>

#include "engine/contact/contact.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr double kNear = 12;              // pixels
constexpr int kParts = 16;                // of a line between two ends
constexpr std::size_t kMostBalls = 30;    // at once
constexpr std::size_t kMostForces = 600;  // joints; reading reactions is quadratic in a chain's
                                          // length
constexpr const char* kBall = "shot ball";
constexpr std::uint32_t kBallGroup = 1u << 31;

/// The candidate nearest to a pixel.
struct Nearest {
  const SeenPixel& mouse;
  Entity found = {};
  double best = kNear;

  void offer(Entity e, Vec3 point) {
    if (!is_finite(point) || !(mouse.eye.depth(point) > 0)) return;
    const Vec3 at = mouse.eye.project(point);
    const double far = std::hypot(at.x - mouse.x, at.y - mouse.y);
    if (far < best) best = far, found = e;
  }
};

void offer_cables(const PosedWorld& scene, Nearest& nearest) {
  std::vector<Vec3> curve;
  const auto& cables = scene.world.cables;
  for (std::size_t i = 0; i < cables.size(); ++i) {
    curve.clear();
    add_cable(scene, cables.values()[i], 16, curve);
    for (std::size_t k = 1; k < curve.size(); ++k)
      for (int part = 0; part <= kParts; ++part)
        nearest.offer(cables.owners()[i], glm::mix(curve[k - 1], curve[k], 1.0 * part / kParts));
  }
}

/// The joint of a body that is nearest to a given point.
Entity joint_at(const PosedWorld& scene, const Picked& picked) {
  Entity found;
  Real best = 1e300;
  const auto& links = scene.world.links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links.values()[i];
    if (link.a != picked.body && link.b != picked.body) continue;
    const auto at = link.a == picked.body ? scene.position_of(link.a, link.joint.anchor_a)
                                          : scene.position_of(link.b, link.joint.anchor_b);
    if (at && glm::distance(*at, picked.point) < best)
      best = glm::distance(*at, picked.point), found = links.owners()[i];
  }
  return found;
}

std::vector<Entity> balls_of(const World& world) {
  std::vector<Entity> balls;
  for (Entity e : world.bodies.owners()) {
    const Collision* c = world.collisions.find(e);
    if (c && c->groups == UINT32_MAX && world.name_of(e) == kBall) balls.push_back(e);
  }
  return balls;
}

/// Lets bodies without contacts collide with balls only.
void let_balls_hit(World& world) {
  const std::vector<Entity> bodies(world.bodies.owners().begin(), world.bodies.owners().end());
  for (Entity e : bodies)
    if (world.shapes.find(e) && !world.collisions.find(e))
      world.collisions.add(e, Collision{.groups = kBallGroup, .with = kBallGroup});
}

/// The sum of contact forces on a body, N, and the number of contacts.
std::pair<Vec3, int> contact_of(const World& world, Entity body) {
  const std::uint32_t slot = world.bodies.slot(body);
  Vec3 force{0};
  int count = 0;
  each_contact(world, [&](const Contact& c) {
    if (!c.active || (c.slot_a != slot && c.slot_b != slot)) return;
    force += c.slot_a == slot ? c.force : -c.force;
    ++count;
  });
  return {force, count};
}

std::string describe_joint(const World& world, Entity e, const Link& link) {
  std::string line = fmt::format("{}: {}", world.name_of(e), info_of(link.joint.kind).name);
  if (const Real angle = joint_angle(world, e); std::isfinite(angle))
    line += fmt::format(", {:.1f} deg", glm::degrees(angle));
  if (const auto reaction = joint_reaction(world, e))
    line += fmt::format(", {:.3g} N", glm::length(reaction->force));
  return line;
}

const char* word_of(Motion motion) {
  return motion == Motion::fixed ? "fixed" : motion == Motion::kinematic ? "kinematic" : "dynamic";
}

}  // namespace

namespace {

/// The joint, cable or pin within a few pixels.
Entity find_connection(const PosedWorld& scene, const SeenPixel& mouse) {
  Nearest nearest{mouse};
  const World& world = scene.world;
  for (std::size_t i = 0; i < world.links.size(); ++i) {
    const Link& link = world.links.values()[i];
    const auto at = scene.position_of(link.a, link.joint.anchor_a);
    if (!at) continue;
    nearest.offer(world.links.owners()[i], *at);
    const auto end = scene.position_of(link.b, link.joint.anchor_b);
    for (int part = 1; end && part <= kParts; ++part)  // far apart: of a distance or a spring
      nearest.offer(world.links.owners()[i], glm::mix(*at, *end, 1.0 * part / kParts));
  }
  for (std::size_t i = 0; i < world.pins.size(); ++i) {
    const Pin& pin = world.pins.values()[i];
    if (const auto at = scene.position_of(pin.body, pin.anchor))
      nearest.offer(world.pins.owners()[i], *at);
  }
  offer_cables(scene, nearest);
  return nearest.found;
}

}  // namespace

Entity find_cut(const PosedWorld& scene, const SeenPixel& mouse) {
  if (const Entity found = find_connection(scene, mouse)) return found;
  const auto picked = pick(scene, mouse);
  return picked ? joint_at(scene, *picked) : Entity{};
}

Entity find_object(const PosedWorld& scene, const SeenPixel& mouse) {
  if (const Entity found = find_connection(scene, mouse)) return found;
  const auto picked = pick(scene, mouse);
  return picked ? picked->body : Entity{};
}

std::optional<bool> toggle_pin(World& world, const Picked& at) {
  if (world.bodies[at.body].motion != Motion::dynamic) return std::nullopt;
  std::vector<Entity> own;
  for (std::size_t i = 0; i < world.pins.size(); ++i) {
    const Entity e = world.pins.owners()[i];
    if (world.pins.values()[i].body == at.body && world.name_of(e) == kUserPin) own.push_back(e);
  }
  world.destroy(own);
  if (!own.empty()) return false;
  Pin pin;
  pin.body = at.body, pin.anchor = at.anchor;
  pin.target = to_world(world.bodies[at.body].pose, at.anchor);
  world.add_pin(pin, kUserPin);
  return true;
}

BallGun usual_gun(const World& world, double distance) {
  double mass = 0;
  std::size_t count = 0;
  for (const Body& b : world.bodies.values())
    if (b.motion == Motion::dynamic) mass += b.mass, ++count;
  BallGun gun;
  gun.radius = std::clamp(0.02 * distance, 1e-3, 10.0);
  gun.mass = count > 0 ? std::max(3 * mass / static_cast<double>(count), 1e-6) : 1;
  gun.speed = std::clamp(2 * distance, 0.1, 200.0);
  return gun;
}

Result<Entity> shoot(World& world, const Ray& ray, const BallGun& gun) {
  const std::vector<Entity> balls = balls_of(world);
  if (balls.size() >= kMostBalls) world.destroy(balls.front());
  let_balls_hit(world);
  const Vec3 way = glm::normalize(ray.way);
  RigidBody ball;
  ball.shape = SphereShape{.radius = gun.radius};
  ball.mass = gun.mass, ball.drag = 0, ball.name = kBall;
  ball.position = ray.origin + 4 * gun.radius * way, ball.velocity = gun.speed * way;
  ball.collision = Collision{.restitution = 0.3, .groups = UINT32_MAX, .others = true};
  return world.add(ball);
}

void sweep_balls(World& world, Vec3 from, double reach) {
  for (Entity e : balls_of(world))
    if (!(glm::distance(world.bodies[e].pose.position, from) < reach)) world.destroy(e);
}

std::vector<std::string> describe(const World& world, Entity body) {
  const Body* b = world.bodies.find(body);
  if (!b) return {};
  const Vec3 at = b->pose.position;
  std::vector<std::string> lines{world.name_of(body)};
  lines.push_back(b->motion == Motion::dynamic ? fmt::format("dynamic, {:.4g} kg", b->mass)
                                               : word_of(b->motion));
  lines.push_back(fmt::format("at {:.3f}, {:.3f}, {:.3f} m", at.x, at.y, at.z));
  lines.push_back(fmt::format("{:.3g} m/s, rotates at {:.3g} rad/s", glm::length(b->velocity),
                              glm::length(b->angular_velocity)));
  if (const auto [force, count] = contact_of(world, body); count > 0)
    lines.push_back(
        fmt::format("{} contact{}, {:.3g} N", count, count > 1 ? "s" : "", glm::length(force)));
  constexpr std::size_t kMostLines = 8;
  for (std::size_t i = 0; i < world.links.size() && lines.size() < kMostLines; ++i) {
    const Link& link = world.links.values()[i];
    if (link.a == body || link.b == body)
      lines.push_back(describe_joint(world, world.links.owners()[i], link));
  }
  return lines;
}

std::string describe_shortly(const World& world, Entity body) {
  const std::vector<std::string> lines = describe(world, body);
  std::string line;
  for (std::size_t i = 0; i < std::min<std::size_t>(lines.size(), 4); ++i)
    line += (i > 0 ? ", " : "") + lines[i];
  return line;
}

std::vector<Vec3> places_of(const PosedWorld& scene, std::span<const Finding> findings) {
  std::vector<Vec3> places;
  const World& world = scene.world;
  for (const Finding& f : findings) {
    std::optional<Vec3> at = scene.position_of(f.where, Vec3(0));
    if (const Link* link = world.links.find(f.where))
      at = scene.position_of(link->b, link->joint.anchor_b);
    if (const Cable* cable = world.cables.find(f.where))
      at = scene.position_of(cable->b, cable->joint.anchor_b);
    if (const Pin* pin = world.pins.find(f.where)) at = scene.position_of(pin->body, pin->anchor);
    if (const SurfaceContact* c = world.surface_contacts.find(f.where)) at = c->point;
    if (at) places.push_back(*at);
  }
  return places;
}

std::vector<Overlay::Arrow> forces_of(const PosedWorld& scene) {
  std::vector<Overlay::Arrow> arrows;
  const World& world = scene.world;
  for (std::size_t i = 0; i < std::min(world.links.size(), kMostForces); ++i) {
    const Link& link = world.links.values()[i];
    const auto at = scene.position_of(link.b, link.joint.anchor_b);
    const auto reaction = joint_reaction(world, world.links.owners()[i]);
    if (at && reaction) arrows.push_back({*at, reaction->force});
  }
  std::vector<Vec3> curve;
  for (std::size_t i = 0; i < std::min(world.cables.size(), kMostForces); ++i) {
    const Real tension = cable_tension(world, world.cables.owners()[i]);
    if (!(tension > 0)) continue;
    curve.clear();
    add_cable(scene, world.cables.values()[i], 1, curve);
    if (curve.size() < 2) continue;
    const Vec3 end = curve.back(), span = curve[curve.size() - 2] - end;
    if (glm::length(span) > 0) arrows.push_back({end, tension / glm::length(span) * span});
  }
  for (std::size_t i = 0; i < std::min(world.pins.size(), kMostForces); ++i) {
    const Pin& pin = world.pins.values()[i];
    const auto at = scene.position_of(pin.body, pin.anchor);
    const auto force = pin_force(world, world.pins.owners()[i]);
    if (at && force) arrows.push_back({*at, *force});
  }
  return arrows;
}

}  // namespace pantin::program
#endif
