// The state of a lamina in its World at a time: `pantin modes --at`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/runtime/simulation.hpp"
#include "engine/solvers/quasistatic/island.hpp"
#include "tools/pantin/modes.hpp"

namespace pantin::program {
namespace {

constexpr double kTouch = 1e-6;   // relative to the outline's extent, as in the scene reader
constexpr double kForEver = 1e6;  // s

/// The rest of a path from a time on.
std::vector<Waypoint> rest_of(const std::vector<Waypoint>& path, double time, Vec2 at) {
  std::vector<Waypoint> rest{{0, at}};
  for (const Waypoint& w : path)
    if (w.time > time) rest.push_back({w.time - time, w.at});
  if (rest.size() == 1) rest.push_back({kForEver, at});
  return rest;
}

void move_finger(const LaminaPlan& plan, double time, FingerPlan& f) {
  std::vector<detail::FingerKey> keys;
  for (const Waypoint& w : f.path) keys.push_back({w.time, {w.at.x, w.at.y, 0}});
  const Vec3 at = detail::motion_of(keys, time).at;
  f.point = {at.x, at.y}, f.path = rest_of(f.path, time, f.point);
  const double size = extent(plan.outline);
  if (f.flat) {
    double least = 1e300;
    for (const Vec2 corner : plan.outline) least = std::min(least, dot(f.normal, corner - f.point));
    f.touches = least <= kTouch * size;
    return;
  }
  const Nearest near = nearest_edge(plan.outline, f.point, kTouch * size);
  f.touches = near.distance <= kTouch * size;
  f.normal = edge_of(plan.outline, near.edge).normal;
}

std::string running(const detail::quasistatic::Island& m, std::size_t fingers) {
  if (m.phase == detail::quasistatic::Phase::dynamics)
    return fmt::format("dynamics: {}", word_for(m.why));
  std::string letters(fingers, '.');
  for (std::size_t i = 0; i < m.motion.touches.count; ++i)
    letters[m.motion.touches.list[i].finger] = m.motion.signs.roll >> i & 1    ? 'R'
                                               : m.motion.signs.plus >> i & 1  ? '+'
                                               : m.motion.signs.minus >> i & 1 ? '-'
                                                                               : 'B';
  return letters;
}

}  // namespace

std::optional<LaminaPlan> plan_at(const Scene& scene, LaminaPlan plan, ModesChoices& c) {
  if (!can_move(plan, c)) return std::nullopt;
  Simulation sim = Simulation::copy_of(scene.world, {scene.step, scene.substeps});
  const Entity body = sim.world.find(plan.name);
  if (!detail::is_body(plan) || !body) {
    complain(fmt::format("{}: lamina \"{}\": found mass 0, expected some to move it by", c.scene,
                         plan.name));
    return std::nullopt;
  }
  detail::Lamina& moved = detail::laminas_of(sim.world)[body];
  for (std::size_t i = 0; i < plan.fingers.size(); ++i)
    moved.fingers[i].roll = plan.fingers[i].roll, moved.fingers[i].slide = plan.fingers[i].slide;
  while (c.at - sim.world.time > 1e-9) {
    sim.settings.h = std::min(scene.step, c.at - sim.world.time);
    if (sim.step().status == Status::diverged) {
      complain(fmt::format("{}: diverged at {:.6g} s", c.scene, sim.world.time));
      return std::nullopt;
    }
    if (interrupted()) return std::nullopt;
  }
  for (const detail::quasistatic::Island& m : detail::quasistatic::islands_of(sim.world))
    if (m.body == body) c.running = running(m, plan.fingers.size());
  const Pose pose = sim.world.origin_pose(body);
  const auto place = [&](Vec2 p) {
    const Vec3 at = to_world(pose, {p.x, p.y, 0});
    return Vec2{at.x, at.y};
  };
  for (Vec2& corner : plan.outline) corner = place(corner);
  plan.centre = place(plan.centre);
  for (FingerPlan& f : plan.fingers) move_finger(plan, c.at, f);
  return plan;
}

}  // namespace pantin::program
