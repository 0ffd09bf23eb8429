// Springs and motors of joints whose bodies belts or gears tie to others. Box2D knows neither: a
// stiff motor on a light pulley would see the pulley alone, and lose what the rest takes from it.
// They act before the step instead, implicitly, on all that moves with their joint.
#include <algorithm>

#include "engine/solvers/planar/island.hpp"

namespace pantin::detail::planar {
namespace {

constexpr Real kMoves = 1e-12;  // of the mobility of a joint alone: below it nothing gives way

Real rate_of(const Row& row, std::span<const Vec3> velocity) {
  Real rate = 0;
  for (int i = 0; i < row.count; ++i) rate += glm::dot(row.j[i], velocity[row.body[i]]);
  return rate;
}

/// Takes from velocities what opens joints, gears and belts.
void project(StepScratch& s, std::vector<Vec3>& velocity) {
  s.lambda.clear();
  for (const Row& row : s.rows) s.lambda.push_back(-rate_of(row, velocity));
  s.factor.solve(s.lambda);
  for (std::size_t r = 0; r < s.rows.size(); ++r)
    for (int i = 0; i < s.rows[r].count; ++i) {
      const std::uint32_t b = s.rows[r].body[i];
      velocity[b] += s.motions.inverse_mass[b] * (s.lambda[r] * s.rows[r].j[i]);
    }
}

/// The motion at the start of the step, and what forces from outside would add to it.
void begin_motions(StepScratch& s, Vec3 gravity, Real h) {
  Motions& m = s.motions;
  const std::size_t count = s.plane.bodies.size();
  m.position.assign(count, Vec3(0)), m.velocity = m.inverse_mass = m.position;
  m.gained.assign(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const PlaneBody& b = s.plane.bodies[i];
    m.position[i] = {b.position.x, b.position.y, b.angle};
    if (b.kind != PlaneBody::fixed) m.velocity[i] = {b.velocity.x, b.velocity.y, b.spin};
    if (b.kind != PlaneBody::dynamic) continue;
    m.inverse_mass[i] = {1 / b.mass, 1 / b.mass, 1 / b.inertia};
    const Vec3 fall = b.gravity_scale * gravity;
    m.velocity[i] +=
        h * (Vec3(fall.x, fall.y, 0) + m.inverse_mass[i] * Vec3(b.force.x, b.force.y, b.torque));
  }
}

std::vector<bool> tied_islands(const Planar& all) {
  std::vector<bool> tied(all.islands, false);
  const auto mark = [&](std::uint32_t body) {
    if (all.bodies[body].island != kNobody) tied[all.bodies[body].island] = true;
  };
  for (const FlatSpan& s : all.spans) mark(s.a), mark(s.b);
  for (const FlatGear& g : all.gears)
    for (const std::uint32_t link : g.links) mark(all.links[link].a), mark(all.links[link].b);
  return tied;
}

/// Drives one joint; `answer` is memory.
void drive(StepScratch& s, PlaneJoint& j, std::vector<Vec3>& answer, Real h) {
  const Row along = coordinate_row(j, s.motions);
  const PlaneSpring& spring = j.along;
  answer.assign(s.motions.velocity.size(), Vec3(0));
  for (int i = 0; i < along.count; ++i)
    answer[along.body[i]] += s.motions.inverse_mass[along.body[i]] * along.j[i];
  const Real alone = rate_of(along, answer);
  project(s, answer);
  const Real mobility = rate_of(along, answer);
  // Stiff springs act where they come to, soft ones where they are: that loses no energy.
  const Real stiff = h * h * mobility * spring.stiffness;
  const Real slope = spring.damping + stiff / (1 + stiff) * h * spring.stiffness;
  const Real load = spring.load - (j.kind == PlaneJoint::slider ? spring.stiffness * along.c : 0);
  const Real effort =
      (load - slope * rate_of(along, s.motions.velocity)) / (1 + h * mobility * slope);
  j.along = {}, j.load.spring = 0;
  if (!(mobility > kMoves * alone)) return;
  for (std::size_t r = 0; r < s.rows.size(); ++r) s.borne[r] += h * effort * s.lambda[r];
  for (std::size_t i = 0; i < answer.size(); ++i) {
    const Vec3 more = h * effort * answer[i];
    s.motions.velocity[i] += more;
    PlaneBody& b = s.plane.bodies[i];
    if (b.kind == PlaneBody::dynamic) b.velocity += Vec3(more.x, more.y, 0), b.spin += more.z;
  }
}

}  // namespace

void drive_tied(const World& world, Planar& all, Real h) {
  all.scratch.borne.clear();
  if (all.spans.empty() && all.gears.empty()) return;
  StepScratch& s = all.scratch;
  const std::vector<bool> tied = tied_islands(all);
  const auto is_driven = [&](const PlaneJoint& j) {
    if (!(j.along.stiffness > 0) && !(j.along.damping > 0)) return false;
    if (j.kind != PlaneJoint::hinge && j.kind != PlaneJoint::slider) return false;
    return std::ranges::any_of(std::array{j.a, j.b}, [&](std::uint32_t b) {
      return b < all.bodies.size() && all.bodies[b].island != kNobody && tied[all.bodies[b].island];
    });
  };
  std::vector<PlaneJoint>& joints = s.plane.joints;
  if (std::none_of(joints.begin(), joints.end(), is_driven)) return;
  begin_motions(s, s.plane.gravity, h);
  find_rows(world, all);
  if (!s.factor.fits(s.rows.size())) s.factor.analyse(s.rows, s.motions.inverse_mass);
  s.factor.compute(s.rows, s.motions.inverse_mass);
  project(s, s.motions.velocity);
  s.borne.assign(s.rows.size(), 0);
  std::vector<Vec3> answer;
  for (PlaneJoint& j : joints)
    if (is_driven(j)) drive(s, j, answer, h);
  const std::size_t first = s.rows.size() - all.spans.size();
  for (std::size_t i = 0; i < all.spans.size(); ++i) all.spans[i].impulse = s.borne[first + i];
}

}  // namespace pantin::detail::planar
