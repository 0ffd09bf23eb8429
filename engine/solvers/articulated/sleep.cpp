// Islands at rest on fixed bodies sleep until something wakes them.
#include <algorithm>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// A body that has drifted by less counts as unmoved: the way at the sleep speed in this time, s,
/// and a fraction of the size of its island. Less than half of the island's mass may sway this much
/// farther.
constexpr Real kRestDriftTime = 2.5, kRestDriftOfSize = 3e-3, kSwayFactor = 16;
/// s: what stays for so long rests. Creep shows as motion only after that time.
constexpr Real kTimeToRest = 1;

}  // namespace

bool must_wake(const World& world, const Island& a) {
  if (world.gravity != a.asleep_gravity) return true;
  for (const Tree& t : a.trees)
    if (t.target != t.target_before) return true;
  for (const PackedPin& h : a.pins)
    if (h.target != h.target_before) return true;
  for (const std::uint32_t slot : a.slots) {
    const Body& b = world.bodies.values()[slot];
    if (b.restart || b.teleport || b.velocity != Vec3(0) || b.angular_velocity != Vec3(0))
      return true;
  }
  for (std::size_t c = 0; !world.forces.empty() && c < a.count(); ++c) {
    const Force* f = world.forces.find(a.bodies[c]);
    if (f && (f->force != Vec3(0) || f->torque != Vec3(0))) return true;
  }
  return false;
}

void rouse(Island& a) {
  a.asleep = a.rested = false;
  a.quiet_time = a.rest_time = 0;
}

void wake(World& world, Island& a, Real h) {
  rouse(a);
  update(world, a, h);
}

void predict_still(const World& world, Island& a) {
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Pose& pose = world.bodies.values()[a.slots[c]].pose;
    a.scratch.work.set(kPosition, c, pose.position),
        a.scratch.work.set(kRotation, c, pose.rotation);
  }
}

bool has_rested(const World& world, Island& a, Real h) {
  if (a.rests.empty()) return false;
  PANTIN_ASSERT(a.rests.size() == a.count());
  Real near = kRestDriftTime * a.settings.sleep_speed;
  if (a.size > 0) near = std::min(near, kRestDriftOfSize * a.size);
  Real moved = 0, whole = 0, farthest = 0, fastest = 0;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    const Quat turn = b.pose.rotation * glm::conjugate(a.rests[c].rotation);
    const Real angle = 2 * glm::length(Vec3(turn.x, turn.y, turn.z));
    const Real by = std::max(glm::length(b.pose.position - a.rests[c].position), angle / kTurning);
    farthest = std::max(farthest, by);
    fastest =
        std::max({fastest, glm::length(b.velocity), glm::length(b.angular_velocity) / kTurning});
    whole += b.mass;
    if (!(by < near)) moved += b.mass;
  }
  a.rest_time += h;
  if (!(farthest < kSwayFactor * near) || !(2 * moved < whole)) {
    a.rested = a.contact_active && a.rest_time > kTimeToRest;
    a.rest_time = 0;
    for (std::size_t c = 0; c < a.count(); ++c) a.rests[c] = world.bodies.values()[a.slots[c]].pose;
  }
  return a.contact_active && near > 0 && fastest * kTimeToSleep < kSwayFactor * near &&
         (a.rested || a.rest_time > kTimeToRest);
}

void fall_asleep(World& world, Island& a) {
  PANTIN_ASSERT(!a.asleep);
  a.asleep = true;
  a.asleep_gravity = world.gravity;
  for (std::uint32_t c = 0; c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.velocity = b.angular_velocity = Vec3(0);
    a.memory.set(kLastTranslation, c, Vec3(0)), a.memory.set(kLastRotation, c, Vec3(0));
  }
}

}  // namespace pantin::detail::articulated
