// Planar dynamics of the same lamina and fingers, where the quasi-static method finds no motion.
#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/solvers/quasistatic/island.hpp"
#include "engine/world/flat.hpp"

namespace pantin::detail::quasistatic {
namespace {

constexpr std::uint32_t kMostCorners = 8;  // of a piece, as Box2D has them
constexpr Real kCalm = 0.1;                // s, of agreement before modes take over again
constexpr Real kAlike = 0.1;               // of the fastest finger: motions that agree
constexpr Real kNoise = 1e-3;              // of the speed of a fall through the outline's extent
constexpr Real kPoint = 1e-3;              // of the extent: radius of a finger without a size
constexpr Real kWidest = 1e12;             // m, m/s: larger motions are failures

Vec3 flat(Vec3 v) { return {v.x, v.y, 0}; }

planar::Outline solid() {
  planar::Outline o;
  o.low = -1, o.high = 1;
  return o;
}

/// Fans of the convex pieces of the outline.
void append_outline(const Island& m, planar::Plane& plane) {
  for (const auto& piece : modes::convex_pieces(m.scratch.outline))
    for (std::size_t at = 1; at + 1 < piece.size(); at += kMostCorners - 2) {
      planar::Outline o = solid();
      o.kind = planar::Outline::polygon;
      o.first = static_cast<std::uint32_t>(plane.corners.size());
      const std::size_t end = std::min(piece.size(), at + kMostCorners - 1);
      plane.corners.push_back({piece[0].x, piece[0].y, 0});
      for (std::size_t i = at; i < end; ++i) plane.corners.push_back({piece[i].x, piece[i].y, 0});
      o.count = static_cast<std::uint32_t>(plane.corners.size()) - o.first;
      plane.outlines.push_back(o);
    }
}

planar::PlaneBody lamina_body(const World& world, const Island& m) {
  const Body& b = world.bodies.values()[m.slot];
  planar::PlaneBody p;
  p.kind = planar::PlaneBody::dynamic;
  p.position = flat(b.pose.position), p.angle = m.turned;
  p.velocity = flat(b.velocity), p.spin = b.angular_velocity.z;
  p.mass = b.mass, p.inertia = world_inertia(b.pose.rotation, b.inertia)[2].z;
  p.gravity_scale = b.gravity_scale, p.friction = 1;
  if (const Force* push = world.forces.find(m.body))
    p.force = flat(push->force), p.torque = push->torque.z;
  return p;
}

/// Uses the sliding coefficient; Box2D takes the square root of the product of both.
planar::PlaneBody finger_body(const World& world, const LaminaFinger& f, const Clock& clock,
                              planar::Outline& o) {
  const Body& b = world.bodies[f.body];
  planar::PlaneBody p;
  p.kind = planar::PlaneBody::kinematic;
  const Vec3 to_point = b.pose.rotation * f.point;
  const Vec3 end = b.pose.position + to_point;
  const Vec3 start =
      f.path.empty() ? end - clock.left() * b.velocity : motion_of(f.path, clock.now()).at;
  p.velocity = flat(end - start) / clock.left();
  p.friction = f.slide * f.slide;
  if (f.flat) {
    o.kind = planar::Outline::half_plane, o.normal = flat(b.pose.rotation * f.normal);
    p.position = flat(end);
  } else {
    const Real size = glm::length(f.point);
    o.radius = std::max(size, o.radius);
    p.position = flat(size > 0 ? b.pose.position : end);
  }
  return p;
}

void gather(const World& world, Island& m, const Clock& clock) {
  planar::Plane& plane = m.scratch.plane;
  const Real size = modes::extent(m.scratch.outline);
  if (plane.corners.empty()) append_outline(m, plane);
  std::erase_if(plane.outlines, [](const auto& o) { return o.kind != planar::Outline::polygon; });
  plane.bodies.clear();
  plane.bodies.push_back(lamina_body(world, m));
  plane.bodies[0].count = static_cast<std::uint32_t>(plane.outlines.size());
  const std::vector<LaminaFinger>& fingers = laminas_of(world)->find(m.body)->fingers;
  for (const std::uint32_t number : m.scratch.finger_of) {
    planar::Outline o = solid();
    o.radius = kPoint * size;
    planar::PlaneBody p = finger_body(world, fingers[number], clock, o);
    p.first = static_cast<std::uint32_t>(plane.outlines.size()), p.count = 1;
    plane.bodies.push_back(p), plane.outlines.push_back(o);
  }
  plane.gravity = flat(world.gravity);
  plane.unit = std::exp2(std::round(std::log2(size / 2)));
}

/// False, without changes, if the result is not finite.
bool take_result(World& world, Island& m, Real h) {
  const planar::PlaneBody& p = m.scratch.plane.bodies[0];
  Body& b = world.bodies.values()[m.slot];
  const Real damping = std::exp(-b.drag * h);
  const Vec3 position = b.pose.position + p.moved;
  const Vec3 velocity = damping * (flat(b.velocity) + p.sped_up);
  const Real spin = damping * (b.angular_velocity.z + p.spun_up);
  const auto fits = [](Vec3 v) { return glm::dot(v, v) < kWidest * kWidest; };
  if (!fits(position) || !fits(velocity) || !(std::abs(spin) < kWidest)) return false;
  m.turned += p.turned;
  b.pose.position = position, b.velocity = velocity, b.angular_velocity = {0, 0, spin};
  const Real half = 0.5 * std::remainder(m.turned, 2 * kPi);
  b.pose.rotation = Quat(std::cos(half), 0, 0, std::sin(half));
  b.restart = b.teleport = false;
  return true;
}

/// The fingers in contact, one bit each.
std::uint32_t touching(const Island& m) {
  std::uint32_t fingers = 0;
  for (const planar::PlaneContact& t : m.touches)
    if (t.normal_impulse > 0) fingers |= 1u << (std::max(t.a, t.b) - 1);
  return fingers;
}

/// Returns to modes once one has agreed with dynamics for long enough.
void go_back(World& world, Island& m, const Clock& clock) {
  IslandScratch& s = m.scratch;
  Body& b = world.bodies.values()[m.slot];
  const modes::Part part = part_of(world, m);
  find_fingers(world, m, {clock.start, clock.h, clock.h});
  Real fastest = 0;
  for (const modes::Finger& f : s.fingers) fastest = std::max(fastest, length(f.velocity));
  const Real fall = std::sqrt(length(part.force) / b.mass * modes::extent(s.outline));
  const Vec3 at = b.pose.position, v = b.velocity;
  const Real spin = b.angular_velocity.z;
  const modes::Found found{{{at.x, at.y}, m.turned},
                           {v.x + spin * at.y, v.y - spin * at.x, spin},
                           kAlike * fastest + kNoise * fall,
                           touching(m)};
  const modes::Signs last = m.motion.signs;
  s.stepper.motion = {};
  const bool holds = !m.touches.empty() && s.stepper.resume(part, s.fingers, found);
  const bool same = m.calm > 0 && s.stepper.motion.signs == last;
  m.calm = !holds ? 0 : same ? m.calm + clock.h : clock.h;
  m.motion = {};
  m.motion.signs = s.stepper.motion.signs;
  if (m.calm < kCalm) return;
  const modes::Placement& p = s.stepper.placed;
  b.pose.position.x = p.shift.x, b.pose.position.y = p.shift.y, m.turned = p.angle;
  const Real half = 0.5 * std::remainder(m.turned, 2 * kPi);
  b.pose.rotation = Quat(std::cos(half), 0, 0, std::sin(half));
  m.motion = s.stepper.motion;
  m.phase = Phase::modes, m.calm = 0, m.touches.clear();
  s.changed = true;
}

}  // namespace

void step_dynamics(World& world, Island& m, const Clock& clock) {
  Body& b = world.bodies.values()[m.slot];
  if (!has_planar_solver()) {  // it stays where the modes left it
    b.velocity = b.angular_velocity = Vec3(0);
    return;
  }
  find_fingers(world, m, clock);
  gather(world, m, clock);
  if (planar::find_unfit(m.scratch.plane) != UINT32_MAX) {
    m.lost = true;
    return;
  }
  const std::vector<planar::PlaneContact> before = m.touches;
  planar::step_plane(m.scratch.plane, clock.left(), m.touches);
  if (!take_result(world, m, clock.left())) {
    m.lost = true, m.touches = before;
    return;
  }
  go_back(world, m, clock);
}

}  // namespace pantin::detail::quasistatic
