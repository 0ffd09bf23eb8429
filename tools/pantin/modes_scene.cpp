// Laminas as bodies of a scene, for other commands to draw and move.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/pantin/modes.hpp"

namespace pantin::program {
namespace {

/// Sizes relative to the outline's extent.
constexpr double kFinger = 0.01, kThick = 0.04, kFlat = 10;
// Fraction of a path segment in which a finger changes over to the next.
constexpr double kTurn = 0.002;

Json triple(Vec2 v, double z = 0) { return Json::array({v.x, v.y, z}); }

Json hull_of(std::span<const Vec2> corners, double thick) {
  Json points = Json::array();
  for (const Vec2 c : corners)
    for (const double z : {-thick / 2, thick / 2}) points.push_back(triple(c, z));
  return {{"type", "hull"}, {"points", points}, {"material", "lamina"}};
}

Json shapes_of(const LaminaPlan& plan, double thick) {
  Json shapes = Json::array();
  for (const auto& piece : convex_pieces(plan.outline)) shapes.push_back(hull_of(piece, thick));
  return shapes;
}

/// The position of a finger's body for a position of its contact point.
Vec2 behind(const FingerPlan& f, Vec2 point, double size) {
  return point - kFinger * size * f.normal;
}

Json finger_body(const LaminaPlan& plan, std::size_t i, double size) {
  const FingerPlan& f = plan.fingers[i];
  Json body{{"name", fmt::format("finger {}", f.name)}, {"motion", "kinematic"}};
  const std::string material = fmt::format("finger {}", i + 1);
  if (f.flat) {
    const double angle = std::atan2(f.normal.y, f.normal.x) * 180 / kPi;
    body["rotation_deg"] = {0, 0, angle};
    body["shape"] = {{"type", "box"},
                     {"size", {2 * kFinger * size, kFlat * size, kThick * size}},
                     {"material", material}};
  } else {
    body["shape"] = {{"type", "sphere"}, {"radius", kFinger * size}, {"material", material}};
  }
  body["position"] = triple(behind(f, f.point, size));
  return body;
}

/// The finger's path as keys, slower by a factor; a key before and one after keep the speed
/// constant.
Json finger_path(const FingerPlan& f, double duration, double slower, double size) {
  Json keys = Json::array();
  const auto add = [&](double time, Vec2 at) {
    keys.push_back({{"time", time * slower}, {"position", triple(behind(f, at, size))}});
  };
  const Vec2 first = first_velocity(f);
  add(-duration, f.point - duration * first);
  Vec2 velocity = first, at = f.point;
  double time = 0;
  for (std::size_t k = 0; k + 1 < f.path.size(); ++k) {
    const Waypoint &a = f.path[k], &b = f.path[k + 1];
    add(a.time, a.at);
    velocity = 1 / (b.time - a.time) * (b.at - a.at);
    time = std::min(b.time, duration), at = a.at + (time - a.time) * velocity;
    const double turn = kTurn * (time - a.time);
    add(a.time + turn, a.at + turn * velocity);
    add(time - turn, at - turn * velocity);
    if (b.time >= duration) break;
    velocity = {};
  }
  add(time, at);
  add(time + kTurn * duration, at + kTurn * duration * velocity);
  add(time + duration, at + duration * velocity);
  return {{"body", fmt::format("finger {}", f.name)}, {"keyframes", keys}};
}

/// The scene without the lamina's own body.
Json frame_of(const Scene& scene, const LaminaPlan& plan, double duration, double slower) {
  const double size = extent(plan.outline);
  const Vec3 g = scene.world.gravity;
  Json j{{"version", 1},
         {"title", scene.title},
         {"gravity", {g.x, g.y, g.z}},
         {"duration", duration * slower},
         {"step", 1.0 / 240},
         {"drift_bound", 1e-6},
         {"ground", false},
         {"collision", {{"restitution", 0}, {"others", false}, {"self", false}}},
         {"solver", {{"type", "lagrangian"}}}};
  j["camera"] = {{"eye", {0, 0, 3 * size}}, {"target", {0, 0, 0}}, {"automatic", true}};
  j["materials"] = Json::array({{{"name", "lamina"}, {"colour", "#c89b5c"}}});
  j["material_pairs"] = j["bodies"] = j["paths"] = Json::array();
  for (std::size_t i = 0; i < plan.fingers.size(); ++i) {
    const std::string material = fmt::format("finger {}", i + 1);
    j["materials"].push_back({{"name", material}, {"colour", "#2f66b0"}});
    j["material_pairs"].push_back(
        {{"a", "lamina"}, {"b", material}, {"friction", plan.fingers[i].slide}});
    j["bodies"].push_back(finger_body(plan, i, size));
    j["paths"].push_back(finger_path(plan.fingers[i], duration, slower, size));
  }
  return j;
}

}  // namespace

double radius_of_finger(const LaminaPlan& plan) { return kFinger * extent(plan.outline); }

std::string scene_along(const Scene& scene, const LaminaPlan& plan, const Places& places) {
  const double end = places.interval * static_cast<double>(places.list.size() - 1);
  Json j = frame_of(scene, plan, std::max(end, 0.01), 1);
  j.erase("solver"), j.erase("collision"), j["step"] = 1.0 / 60;
  j["bodies"].push_back({{"name", plan.name},
                         {"motion", "kinematic"},
                         {"shapes", shapes_of(plan, kThick * extent(plan.outline))}});
  Json keys = Json::array();
  for (std::size_t i = 0; i < places.list.size(); ++i) {
    const Placement& p = places.list[i];
    keys.push_back({{"time", places.interval * static_cast<double>(i)},
                    {"position", triple(p.shift)},
                    {"rotation", {0, 0, std::sin(p.angle / 2), std::cos(p.angle / 2)}}});
  }
  j["paths"].push_back({{"body", plan.name}, {"keyframes", keys}});
  return j.dump(1) + "\n";
}

std::string scene_of_dynamics(const Scene& scene, const LaminaPlan& plan, double duration,
                              double slower) {
  Json j = frame_of(scene, plan, duration, slower);
  const Vec3 g = scene.world.gravity;
  const Vec2 pull = plan.force - Vec2{plan.mass * g.x, plan.mass * g.y};
  j["bodies"].push_back({{"name", plan.name},
                         {"mass", plan.mass},
                         {"drag", 0},
                         {"centre_of_mass", triple(plan.centre)},
                         {"collision", true},
                         {"shapes", shapes_of(plan, kThick * extent(plan.outline))}});
  j["joints"] = Json::array({{{"kind", "planar"},
                              {"a", "world"},
                              {"b", plan.name},
                              {"anchor", triple(plan.centre)},
                              {"axis", {0, 0, 1}}}});
  if (length(pull) > 0 || plan.torque != 0)
    j["events"] = Json::array({{{"type", "push"},
                                {"body", plan.name},
                                {"force", triple(pull)},
                                {"torque", {0, 0, plan.torque}},
                                {"anchor", triple(plan.centre)},
                                {"from", 0},
                                {"to", duration * slower}}});
  return j.dump(1) + "\n";
}

}  // namespace pantin::program
