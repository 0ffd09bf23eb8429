#include "engine/scene/build/cable_route.hpp"

#include "engine/scene/json/words.hpp"

namespace pantin::detail {
std::vector<PathPoint> route_of(const BuiltScene& built, const BuiltCable& cable) {
  std::vector<PathPoint> route;
  const auto add = [&](std::uint32_t body, const CableGuide& g) {
    const Pose pose = built.pose_of(body);
    const Mat3 turned = glm::mat3_cast(pose.rotation);
    route.push_back(path_point({pose.position, pose.rotation, turned, Vec3(0), Vec3(0)}, g.anchor,
                               g.axis, g.radius));
    route.back().wrap = g.wrap;
  };
  add(cable.a, {.body = {}, .anchor = cable.joint.anchor_a});
  for (const BuiltGuide& g : cable.guides) add(g.body, g.guide);
  add(cable.b, {.body = {}, .anchor = cable.joint.anchor_b});
  return route;
}

std::string fault_in(const std::vector<PathPoint>& route) {
  const auto fault = fault_of(route);
  if (!fault) return "";
  const std::string at = "found guides " + std::to_string(fault->place) + " and " +
                         std::to_string(fault->place + 1) +
                         " of the cable, counted from its end a, ";
  if (fault->askew)
    return at +
           "two pulleys in different planes, expected them in one plane, or a ring between them";
  return at + written(fault->distance) + " m apart, expected more than " + written(fault->least) +
         " m: they overlap";
}

}  // namespace pantin::detail
