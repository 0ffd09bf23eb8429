// Lists the laminas, and carries over their state.
#include <algorithm>
#include <cmath>

#include "engine/base/invariants.hpp"
#include "engine/solvers/quasistatic/island.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::quasistatic {
namespace {

modes::Vec2 flat(Vec3 v) { return {v.x, v.y}; }

}  // namespace

void compile(World& world, std::span<const IslandPlan> plans) {
  std::vector<Island>& all = islands_of(world);
  const std::vector<Island> before = std::move(all);
  all.clear();
  Partition& partition = world.memory.of<Partition>();
  for (const IslandPlan& plan : plans) {
    Island& m = all.emplace_back();
    PANTIN_ASSERT(plan.solver == kQuasistatic && !plan.slots.empty());
    m.slot = plan.slots.front();
    m.body = world.bodies.owners()[m.slot];
    const auto old = std::find_if(before.begin(), before.end(),
                                  [&](const Island& b) { return b.body == m.body && !b.unfit; });
    if (old != before.end()) m = *old, m.slot = plan.slots.front();
    m.unfit = bool(plan.unfit);
    for (const std::uint32_t slot : plan.slots) partition.set_column(slot, 0);
    const std::size_t fingers = m.unfit ? 0 : laminas_of(world)[m.body].fingers.size();
    const auto gone = [&](const modes::Touch& t) { return t.finger >= fingers; };
    if (std::any_of(m.motion.touches.begin(), m.motion.touches.end(), gone)) m.motion = {};
    const auto unknown = [&](const planar::PlaneContact& t) {
      return std::max(t.a, t.b) > fingers;
    };
    std::erase_if(m.touches, unknown);
  }
}

void prepare(World& world) {
  for (Island& m : islands_of(world)) {
    IslandScratch& s = m.scratch;
    if (m.unfit || !s.outline.empty()) continue;
    const Lamina& lamina = laminas_of(world)[m.body];
    for (const Vec3 corner : lamina.outline) s.outline.push_back(flat(corner));
    s.fingers.reserve(lamina.fingers.size()), s.finger_of.reserve(lamina.fingers.size());
    // A flat finger may touch two corners, a pointed one two edges of a reflex corner.
    s.stepper.reserve(2 * lamina.fingers.size());
    s.stepper.doubt = modes::Doubt::stop;
  }
}

modes::Part part_of(const World& world, const Island& m) {
  PANTIN_ASSERT(m.slot < world.bodies.size());
  const Body& b = world.bodies.values()[m.slot];
  Vec3 force = b.mass * b.gravity_scale * world.gravity;
  Real torque = 0;
  if (const Force* push = world.forces.find(m.body)) force += push->force, torque = push->torque.z;
  return {m.scratch.outline, {0, 0}, flat(force), torque};
}

Real find_fingers(const World& world, Island& m, const Clock& clock) {
  IslandScratch& s = m.scratch;
  s.fingers.clear(), s.finger_of.clear();
  Real until = clock.start + clock.h;
  PANTIN_ASSERT(laminas_of(world)->find(m.body));
  const std::vector<LaminaFinger>& all = laminas_of(world)->find(m.body)->fingers;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const LaminaFinger& f = all[i];
    const Body* body = world.bodies.find(f.body);
    if (!body) continue;
    const Vec3 arm = body->pose.rotation * f.point;
    FingerMotion motion{body->pose.position + arm - clock.left() * body->velocity, body->velocity,
                        until};
    if (!f.path.empty()) motion = motion_of(f.path, clock.now());
    until = std::min(until, motion.until);
    s.fingers.push_back({flat(motion.at), flat(motion.velocity),
                         flat(body->pose.rotation * f.normal), f.flat, f.roll, f.slide});
    s.finger_of.push_back(static_cast<std::uint32_t>(i));
  }
  return until;
}

}  // namespace pantin::detail::quasistatic
