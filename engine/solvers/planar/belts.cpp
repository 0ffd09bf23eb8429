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

/// A pulley as the motions of the step have brought it.
BeltPlace place_in(const World& world, const Planar& all, const PulleyAt& at) {
  const Motions& m = all.scratch.motions;
  const BeltPulley& p = at.belt.pulleys[at.index];
  const Real gained = m.gained[at.body];
  const Vec3 arm = pose_of(world, all, at.body).rotation * p.anchor;
  const Real c = std::cos(gained), s = std::sin(gained);
  const Vec3 centre = Vec3(c * arm.x - s * arm.y, s * arm.x + c * arm.y, 0) + m.position[at.body];
  return {p.outline, centre * Vec3(1, 1, 0), p.angle + gained, p.sense};
}

Row span_row(const World& world, const Planar& all, const FlatSpan& of) {
  const Belt& belt = world.belts.values()[of.belt];
  const std::size_t next = (of.index + 1) % belt.pulleys.size();
  const BeltPlace a = place_in(world, all, {belt, of.index, of.a}),
                  b = place_in(world, all, {belt, next, of.b});
  const BeltSpan span = span_between(a, b, belt.pulleys[of.index].direction);
  Row row;
  if (!span.is_found || of.slips) {  // names its bodies all the same: the factor keeps its pattern
    row.add(of.a, Vec3(0)), row.add(of.b, Vec3(0));
    return row;
  }
  const std::vector<Vec3>& at = all.scratch.motions.position;
  const Vec3 u = span.along;
  row.add(of.a, {-u.x, -u.y, -cross(span.from - at[of.a], u)});
  row.add(of.b, {u.x, u.y, cross(span.to - at[of.b], u)});
  row.c = marked_length(a, b, span) - belt.pulleys[of.index].offset;
  return row;
}

Real rate_of(const Row& row, const Motions& m) {
  Real rate = 0;
  for (int i = 0; i < row.count; ++i) rate += glm::dot(row.j[i], m.velocity[row.body[i]]);
  return rate;
}

void push(Motions& m, const Row& row, Real impulse, Real h) {
  for (int i = 0; i < row.count; ++i) {
    const std::uint32_t b = row.body[i];
    const Vec3 more = m.inverse_mass[b] * (impulse * row.j[i]);
    m.velocity[b] += more, m.position[b] += h * more, m.gained[b] += h * more.z;
  }
}

}  // namespace

void append_belt_rows(const World& world, const Planar& all, std::vector<Row>& rows) {
  for (const FlatSpan& s : all.spans) rows.push_back(span_row(world, all, s));
}

void begin_belts(World& world, Planar& all) {
  StepScratch& s = all.scratch;
  s.start_rows.clear();
  if (all.spans.empty()) return;
  for (FlatSpan& span : all.spans) {
    span.slips = false, span.impulse = 0;
    Belt& belt = world.belts.values()[span.belt];
    const std::size_t next = (span.index + 1) % belt.pulleys.size();
    BeltPulley &a = belt.pulleys[span.index], &b = belt.pulleys[next];
    a.angle = place_of(a, pose_of(world, all, span.a)).angle;
    b.angle = place_of(b, pose_of(world, all, span.b)).angle;
  }
  Motions& m = s.motions;
  m.position.clear(), m.gained.assign(s.plane.bodies.size(), 0);
  for (const PlaneBody& b : s.plane.bodies)
    m.position.push_back({b.position.x, b.position.y, b.angle});
  append_belt_rows(world, all, s.start_rows);
}

void let_slip(const World& world, Planar& all, Real h) {
  StepScratch& s = all.scratch;
  const std::size_t first = s.rows.size() - all.spans.size();
  s.factor.compute(s.rows, s.motions.inverse_mass);
  s.lambda.clear();
  for (const Row& row : s.rows) s.lambda.push_back(-rate_of(row, s.motions));
  s.factor.solve(s.lambda);
  for (std::size_t i = 0; i < all.spans.size(); ++i) {
    const Belt& belt = world.belts.values()[all.spans[i].belt];
    if (!(belt.friction > 0)) continue;
    const Real most = grip_of(belt) * h, asked = s.lambda[first + i];
    if (!(std::abs(asked) > most)) continue;
    all.spans[i].slips = true, all.spans[i].impulse = std::copysign(most, asked);
    push(s.motions, s.rows[first + i], all.spans[i].impulse, h);
  }
}

bool may_slip(const World& world, const Planar& all) {
  return std::any_of(all.spans.begin(), all.spans.end(),
                     [&](const FlatSpan& s) { return world.belts.values()[s.belt].friction > 0; });
}

void end_belts(World& world, Planar& all, Real h) {
  for (std::size_t first = 0; first < all.spans.size(); first += all.spans[first].held) {
    const std::span<const FlatSpan> spans(&all.spans[first], all.spans[first].held);
    Belt& belt = world.belts.values()[spans.front().belt];
    const std::size_t count = belt.pulleys.size();
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
    belt.slips = spans.front().slips;
    if (belt.slips) lay_mark(belt, 0, {poses, count});
  }
}

}  // namespace pantin::detail::planar
