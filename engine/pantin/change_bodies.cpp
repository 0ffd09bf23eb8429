// Changes bodies of a running World: mass, gravity, collision, impulses, sleep, pose.
#include <algorithm>
#include <pantin/change.hpp>

#include "engine/contact/detect.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/pantin/detail/checks.hpp"
#include "engine/pantin/detail/touching.hpp"
#include "engine/runtime/requests.hpp"

namespace pantin {

using namespace detail;

namespace {

/// Wakes bodies that were in contact with a body in the last step.
void wake_touching(World& world, Entity body) {
  each_touching(world, [&](Entity a, Entity b) {
    if (a == body) wake(world, b);
    if (b == body) wake(world, a);
  });
}

/// Whether the bounding spheres of two bodies overlap.
bool may_overlap(const World& world, Entity a, Entity b) {
  const Shapes *on_a = world.shapes.find(a), *on_b = world.shapes.find(b);
  if (!on_a || !on_b) return false;
  const auto is_endless = [](const Shape& s) { return !can_move(s.kind); };
  if (std::any_of(on_a->list.begin(), on_a->list.end(), is_endless) ||
      std::any_of(on_b->list.begin(), on_b->list.end(), is_endless))
    return true;
  const Vec3 way = world.bodies[a].pose.position - world.bodies[b].pose.position;
  return glm::length(way) <= contact::extent_of(*on_a) + contact::extent_of(*on_b);
}

/// Wakes bodies with which a body collides now but did not before.
void wake_new_partners(World& world, Entity body, const Collision* before, const Collision& now) {
  if (before && !before->sensor && before->others == now.others && before->groups == now.groups &&
      before->with == now.with)
    return;
  for (std::size_t i = 0; i < world.collisions.size(); ++i) {
    const Entity other = world.collisions.owners()[i];
    if (other == body || !world.bodies.find(other)) continue;
    const Collision& on = world.collisions.values()[i];
    const auto collide = [&](const Collision& c) {
      return !c.sensor && do_groups_agree(c, on) && (c.others || on.others);
    };
    if (collide(now) && !(before && collide(*before)) && may_overlap(world, body, other))
      wake(world, other);
  }
}

/// Replaces a body by an edited copy: a change of structure.
template <class Edit>
Result<Done> change_body(World& world, Findings findings, Entity body, const Edit& edit) {
  findings.body("body", body);
  if (findings.ok() && world.bodies[body].motion != Motion::dynamic)
    findings.add("body", "a fixed or kinematic body", "a dynamic one");
  if (!findings.ok()) return findings.take();
  Body changed = world.bodies[body];
  edit(changed);
  world.bodies.add(body, changed);
  wake(world, body);
  return Done{};
}

Findings of(const World& world, const char* what, Entity body) {
  return Findings(world, what, world.is_alive(body) ? world.name_of(body) : "");
}

}  // namespace

Result<Done> set_mass(World& world, Entity body, Real mass) {
  Findings findings = of(world, "set_mass", body);
  findings.above_zero("mass", mass);
  return change_body(world, std::move(findings), body,
                     [&](Body& b) { b.inertia *= mass / b.mass, b.mass = mass; });
}

Result<Done> set_gravity_scale(World& world, Entity body, Real scale) {
  Findings findings = of(world, "set_gravity_scale", body);
  findings.finite("scale", scale);
  return change_body(world, std::move(findings), body, [&](Body& b) { b.gravity_scale = scale; });
}

Result<Done> set_drag(World& world, Entity body, Real drag) {
  Findings findings = of(world, "set_drag", body);
  findings.not_negative("drag", drag);
  return change_body(world, std::move(findings), body, [&](Body& b) { b.drag = drag; });
}

Result<Done> set_collision(World& world, Entity body, const std::optional<Collision>& collision) {
  Findings findings = of(world, "set_collision", body);
  findings.body("body", body);
  if (collision) check(findings, *collision);
  if (!findings.ok()) return findings.take();
  wake(world, body), wake_touching(world, body);
  if (collision) wake_new_partners(world, body, world.collisions.find(body), *collision);
  if (collision)
    world.collisions.add(body, *collision);
  else
    world.collisions.remove(body);
  return Done{};
}

Result<Done> impulse(World& world, Entity body, Vec3 impulse, Vec3 point) {
  Findings findings = of(world, "impulse", body);
  findings.body("body", body);
  findings.finite("impulse", impulse), findings.finite("point", point);
  if (findings.ok() && world.bodies[body].motion != Motion::dynamic)
    findings.add("body", "a fixed or kinematic body", "a dynamic one");
  if (!findings.ok()) return findings.take();
  Store<Impulse>& all = world.store<Impulse>();
  Impulse* blow = all.find(body);
  if (!blow) blow = &all.add(body, {});
  blow->linear += impulse;
  blow->angular += glm::cross(point - world.bodies[body].pose.position, impulse);
  return Done{};
}

bool wake(World& world, Entity body) { return rouse(world, body); }

Result<Done> ignore(World& world, Entity a, Entity b, Real seconds) {
  Findings findings(world, "ignore", "");
  findings.body("a", a), findings.body("b", b);
  if (!(seconds >= 0)) findings.add("seconds", shown(seconds), "0 or a number above it");
  if (findings.ok() && a == b) findings.add("b", "the same body as a", "another one");
  if (!findings.ok()) return findings.take();
  wake(world, a), wake(world, b);
  wake_touching(world, a), wake_touching(world, b);
  Store<IgnoredPair>& all = world.store<IgnoredPair>();
  for (IgnoredPair& pair : all.values())
    if ((pair.a == a && pair.b == b) || (pair.a == b && pair.b == a)) {
      pair.until = world.time + seconds;
      return Done{};
    }
  if (seconds > 0) all.add(world.create(), {a, b, world.time + seconds});
  return Done{};
}

namespace {

/// Reports joints and pins between the moved bodies and others, which would be torn.
void check_ties(Findings& findings, std::span<const Entity> bodies) {
  const World& world = findings.world();
  const auto moves = [&](Entity e) {
    return std::find(bodies.begin(), bodies.end(), e) != bodies.end();
  };
  const auto torn = [&](Entity tie, Entity stays) {
    findings.add("bodies",
                 "'" + world.name_of(tie) + "', which ties them to " +
                     (stays ? "'" + world.name_of(stays) + "'" : "a place"),
                 "all that it ties");
  };
  for (std::size_t i = 0; i < world.links.size(); ++i) {
    const Link& l = world.links.values()[i];
    if (moves(l.a) != moves(l.b)) torn(world.links.owners()[i], moves(l.a) ? l.b : l.a);
  }
  for (std::size_t i = 0; i < world.pins.size(); ++i) {
    const Pin& p = world.pins.values()[i];
    if (moves(p.body) != (p.to && moves(p.to)))
      torn(world.pins.owners()[i], moves(p.body) ? p.to : p.body);
  }
  for (std::size_t i = 0; i < world.surface_contacts.size(); ++i) {
    const SurfaceContact& c = world.surface_contacts.values()[i];
    if (moves(c.a) != moves(c.b)) torn(world.surface_contacts.owners()[i], moves(c.a) ? c.b : c.a);
  }
}

}  // namespace

Result<Done> teleport(World& world, std::span<const Entity> bodies, const Pose& to) {
  Findings findings(world, "teleport", "");
  for (const Entity e : bodies) findings.body("bodies", e);
  findings.finite("to", to.position);
  const Pose there{to.position, findings.rotation("to", to.rotation)};
  if (findings.ok()) check_ties(findings, bodies);
  if (!findings.ok()) return findings.take();
  if (bodies.empty()) return Done{};
  const Pose way = compose(there, inverse(world.origin_pose(bodies.front())));
  for (const Entity e : bodies) {
    wake(world, e), wake_touching(world, e);
    const Body& b = world.bodies[e];
    Pose pose = compose(way, b.pose);
    pose.rotation = glm::normalize(pose.rotation);
    const Vec3 velocity = way.rotation * b.velocity, spin = way.rotation * b.angular_velocity;
    world.teleport(e, pose);
    world.bodies[e].velocity = velocity, world.bodies[e].angular_velocity = spin;
  }
  return Done{};
}

}  // namespace pantin
