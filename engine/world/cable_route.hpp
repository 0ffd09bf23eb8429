#pragma once
/// The points that a cable over guides passes, for the present poses.
#include <algorithm>
#include <vector>

#include "engine/joints/cable_path.hpp"
#include "engine/world/link.hpp"

namespace pantin::detail {

/// The route from a to b; `pose_of(body)` is a pose, or null if the body is gone: the route is then
/// empty.
template <class PoseOf>
std::vector<PathPoint> route_of(const Cable& cable, const PoseOf& pose_of) {
  std::vector<PathPoint> route;
  const auto add = [&](const CableGuide& g) {
    const Pose* pose = pose_of(g.body);
    if (!pose || !is_finite(*pose)) return false;
    const Mat3 turned = glm::mat3_cast(pose->rotation);
    route.push_back(path_point({pose->position, pose->rotation, turned, Vec3(0), Vec3(0)}, g.anchor,
                               g.axis, g.radius));
    route.back().wrap = g.wrap;
    return true;
  };
  bool known = add({.body = cable.a, .anchor = cable.joint.anchor_a});
  for (const CableGuide& g : cable.guides) known = known && add(g);
  known = known && add({.body = cable.b, .anchor = cable.joint.anchor_b});
  if (!known || route.size() > kMostPathPoints) route.clear();
  return route;
}

/// Elongation of a cable beyond its rest length, m, with or without guides; 0 if it is slack or a
/// body is gone.
template <class PoseOf>
Real stretch_of(const Cable& cable, const PoseOf& pose_of) {
  if (cable.guides.empty()) {
    const Pose *a = pose_of(cable.a), *b = pose_of(cable.b);
    return a && b ? stretch(cable.joint, *a, *b) : 0;
  }
  const std::vector<PathPoint> route = route_of(cable, pose_of);
  if (route.empty()) return 0;
  return std::max(Real(0), path_length(route, {}).length - cable.joint.length);
}

}  // namespace pantin::detail
