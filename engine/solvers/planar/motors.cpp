// Springs and motors of joints in belt or gear trains. Box2D knows neither belts nor such gears: a
// stiff motor on a light pulley would drive the pulley alone, and lose the load of the rest. So
// they act before the step, implicitly, on all bodies that move with their joint.
#include <algorithm>

#include "engine/solvers/planar/island.hpp"

namespace pantin::detail::planar {
namespace {

constexpr Real kMoves = 1e-12;  // fraction of the mobility of a joint alone: below it is locked

/// What a projection is made for: the velocities that rows demand, or changes of them.
enum class Demand { rates, changes };

/// Projects velocities onto the rows of the mechanism.
void project(StepScratch& s, const Mechanism& of, std::vector<Vec3>& velocity, Demand demand) {
  s.lambda.clear();
  for (const Row& row : s.rows)
    s.lambda.push_back((demand == Demand::rates ? row.rate : 0) - rate_of(row, velocity));
  of.closing.solve(s.lambda);
  for (std::size_t r = 0; r < s.rows.size(); ++r)
    for (int i = 0; i < s.rows[r].count; ++i) {
      const std::uint32_t b = s.rows[r].body[i];
      velocity[b] += s.motions.inverse_mass[b] * (s.lambda[r] * s.rows[r].j[i]);
    }
}

/// Adds external forces to the motion at the start of the step.
void add_forces(StepScratch& s, const Mechanism& of, Real h) {
  for (const std::uint32_t i : of.bodies) {
    const PlaneBody& b = s.plane.bodies[i];
    const Vec3 fall = b.gravity_scale * s.plane.gravity;
    s.motions.velocity[i] += h * (Vec3(fall.x, fall.y, 0) +
                                  s.motions.inverse_mass[i] * Vec3(b.force.x, b.force.y, b.torque));
  }
}

bool is_driven(const PlaneJoint& j) {
  if (!(j.along.stiffness > 0) && !(j.along.damping > 0)) return false;
  return j.kind == PlaneJoint::hinge || j.kind == PlaneJoint::slider;
}

/// Motions::answer to a unit impulse along a row, alone and with the mechanism.
struct Mobility {
  Real alone = 0, tied = 0;
  bool moves() const { return tied > kMoves * alone; }
};
Mobility answer_to(StepScratch& s, const Mechanism& of, const Row& along) {
  std::vector<Vec3>& answer = s.motions.answer;
  answer.assign(s.motions.velocity.size(), Vec3(0));
  for (int i = 0; i < along.count; ++i)
    answer[along.body[i]] += s.motions.inverse_mass[along.body[i]] * along.j[i];
  const Real alone = rate_of(along, answer);
  project(s, of, answer, Demand::changes);
  return {alone, rate_of(along, answer)};
}

/// Drives one joint.
void drive(StepScratch& s, Mechanism& of, PlaneJoint& j, Real h) {
  PANTIN_ASSERT(is_driven(j) && of.row_impulses.size() == s.rows.size());
  const std::vector<Vec3>& answer = s.motions.answer;
  const Row along = coordinate_row(j, s.motions);
  const PlaneSpring& spring = j.along;
  const Mobility found = answer_to(s, of, along);
  const Real mobility = found.tied;
  // Stiff springs act at the end position, soft ones at the present one: that loses no energy.
  const Real stiff = h * h * mobility * spring.stiffness;
  const Real slope = spring.damping + stiff / (1 + stiff) * h * spring.stiffness;
  const Real load = spring.load - (j.kind == PlaneJoint::slider ? spring.stiffness * along.c : 0);
  const Real effort =
      (load - slope * rate_of(along, s.motions.velocity)) / (1 + h * mobility * slope);
  j.along = {}, j.load.spring = 0;
  if (!found.moves()) return;
  for (std::size_t r = 0; r < s.rows.size(); ++r) of.row_impulses[r] += h * effort * s.lambda[r];
  for (const std::uint32_t i : of.bodies) {
    const Vec3 more = h * effort * answer[i];
    s.motions.velocity[i] += more;
    s.plane.bodies[i].velocity += Vec3(more.x, more.y, 0), s.plane.bodies[i].spin += more.z;
  }
}

}  // namespace

Real mobility_of(StepScratch& s, const Mechanism& of, const Row& along) {
  const Mobility found = answer_to(s, of, along);
  return found.moves() ? found.tied : found.alone;
}

void drive_tied(const World& world, Planar& all, Real h) {
  StepScratch& s = all.scratch;
  s.nows.resize(kMostPlaces * all.curves.size());
  for (Mechanism& of : all.mechanisms) {
    if (of.spans.empty() && of.gears.empty()) continue;
    PANTIN_ASSERT(!of.bodies.empty());
    if (s.plane.bodies[of.bodies.front()].kind == PlaneBody::absent) continue;
    bool any = false;
    each_joint(all, of, [&](const PlaneJoint& j) { any = any || is_driven(j); });
    if (!any) continue;
    add_forces(s, of, h);
    find_rows(world, all, of);
    if (!of.closing.fits(s.rows.size())) of.closing.analyse(s.rows, s.motions.inverse_mass);
    of.closing.compute(s.rows, s.motions.inverse_mass);
    project(s, of, s.motions.velocity, Demand::rates);
    of.row_impulses.assign(s.rows.size(), 0);
    each_joint(all, of, [&](PlaneJoint& j) {
      if (is_driven(j)) drive(s, of, j, h);
    });
    const std::size_t first = s.rows.size() - of.spans.size();
    for (std::size_t i = 0; i < of.spans.size(); ++i)
      all.spans[of.spans[i]].impulse = of.row_impulses[first + i];
  }
}

}  // namespace pantin::detail::planar
