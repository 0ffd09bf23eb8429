#include "engine/joints/stops.hpp"

#include <cmath>

#include "engine/joints/kinds.hpp"

namespace pantin::detail {
namespace {

/// Fraction of the cone: closer to its centre the gradient is undefined.
constexpr Real kMiddle = 1e-9;

/// For C = 1 - m^2: m - 1 divided by the length of its gradient.
JointStop cone_side(Real c, Vec3 along) {
  const Real m = std::sqrt(std::max(Real(0), 1 - c)), steep = glm::length(along) / (2 * m);
  if (!(m > kMiddle) || !(steep > 0)) return {-1, Vec3(0), false};
  return {(m - 1) / steep, -along / (2 * m * steep), true};
}

}  // namespace

FreeAxes free_axes(JointKind kind, Quat a, Quat b) {
  switch (turns_of(kind)) {
    case Turns::about_x:
      return {a * Vec3(1, 0, 0), Vec3(0)};
    case Turns::about_two:
      return {a * Vec3(0, 1, 0), b * Vec3(0, 0, 1)};
    case Turns::freely:
    case Turns::nowhere:
    case Turns::own:
      break;
  }
  return {};
}

void find_sides(const AngleLimit& limit, Real angle, Vec3 along, JointStop* out) {
  const Real middle = 0.5 * (limit.low + limit.high);
  angle -= 2 * kPi * std::round((angle - middle) / (2 * kPi));
  out[0] = {limit.low - angle, -along, true};
  out[1] = {angle - limit.high, along, true};
}

void find_stops(const JointState& at, JointStop (&out)[4]) {
  for (JointStop& side : out) side = {};
  const JointLimits& limits = at.joint.limits;
  if (!limits.any()) return;
  Real value = 0;
  Vec3 row[4];
  for (const FreeCoordinate& c : info_of(at.joint.kind).coordinates) {
    const bool is_angle = c.which == Coordinate::angle && limits.angle.on;
    const bool is_second = c.which == Coordinate::second && limits.second.on;
    const bool is_cone = c.which == Coordinate::swing && limits.swing.on;
    if (!is_angle && !is_second && !is_cone) continue;
    write_coordinate(at, c.which, {&value, row, nullptr, nullptr});
    const Vec3 along = row[3];
    if (is_angle) find_sides(limits.angle, value, along, &out[0]);
    if (is_second) find_sides(limits.second, value, along, &out[2]);
    if (is_cone) out[2] = cone_side(value, along);
  }
}

Real soft_stop_energy(const JointState& at) {
  const JointLimits& limits = at.joint.limits;
  JointStop sides[4];
  find_stops(at, sides);
  Real sum = 0;
  for (const JointStop& side : sides)
    if (const Real within = limits.soft_zone + side.beyond; side.is_watched && within > 0)
      sum += 0.5 * limits.soft_stiffness * within * within;
  return sum;
}

SoftStopLoad soft_stop_load(const JointState& at) {
  SoftStopLoad load;
  const JointLimits& limits = at.joint.limits;
  const Vec3 spin = at.b.angular_velocity - at.a.angular_velocity;
  JointStop sides[4];
  find_stops(at, sides);
  for (int k = 0; k < 4; ++k) {
    const Real within = limits.soft_zone + sides[k].beyond;
    if (!sides[k].is_watched || !(within > 0)) continue;
    const Real rate = glm::dot(sides[k].along, spin);
    load.torque -= (limits.soft_stiffness * within + limits.soft_damping * rate) * sides[k].along;
    load.along[k / 2] = sides[k].along, load.acts[k / 2] = true;
  }
  return load;
}

}  // namespace pantin::detail
