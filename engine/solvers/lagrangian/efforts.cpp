// Springs, friction and motors along freedoms: as forces, or as rows of their own that give way.
#include <algorithm>

#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::lagrangian {
namespace {

/// A row that would change its rate by less than this part in a step acts as a plain force.
constexpr Real kSlack = 1e-10;

/// J M^-1 J^T of a row.
Real mobility(const Island& m, const Block& b) {
  Real sum = 0;
  for (std::size_t k = 0; k < b.count; ++k) {
    if (b.body[k] >= m.count()) continue;
    const RowVectors j = row_of(b, jacobian_of(m, b), 0, k);
    sum += glm::dot(j.v, j.v) / m.mass[b.body[k]] + glm::dot(j.w, m.room.give[b.body[k]] * j.w);
  }
  return sum;
}

const Freedom& freedom_of(const World& world, std::uint32_t link, Coordinate which) {
  const JointExtras& extras = *world.links.values()[link].joint.extras;
  return which == Coordinate::turn ? extras.turn : extras.slide;
}

}  // namespace

Pull pull_of(const Freedom& f, Real coordinate, Real rate, bool secant) {
  Pull p;
  p.effort = -f.spring.stiffness * (coordinate - f.spring.rest) - f.spring.damping * rate;
  p.stiffness = f.spring.stiffness, p.damping = f.spring.damping;
  p.effort -= f.friction.viscous * rate, p.damping += f.friction.viscous;
  if (f.friction.dry != 0) {
    const Real u = rate / f.friction.slip, t = std::tanh(u), steepest = f.friction.dry / f.friction.slip;
    p.effort -= f.friction.dry * t;
    p.damping += secant ? steepest * (std::abs(u) > 1e-6 ? t / u : 1) : steepest * (1 - t * t);
  }
  if (f.motor.kind == MotorKind::none) return p;
  const bool speed = f.motor.kind == MotorKind::velocity;
  const Real asked = speed ? f.motor.gain * (f.motor.target - rate)
                           : f.motor.gain * (f.motor.target - coordinate) - f.motor.damping * rate;
  p.effort += std::clamp(asked, -f.motor.cap, f.motor.cap);
  const bool capped = std::abs(asked) >= f.motor.cap;
  const Real part = !capped ? 1 : secant ? f.motor.cap / std::abs(asked) : 0;
  p.stiffness += speed ? 0 : part * f.motor.gain;
  p.damping += part * (speed ? f.motor.gain : f.motor.damping);
  return p;
}

CoordinateRow coordinate_row(const World& world, const Island& m, std::uint32_t link,
                             Coordinate which, std::uint32_t a, std::uint32_t b, Real before) {
  CoordinateRow row;
  const Placed &at_a = m.room.placed[a], &at_b = m.room.placed[b];
  write_coordinate(world.links.values()[link].joint, which, at_a, at_b, before,
                   {&row.value, row.j, &row.gamma});
  row.rate = glm::dot(row.j[0], at_a.velocity) + glm::dot(row.j[1], at_a.spin) +
             glm::dot(row.j[2], at_b.velocity) + glm::dot(row.j[3], at_b.spin);
  return row;
}

void push_efforts(const World& world, Island& m) {
  for (const Effort& e : m.efforts) {
    const CoordinateRow row =
        coordinate_row(world, m, e.link, e.coordinate, e.body[0], e.body[1], e.before);
    const Freedom& freedom = freedom_of(world, e.link, e.coordinate);
    const Real effort = pull_of(freedom, row.value, row.rate, false).effort;
    for (std::size_t k = 0; k < 2; ++k)
      if (e.body[k] < m.count())
        m.room.force[2 * e.body[k]] += effort * row.j[2 * k],
            m.room.force[2 * e.body[k] + 1] += effort * row.j[2 * k + 1];
  }
}

Stiffness stiffness_of(const World& world, const Island& m) {
  Stiffness most;
  for (const Effort& e : m.efforts) {
    const CoordinateRow row =
        coordinate_row(world, m, e.link, e.coordinate, e.body[0], e.body[1], e.before);
    Real mobile = 0;
    for (std::size_t k = 0; k < 2; ++k)
      if (e.body[k] < m.count())
        mobile += glm::dot(row.j[2 * k], row.j[2 * k]) / m.mass[e.body[k]] +
                  glm::dot(row.j[2 * k + 1], m.room.give[e.body[k]] * row.j[2 * k + 1]);
    const Pull p = pull_of(freedom_of(world, e.link, e.coordinate), row.value, row.rate, false);
    most.spring = std::max(most.spring, mobile * p.stiffness);
    most.damper = std::max(most.damper, mobile * p.damping);
  }
  return most;
}

void meet_efforts(const World& world, Island& m, std::span<Real> asked, Real by_way, Real by_speed,
                  bool secant) {
  for (const Block& b : m.blocks) {
    if (b.kind != BlockKind::spring) continue;
    const Freedom& f = freedom_of(world, b.source, b.coordinate);
    const Pull p = pull_of(f, m.room.c[b.first_row], rate_of(m, b, 0), secant);
    const Real give = p.stiffness * by_way + p.damping * by_speed;
    m.room.weights[b.first_row] = 1 / std::max(give, kSlack / std::max(mobility(m, b), Real(1e-300)));
    asked[b.first_row] = p.effort;
  }
}

void meet_efforts_at_end(const World& world, Island& m, std::span<Real> right, Real h) {
  for (const Block& b : m.blocks) {
    if (b.kind != BlockKind::spring) continue;
    const Freedom& f = freedom_of(world, b.source, b.coordinate);
    const Real rate = rate_of(m, b, 0), mobile = std::max(mobility(m, b), Real(1e-300));
    Pull p = pull_of(f, m.room.c[b.first_row], rate, true);
    // An effort at its cap, or sliding, that would still be so at the end is a plain force.
    const Real end = rate + h * mobile * p.effort;
    if (pull_of(f, m.room.c[b.first_row] + h * end, end, true).effort == p.effort)
      p.stiffness = p.damping = 0;
    const Real least = kSlack / (h * mobile);
    const Real give = std::max(h * p.stiffness + p.damping, least);
    m.room.weights[b.first_row] = 1 / (h * give);
    right[b.first_row] += (p.effort + (give - h * p.stiffness) * rate) / give;
  }
}

}  // namespace pantin::lagrangian
