#include "engine/scene/cable_route.hpp"

#include "engine/scene/words.hpp"

namespace pantin::detail {
namespace {

/// How far pulleys that follow one another may be askew, rad, and that sine.
constexpr Real kAskew = 0.02;

}  // namespace

std::vector<PathPoint> route_of(const BuiltScene& built, const BuiltCable& cable) {
  std::vector<PathPoint> route;
  const auto add = [&](std::uint32_t body, const CableGuide& g) {
    const Pose pose = built.pose_of(body);
    const Mat3 turned = glm::mat3_cast(pose.rotation);
    route.push_back(path_point({pose.position, pose.rotation, turned, Vec3(0), Vec3(0)}, g.anchor,
                               g.axis, g.radius));
  };
  add(cable.a, {.body = {}, .anchor = cable.joint.anchor_a});
  for (const BuiltGuide& g : cable.guides) add(g.body, g.guide);
  add(cable.b, {.body = {}, .anchor = cable.joint.anchor_b});
  return route;
}

std::string fault_of(const std::vector<PathPoint>& route) {
  for (std::size_t i = 0; i + 1 < route.size(); ++i) {
    const PathPoint &a = route[i], &b = route[i + 1];
    const Vec3 d = b.centre - a.centre;
    const Real distance = glm::length(d);
    const std::string at = "found places " + std::to_string(i) + " and " + std::to_string(i + 1) +
                           " of the cable, counted from its end a, ";
    const bool crosses = glm::dot(a.axis, b.axis) < 0;
    const bool two = a.radius > 0 && b.radius > 0;
    const Real least = two && crosses ? a.radius + b.radius : std::abs(a.radius - b.radius);
    if (!(distance > least))
      return at + written(distance) + " m apart, expected more than " + written(least) +
             " m: they lie within one another";
    if (!two) continue;
    const bool leans = glm::length(glm::cross(a.axis, b.axis)) > kAskew;
    if (leans || std::abs(glm::dot(d, a.axis)) > kAskew * distance)
      return at + "two pulleys, expected them in one plane, or a ring between them";
  }
  return "";
}

}  // namespace pantin::detail
