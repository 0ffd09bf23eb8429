// Box2D computes in single precision about one origin: clusters of bodies far from one another are
// stepped separately, each about its own. Box2D aborts the program on NaN: such planes never reach
// it.
#include <algorithm>
#include <cmath>

#include "engine/base/invariants.hpp"
#include "engine/solvers/planar/island.hpp"

namespace pantin::detail::planar {
namespace {

/// In units: radius about one body within which all are stepped together; the cluster extends
/// beyond it up to the next gap that no body crosses in a step.
constexpr Real kClusterRadius = 1e4, kClusterGap = 200;
/// In units, and m, m/s ...: bound on the numbers given to Box2D.
constexpr Real kLargest = 1e12;

bool fits(Real x) { return std::abs(x) < kLargest; }
bool fits(Vec3 v) { return fits(v.x) && fits(v.y) && fits(v.z); }
/// Whether a mass, also in single precision, is positive and finite.
bool is_float_mass(Real x) { return is_mass(x) && is_mass(static_cast<float>(x)); }

bool fits(const PlaneBody& b, Real unit) {
  if (!fits(b.position / unit) || !fits(b.velocity / unit) || !fits(b.angle) || !fits(b.spin))
    return false;
  if (!(b.friction >= 0 && fits(b.friction) && b.restitution >= 0 && fits(b.restitution)))
    return false;
  if (b.kind != PlaneBody::dynamic) return true;
  return is_float_mass(b.mass) && is_float_mass(b.inertia / (unit * unit)) &&
         fits(b.force / (b.mass * unit)) && fits(b.torque / b.inertia) && fits(b.gravity_scale);
}

bool fits(const PlaneJoint& j, Real unit) {
  const bool placed = fits(j.arm_a / unit) && fits(j.arm_b / unit) && fits(j.axis);
  const bool ranged = !j.limited || (fits(j.low) && fits(j.high) && j.low <= j.high);
  const Real squared = unit * unit;
  return placed && ranged && fits(j.angle_error) && fits(j.length / unit) &&
         std::isfinite(static_cast<float>(j.along.stiffness / squared)) &&
         std::isfinite(static_cast<float>(j.along.damping / squared)) && is_finite(j.load.force) &&
         std::isfinite(j.along.load) && std::isfinite(j.load.torque + j.load.spring);
}

/// Removes from `rest` the cluster of bodies about the first of them, up to a gap.
std::vector<std::uint32_t> take_cluster(const Plane& plane, std::vector<std::uint32_t>& rest) {
  PANTIN_ASSERT(!rest.empty() && std::is_sorted(rest.begin(), rest.end()));
  const Vec3 middle = plane.bodies[rest.front()].position;
  const auto distance = [&](std::uint32_t i) {
    return glm::length(plane.bodies[i].position - middle) / plane.unit;
  };
  std::sort(rest.begin(), rest.end(), [&](std::uint32_t i, std::uint32_t j) {
    return std::pair(distance(i), i) < std::pair(distance(j), j);
  });
  std::size_t count = 1;
  while (count < rest.size() && (distance(rest[count]) < kClusterRadius ||
                                 distance(rest[count]) - distance(rest[count - 1]) < kClusterGap))
    ++count;
  const auto end = rest.begin() + static_cast<std::ptrdiff_t>(count);
  std::vector<std::uint32_t> cluster(rest.begin(), end);
  rest.erase(rest.begin(), end);
  std::sort(rest.begin(), rest.end());
  return cluster;
}

}  // namespace

std::uint32_t find_unfit(const Plane& plane) {
  if (!fits(plane.gravity / plane.unit)) return 0;
  for (std::uint32_t i = 0; i < plane.bodies.size(); ++i)
    if (!fits(plane.bodies[i], plane.unit)) return i;
  for (const PlaneJoint& j : plane.joints)
    if (!fits(j, plane.unit)) return plane.bodies[j.b].kind == PlaneBody::dynamic ? j.b : j.a;
  return kNobody;
}

void step_clusters(Plane& plane, Real h, std::vector<PlaneContact>& touches) {
  std::vector<std::uint32_t> rest;
  for (std::uint32_t i = 0; i < plane.bodies.size(); ++i)
    if (plane.bodies[i].kind == PlaneBody::dynamic) rest.push_back(i);
  const std::vector<std::uint32_t> all = rest;
  if (rest.empty()) return touches.clear();
  std::vector<std::uint32_t> cluster = take_cluster(plane, rest);
  if (rest.empty()) return step_plane(plane, h, touches);
  const std::vector<PlaneContact> before = touches;
  touches.clear();
  for (;;) {
    for (const std::uint32_t i : all) plane.bodies[i].kind = PlaneBody::absent;
    for (const std::uint32_t i : cluster) plane.bodies[i].kind = PlaneBody::dynamic;
    std::vector<PlaneContact> own = before;
    step_plane(plane, h, own);
    touches.insert(touches.end(), own.begin(), own.end());
    if (rest.empty()) break;
    cluster = take_cluster(plane, rest);
  }
  for (const std::uint32_t i : all) plane.bodies[i].kind = PlaneBody::dynamic;
  std::sort(touches.begin(), touches.end(), comes_before);
}

}  // namespace pantin::detail::planar
