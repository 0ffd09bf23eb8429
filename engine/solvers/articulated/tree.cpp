// The articulated solve for general joints: with constrained rotations, springs, limits and torques
// transmitted to the parent.
//
// With the translation y of the own joint point and the rotation t_p of the parent, a body rotates
// by t = t_p + c + r, where r lies in the free directions S. Minimising the energy of JointBlock
// over r, with a spring K of torque b at r = 0, gives with G = S (S^T (tt + K) S)^-1 S^T
//   t = [c + G (gt + b - tt c)] + P t_p - Y y,   P = 1 - G tt,  Y = G ty
// and for the parent an energy of the same form in (t_p, y): Featherstone's articulated inertia, in
// displacements instead of accelerations.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// The inverse of a symmetric positive definite matrix, pivots floored.
Mat3 inverse_of(const Mat3& m) {
  const Real floor = 4 * 2.220446049250313e-16 * (m[0][0] + m[1][1] + m[2][2]);
  const Real i0 = 1 / std::max(m[0][0], floor), l10 = m[0][1] * i0, l20 = m[0][2] * i0;
  const Real i1 = 1 / std::max(m[1][1] - l10 * m[0][1], floor), s = m[1][2] - l20 * m[0][1];
  const Real l21 = s * i1;
  const Real i2 = 1 / std::max(m[2][2] - l20 * m[0][2] - l21 * s, floor);
  const Real u20 = l10 * l21 - l20;
  const Real xx = i0 + l10 * l10 * i1 + u20 * u20 * i2, xy = -l10 * i1 - l21 * u20 * i2;
  const Real xz = u20 * i2, yy = i1 + l21 * l21 * i2, yz = -l21 * i2;
  return Mat3(xx, xy, xz, xy, yy, yz, xz, yz, i2);
}

/// Orthonormal basis of the free directions without locked ones; returns its size.
std::size_t free_directions(const PackedJoint& joint, JointTerms& t, Vec3 (&free)[3]) {
  Vec3 locked[2];
  std::size_t locks = 0, count = 0;
  for (const LimitRow& limit : t.limits) {
    if (!limit.is_lock() || locks == 2) continue;
    Vec3 n = limit.along;
    for (std::size_t i = 0; i < locks; ++i) n -= glm::dot(n, locked[i]) * locked[i];
    if (const Real size = glm::length(n); size > 1e-6) locked[locks++] = n / size;
  }
  const auto add = [&](Vec3 v) {
    for (std::size_t i = 0; i < locks; ++i) v -= glm::dot(v, locked[i]) * locked[i];
    for (std::size_t i = 0; i < count; ++i) v -= glm::dot(v, free[i]) * free[i];
    if (const Real size = glm::length(v); size > 1e-3) free[count++] = v / size;
  };
  PANTIN_ASSERT(turns_of(joint.joint.kind) != Turns::own);
  switch (turns_of(joint.joint.kind)) {
    case Turns::freely:
      if (locks == 2) {
        add(glm::cross(locked[0], locked[1]));
      } else if (locks == 1) {
        const Vec3 n = glm::abs(locked[0]);
        const Vec3 other = n.x <= n.y && n.x <= n.z ? Vec3(1, 0, 0)
                           : n.y <= n.z             ? Vec3(0, 1, 0)
                                                    : Vec3(0, 0, 1);
        add(other), add(glm::cross(locked[0], free[0]));
      } else {
        add(Vec3(1, 0, 0)), add(Vec3(0, 1, 0)), add(Vec3(0, 0, 1));
      }
      break;
    case Turns::about_x:
      add(t.free.first);
      break;
    case Turns::about_two:
      add(t.free.first), add(t.free.second);
      break;
    case Turns::nowhere:
    case Turns::own:  // does not come here
      break;
  }
  return count;
}

}  // namespace

Mat3 compliance_of(const Mat3& stiffness, const Vec3 (&free)[3], std::size_t count) {
  PANTIN_ASSERT(count <= 3);
  if (count == 3) return inverse_of(stiffness);
  if (count == 1)
    return glm::outerProduct(free[0], free[0]) / glm::dot(free[0], stiffness * free[0]);
  if (count == 0) return Mat3(0);
  const Vec3 k0 = stiffness * free[0], k1 = stiffness * free[1];
  const Real a = glm::dot(free[0], k0), b = glm::dot(free[1], k0), d = glm::dot(free[1], k1);
  const Real l = b / a, e = std::max(d - l * b, 1e-15 * d);
  const Vec3 v = free[1] - l * free[0];
  return glm::outerProduct(free[0], free[0]) / a + glm::outerProduct(v, v) / e;
}

namespace {

/// The relative rotation at the active locked limits.
Vec3 held_rotation(const JointTerms& t) {
  const LimitRow* on[2] = {nullptr, nullptr};
  for (const LimitRow& limit : t.limits)
    if (limit.is_lock() && !on[1]) (on[0] ? on[1] : on[0]) = &limit;
  if (!on[0]) return Vec3(0);
  const Real first = on[0]->clearance - on[0]->nonlinearity;
  if (!on[1]) return first * on[0]->along;
  const Real second = on[1]->clearance - on[1]->nonlinearity,
             c = glm::dot(on[0]->along, on[1]->along);
  const Real det = 1 - c * c;
  if (!(det > 1e-6)) return first * on[0]->along;
  return ((first - c * second) * on[0]->along + (second - c * first) * on[1]->along) / det;
}

/// A free ball joint: no torque is transmitted to the parent.
void eliminate_free_ball(const JointBlock& b, JointNode& n) {
  n.free_ball = true;
  n.compliance = inverse_of(b.tt);
  n.rotation_per_translation = n.compliance * b.ty;
  n.bias_rotation = n.compliance * b.gt;
  n.articulated_mass = b.yy - glm::transpose(b.ty) * n.rotation_per_translation;
  n.lambda = b.gy - glm::transpose(b.ty) * n.bias_rotation;
}

/// Any other joint. On return `b` is the block transmitted to the parent, at the own joint point.
void eliminate_stiff(Island& a, std::size_t c, JointBlock& b) {
  const Real torque_fraction = a.joint_memory[c].torque_fraction;
  PANTIN_ASSERT(c < a.joint_memory.size() && c < a.scratch.terms.size());
  JointTerms& t = a.scratch.terms[c];
  JointNode& n = a.scratch.joint_nodes[c];
  Mat3 spring = t.spring + Mat3(torque_fraction * t.drive_spring);
  Vec3 torque = t.torque + torque_fraction * t.drive_torque;
  for (const LimitRow& limit : t.limits) {
    if (!limit.on || limit.is_lock()) continue;
    spring += limit.weight * glm::outerProduct(limit.along, limit.along);
    torque += (limit.weight * (limit.clearance - limit.nonlinearity) - limit.lambda) * limit.along;
  }
  const Mat3 stiffness = b.tt + spring;
  const Vec3 held = held_rotation(t), stays = t.align + held;
  Vec3 free[3];
  const std::size_t count = free_directions(a.joints[c], t, free);
  n.free_ball = false;
  n.compliance = compliance_of(stiffness, free, count);
  for (LimitRow& limit : t.limits) {
    if (limit.along == Vec3(0)) continue;
    limit.pull = glm::dot(limit.along, b.gt + torque);
    limit.by_rotation = b.tt * limit.along,
    limit.by_translation = glm::transpose(b.ty) * limit.along;
    limit.by_relative = spring * limit.along;
  }
  const Mat3 passed = b.tt * n.compliance;  // tt G
  n.propagation = Mat3(1) - glm::transpose(passed);
  n.rotation_per_translation = n.compliance * b.ty;
  n.bias_rotation = stays + n.compliance * (b.gt + torque - b.tt * stays - spring * held);
  n.coupling = b.ty - passed * b.ty;
  n.articulated_mass = b.yy - glm::transpose(b.ty) * n.rotation_per_translation;
  n.lambda = b.gy - glm::transpose(b.ty) * n.bias_rotation;
  n.torque = b.gt - b.tt * n.bias_rotation;
  b.tt -= passed * b.tt;
}

/// An eliminated body as its parent sees it: the rotational part of its block, the gap at its joint
/// and the way from the parent's joint point to its own, m, world axes.
struct Child {
  const JointNode& node;
  const Mat3& rotational;
  Vec3 gap, lever;
};

/// Adds an eliminated body to the block of its parent.
void add_child(JointBlock& parent, const Child& child) {
  const auto& [n, rotational, gap, rho] = child;
  const Mat3 k = cross_matrix(rho);
  const Mat3 km = k * n.articulated_mass;
  const Vec3 f = n.lambda - n.articulated_mass * gap;
  parent.yy += n.articulated_mass, parent.gy += f, parent.gt += glm::cross(rho, f);
  parent.ty += km, parent.tt -= km * k;
  if (n.free_ball) return;
  // y = y_p + X t with X = -K.
  const Mat3 fx = n.coupling * k;
  parent.ty += n.coupling;
  parent.tt += rotational - fx - glm::transpose(fx);
  parent.gt += n.torque - n.coupling * gap;
}

Mat3 symmetric_at(const LaneTable& w, std::size_t row, std::size_t c) {
  const Real xx = w.at(row, c), xy = w.at(row + 1, c), xz = w.at(row + 2, c);
  const Real yy = w.at(row + 3, c), yz = w.at(row + 4, c), zz = w.at(row + 5, c);
  return Mat3(xx, xy, xz, xy, yy, yz, xz, yz, zz);
}

/// Geometric stiffness t (1 - r r^T / r^2) of a joint in tension t > 0.
Mat3 tension_stiffness(Real t, Vec3 r) {
  const Real r2 = glm::dot(r, r);
  return t > 0 && r2 > 0 ? t * (Mat3(1) - glm::outerProduct(r, r) / r2) : Mat3(0);
}

/// Cayley's map with an angle below 148 degrees; the identity if a number is not finite.
Quat bounded_rotation(Vec3 d) {
  const Real far = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
  if (!(far < 1e30)) return kIdentity;
  return cayley(far > 4 ? 4 / far * d : d);
}

bool is_stiff(const Island& a, std::size_t c) { return !a.joints.empty() && a.joints[c].stiff; }

}  // namespace

std::uint32_t held_body_of(const Island& a, std::size_t c) {
  for (const Tree& t : a.trees)
    if (t.first == c) return t.held_body;
  return UINT32_MAX;
}

void keep_gaps(Island& a) {
  PANTIN_ASSERT(a.scratch.gaps.size() == a.count());
  for (std::size_t c = 0; c < a.count(); ++c) a.scratch.gaps[c] = a.scratch.work.vec(kGap, c);
}

void fill_base(Island& a, Tension tension) {
  PANTIN_ASSERT(a.scratch.base.size() == a.count() && a.scratch.levers.size() == a.count());
  const LaneTable& w = a.scratch.work;
  for (std::size_t c = 0; c < a.count(); ++c) {
    JointBlock& b = a.scratch.base[c];
    const Real mass = a.constants.at(kMass, c);
    b.tt = symmetric_at(w, kRotationalInertia, c);
    b.ty = cross_matrix(-mass * w.vec(kArm, c));
    b.yy = Mat3(mass);
    b.gt = b.gy = Vec3(0);
    a.scratch.levers[c] = Vec3(0);
  }
  for (std::size_t c = 0; c < a.count(); ++c) {
    if (a.parents[c] < 0) continue;
    const auto parent = static_cast<std::size_t>(a.parents[c]);
    a.scratch.levers[c] = w.vec(kParentArm, c) - w.vec(kArm, parent);
  }
  for (std::size_t c = 0; tension == Tension::stiffens && c < a.count(); ++c) {
    const Vec3 lambda = a.memory.vec(kLambda, c), arm = w.vec(kArm, c), out = w.vec(kParentArm, c);
    a.scratch.base[c].tt += tension_stiffness(glm::dot(lambda, arm), arm);
    if (a.parents[c] >= 0)
      a.scratch.base[static_cast<std::size_t>(a.parents[c])].tt +=
          tension_stiffness(-glm::dot(lambda, out), out);
  }
}

void inward_pass(Island& a) {
  std::vector<JointBlock>& blocks = a.scratch.joint_blocks;
  PANTIN_ASSERT(blocks.size() == a.count() && a.scratch.joint_nodes.size() == a.count());
  for (std::size_t c = a.count(); c-- > 0;) {
    JointNode& n = a.scratch.joint_nodes[c];
    if (is_stiff(a, c))
      eliminate_stiff(a, c, blocks[c]);
    else
      eliminate_free_ball(blocks[c], n);
    if (a.parents[c] < 0) continue;
    PANTIN_ASSERT(static_cast<std::size_t>(a.parents[c]) < c);
    add_child(blocks[static_cast<std::size_t>(a.parents[c])],
              {n, blocks[c].tt, a.scratch.gaps[c], a.scratch.levers[c]});
  }
}

bool outward_pass(World& world, Island& a, Real h, const Pass& pass) {
  StepScratch& r = a.scratch;
  LaneTable& w = r.work;
  bool converged = true;
  auto tree = a.trees.begin();
  for (std::size_t c = 0; c < a.count(); ++c) {
    const JointNode& n = r.joint_nodes[c];
    const Quat q = w.quat(pass.from.rotation, c);
    const Vec3 own = w.vec(pass.from.position, c) + w.vec(kArm, c);
    Vec3 goal, parent_response(0);
    Quat parent_now = kIdentity;
    if (a.parents[c] >= 0) {
      const auto p = static_cast<std::size_t>(a.parents[c]);
      parent_now = r.rotations[p], parent_response = r.rotation[p];
      // The parent's joint point is at its final position; the arm rotates with the parent.
      goal = w.vec(kAttach, p) +
             parent_now * (a.constants.vec(kParentAnchor, c) - a.constants.vec(kOwnAnchor, p));
    } else {
      PANTIN_ASSERT(tree != a.trees.end() && tree->first == c);
      goal = a.parents[c] == kHeld ? tree->target
                                   : own + solve_symmetric(n.articulated_mass, n.lambda);
      ++tree;
    }
    // The next body responds to the nonlinear position of this joint. With stiff contact rows it
    // responds to the linear solution instead (see README.md).
    Vec3 y = goal - own;
    if (a.stiff_contacts && !pass.corrects && a.parents[c] >= 0) {
      const auto p = static_cast<std::size_t>(a.parents[c]);
      y = r.translation[p] + glm::cross(r.rotation[p], r.levers[c]) + r.gaps[c];
    }
    Vec3 d = n.bias_rotation - n.rotation_per_translation * y;
    Vec3 lambda = n.articulated_mass * y - n.lambda;
    if (!n.free_ball)
      d += n.propagation * parent_response, lambda += glm::transpose(n.coupling) * parent_response;
    if (a.parents[c] == kFree || !(glm::dot(lambda, lambda) < 1e36)) lambda = Vec3(0);
    a.memory.set(kLambda, c, lambda);
    if (!is_finite(d)) d = Vec3(0);
    Quat now, rotated;
    if (n.free_ball) {
      rotated = bounded_rotation(d);
      now = glm::normalize(rotated * q);
    } else {
      JointTerms& t = r.terms[c];
      const PackedJoint& joint = a.joints[c];
      if (a.parents[c] < 0) parent_now = t.parent;
      t.rotated = d - parent_response - t.align;
      const Quat relative = bounded_rotation(t.rotated) * (from_rotation_vector(t.align) * q);
      now = glm::normalize(parent_now * glm::conjugate(t.parent) * relative);
      const Quat rotation = joint_rotation(joint, now, parent_now);
      const Quat kind = allowed_by_kind(joint.joint.kind, rotation);
      if (!pass.corrects) {
        const Quat unclamped = own_rotation(joint, parent_now, kind);
        const JointResponse moved{
            .own = unclamped, .parent = parent_now, .rotation = d, .translation = y};
        converged = update_limits(a, c, moved) && converged;
        converged = update_drive(world, a, h, c) && converged;
      }
      const Quat allowed = allowed_rotation(joint.joint, kind);
      if (turns_of(joint.joint.kind) != Turns::freely || !(allowed == rotation))
        now = own_rotation(joint, parent_now, allowed);
      rotated = now * glm::conjugate(q);
    }
    r.translation[c] = y, r.rotation[c] = d;
    r.rotations[c] = now;
    w.set(kAppliedRotation, c, rotated);
    w.set(kAttach, c, goal);
  }
  return converged;
}

void propagate_inward(const Island& a, std::vector<Vec3x4>& force, std::vector<Vec3x4>& torque) {
  PANTIN_ASSERT(force.size() == a.count() && torque.size() == a.count());
  for (std::size_t c = a.count(); c-- > 0;) {
    if (force[c].none() && torque[c].none()) continue;
    const JointNode& n = a.scratch.joint_nodes[c];
    Vec3x4 f = force[c];
    f.subtract(Vec3x4::transposed_times(n.rotation_per_translation, torque[c]));
    Vec3x4 t;
    if (!n.free_ball) t = Vec3x4::transposed_times(n.propagation, torque[c]);
    torque[c] = Vec3x4::times(n.compliance, torque[c]);
    force[c] = f;
    if (a.parents[c] < 0) continue;
    const auto parent = static_cast<std::size_t>(a.parents[c]);
    force[parent].add(f);
    torque[parent].add_cross(a.scratch.levers[c], f);
    if (!n.free_ball) torque[parent].add(t);
  }
}

void propagate_outward(const Island& a, std::vector<Vec3x4>& force, std::vector<Vec3x4>& torque) {
  PANTIN_ASSERT(force.size() == a.count() && torque.size() == a.count());
  for (std::size_t c = 0; c < a.count(); ++c) {
    const JointNode& n = a.scratch.joint_nodes[c];
    Vec3x4 y;
    if (a.parents[c] >= 0) {
      const auto parent = static_cast<std::size_t>(a.parents[c]);
      y = force[parent];
      y.subtract_cross(a.scratch.levers[c], torque[parent]);
      if (!n.free_ball) torque[c].add(Vec3x4::times(n.propagation, torque[parent]));
    } else if (a.parents[c] == kFree) {
      y = Vec3x4::times(inverse_of(n.articulated_mass), force[c]);
    }
    torque[c].subtract(Vec3x4::times(n.rotation_per_translation, y));
    force[c] = y;
  }
}

}  // namespace pantin::detail::articulated
