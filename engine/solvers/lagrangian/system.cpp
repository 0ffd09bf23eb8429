// What the equations are made of: places, rows, forces.
#include <algorithm>
#include <array>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::lagrangian {
namespace {

/// Derivatives of a path by differences of this width, s; fourth order.
constexpr Real kWidth = 1e-3;

struct FrameMotion {
  Pose pose;
  Vec3 velocity{0}, spin{0}, acceleration{0}, spin_acceleration{0};
};

Vec3 vector_part(Quat q) { return {q.x, q.y, q.z}; }

FrameMotion along(const Drive& drive, Real time) {
  std::array<Pose, 5> p;
  for (int i = 0; i < 5; ++i) {
    p[i] = pose_at(drive, time + (i - 2) * kWidth);
    if (i > 0 && glm::dot(p[i].rotation, p[0].rotation) < 0) p[i].rotation = -p[i].rotation;
  }
  const auto first = [&](auto part) {
    return (part(0) - part(4) + 8.0 * (part(3) - part(1))) / (12 * kWidth);
  };
  const auto second = [&](auto part) {
    return (16.0 * (part(1) + part(3)) - (part(0) + part(4)) - 30.0 * part(2)) /
           (12 * kWidth * kWidth);
  };
  const auto x = [&](int i) { return p[i].position; };
  const auto q = [&](int i) { return p[i].rotation; };
  const Quat back = 2.0 * glm::conjugate(p[2].rotation);
  return {p[2], first(x), vector_part(first(q) * back), second(x), vector_part(second(q) * back)};
}

/// A frame that is moved by hand: evenly over the step.
FrameMotion evenly(const Pose& from, const Pose& to, Real part, Real h) {
  FrameMotion f;
  f.velocity = (to.position - from.position) / h;
  f.spin = spin_between(from.rotation, to.rotation, h);
  f.pose = {glm::mix(from.position, to.position, part),
            glm::normalize(turn_by(part * h * f.spin) * from.rotation)};
  return f;
}

FrameMotion motion_of(const World& world, const Frame& frame, Real part, Real h) {
  if (frame.pin != UINT32_MAX) {
    const Pose to{world.pins.values()[frame.pin].target, kNoTurn};
    return evenly(frame.known ? frame.before : to, to, part, h);
  }
  const Body& body = world.bodies.values()[frame.slot];
  if (body.motion == Motion::fixed) return {body.pose};
  if (const Drive* drive = world.drives.find(world.bodies.owners()[frame.slot]))
    return along(*drive, world.time + part * h);
  return evenly(frame.known && !body.teleport ? frame.before : body.pose, body.pose, part, h);
}

void place_body(Placed& to, Vec3 x, Quat q, Vec3 v, Vec3 w) {
  to.position = x, to.rotation = q, to.turn = glm::mat3_cast(q), to.velocity = v, to.spin = w;
}

/// R diag(d) R^T.
Mat3 turned(const Mat3& r, Vec3 d) {
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

/// A string as a joint whose slide is the distance of its ends.
Joint joint_of_string(const String& s) {
  Joint j;
  j.kind = JointKind::spring, j.anchor_a = s.joint.anchor_a, j.anchor_b = s.joint.anchor_b;
  return j;
}

void write_limit(const World& world, Island& m, const Block& b, const BlockMemory& memory,
                 bool bears_load) {
  const auto& link = world.links;
  const bool is_string = b.kind == BlockKind::cable;
  Vec3* j = &m.room.jacobian[b.first_vector];
  Real& c = m.room.c[b.first_row];
  Real& gamma = m.room.gamma[b.first_row];
  const RowsOut out{&c, bears_load ? j : nullptr, bears_load ? &gamma : nullptr};
  const Placed &at_a = m.room.placed[b.body[0]], &at_b = m.room.placed[b.body[1]];
  Real bound = b.bound;
  if (is_string) {
    const String& s = world.strings.values()[b.source];
    write_coordinate(joint_of_string(s), Coordinate::slide, at_a, at_b, 0, out);
    bound = s.joint.length;
  } else {
    write_coordinate(link.values()[b.source].joint, b.coordinate, at_a, at_b, memory.before[0],
                     out);
  }
  const Real sign = b.upper || is_string ? -1 : 1;
  c = sign * (c - bound);
  if (!bears_load) {
    gamma = 0;
    for (int i = 0; i < 4; ++i) j[i] = Vec3(0);
    return;
  }
  gamma *= sign;
  for (int i = 0; i < 4; ++i) j[i] *= sign;
}

void write_ratio(const World& world, Island& m, const Block& b, const BlockMemory& memory) {
  const Ratio& ratio = world.ratios.values()[b.source];
  Vec3* j = &m.room.jacobian[b.first_vector];
  std::fill(j, j + 2 * b.count, Vec3(0));
  Real c = -b.bound, gamma = 0;
  const auto add = [&](Entity e, const std::uint8_t* ends, Coordinate which, Real before,
                       Real factor) {
    Real value = 0, g = 0;
    Vec3 row[4];
    write_coordinate(world.links[e].joint, which, m.room.placed[b.body[ends[0]]],
                     m.room.placed[b.body[ends[1]]], before, {&value, row, &g});
    c += factor * value, gamma += factor * g;
    for (int end = 0; end < 2; ++end)
      for (int i = 0; i < 2; ++i) j[2 * ends[end] + i] += factor * row[2 * end + i];
  };
  add(ratio.second, b.ends + 2, b.second, memory.before[1], 1);
  add(ratio.first, b.ends, b.coordinate, memory.before[0], -ratio.ratio);
  m.room.c[b.first_row] = c, m.room.gamma[b.first_row] = gamma;
}

void push_pose_drives(const World& world, Island& m) {
  for (const Pulling& p : m.pose_drives) {
    const PoseDrive* drive = world.pose_drives.find(world.links.owners()[p.source]);
    if (!drive) continue;
    const Joint& joint = world.links.values()[p.source].joint;
    const Placed &a = m.room.placed[p.body[0]], &b = m.room.placed[p.body[1]];
    const Quat axes = a.rotation * joint.frames.a();
    const Quat target = target_at(*drive, m.room.time), now = relative_turn(joint, a.rotation, b.rotation);
    const Vec3 own = drive->keys.empty() ? Vec3(0)
                                         : axes * spin_between(target_at(*drive, m.room.time - kWidth),
                                                               target_at(*drive, m.room.time + kWidth),
                                                               2 * kWidth);
    Vec3 torque = drive->stiffness * (axes * rotation_vector(target * glm::conjugate(now))) -
                  drive->damping * (b.spin - a.spin - own);
    if (const Real size = glm::length(torque); size > drive->max_torque)
      torque *= drive->max_torque / size;
    for (int k = 0; k < 2; ++k)
      if (p.body[k] < m.count()) m.room.force[2 * p.body[k] + 1] += (k == 0 ? -1.0 : 1.0) * torque;
  }
}

/// A force on the mechanism's own bodies, at points of theirs.
void pull(Island& m, const Pulling& p, Vec3 on_a, Vec3 arm_a, Vec3 arm_b) {
  if (p.body[0] < m.count())
    m.room.force[2 * p.body[0]] += on_a, m.room.force[2 * p.body[0] + 1] += glm::cross(arm_a, on_a);
  if (p.body[1] < m.count())
    m.room.force[2 * p.body[1]] -= on_a, m.room.force[2 * p.body[1] + 1] -= glm::cross(arm_b, on_a);
}

void pull_elastic(const World& world, Island& m) {
  for (const Pulling& p : m.elastic_strings) {
    const StringJoint& s = world.strings.values()[p.source].joint;
    const Placed &a = m.room.placed[p.body[0]], &b = m.room.placed[p.body[1]];
    const Vec3 ra = a.turn * s.anchor_a, rb = b.turn * s.anchor_b;
    const Vec3 d = b.position + rb - a.position - ra;
    const Real span = glm::length(d);
    if (span > s.length) pull(m, p, (span - s.length) / s.compliance / span * d, ra, rb);
  }
  for (const Pulling& p : m.elastic_pins) {
    const Pin& pin = world.pins.values()[p.source];
    const Placed &a = m.room.placed[p.body[0]], &b = m.room.placed[p.body[1]];
    const Vec3 ra = a.turn * pin.anchor, rb = pin.to ? b.turn * pin.target : Vec3(0);
    const Vec3 d = b.position + rb - a.position - ra;
    const Vec3 rate = b.velocity + glm::cross(b.spin, rb) - a.velocity - glm::cross(a.spin, ra);
    // Critically damped for the body it holds.
    const Real mass = p.body[0] < m.count() ? m.mass[p.body[0]] : 0;
    pull(m, p, pin.stiffness * d + 2 * std::sqrt(pin.stiffness * mass) * rate, ra, rb);
  }
}

}  // namespace

bool bears(const Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  if (b.kind == BlockKind::spring) return m.room.springs_bear;
  if (b.kind != BlockKind::limit && b.kind != BlockKind::cable) return true;
  return b.lock || m.memory[block].active;
}

void place(Island& m) {
  const Motions& s = m.room.state;
  for (std::size_t b = 0; b < m.count(); ++b) {
    place_body(m.room.placed[b], s.x[b], s.q[b], s.v[b], s.w[b]);
    m.room.give[b] = turned(m.room.placed[b].turn, 1.0 / m.inertia[b]);
  }
}

void place_frames(const World& world, Island& m, Real part, Real h) {
  m.room.time = world.time + part * h;
  for (std::size_t i = 0; i < m.frames.size(); ++i) {
    const std::size_t n = m.count() + i;
    const FrameMotion f = motion_of(world, m.frames[i], part, h);
    place_body(m.room.placed[n], f.pose.position, f.pose.rotation, f.velocity, f.spin);
    m.room.motion[2 * n] = f.acceleration, m.room.motion[2 * n + 1] = f.spin_acceleration;
  }
}

void write_all_rows(const World& world, Island& m, Want want) {
  StepScratch& room = m.room;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    Vec3* j = &room.jacobian[b.first_vector];
    const RowsOut out{want.c ? &room.c[b.first_row] : nullptr, b.point ? nullptr : j,
                      want.gamma ? &room.gamma[b.first_row] : nullptr, b.point ? j : nullptr};
    const auto at = [&](int k) -> const Placed& { return room.placed[b.body[k]]; };
    switch (b.kind) {
      case BlockKind::joint:
        write_rows(world.links.values()[b.source].joint, at(0), at(1), m.memory[i].before[0], out);
        break;
      case BlockKind::pin:
        write_rows(joint_of_pin(world.pins.values()[b.source]), at(0), at(1), 0, out);
        break;
      case BlockKind::interface: {
        Joint joint;
        joint.anchor_a = m.interfaces[b.source].anchor;
        write_rows(joint, at(0), at(1), 0, out);
        break;
      }
      case BlockKind::ratio:
        write_ratio(world, m, b, m.memory[i]);
        break;
      case BlockKind::limit:
      case BlockKind::cable:
        write_limit(world, m, b, m.memory[i], bears(m, i));
        break;
      case BlockKind::spring:
        if (!room.springs_bear) {
          std::fill(out.j, out.j + 4, Vec3(0));
          break;
        }
        write_coordinate(world.links.values()[b.source].joint, b.coordinate, at(0), at(1),
                         m.memory[i].before[0], out);
        break;
    }
  }
}

void add_forces(const World& world, Island& m, bool gyroscopic) {
  std::vector<Vec3>& f = m.room.force;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Placed& at = m.room.placed[b];
    f[2 * b] = m.mass[b] * (m.gravity_scale[b] * world.gravity - m.drag[b] * at.velocity);
    f[2 * b + 1] = Vec3(0);
    if (m.drag[b] == 0 && !gyroscopic) continue;
    const Vec3 local = at.spin * at.turn;  // R^T w
    const Vec3 l = at.turn * (m.inertia[b] * local);
    f[2 * b + 1] = -m.drag[b] * l;
    if (gyroscopic) f[2 * b + 1] -= glm::cross(at.spin, l);
  }
  for (std::size_t i = 0; i < m.owed.size() && m.room.pushed; ++i)
    f[i] += m.owed[i] + m.room.applied[i];
  if (!m.room.springs_bear) push_efforts(world, m);
  push_pose_drives(world, m);
  pull_elastic(world, m);
}

Real tolerance_of(const Island& m) { return 1e-13 * std::max(Real(1), m.size); }

Real worst_residual(const Island& m) {
  Real worst = 0;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (b.kind == BlockKind::spring) continue;
    if (!bears(m, i)) continue;
    for (std::size_t r = 0; r < b.rows; ++r)
      worst = std::max(worst, std::abs(m.room.c[b.first_row + r]));
  }
  return worst;
}

bool is_within_bounds(const Motions& s, std::size_t b) {
  const auto within = [](Vec3 v, Real bound) { return glm::dot(v, v) <= bound * bound; };
  return within(s.x[b], 1e12) && is_finite(s.q[b]) && within(s.v[b], 1e9) && within(s.w[b], 1e9);
}

bool all_within_bounds(const Island& m) {
  const Motions& s = m.room.state;
  for (std::size_t b = 0; b < m.count(); ++b)
    if (!is_within_bounds(s, b)) return false;
  return true;
}

}  // namespace pantin::lagrangian
