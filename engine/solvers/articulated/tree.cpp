// The articulated solve in its general form: joints may leave fewer turns free than all, carry
// springs and stops, and pass torque to the parent; bodies may be tied to places in the world.
//
// With the own joint point's slide y and the parent's turn t_p, a body turns by t = t_p + c + r,
// where r lies in the free directions. Minimising the energy of JointBlock over r, with a spring K
// that pulls with b at r = 0, leaves with G = S (S^T (tt + K) S)^-1 S^T
//   t = [c + G (gt + b - tt c)] + P t_p - Y y,   P = 1 - G tt,  Y = G ty
// and to the parent an energy of the same form in (t_p, y). [Featherstone's articulated inertia, in
// displacements instead of accelerations]
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::articulated {
namespace {

Mat3 crossing(Vec3 v) { return Mat3(0, v.z, -v.y, -v.z, 0, v.x, v.y, -v.x, 0); }

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

/// The directions a kind leaves free, orthonormal, locked ones taken out; returns how many.
std::size_t free_directions(const PackedJoint& joint, JointTerms& t, Vec3 (&free)[3]) {
  Vec3 locked[2];
  std::size_t locks = 0, count = 0;
  for (const Stop& stop : t.stops) {
    if (!stop.is_lock() || locks == 2) continue;
    Vec3 n = stop.along;
    for (std::size_t i = 0; i < locks; ++i) n -= glm::dot(n, locked[i]) * locked[i];
    if (const Real size = glm::length(n); size > 1e-6) locked[locks++] = n / size;
  }
  const auto add = [&](Vec3 v) {
    for (std::size_t i = 0; i < locks; ++i) v -= glm::dot(v, locked[i]) * locked[i];
    for (std::size_t i = 0; i < count; ++i) v -= glm::dot(v, free[i]) * free[i];
    if (const Real size = glm::length(v); size > 1e-3) free[count++] = v / size;
  };
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
      add(t.first);
      break;
    case Turns::about_two:
      add(t.first), add(t.second);
      break;
    default:  // nowhere; other kinds do not come here
      break;
  }
  return count;
}

/// G = S (S^T K S)^-1 S^T for the directions S.
Mat3 give_of(const Mat3& stiffness, const Vec3 (&free)[3], std::size_t count) {
  if (count == 3) return inverse_of(stiffness);
  if (count == 1) return glm::outerProduct(free[0], free[0]) / glm::dot(free[0], stiffness * free[0]);
  if (count == 0) return Mat3(0);
  const Vec3 k0 = stiffness * free[0], k1 = stiffness * free[1];
  const Real a = glm::dot(free[0], k0), b = glm::dot(free[1], k0), d = glm::dot(free[1], k1);
  const Real l = b / a, e = std::max(d - l * b, 1e-15 * d);
  const Vec3 v = free[1] - l * free[0];
  return glm::outerProduct(free[0], free[0]) / a + glm::outerProduct(v, v) / e;
}

/// The relative turn that the stops which are on hold the joint to.
Vec3 held_turn(const JointTerms& t) {
  const Stop* on[2] = {nullptr, nullptr};
  for (const Stop& stop : t.stops)
    if (stop.is_lock() && !on[1]) (on[0] ? on[1] : on[0]) = &stop;
  if (!on[0]) return Vec3(0);
  const Real first = on[0]->room - on[0]->bend;
  if (!on[1]) return first * on[0]->along;
  const Real second = on[1]->room - on[1]->bend, c = glm::dot(on[0]->along, on[1]->along);
  const Real det = 1 - c * c;
  if (!(det > 1e-6)) return first * on[0]->along;
  return ((first - c * second) * on[0]->along + (second - c * first) * on[1]->along) / det;
}

/// A free ball joint: the parent does not feel the body's turn.
void eliminate_loose(const JointBlock& b, JointNode& n) {
  n.loose = true;
  n.give = inverse_of(b.tt);
  n.swing = n.give * b.ty;
  n.turn = n.give * b.gt;
  n.group = b.yy - glm::transpose(b.ty) * n.swing;
  n.load = b.gy - glm::transpose(b.ty) * n.turn;
}

/// Any other joint. Leaves in `b` what the parent feels, at the own joint point.
void eliminate_stiff(Island& a, std::size_t c, JointBlock& b) {
  const Real share = a.joint_memory[c].share;
  JointTerms& t = a.room.terms[c];
  JointNode& n = a.room.joint_nodes[c];
  Mat3 spring = t.spring + Mat3(share * t.drive_spring);
  Vec3 torque = t.torque + share * t.drive_torque;
  for (const Stop& stop : t.stops) {
    if (!stop.on || stop.is_lock()) continue;
    spring += stop.weight * glm::outerProduct(stop.along, stop.along);
    torque += (stop.weight * (stop.room - stop.bend) - stop.load) * stop.along;
  }
  const Mat3 stiffness = b.tt + spring;
  const Vec3 held = held_turn(t), stays = t.align + held;
  Vec3 free[3];
  const std::size_t count = free_directions(a.joints[c], t, free);
  n.loose = false;
  n.give = give_of(stiffness, free, count);
  for (Stop& stop : t.stops) {
    if (stop.along == Vec3(0)) continue;
    stop.pull = glm::dot(stop.along, b.gt + torque);
    stop.by_turn = b.tt * stop.along, stop.by_slide = glm::transpose(b.ty) * stop.along;
    stop.by_relative = spring * stop.along;
  }
  const Mat3 passed = b.tt * n.give;  // tt G
  n.follow = Mat3(1) - glm::transpose(passed);
  n.swing = n.give * b.ty;
  n.turn = stays + n.give * (b.gt + torque - b.tt * stays - spring * held);
  n.lever = b.ty - passed * b.ty;
  n.group = b.yy - glm::transpose(b.ty) * n.swing;
  n.load = b.gy - glm::transpose(b.ty) * n.turn;
  n.torque = b.gt - b.tt * n.turn;
  b.tt -= passed * b.tt;
}

/// Adds a body, as felt at its joint, to the block of its parent. `felt` is the turning part.
void add_child(JointBlock& parent, const JointNode& n, const Mat3& felt, Vec3 gap, Vec3 rho) {
  const Mat3 k = crossing(rho);
  const Mat3 km = k * n.group;
  const Vec3 f = n.load - n.group * gap;
  parent.yy += n.group, parent.gy += f, parent.gt += glm::cross(rho, f);
  parent.ty += km, parent.tt -= km * k;
  if (n.loose) return;
  // y = y_p + X t with X = -K.
  const Mat3 fx = n.lever * k;
  parent.ty += n.lever;
  parent.tt += felt - fx - glm::transpose(fx);
  parent.gt += n.torque - n.lever * gap;
}

Mat3 symmetric_at(const Table& w, std::size_t row, std::size_t c) {
  const Real xx = w.at(row, c), xy = w.at(row + 1, c), xz = w.at(row + 2, c);
  const Real yy = w.at(row + 3, c), yz = w.at(row + 4, c), zz = w.at(row + 5, c);
  return Mat3(xx, xy, xz, xy, yy, yz, xz, yz, zz);
}

/// t (1 - r r^T / r^2) where t > 0: a loaded joint's force turns with its body within the step.
Mat3 tension_stiffness(Real t, Vec3 r) {
  const Real r2 = glm::dot(r, r);
  return t > 0 && r2 > 0 ? t * (Mat3(1) - glm::outerProduct(r, r) / r2) : Mat3(0);
}

/// Cayley's map with its angle kept below 148 degrees; a number that is none turns nothing.
Quat turn_within(Vec3 d) {
  const Real far = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
  if (!(far < 1e30)) return kNoTurn;
  return cayley(far > 4 ? 4 / far * d : d);
}

bool is_stiff(const Island& a, std::size_t c) {
  return !a.joints.empty() && a.joints[c].stiff;
}

}  // namespace

std::uint32_t held_body_of(const Island& a, std::size_t c) {
  for (const Tree& t : a.trees)
    if (t.first == c) return t.held_body;
  return UINT32_MAX;
}

void keep_gaps(Island& a) {
  for (std::size_t c = 0; c < a.count(); ++c) a.room.gaps[c] = a.room.work.vec(kGap, c);
}

void fill_base(Island& a, bool tension) {
  const Table& w = a.room.work;
  for (std::size_t c = 0; c < a.count(); ++c) {
    JointBlock& b = a.room.base[c];
    const Real mass = a.constants.at(kMass, c);
    b.tt = symmetric_at(w, kTurning, c);
    b.ty = crossing(-mass * w.vec(kArm, c));
    b.yy = Mat3(mass);
    b.gt = b.gy = Vec3(0);
    a.room.levers[c] = Vec3(0);
  }
  for (std::size_t c = 0; c < a.count(); ++c) {
    if (a.parents[c] < 0) continue;
    const auto parent = static_cast<std::size_t>(a.parents[c]);
    a.room.levers[c] = w.vec(kParentArm, c) - w.vec(kArm, parent);
  }
  for (std::size_t c = 0; tension && c < a.count(); ++c) {
    const Vec3 load = a.memory.vec(kLoad, c), arm = w.vec(kArm, c), out = w.vec(kParentArm, c);
    a.room.base[c].tt += tension_stiffness(glm::dot(load, arm), arm);
    if (a.parents[c] >= 0)
      a.room.base[static_cast<std::size_t>(a.parents[c])].tt +=
          tension_stiffness(-glm::dot(load, out), out);
  }
}

void gather_joints(Island& a) {
  std::vector<JointBlock>& blocks = a.room.joint_blocks;
  for (std::size_t c = a.count(); c-- > 0;) {
    JointNode& n = a.room.joint_nodes[c];
    if (is_stiff(a, c))
      eliminate_stiff(a, c, blocks[c]);
    else
      eliminate_loose(blocks[c], n);
    if (a.parents[c] < 0) continue;
    add_child(blocks[static_cast<std::size_t>(a.parents[c])], n, blocks[c].tt, a.room.gaps[c],
              a.room.levers[c]);
  }
}

bool close_joints(World& world, Island& a, Real h, Work position_row, Work rotation_row,
                  bool again) {
  StepScratch& r = a.room;
  Table& w = r.work;
  bool settled = true;
  auto tree = a.trees.begin();
  for (std::size_t c = 0; c < a.count(); ++c) {
    const JointNode& n = r.joint_nodes[c];
    const Quat q = w.quat(rotation_row, c);
    const Vec3 own = w.vec(position_row, c) + w.vec(kArm, c);
    Vec3 goal, parent_turn(0);
    Quat parent_now = kNoTurn;
    if (a.parents[c] >= 0) {
      const auto p = static_cast<std::size_t>(a.parents[c]);
      parent_now = r.rotations[p], parent_turn = r.turn[p];
      // The parent's joint point is on its place; the arm between the two turns with it.
      goal = w.vec(kAttach, p) + parent_now * (a.constants.vec(kParentAnchor, c) -
                                               a.constants.vec(kOwnAnchor, p));
    } else {
      goal = a.parents[c] == kHeld ? tree->target : own + solve_symmetric(n.group, n.load);
      ++tree;
    }
    // What the next body answers to is where this joint really is, large turns included. Stiff
    // rows would have to fight that: bodies they hold answer to the linear solution alone.
    Vec3 y = goal - own;
    if (a.rows_hold && !again && a.parents[c] >= 0) {
      const auto p = static_cast<std::size_t>(a.parents[c]);
      y = r.slide[p] + glm::cross(r.turn[p], r.levers[c]) + r.gaps[c];
    }
    Vec3 d = n.turn - n.swing * y;
    Vec3 load = n.group * y - n.load;
    if (!n.loose) d += n.follow * parent_turn, load += glm::transpose(n.lever) * parent_turn;
    if (a.parents[c] == kFree || !(glm::dot(load, load) < 1e36)) load = Vec3(0);
    a.memory.set(kLoad, c, load);
    if (!is_finite(d)) d = Vec3(0);
    Quat now, turned;
    if (n.loose) {
      turned = turn_within(d);
      now = glm::normalize(turned * q);
    } else {
      JointTerms& t = r.terms[c];
      const PackedJoint& joint = a.joints[c];
      if (a.parents[c] < 0) parent_now = t.parent;
      t.turned = d - parent_turn - t.align;
      const Quat relative = turn_within(t.turned) * (turn_by(t.align) * q);
      now = glm::normalize(parent_now * glm::conjugate(t.parent) * relative);
      const Quat turn = joint_turn(joint, now, parent_now);
      const Quat kind = allowed_by_kind(joint.joint.kind, turn);
      if (!again) {
        const Quat unclamped = own_rotation(joint, parent_now, kind);
        settled = settle_stops(a, c, unclamped, parent_now, d, y) && settled;
        settled = settle_drive(world, a, h, c) && settled;
      }
      const Quat allowed = allowed_turn(joint.joint, kind);
      if (turns_of(joint.joint.kind) != Turns::freely || !(allowed == turn))
        now = own_rotation(joint, parent_now, allowed);
      turned = now * glm::conjugate(q);
    }
    r.slide[c] = y, r.turn[c] = d;
    r.rotations[c] = now;
    w.set(kTurn, c, turned);
    w.set(kAttach, c, goal);
  }
  return settled;
}

void carry_up(const Island& a, std::vector<Loads>& force, std::vector<Loads>& torque) {
  for (std::size_t c = a.count(); c-- > 0;) {
    if (force[c].none() && torque[c].none()) continue;
    const JointNode& n = a.room.joint_nodes[c];
    Loads f = force[c];
    f.subtract(Loads::transposed_times(n.swing, torque[c]));
    Loads t;
    if (!n.loose) t = Loads::transposed_times(n.follow, torque[c]);
    torque[c] = Loads::times(n.give, torque[c]);
    force[c] = f;
    if (a.parents[c] < 0) continue;
    const auto parent = static_cast<std::size_t>(a.parents[c]);
    force[parent].add(f);
    torque[parent].add_cross(a.room.levers[c], f);
    if (!n.loose) torque[parent].add(t);
  }
}

void carry_down(const Island& a, std::vector<Loads>& force, std::vector<Loads>& torque) {
  for (std::size_t c = 0; c < a.count(); ++c) {
    const JointNode& n = a.room.joint_nodes[c];
    Loads y;
    if (a.parents[c] >= 0) {
      const auto parent = static_cast<std::size_t>(a.parents[c]);
      y = force[parent];
      y.subtract_cross(a.room.levers[c], torque[parent]);
      if (!n.loose) torque[c].add(Loads::times(n.follow, torque[parent]));
    } else if (a.parents[c] == kFree) {
      y = Loads::times(inverse_of(n.group), force[c]);
    }
    torque[c].subtract(Loads::times(n.swing, y));
    force[c] = y;
  }
}

}  // namespace pantin::articulated
