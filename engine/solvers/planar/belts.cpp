// Spans of belts as rows of the plane.
#include <algorithm>
#include <cmath>

#include "engine/solvers/planar/island.hpp"

namespace pantin::detail::planar {
namespace {

Real cross(Vec3 a, Vec3 b) { return a.x * b.y - a.y * b.x; }

Pose pose_of(const World& world, const Planar& all, std::uint32_t body) {
  return world.bodies.values()[all.bodies[body].slot].pose;
}

/// A pulley at the current motions of the step.
BeltPlace place_in(const World& world, const Planar& all, const PulleyAt& at) {
  const Motions& m = all.scratch.motions;
  PANTIN_ASSERT(at.index < at.belt.pulleys.size() && at.body < m.position.size());
  const BeltPulley& p = at.belt.pulleys[at.index];
  const Real gained = m.gained[at.body];
  const Vec3 arm = pose_of(world, all, at.body).rotation * p.anchor;
  const Real c = std::cos(gained), s = std::sin(gained);
  const Vec3 centre = Vec3(c * arm.x - s * arm.y, s * arm.x + c * arm.y, 0) + m.position[at.body];
  return {p.outline, centre * Vec3(1, 1, 0), p.angle + gained, p.sense};
}

void push(Motions& m, const Row& row, Real impulse, Real h) {
  for (int i = 0; i < row.count; ++i) {
    const std::uint32_t b = row.body[i];
    const Vec3 more = m.inverse_mass[b] * (impulse * row.j[i]);
    m.velocity[b] += more, m.position[b] += h * more, m.gained[b] += h * more.z;
  }
}

/// An empty row that names its bodies, so that the factor keeps its pattern.
Row slack_row(const FlatSpan& of) {
  Row row;
  row.add(of.a, Vec3(0)), row.add(of.b, Vec3(0));
  return row;
}

}  // namespace

Row span_row(const World& world, const Planar& all, const FlatSpan& of) {
  return of.slips == 0 ? span_pull(world, all, of) : slack_row(of);
}

Row span_pull(const World& world, const Planar& all, const FlatSpan& of) {
  const Belt& belt = world.belts.values()[of.belt];
  const std::size_t next = (of.index + 1) % belt.pulleys.size();
  const BeltPlace a = place_in(world, all, {belt, of.index, of.a}),
                  b = place_in(world, all, {belt, next, of.b});
  const BeltSpan span = span_between(a, b, belt.pulleys[of.index].direction);
  if (!span.is_found) return slack_row(of);
  Row row;
  const std::vector<Vec3>& at = all.scratch.motions.position;
  const Vec3 u = span.along;
  row.add(of.a, {-u.x, -u.y, -cross(span.from - at[of.a], u)});
  row.add(of.b, {u.x, u.y, cross(span.to - at[of.b], u)});
  row.c = marked_length(a, b, span) - belt.pulleys[of.index].offset;
  return row;
}

void begin_belts(World& world, Planar& all) {
  StepScratch& s = all.scratch;
  s.start_rows.clear();
  for (FlatSpan& span : all.spans) {
    span.slips = 0, span.impulse = 0;
    Belt& belt = world.belts.values()[span.belt];
    const std::size_t next = (span.index + 1) % belt.pulleys.size();
    BeltPulley &a = belt.pulleys[span.index], &b = belt.pulleys[next];
    a.angle = place_of(a, pose_of(world, all, span.a)).angle;
    b.angle = place_of(b, pose_of(world, all, span.b)).angle;
  }
  for (const FlatSpan& span : all.spans) s.start_rows.push_back(span_row(world, all, span));
}

void let_slip(const World& world, Planar& all, const Mechanism& of, Real h) {
  StepScratch& s = all.scratch;
  PANTIN_ASSERT(s.rows.size() >= of.spans.size());
  const std::size_t first = s.rows.size() - of.spans.size();
  s.lambda.clear();
  for (const Row& row : s.rows) s.lambda.push_back(lack_of(row, s.motions.velocity));
  of.closing.solve(s.lambda);
  for (std::size_t i = 0; i < of.spans.size(); ++i) {
    FlatSpan& span = all.spans[of.spans[i]];
    const Belt& belt = world.belts.values()[span.belt];
    if (!(belt.friction > 0)) continue;
    const Real most = grip_of(belt) * h, asked = s.lambda[first + i];
    if (!(std::abs(asked) > most)) continue;
    span.slips = asked < 0 ? -1 : 1, span.impulse = span.slips * most;
    push(s.motions, s.rows[first + i], span.impulse, h);
  }
}

bool may_slip(const World& world, const Planar& all, const Mechanism& of) {
  return std::any_of(of.spans.begin(), of.spans.end(), [&](std::uint32_t span) {
    return world.belts.values()[all.spans[span].belt].friction > 0;
  });
}

void end_belts(World& world, Planar& all, Real h) {
  for (std::size_t first = 0; first < all.spans.size(); first += all.spans[first].held) {
    const std::span<const FlatSpan> spans(&all.spans[first], all.spans[first].held);
    Belt& belt = world.belts.values()[spans.front().belt];
    const std::size_t count = belt.pulleys.size();
    PANTIN_ASSERT(count <= kMostPulleys && spans.size() <= count);
    Pose poses[kMostPulleys];
    Real angles[kMostPulleys] = {};
    const auto note = [&](std::size_t pulley, std::uint32_t body) {
      poses[pulley] = pose_of(world, all, body);
      angles[pulley] = belt.pulleys[pulley].angle + all.scratch.motions.gained[body];
    };
    for (const FlatSpan& s : spans) {
      note(s.index, s.a), note((s.index + 1) % count, s.b);
      belt.pulleys[s.index].tension = belt.pretension - s.impulse / h;
    }
    if (spans.size() < count) belt.pulleys.back().tension = belt.pretension;
    follow_belt(belt, {poses, count}, {angles, count});
    belt.slips = spans.front().slips != 0;
    if (belt.slips) lay_mark(belt, 0, {poses, count});
  }
}

}  // namespace pantin::detail::planar
