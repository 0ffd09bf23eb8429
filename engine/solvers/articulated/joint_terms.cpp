// Terms of joints that constrain rotations: free directions, limits and springs at the predicted
// poses.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/joints/stops.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

const Vec3 kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);

/// Stiffness of a limit as a stiff row, relative to its body's inertia.
constexpr Real kLimitWeight = 100;

/// Smallest half angle of a cone that is locked in one direction.
constexpr Real kMinConeAngle = 1e-6;  // rad

/// A joint at given rotations of its bodies.
struct At {
  const PackedJoint& packed;
  Quat a, b;      // joint axes of both bodies, world
  Quat rotation;  // of b's in a's

  At(const PackedJoint& j, Quat own, Quat parent)
      : packed(j),
        a((j.own_is_a ? own : parent) * j.joint.frames.a()),
        b((j.own_is_a ? parent : own) * j.joint.frames.b()),
        rotation(glm::conjugate(a) * b) {}

  /// 1 if the own body is the joint's body b, else -1.
  Real sign() const { return packed.own_is_a ? -1 : 1; }

  /// Rotation of the own body for the relative rotation `q`, with the parent fixed.
  Quat own_at(Quat q) const {
    return packed.own_is_a ? b * glm::conjugate(q) * glm::conjugate(packed.joint.frames.a())
                           : a * q * glm::conjugate(packed.joint.frames.b());
  }
};

void watch(const AngleLimit& limit, Real angle, Vec3 along, JointStop* out) {
  if (limit.on) find_sides(limit, angle, along, out);
}

void find_cone_side(const SwingLimit& limit, const At& at, Vec3 swing, JointStop* out) {
  if (!limit.on) return;
  const Real y = std::max(limit.y, kMinConeAngle), z = std::max(limit.z, kMinConeAngle);
  const Real angle = glm::length(swing), m = std::hypot(swing.y / y, swing.z / z);
  if (!(m > 1e-9) || !(angle > 1e-12)) {  // at the centre of the cone
    *out = {-std::min(y, z), Vec3(0), false};
    return;
  }
  // d(swing) = (w.e) e + (angle / sin angle) (w.(x_b x e)) (x_a x e) for a relative angular
  // velocity w.
  const Vec3 local = swing / angle, e = at.a * local;
  const Vec3 slope = at.a * Vec3(0, swing.y / (y * y * m), swing.z / (z * z * m));
  const Vec3 xa = at.a * kX, xb = at.b * kX;
  const Real ratio = std::sin(angle) > 1e-6 ? angle / std::sin(angle) : 1e6;
  const Vec3 grow =
      glm::dot(slope, e) * e + ratio * glm::dot(slope, glm::cross(xa, e)) * glm::cross(xb, e);
  const Real size = glm::length(grow);
  *out = {(m - 1) / size, grow / size, true};
}

/// The limits of a joint: angle low and high, second angle low and high (or one for swing).
void measure_stops(const At& at, JointStop (&out)[4]) {
  PANTIN_ASSERT(turns_of(at.packed.joint.kind) != Turns::own);
  const Joint& joint = at.packed.joint;
  const JointLimits& limits = joint.limits;
  switch (turns_of(joint.kind)) {
    case Turns::about_x:
      watch(limits.angle, swing_twist(at.rotation).twist, at.a * kX, &out[0]);
      return;
    case Turns::about_two: {
      const UniversalAngles angles = universal_angles(at.rotation);
      watch(limits.angle, angles.first, at.a * kY, &out[0]);
      watch(limits.second, angles.second, at.b * kZ, &out[2]);
      return;
    }
    case Turns::freely:
      break;
    case Turns::nowhere:
    case Turns::own:  // does not come here
      return;
  }
  if (!limits.any()) return;
  const SwingTwist parts = swing_twist(at.rotation);
  const Vec3 xa = at.a * kX, xb = at.b * kX;
  const Real c = 1 + glm::dot(xa, xb);
  if (c > 1e-6) watch(limits.angle, parts.twist, (xa + xb) / c, &out[0]);
  find_cone_side(limits.swing, at, parts.swing, &out[2]);
}

/// The limits of a joint, with gradients for the rotation of the own body relative to the parent. A
/// lock is one limit that acts in both directions.
void find_limits(const At& at, JointLimit (&out)[4]) {
  JointStop excess[4];
  measure_stops(at, excess);
  for (int s = 0; s < 4; ++s) {
    out[s] = {};
    if (!excess[s].is_watched) continue;
    const bool with_next = s % 2 == 0 && excess[s + 1].is_watched;
    if (with_next && excess[s].beyond + excess[s + 1].beyond > -1e-12) continue;
    const JointLimits& limits = at.packed.joint.limits;
    const bool both = s % 2 == 1 && (s == 1 ? limits.angle : limits.second).on &&
                      excess[s - 1].is_watched && excess[s - 1].beyond + excess[s].beyond > -1e-12;
    out[s] = {at.sign() * excess[s].along, -excess[s].beyond, true, both};
  }
}

/// Adds a spring of stiffness k (kg m^2/rad) along a direction, with `torque` at zero relative
/// rotation.
void add_spring(JointTerms& t, Real k, Vec3 along, Real torque) {
  t.spring += k * glm::outerProduct(along, along);
  t.torque += torque * along;
}

/// Length of a step, s, and what turns a force in it into a multiplier, kg m per N.
struct LoadScale {
  Real h = 0, to_load = 0;
};

void add_soft_zones(const JointLimits& limits, const LoadScale& scale, JointTerms& t) {
  if (!(limits.soft_zone > 0)) return;
  for (LimitRow& limit : t.limits) {
    if (limit.along == Vec3(0)) continue;
    // Tested at the prediction: a joint that leaves the zone is released in the next step.
    limit.soft = limits.soft_zone - limit.clearance;
    if (!(limit.soft > 0)) continue;
    PANTIN_ASSERT(scale.h > 0);
    const Real k = limits.soft_stiffness * scale.to_load;
    const Real d = limits.soft_damping * scale.to_load / scale.h;
    add_spring(t, k + d, limit.along, -k * limit.soft - d * glm::dot(limit.along, t.way));
  }
}

/// The drive as an implicit spring, without its torque limit.
void add_drive(const World& world, const At& at, const LoadScale& scale, JointTerms& t) {
  PANTIN_ASSERT(at.packed.drive < world.joint_drives.size());
  const JointDrive& drive = world.joint_drives.values()[at.packed.drive];
  const Quat own = at.own_at(at.rotation);
  const Quat target = target_at(drive, world.time + scale.h);
  const Vec3 residual = rotation_vector(at.own_at(target) * glm::conjugate(own));
  Vec3 ahead(0);
  if (!drive.keys.empty())
    ahead =
        at.sign() * (at.a * rotation_vector(target * glm::conjugate(target_at(drive, world.time))));
  const Real k = drive.stiffness * scale.to_load, d = drive.damping * scale.to_load / scale.h;
  t.drive_spring = k + d;
  t.drive_torque = k * residual - d * (t.way - ahead);
}

/// What acts along the coordinate of a joint.
struct Actuated {
  const Dof& by;
  Real angle;  // rad, before the step
};
/// The spring, friction and motor along the coordinate, at its end as far as the slopes tell.
void add_actuator(const Actuated& joint, const At& at, const LoadScale& scale, JointTerms& t) {
  const PackedJoint& j = at.packed;
  const Quat own = at.own_at(at.rotation);
  const Vec3 along = sign_of(j) * actuated_axis(j, own, t.parent);
  const Real angle = unwound(coordinate_of(j, own, t.parent), joint.angle);
  const Real rate = glm::dot(along, t.way) / scale.h;
  const LinearisedForce f = linearise(joint.by, angle, rate, Slope::secant);
  add_spring(t, scale.to_load * (f.stiffness + f.damping / scale.h), along,
             scale.to_load * f.force);
}

}  // namespace

Quat parent_rotation(const World& world, const Island& a, std::size_t c, Work rotation_row) {
  if (a.parents[c] >= 0)
    return a.scratch.work.quat(rotation_row, static_cast<std::size_t>(a.parents[c]));
  const std::uint32_t held = held_body_of(a, c);
  return held == UINT32_MAX ? kIdentity : world.bodies.values()[held].pose.rotation;
}

Quat own_rotation(const PackedJoint& joint, Quat parent, Quat rotation) {
  const At at(joint, kIdentity, parent);
  return glm::normalize(at.own_at(rotation));
}

Quat joint_rotation(const PackedJoint& joint, Quat own, Quat parent) {
  return At(joint, own, parent).rotation;
}

FreeAxes free_axes(const PackedJoint& joint, Quat own, Quat parent) {
  const At at(joint, own, parent);
  return detail::free_axes(joint.joint.kind, at.a, at.b);
}

void find_limits(const PackedJoint& joint, Quat own, Quat parent, JointLimit (&out)[4]) {
  find_limits(At(joint, own, parent), out);
}

void set_terms(const World& world, Island& a, Real h, const Pass& pass) {
  const Work rotation_row = pass.from.rotation;
  const LoadScale scale{.h = h, .to_load = a.force_share * h * h};
  PANTIN_ASSERT(a.joints.size() == a.count() && a.scratch.terms.size() == a.count());
  for (std::size_t c = 0; c < a.count(); ++c) {
    PackedJoint& j = a.joints[c];
    if (!j.stiff) continue;
    JointTerms& t = a.scratch.terms[c];
    const Quat own = a.scratch.work.quat(rotation_row, c);
    t.parent = parent_rotation(world, a, c, rotation_row);
    t.spring = Mat3(0), t.torque = t.drive_torque = t.align = Vec3(0), t.drive_spring = 0;
    Quat aligned = own;
    const At before(j, own, t.parent);
    if (turns_of(j.joint.kind) != Turns::freely) {
      aligned = glm::normalize(before.own_at(allowed_by_kind(j.joint.kind, before.rotation)));
      t.align = rotation_vector(aligned * glm::conjugate(own));
    }
    const At at(j, aligned, t.parent);
    t.free = detail::free_axes(j.joint.kind, at.a, at.b);
    JointLimit found[4];
    find_limits(at, found);
    for (int s = 0; s < 4; ++s) {
      LimitRow& limit = t.limits[s];
      const bool was_on = limit.on;
      limit = LimitRow{};
      if (!found[s].watched) continue;
      limit.along = found[s].along, limit.clearance = found[s].clearance;
      limit.both_ways = found[s].both_ways;
      limit.lambda = pass.corrects ? 0 : a.joint_memory[c].lambdas[s];
      limit.on =
          limit.both_ways || (pass.corrects ? was_on : limit.lambda > 0) || limit.clearance < 0;
    }
    if (pass.corrects) continue;
    const Body& body = world.bodies.values()[a.slots[c]];
    t.way = rotation_vector(own * glm::conjugate(body.pose.rotation));
    if (a.parents[c] >= 0) {
      const Body& q = world.bodies.values()[a.slots[static_cast<std::size_t>(a.parents[c])]];
      t.way -= rotation_vector(t.parent * glm::conjugate(q.pose.rotation));
    } else if (const std::uint32_t held = held_body_of(a, c); held != UINT32_MAX) {
      t.way -= h * world.bodies.values()[held].angular_velocity;
    }
    t.way += t.align;
    add_soft_zones(j.joint.limits, scale, t);
    if (j.drive != UINT32_MAX) add_drive(world, at, scale, t);
    if (is_actuated(j)) add_actuator({dof_of(world, a, c), a.joint_memory[c].angle}, at, scale, t);
  }
}

void regularise_limits(Island& a) {
  for (std::size_t c = 0; c < a.joints.size(); ++c) {
    if (!a.joints[c].stiff) continue;
    PANTIN_ASSERT(a.scratch.terms.size() == a.joints.size());
    const Mat3& tt = a.scratch.base[c].tt;
    for (LimitRow& limit : a.scratch.terms[c].limits)
      if (!limit.both_ways) limit.weight = kLimitWeight * (tt[0][0] + tt[1][1] + tt[2][2]);
  }
}

namespace {

/// Multipliers of the active limits, from the torque balance along them.
void find_limit_lambdas(JointTerms& t, Vec3 rotation, Vec3 translation) {
  LimitRow* on[2] = {nullptr, nullptr};
  for (LimitRow& limit : t.limits)
    if (limit.is_lock() && !on[1]) (on[0] ? on[1] : on[0]) = &limit;
  const auto push = [&](const LimitRow& s) {
    return s.pull - glm::dot(s.by_rotation, rotation) - glm::dot(s.by_translation, translation) -
           glm::dot(s.by_relative, t.rotated);
  };
  if (!on[0]) return;
  const Real first = push(*on[0]);
  on[0]->lambda = first;
  if (!on[1]) return;
  const Real second = push(*on[1]), c = glm::dot(on[0]->along, on[1]->along), det = 1 - c * c;
  if (!(det > 1e-6)) {
    on[1]->lambda = 0;
    return;
  }
  on[0]->lambda = (first - c * second) / det, on[1]->lambda = (second - c * first) / det;
}

}  // namespace

bool update_limits(Island& a, std::size_t c, const JointResponse& moved) {
  PackedJoint& j = a.joints[c];
  JointTerms& t = a.scratch.terms[c];
  PANTIN_ASSERT(j.stiff && a.parents[c] != kFree);
  JointStop excess[4];
  const At at(j, moved.own, moved.parent);
  measure_stops(at, excess);
  if (!a.iterates) find_limit_lambdas(t, moved.rotation, moved.translation);
  bool converged = true;
  for (int s = 0; s < 4; ++s) {
    LimitRow& limit = t.limits[s];
    if (!excess[s].is_watched) continue;
    const Real beyond = excess[s].beyond;
    const Vec3 along = at.sign() * excess[s].along;
    if (const Real same = glm::dot(along, limit.along); same < 0.7) {
      // The swing moved to another side of its cone.
      limit.along = along, limit.clearance = glm::dot(along, t.rotated) - beyond,
      limit.nonlinearity = 0;
      limit.lambda *= std::max(Real(0), same);
    }
    const Real linear = glm::dot(limit.along, t.rotated) - limit.clearance;
    if (limit.on && !limit.is_lock()) limit.lambda += limit.weight * (linear + limit.nonlinearity);
    if (a.iterates && !limit.both_ways) {
      converged = converged && std::abs(beyond - linear - limit.nonlinearity) < 1e-4;
    } else if (limit.on) {
      const bool still = !limit.is_lock() && std::abs(beyond) < 1e-5;
      if (limit.lambda <= 0 && still)
        limit.lambda = 0;
      else if (limit.lambda <= 0 && !limit.both_ways)
        limit.lambda = 0, limit.on = false, converged = false;
      converged = converged && beyond < (limit.is_lock() ? 1e-6 : 1e-5);
    } else if (beyond > 1e-9) {
      limit.on = true, limit.lambda = 0, converged = false;
    }
    limit.nonlinearity = beyond - linear;
  }
  return converged;
}

bool update_drive(World& world, Island& a, Real h, std::size_t c) {
  if (a.joints[c].drive == UINT32_MAX) return true;
  JointDrive& drive = world.joint_drives.values()[a.joints[c].drive];
  Real& known = a.joint_memory[c].torque_fraction;
  const JointTerms& t = a.scratch.terms[c];
  const Real to_load = a.force_share * h * h;
  const Real whole = glm::length(t.drive_torque - t.drive_spring * t.rotated) / to_load;
  const Real torque_fraction = whole > drive.max_torque ? drive.max_torque / whole : 1;
  drive.torque = known * whole, drive.capped = torque_fraction < 1;
  const bool converged = std::abs(torque_fraction - known) <= 1e-4 * known;
  if (!converged) known = torque_fraction;
  return converged;
}

Real work_of_springs(const Island& a, std::size_t c, Real h) {
  const JointTerms& t = a.scratch.terms[c];
  const Vec3 torque =
      t.torque - t.spring * t.rotated +
      a.joint_memory[c].torque_fraction * (t.drive_torque - t.drive_spring * t.rotated);
  return glm::dot(torque, t.way + t.rotated) / (a.force_share * h * h);
}

}  // namespace pantin::detail::articulated
