// Terms of the equations: kinematics, rows, forces.
#include <algorithm>
#include <array>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/joints/reel.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Step of the fourth-order differences for derivatives of a path, s.
constexpr Real kDifferenceStep = 1e-3;

struct FrameMotion {
  Pose pose;
  Vec3 velocity{0}, angular_velocity{0}, acceleration{0}, angular_acceleration{0};
};

Vec3 vector_part(Quat q) { return {q.x, q.y, q.z}; }

FrameMotion along(const KinematicPath& drive, Real time) {
  std::array<Pose, 5> p;
  for (int i = 0; i < 5; ++i) {
    p[i] = pose_at(drive, time + (i - 2) * kDifferenceStep);
    if (i > 0 && glm::dot(p[i].rotation, p[0].rotation) < 0) p[i].rotation = -p[i].rotation;
  }
  const auto first = [&](auto part) {
    return (part(0) - part(4) + 8.0 * (part(3) - part(1))) / (12 * kDifferenceStep);
  };
  const auto second = [&](auto part) {
    return (16.0 * (part(1) + part(3)) - (part(0) + part(4)) - 30.0 * part(2)) /
           (12 * kDifferenceStep * kDifferenceStep);
  };
  const auto x = [&](int i) { return p[i].position; };
  const auto q = [&](int i) { return p[i].rotation; };
  const Quat back = 2.0 * glm::conjugate(p[2].rotation);
  return {p[2], first(x), vector_part(first(q) * back), second(x), vector_part(second(q) * back)};
}

/// A frame moved by the caller: constant velocity over the step.
FrameMotion evenly(const Pose& from, const Pose& to, Real part, Real h) {
  FrameMotion f;
  PANTIN_ASSERT(is_positive(h));
  f.velocity = (to.position - from.position) / h;
  f.angular_velocity = angular_velocity_between(from.rotation, to.rotation, h);
  f.pose = {glm::mix(from.position, to.position, part),
            glm::normalize(from_rotation_vector(part * h * f.angular_velocity) * from.rotation)};
  return f;
}

FrameMotion motion_of(const World& world, const Frame& frame, Real part, Real h) {
  if (frame.pin != UINT32_MAX) {
    const Pose to{world.pins.values()[frame.pin].target, kIdentity};
    return evenly(frame.known ? frame.before : to, to, part, h);
  }
  if (frame.cable != UINT32_MAX) {
    const CableParameters& cable = world.cables.values()[frame.cable].joint;
    const CableReel before{frame.known ? frame.before.position.x : -1, frame.rate_before};
    const ReeledLength x = reeled_in_step(before, cable, part, h);
    FrameMotion f;
    f.pose.position.x = x.length, f.velocity.x = x.rate, f.acceleration.x = x.acceleration;
    return f;
  }
  if (frame.drive != UINT32_MAX) {
    const CoordinateMotion x = drive_motion(world, frame, world.time + part * h);
    FrameMotion f;
    f.pose.position.x = x.value, f.velocity.x = x.rate, f.acceleration.x = x.acceleration;
    return f;
  }
  PANTIN_ASSERT(frame.slot < world.bodies.size());
  const Body& body = world.bodies.values()[frame.slot];
  if (body.motion == Motion::fixed) return {body.pose};
  if (const KinematicPath* drive = world.paths.find(world.bodies.owners()[frame.slot]))
    return along(*drive, world.time + part * h);
  return evenly(frame.known && !body.teleport ? frame.before : body.pose, body.pose, part, h);
}

void place_body(BodyState& to, const Pose& at, Vec3 v, Vec3 w) {
  to.position = at.position, to.rotation = at.rotation;
  to.rotation_matrix = glm::mat3_cast(at.rotation);
  to.velocity = v, to.angular_velocity = w;
}

/// R diag(d) R^T.
Mat3 rotated(const Mat3& r, Vec3 d) {
  const Vec3 a = d.x * r[0], b = d.y * r[1], c = d.z * r[2];
  const auto entry = [&](int i, int k) { return a[i] * r[0][k] + b[i] * r[1][k] + c[i] * r[2][k]; };
  const Real xy = entry(0, 1), xz = entry(0, 2), yz = entry(1, 2);
  return Mat3(entry(0, 0), xy, xz, xy, entry(1, 1), yz, xz, yz, entry(2, 2));
}

Joint joint_of_pin(const Pin& pin) {
  Joint j;
  j.anchor_a = pin.anchor, j.anchor_b = pin.to ? pin.target : Vec3(0);
  return j;
}

void write_limit(const World& world, Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  const bool is_active_row = is_active(m, block);
  const auto& link = world.links;
  const bool is_cable = b.kind == BlockKind::cable;
  Vec3* j = &m.scratch.jacobian[b.first_vector];
  Real& c = m.scratch.c[b.first_row];
  Real& gamma = m.scratch.gamma[b.first_row];
  const RowsOut out{&c, is_active_row ? j : nullptr, is_active_row ? &gamma : nullptr};
  const BodyState &at_a = m.scratch.body_states[b.body[0]],
                  &at_b = m.scratch.body_states[b.body[1]];
  Real bound = b.bound;
  if (is_cable) {
    write_cable_length(world, m, b, out);
    bound = m.scratch.body_states[b.body[b.count - 1]].position.x;
  } else {
    write_coordinate({link.values()[b.source].joint, at_a, at_b, m.memory[block].before[0]},
                     b.coordinate, out);
  }
  const Real sign = b.upper || is_cable ? -1 : 1;
  c = sign * (c - bound);
  if (!is_active_row) {
    gamma = 0;
    std::fill(j, j + vectors_of(b), Vec3(0));
    return;
  }
  gamma *= sign;
  for (std::uint32_t i = 0; i < vectors_of(b); ++i) j[i] *= sign;
  if (!is_cable) return;
  Vec3* winch = j + 2 * (b.count - 1);
  winch[0] = {1, 0, 0}, winch[1] = Vec3(0);
}

/// One of the two coordinates that a gear couples: its link, the indices of that link's bodies in
/// Block::body, and its value before.
struct CoupledCoordinate {
  Entity link;
  const std::uint8_t* ends;
  Coordinate which;
  Real before;
};

void write_gear(const World& world, Island& m, const Block& b, const BlockMemory& memory) {
  const Gear& ratio = world.gears.values()[b.source];
  Vec3* j = &m.scratch.jacobian[b.first_vector];
  std::fill(j, j + 2 * b.count, Vec3(0));
  Real c = -b.bound, gamma = 0;
  const auto add = [&](const CoupledCoordinate& of, Real factor) {
    const std::uint8_t* ends = of.ends;
    Real value = 0, g = 0;
    Vec3 row[4];
    write_coordinate({world.links[of.link].joint, m.scratch.body_states[b.body[ends[0]]],
                      m.scratch.body_states[b.body[ends[1]]], of.before},
                     of.which, {&value, row, &g});
    c += factor * value, gamma += factor * g;
    PANTIN_ASSERT(ends[0] < b.count && ends[1] < b.count);
    for (int end = 0; end < 2; ++end)
      for (int i = 0; i < 2; ++i) j[2 * ends[end] + i] += factor * row[2 * end + i];
  };
  add({ratio.second, b.ends + 2, b.second, memory.before[1]}, 1);
  add({ratio.first, b.ends, b.coordinate, memory.before[0]}, -ratio.ratio);
  m.scratch.c[b.first_row] = c, m.scratch.gamma[b.first_row] = gamma;
}

void add_elastic_forces(const World& world, Island& m) {
  for (const BodyPairForce& p : m.elastic_cables) {
    const CableParameters& s = world.cables.values()[p.source].joint;
    const BodyState &a = m.scratch.body_states[p.body[0]], &b = m.scratch.body_states[p.body[1]];
    const Vec3 ra = a.rotation_matrix * s.anchor_a, rb = b.rotation_matrix * s.anchor_b;
    const Vec3 d = b.position + rb - a.position - ra;
    const Real span = glm::length(d);
    if (span > s.length) add_pair_force(m, p, {tension_of(s, span - s.length) / span * d, ra, rb});
  }
  add_path_forces(world, m);
  add_pin_forces(world, m);
}

/// Rows of compliant elements: zero unless springs are active.
void write_compliant(const World& world, Island& m, const Block& b) {
  Vec3* j = &m.scratch.jacobian[b.first_vector];
  std::fill(j, j + vectors_of(b), Vec3(0));
  PANTIN_ASSERT(b.kind == BlockKind::elastic_cable || b.count == 2);
  if (!m.scratch.springs_active) return;
  const BodyState &at_a = m.scratch.body_states[b.body[0]],
                  &at_b = m.scratch.body_states[b.body[1]];
  if (b.kind == BlockKind::elastic_cable) {
    write_cable_length(world, m, b, {&m.scratch.c[b.first_row], j, &m.scratch.gamma[b.first_row]});
    return;
  }
  if (b.kind == BlockKind::joint_torque) {
    const JointTorque torque = torque_of(world, m, {b.source, {b.body[0], b.body[1]}});
    for (int r = 0; r < 3; ++r) j[4 * r + 1] = torque.axes[r], j[4 * r + 3] = -torque.axes[r];
    return;
  }
  Vec3 arm[2] = {Vec3(0), Vec3(0)};
  if (b.kind == BlockKind::elastic_pin) {
    const Pin& pin = world.pins.values()[b.source];
    arm[0] = at_a.rotation_matrix * pin.anchor;
    if (pin.to) arm[1] = at_b.rotation_matrix * pin.target;
  }
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < 2; ++k) {
      Vec3 unit(0);
      unit[r] = k == 0 ? 1 : -1;
      j[4 * r + 2 * k] = unit, j[4 * r + 2 * k + 1] = glm::cross(arm[k], unit);
    }
}

}  // namespace

void add_pair_force(Island& m, const BodyPairForce& p, const OppositeForces& forces) {
  const auto& [on_a, arm_a, arm_b] = forces;
  if (p.body[0] < m.count())
    m.scratch.force[2 * p.body[0]] += on_a,
        m.scratch.force[2 * p.body[0] + 1] += glm::cross(arm_a, on_a);
  if (p.body[1] < m.count())
    m.scratch.force[2 * p.body[1]] -= on_a,
        m.scratch.force[2 * p.body[1] + 1] -= glm::cross(arm_b, on_a);
}

Real opening_rate(const World& world, Island& m, std::size_t block) {
  PANTIN_ASSERT(is_one_sided(m, block) && !m.memory[block].active);
  m.memory[block].active = true;
  write_limit(world, m, block);
  const Real rate = rate_of(m, m.blocks[block], 0);
  m.memory[block].active = false;
  write_limit(world, m, block);
  return rate;
}

bool is_active_now(const Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  PANTIN_ASSERT(m.memory.size() == m.blocks.size());
  if (is_compliant(b.kind)) return m.scratch.springs_active;
  if (b.kind == BlockKind::joint && !b.holonomic)
    return !m.scratch.poses_only && (b.lock || m.memory[block].active);
  if (b.kind == BlockKind::roll)
    return (b.holonomic || !m.scratch.poses_only) && (b.lock || m.memory[block].active) &&
           is_active(m, block - 1);
  if (b.kind == BlockKind::surface)
    return m.touches[b.first_place].known && !m.touches[b.first_place].is_over() &&
           (b.lock || m.memory[block].active);
  if (b.kind == BlockKind::drive) return !lag_of(m, b).yields;
  if (b.kind != BlockKind::limit && b.kind != BlockKind::cable) return true;
  return b.lock || m.memory[block].active;
}

void update_kinematics(Island& m) {
  const Motions& s = m.scratch.state;
  for (std::size_t b = 0; b < m.count(); ++b) {
    place_body(m.scratch.body_states[b], {s.x[b], s.q[b]}, s.v[b], s.w[b]);
    m.scratch.inverse_inertia[b] =
        rotated(m.scratch.body_states[b].rotation_matrix, 1.0 / m.inertia[b]);
  }
}

void regularise_inertia(Island& m, Real least) {
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Vec3 inertia = m.inertia[b];
    const Real thinnest = least * std::max({inertia.x, inertia.y, inertia.z});
    m.scratch.inverse_inertia[b] =
        rotated(m.scratch.body_states[b].rotation_matrix, 1.0 / glm::max(inertia, Vec3(thinnest)));
  }
}

void update_frames(const World& world, Island& m, Real part, Real h) {
  PANTIN_ASSERT(is_range(0, part) && is_range(part, 1 + 1e-9));
  PANTIN_ASSERT(m.scratch.body_states.size() == m.count() + m.frames.size());
  m.scratch.time = world.time + part * h;
  for (std::size_t i = 0; i < m.frames.size(); ++i) {
    const std::size_t n = m.count() + i;
    const FrameMotion f = motion_of(world, m.frames[i], part, h);
    place_body(m.scratch.body_states[n], f.pose, f.velocity, f.angular_velocity);
    m.scratch.motion[2 * n] = f.acceleration, m.scratch.motion[2 * n + 1] = f.angular_acceleration;
  }
}

void note_end(const World& world, Frame& frame, const BodyState& at) {
  const bool reels = frame.cable != UINT32_MAX;
  const Real rate = reels ? world.cables.values()[frame.cable].joint.rate : 0;
  frame.begin({{at.position, at.rotation}, rate, true});
}

bool frames_rest(const World& world, const Island& m, const Span& span) {
  const auto rests = [&](const Frame& frame) {
    if (frame.is_body() && world.bodies.values()[frame.slot].motion == Motion::fixed) return true;
    for (const Real part : {0.0, 0.5, 1.0}) {
      const FrameMotion f = motion_of(world, frame, span.fraction(part), span.whole);
      if (f.velocity != Vec3(0) || f.angular_velocity != Vec3(0)) return false;
    }
    return true;
  };
  return std::all_of(m.frames.begin(), m.frames.end(), rests);
}

void write_block(const World& world, Island& m, std::size_t i, Want want) {
  StepScratch& scratch = m.scratch;
  PANTIN_ASSERT(i < m.blocks.size());
  const Block& b = m.blocks[i];
  const bool keeps =
      !want.jacobian && b.holonomic && (b.kind == BlockKind::joint || b.kind == BlockKind::pin);
  Vec3* j = keeps ? nullptr : &scratch.jacobian[b.first_vector];
  const RowsOut out{want.c ? &scratch.c[b.first_row] : nullptr, b.point ? nullptr : j,
                    want.gamma ? &scratch.gamma[b.first_row] : nullptr, b.point ? j : nullptr};
  const auto at = [&](int k) -> const BodyState& { return scratch.body_states[b.body[k]]; };
  switch (b.kind) {
    case BlockKind::joint:
      if (!b.holonomic) {
        write_slip(world, m, i, out);
        break;
      }
      write_rows({world.links.values()[b.source].joint, at(0), at(1), m.memory[i].before[0]}, out);
      break;
    case BlockKind::pin:
      write_rows({joint_of_pin(world.pins.values()[b.source]), at(0), at(1)}, out);
      break;
    case BlockKind::gear:
      write_gear(world, m, b, m.memory[i]);
      break;
    case BlockKind::belt:
      write_belt(world, m, i, out);
      break;
    case BlockKind::limit:
    case BlockKind::cable:
      write_limit(world, m, i);
      break;
    case BlockKind::drive:
      write_drive(world, m, i);
      break;
    case BlockKind::surface:
      write_surface(world, m, i, want);
      break;
    case BlockKind::roll:
      break;  // written with the block before
    case BlockKind::spring:
      if (!scratch.springs_active) {
        std::fill(out.j, out.j + 4, Vec3(0));
        break;
      }
      write_coordinate({world.links.values()[b.source].joint, at(0), at(1), m.memory[i].before[0]},
                       b.coordinate, out);
      break;
    case BlockKind::elastic_cable:
    case BlockKind::elastic_pin:
    case BlockKind::joint_torque:
      write_compliant(world, m, b);
      break;
  }
}

void write_all_rows(const World& world, Island& m, Want want) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i) write_block(world, m, i, want);
}

void add_forces(const World& world, Island& m, Torques torques) {
  const bool gyroscopic = torques == Torques::with_gyroscopic;
  std::vector<Vec3>& f = m.scratch.force;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const BodyState& at = m.scratch.body_states[b];
    f[2 * b] = m.mass[b] * (m.gravity_scale[b] * world.gravity - m.drag[b] * at.velocity);
    f[2 * b + 1] = Vec3(0);
    if (m.drag[b] == 0 && !gyroscopic) continue;
    const Vec3 local = at.angular_velocity * at.rotation_matrix;  // R^T w
    const Vec3 l = at.rotation_matrix * (m.inertia[b] * local);
    f[2 * b + 1] = -m.drag[b] * l;
    if (gyroscopic) f[2 * b + 1] -= glm::cross(at.angular_velocity, l);
  }
  for (std::size_t i = 0; i < 2 * m.count() && m.scratch.pushed; ++i) f[i] += m.scratch.applied[i];
  if (!m.scratch.springs_active) add_joint_forces(world, m);
  add_joint_torques(world, m), add_drive_forces(world, m);
  add_elastic_forces(world, m);
  add_slip_forces(m);
}

Real tolerance_of(const Island& m) { return 1e-13 * std::max(Real(1), m.size); }

Real worst_residual(const Island& m) {
  Real worst = 0;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (is_compliant(b.kind)) continue;
    if (!is_active(m, i)) continue;
    for (std::size_t r = 0; r < b.rows; ++r)
      worst = std::max(worst, std::abs(m.scratch.c[b.first_row + r]));
  }
  return worst;
}

bool is_within_bounds(const Motions& s, std::size_t b) {
  const auto within = [](Vec3 v, Real bound) { return glm::dot(v, v) <= bound * bound; };
  return within(s.x[b], 1e12) && is_finite(s.q[b]) && within(s.v[b], 1e9) && within(s.w[b], 1e9);
}

bool all_within_bounds(const Island& m) {
  const Motions& s = m.scratch.state;
  for (std::size_t b = 0; b < m.count(); ++b)
    if (!is_within_bounds(s, b)) return false;
  return true;
}

}  // namespace pantin::detail::lagrangian
