// Rows of joints and gears. Closes mechanisms in double precision after Box2D's step, which leaves
// gaps of its tolerance and supports gears only between joints on a common ground body.
#include <algorithm>
#include <cmath>

#include "engine/joints/kinds.hpp"
#include "engine/joints/rows.hpp"
#include "engine/solvers/planar/island.hpp"
#include "engine/world/joint_coordinate.hpp"

namespace pantin::detail::planar {

Vec3 turned(Vec3 v, Real angle) {
  const Real c = std::cos(angle), s = std::sin(angle);
  return {c * v.x - s * v.y, s * v.x + c * v.y, 0};
}

int rows_of(const PlaneJoint& joint) {
  constexpr int kRows[] = {2, 3, 2, 1, 0};  // hinge, weld, slider, rod, spring
  PANTIN_ASSERT(joint.kind <= PlaneJoint::spring);
  return kRows[joint.kind];
}

namespace {

constexpr int kMostIterations = 48;
constexpr Real kMostTurn = 0.5;          // rad, of a body in an iteration
constexpr Real kClosedResidual = 1e-13;  // of the size of the joints

Real cross(Vec3 a, Vec3 b) { return a.x * b.y - a.y * b.x; }

/// A joint at the current poses.
struct Placed {
  const PlaneJoint& joint;
  Vec3 arm_a, arm_b;
  Vec3 gap;   // from a's anchor to b's, m
  Real turn;  // rad, rotation of b relative to a since the start of the step
};

Placed place(const PlaneJoint& j, const Motions& m) {
  PANTIN_ASSERT(j.a < m.gained.size() && j.b < m.gained.size());
  const Vec3 a = turned(j.arm_a, m.gained[j.a]), b = turned(j.arm_b, m.gained[j.b]);
  const Vec3 gap = (m.position[j.b] - m.position[j.a]) * Vec3(1, 1, 0) + b - a;
  return {j, a, b, gap, m.gained[j.b] - m.gained[j.a]};
}

/// The row of n . gap. `fixed`: 1 if n is fixed to a, else 0.
Row along(const Placed& p, Vec3 n, Real fixed) {
  Row row;
  row.add(p.joint.a, {-n.x, -n.y, -cross(p.arm_a + fixed * p.gap, n)});
  row.add(p.joint.b, {n.x, n.y, cross(p.arm_b, n)});
  row.c = glm::dot(n, p.gap);
  return row;
}

Row turning(const Placed& p) {
  Row row;
  row.add(p.joint.a, {0, 0, -1}), row.add(p.joint.b, {0, 0, 1});
  row.c = p.joint.angle_error + p.turn;
  return row;
}

Vec3 axis_of(const Placed& p, const Motions& m) {
  return turned(p.joint.axis, m.gained[p.joint.a]);
}

}  // namespace

void append_joint_rows(const PlaneJoint& joint, const Motions& m, std::vector<Row>& rows) {
  const Placed p = place(joint, m);
  switch (p.joint.kind) {
    case PlaneJoint::weld:
      rows.push_back(turning(p));
      [[fallthrough]];
    case PlaneJoint::hinge:
      rows.push_back(along(p, {1, 0, 0}, 0)), rows.push_back(along(p, {0, 1, 0}, 0));
      return;
    case PlaneJoint::slider: {
      const Vec3 axis = axis_of(p, m);
      rows.push_back(along(p, {-axis.y, axis.x, 0}, 1)), rows.push_back(turning(p));
      return;
    }
    case PlaneJoint::rod: {
      Row row = along(p, p.gap / p.joint.length, 0);
      row.c = 0.5 * (glm::dot(p.gap, p.gap) / p.joint.length - p.joint.length);
      rows.push_back(row);
      return;
    }
    case PlaneJoint::spring:
      return;
  }
}

Row sprung_row(const PlaneJoint& joint, const Motions& m) {
  const Placed p = place(joint, m);
  if (joint.kind == PlaneJoint::slider) return along(p, axis_of(p, m), 1);
  if (joint.kind == PlaneJoint::hinge) {
    Row row = turning(p);
    row.c = p.turn;
    return row;
  }
  const Real length = glm::length(p.gap);
  Row row = along(p, length > 0 ? p.gap / length : Vec3(1, 0, 0), 0);
  row.c = length - joint.length;
  return row;
}

namespace {

Coordinate first_of(const Gear& gear) {
  return gear.first_travels ? Coordinate::travel : Coordinate::angle;
}
Coordinate second_of(const Gear& gear) {
  return gear.second_travels ? Coordinate::travel : Coordinate::angle;
}

}  // namespace

Row counted_row(const World& world, const Planar& all, std::uint32_t at, Coordinate which) {
  const StepScratch& s = all.scratch;
  PANTIN_ASSERT(at < s.joint_of.size() && s.joint_of[at] != kNobody);
  const PlaneJoint& j = s.plane.joints[s.joint_of[at]];
  const Placed p = place(j, s.motions);
  if (which == Coordinate::travel) return along(p, axis_of(p, s.motions), 1);
  const FlatLink& l = all.links[at];
  const Link& link = world.links.values()[l.link];
  const Quat axes =
      world.bodies.values()[all.bodies[l.a].slot].pose.rotation * link.joint.frames.a();
  const Real sign = (axes * Vec3(1, 0, 0)).z > 0 ? 1 : -1;
  Row row;
  row.add(l.a, {0, 0, -sign}), row.add(l.b, {0, 0, sign});
  row.c = sign * (s.motions.position[l.b].z - s.motions.position[l.a].z);
  return row;
}

Row gear_row(const World& world, const Planar& all, const FlatGear& gear) {
  const Gear& told = world.gears.values()[gear.slot];
  const Row first = counted_row(world, all, gear.links[0], first_of(told));
  Row row = counted_row(world, all, gear.links[1], second_of(told));
  for (int i = 0; i < first.count; ++i) row.add(first.body[i], -told.ratio * first.j[i]);
  row.c += gear.second - told.ratio * (first.c + gear.first) - gear.offset;
  return row;
}

void find_rows(const World& world, Planar& all, const Mechanism& of) {
  StepScratch& s = all.scratch;
  s.rows.clear();
  each_joint(all, of, [&](const PlaneJoint& j) { append_joint_rows(j, s.motions, s.rows); });
  for (const std::uint32_t gear : of.gears) s.rows.push_back(gear_row(world, all, all.gears[gear]));
  for (const std::uint32_t drive : of.drives)
    s.rows.push_back(drive_row(world, all, all.drives[drive]));
  append_curve_rows(all, of, s.rows);
  for (const std::uint32_t span : of.spans) s.rows.push_back(span_row(world, all, all.spans[span]));
}

Row coordinate_row(const PlaneJoint& joint, const Motions& m) {
  const Placed p = place(joint, m);
  if (joint.kind == PlaneJoint::slider) return along(p, axis_of(p, m), 1);
  Row row;
  row.add(joint.a, {0, 0, -1}), row.add(joint.b, {0, 0, 1});
  return row;
}

namespace {

/// Adds M^-1 J^T lambda.
void add(std::span<const Row> rows, std::span<const Real> lambda, const Motions& m,
         std::vector<Vec3>& to) {
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (int i = 0; i < rows[r].count; ++i) {
      const std::uint32_t b = rows[r].body[i];
      to[b] += m.inverse_mass[b] * (lambda[r] * rows[r].j[i]);
    }
}

Real worst(std::span<const Row> rows) {
  Real most = 0;
  for (const Row& row : rows) most = std::max(most, std::abs(row.c));
  return most;
}

Real size_of(const Planar& all) {
  Real size = 1e-3;
  for (const PlaneJoint& j : all.scratch.plane.joints)
    size = std::max({size, glm::length(j.arm_a), glm::length(j.arm_b)});
  return size;
}

/// Takes a step of Newton's method, shortened so that no body rotates too far for the linearised
/// rows.
void move(Motions& m, std::span<const Row> rows, std::span<const Real> lambda) {
  m.before = m.position;
  add(rows, lambda, m, m.position);
  Real most = 0;
  for (std::size_t i = 0; i < m.before.size(); ++i)
    most = std::max(most, std::abs(m.position[i].z - m.before[i].z));
  const Real part = most > kMostTurn ? kMostTurn / most : 1;
  for (std::size_t i = 0; i < m.before.size(); ++i) {
    if (part < 1) m.position[i] = m.before[i] + part * (m.position[i] - m.before[i]);
    m.gained[i] += m.position[i].z - m.before[i].z;
  }
}

/// A mechanism that Box2D has moved, and its rows while they are closed.
struct Closing {
  const World& world;
  Planar& all;
  Mechanism& of;
  Real h, enough;
  StepScratch& s = all.scratch;

  std::size_t first_span() const { return s.rows.size() - of.spans.size(); }
  void add_to_spans(Real part) {
    const std::size_t first = first_span();
    for (std::size_t i = 0; i < of.spans.size(); ++i)
      all.spans[of.spans[i]].impulse += part * s.lambda[first + i];
  }
};

/// Conserves the energy of belts with varying ratio: closing impulses act along the rows at the
/// start of the step, on velocities too. [Andersen 1983]
void close_along_start(Closing& c) {
  StepScratch& s = c.s;
  if (c.of.spans.empty()) return;
  const std::size_t first = c.first_span();
  for (int n = 0; n < kMostIterations && worst(s.rows) > c.enough; ++n) {
    s.lambda.clear();
    for (const Row& row : s.rows) s.lambda.push_back(-row.c);
    for (std::size_t i = 0; i < c.of.spans.size(); ++i)
      if (const std::uint32_t span = c.of.spans[i]; c.all.spans[span].slips == 0)
        s.rows[first + i] = s.start_rows[span];
    c.of.closing.compute(s.rows, s.motions.inverse_mass), c.of.closing.solve(s.lambda);
    move(s.motions, s.rows, s.lambda);
    for (std::size_t i = first; i < s.rows.size(); ++i) c.of.row_impulses[i] += s.lambda[i] / c.h;
    c.add_to_spans(1 / c.h);
    for (std::size_t i = first; i < s.rows.size(); ++i) s.lambda[i] /= c.h;
    add(std::span(s.rows).subspan(first), std::span(s.lambda).subspan(first), s.motions,
        s.motions.velocity);
    find_rows(c.world, c.all, c.of);
  }
}

void close_positions(Closing& c) {
  StepScratch& s = c.s;
  for (int n = 0; n < kMostIterations && worst(s.rows) > c.enough; ++n) {
    s.lambda.clear();
    for (const Row& row : s.rows) s.lambda.push_back(-row.c);
    c.of.closing.compute(s.rows, s.motions.inverse_mass), c.of.closing.solve(s.lambda);
    take_curve_impulses(c.all, c.of, c.h);
    move(s.motions, s.rows, s.lambda);
    find_rows(c.world, c.all, c.of);
  }
  c.all.residual = std::max(c.all.residual, worst(s.rows));
}

void close_velocities(Closing& c) {
  StepScratch& s = c.s;
  Motions& m = s.motions;
  c.of.closing.compute(s.rows, m.inverse_mass);
  for (int n = 0; n < 2; ++n) {
    s.lambda.clear();
    for (const Row& row : s.rows) s.lambda.push_back(lack_of(row, m.velocity));
    c.of.closing.solve(s.lambda);
    add(s.rows, s.lambda, m, m.velocity);
    for (std::size_t i = 0; i < s.rows.size(); ++i) c.of.row_impulses[i] += s.lambda[i];
    c.add_to_spans(1);
  }
}

/// Stores joint loads: of Box2D's step, and of closing.
void note_borne(Closing& c) {
  std::size_t row = 0;
  c.of.borne.clear();
  each_joint(c.all, c.of, [&](const PlaneJoint& joint) {
    JointLoad& sum = c.of.borne.emplace_back(joint.load);
    sum.spring = 0;
    const Vec3 arm = turned(joint.arm_b, c.s.motions.gained[joint.b]);
    for (int rows = rows_of(joint); rows-- > 0; ++row) {
      const Real force = c.of.row_impulses[row] / c.h;
      const Vec3 on_b = c.s.rows[row].part(joint.b);
      sum.force += force * Vec3(on_b.x, on_b.y, 0);
      sum.torque += force * (on_b.z - (arm.x * on_b.y - arm.y * on_b.x));
    }
  });
  row += c.of.gears.size();
  for (const std::uint32_t drive : c.of.drives)
    c.all.drives[drive].impulse += c.of.row_impulses[row++];
}

/// The coordinate of a joint in its present pose, as its joint kind counts it; an angle is the one
/// nearest to `before`.
Real coordinate_now(const World& world, const FlatLink& l, Coordinate which, Real before = 0) {
  return coordinate_at(world, world.links.values()[l.link], which, before).value;
}

}  // namespace

void count_coordinates(const World& world, Planar& all) {
  Motions& m = all.scratch.motions;
  const auto are_counted = [](const auto& list) {
    return std::ranges::all_of(list, [](const auto& of) { return of.counted; });
  };
  if (are_counted(all.gears) && are_counted(all.drives)) return;
  const std::vector<PlaneBody>& bodies = all.scratch.plane.bodies;
  m.position.clear(), m.gained.assign(bodies.size(), 0);
  for (const PlaneBody& b : bodies) m.position.push_back({b.position.x, b.position.y, b.angle});
  for (FlatGear& gear : all.gears) {
    if (gear.counted) continue;
    const Gear& told = world.gears.values()[gear.slot];
    const Real first = coordinate_now(world, all.links[gear.links[0]], first_of(told));
    const Real second = coordinate_now(world, all.links[gear.links[1]], second_of(told));
    gear.first = first - counted_row(world, all, gear.links[0], first_of(told)).c;
    gear.second = second - counted_row(world, all, gear.links[1], second_of(told)).c;
    gear.offset = told.has_offset ? told.offset : second - told.ratio * first;
    gear.counted = true;
  }
  for (FlatDrive& d : all.drives) {
    if (d.counted) continue;
    const Coordinate which = d.travels ? Coordinate::travel : Coordinate::angle;
    const Real meant = motion_at(world.joint_drives.values()[d.drive].motion, world.time).value;
    d.first = coordinate_now(world, all.links[d.link], which, meant) -
              counted_row(world, all, d.link, which).c;
    d.counted = true;
  }
}

void close(const World& world, Planar& all, Real h) {
  StepScratch& s = all.scratch;
  s.nows.assign(kMostPlaces * all.curves.size(), {});
  const Real enough = kClosedResidual * size_of(all);
  for (Mechanism& of : all.mechanisms) {
    if (of.moved) continue;
    find_rows(world, all, of);
    if (!of.closing.fits(s.rows.size())) of.closing.analyse(s.rows, s.motions.inverse_mass);
    if (may_slip(world, all, of)) {
      of.closing.compute(s.rows, s.motions.inverse_mass);
      let_slip(world, all, of, h), find_rows(world, all, of);
    }
    of.row_impulses.resize(s.rows.size(), 0);  // may contain impulses from before the step
    Closing closing{world, all, of, h, enough};
    close_along_start(closing), close_positions(closing), close_velocities(closing);
    note_borne(closing);
  }
}

}  // namespace pantin::detail::planar
