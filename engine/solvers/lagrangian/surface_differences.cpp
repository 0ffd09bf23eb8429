#include "engine/solvers/lagrangian/surface_differences.hpp"

#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/surface_spots.hpp"

namespace pantin::detail::lagrangian {
namespace {

using nurbs::ContactStatus;

/// A row of C_p with a shorter gradient binds nothing.
constexpr Real kNoRow = 1e-6;

/// The contact of a block at poses of its bodies.
struct Contact {
  const SurfaceContact& c;
  nurbs::PlacePair from;  // where tracking starts
  BodyState a, b;
};
Contact contact_of(const World& world, const Island& m, std::size_t block) {
  const Block& b = m.blocks[block];
  Contact k{world.surface_contacts.values()[b.source], m.scratch.touching[b.first_place].pair.at,
            m.scratch.body_states[b.body[0]], m.scratch.body_states[b.body[1]]};
  k.a.rotation = pose_of(m, b.body[0]).rotation, k.b.rotation = pose_of(m, b.body[1]).rotation;
  return k;
}

/// The pair at displaced poses, world axes.
struct Sample {
  Vec3 on_a{0}, on_b{0}, normal{0};
  Vec3 tangent[2] = {};
  Real gap = 0;
  ContactStatus status = ContactStatus::lost;
};
Sample sample(const Contact& k, const Pose& a, const Pose& b) {
  const Pose surface_a = compose(a, k.c.on_a.pose), surface_b = compose(b, k.c.on_b.pose);
  const nurbs::CommonNormal now = track_pair(k.c, compose(inverse(surface_b), surface_a), k.from);
  Sample s;
  s.status = now.status;
  if (now.status != ContactStatus::found) return s;
  s.on_a = to_world(surface_b, now.on_a), s.on_b = to_world(surface_b, now.on_b);
  s.normal = surface_b.rotation * now.normal, s.gap = now.gap;
  s.tangent[0] = surface_b.rotation * tangent_of(k.c, now.normal, Vec3(0)).t;
  s.tangent[1] = glm::cross(s.normal, s.tangent[0]);
  return s;
}

Pose displaced(const BodyState& at, Vec3 way, Vec3 turn) {
  return {at.position + way, glm::normalize(from_rotation_vector(turn) * at.rotation)};
}

/// The pair with one coordinate displaced by `by`, m or rad.
Sample sample_beside(const Contact& k, std::size_t coordinate, Real by) {
  Vec3 change[4] = {Vec3(0), Vec3(0), Vec3(0), Vec3(0)};
  change[coordinate / 3][static_cast<int>(coordinate % 3)] = by;
  return sample(k, displaced(k.a, change[0], change[1]), displaced(k.b, change[2], change[3]));
}

/// Rates of the rows at velocities V: of the gap or of C_p, of rolling and of spin.
struct RowRates {
  Real rate[4] = {};
  ContactStatus status = ContactStatus::found;
};
/// After so many seconds of motion with the present velocities.
RowRates rates_after(const Contact& k, Real time, Jacobians form) {
  const auto pose = [&](const BodyState& at) {
    return displaced(at, time * at.velocity, time * at.angular_velocity);
  };
  const Pose a = pose(k.a), b = pose(k.b);
  const Sample s = sample(k, a, b);
  const Vec3 v = k.a.velocity + glm::cross(k.a.angular_velocity, s.on_a - a.position) -
                 k.b.velocity - glm::cross(k.b.angular_velocity, s.on_b - b.position);
  const Real factor = form == Jacobians::squared_distance ? 2 * std::abs(s.gap) : 1;
  return {{factor * glm::dot(s.normal, v), glm::dot(s.tangent[0], v), glm::dot(s.tangent[1], v),
           glm::dot(s.normal, k.a.angular_velocity - k.b.angular_velocity)},
          s.status};
}

/// d/dt of the rates along the motion; a step turns and displaces by those of the scheme.
RowRates rates_of_rates(const Contact& k, const DifferenceScheme& scheme, Jacobians form) {
  const Real size = smaller_size(k.c);
  const Real speed = glm::length(k.a.velocity - k.b.velocity) / size +
                     glm::length(k.a.angular_velocity) + glm::length(k.b.angular_velocity);
  RowRates out;
  if (!(speed > 0)) return out;
  const Real step = scheme.step / speed;
  const auto difference = [&](Real h, Real weight) {
    const RowRates ahead = rates_after(k, h, form), back = rates_after(k, -h, form);
    for (int r = 0; r < 4; ++r) out.rate[r] += weight * (ahead.rate[r] - back.rate[r]) / (2 * h);
    for (const RowRates& side : {ahead, back})
      if (side.status != ContactStatus::found) out.status = side.status;
  };
  if (scheme.extrapolated)
    difference(step, 4.0 / 3), difference(2 * step, -1.0 / 3);
  else
    difference(step, 1);
  return out;
}

/// How a point fixed in a body moves with the coordinate: 0 to 2 along an axis, 3 to 5 about it.
Vec3 material_slope(std::size_t coordinate, Vec3 arm) {
  Vec3 unit(0);
  unit[static_cast<int>(coordinate % 3)] = 1;
  return coordinate < 3 ? unit : glm::cross(unit, arm);
}

/// Rows of the rolling block that are tangents; another is spin.
std::size_t tangents_of(const SurfaceContact& c, const Block& roll) {
  return std::min<std::size_t>(roll.rows, c.on_b.curve ? 1 : 2);
}

void write_jacobian(Island& m, std::size_t block, const Contact& k, const ContactSlopes& slopes) {
  const Block& b = m.blocks[block];
  const SurfaceFound& found = m.scratch.touching[b.first_place];
  Vec3* gap = &m.scratch.jacobian[b.first_vector];
  for (std::size_t i = 0; i < 12; ++i)
    gap[i / 3][static_cast<int>(i % 3)] = glm::dot(found.normal, slopes.on_a[i] - slopes.on_b[i]);
  if (!has_rolling(m, block) || !is_active(m, block + 1)) return;
  const Block& roll = m.blocks[block + 1];
  for (std::size_t r = 0; r < tangents_of(k.c, roll); ++r) {
    Vec3* j = &m.scratch.jacobian[roll.first_vector + 4 * r];
    for (std::size_t i = 0; i < 12; ++i) {
      Vec3 slide = slopes.on_a[i] - slopes.on_b[i];
      slide -= i < 6 ? material_slope(i, found.arm[0]) : -material_slope(i - 6, found.arm[1]);
      j[i / 3][static_cast<int>(i % 3)] = -glm::dot(found.tangent[r], slide);
    }
  }
}

void write_gammas(Island& m, std::size_t block, const Contact& k, const RowRates& change) {
  m.scratch.gamma[m.blocks[block].first_row] = -change.rate[0];
  if (!has_rolling(m, block) || !is_active(m, block + 1)) return;
  const Block& roll = m.blocks[block + 1];
  const std::size_t tangents = tangents_of(k.c, roll);
  Real* gamma = &m.scratch.gamma[roll.first_row];
  for (std::size_t r = 0; r < tangents; ++r) gamma[r] = -change.rate[1 + r];
  if (roll.rows > tangents) gamma[tangents] = -change.rate[3];
}

/// C_p instead of the gap.
void square(Island& m, const Block& b) {
  Real& c = m.scratch.c[b.first_row];
  const Real factor = 2 * std::abs(c);
  c *= std::abs(c);
  const bool binds = factor >= kNoRow;
  Vec3* j = &m.scratch.jacobian[b.first_vector];
  for (int i = 0; i < 4; ++i) j[i] *= binds ? factor : 0;
  if (!binds) m.scratch.gamma[b.first_row] = 0;
}

}  // namespace

ContactSlopes contact_slopes(const World& world, const Island& m, std::size_t block,
                             const DifferenceScheme& scheme) {
  const Contact k = contact_of(world, m, block);
  ContactSlopes out;
  for (std::size_t i = 0; i < 12; ++i) {
    const Real unit = i / 3 % 2 == 0 ? scheme.step * smaller_size(k.c) : scheme.step;
    const auto difference = [&](Real h, Real weight) {
      const Sample ahead = sample_beside(k, i, h), back = sample_beside(k, i, -h);
      for (const Sample& side : {ahead, back})
        if (side.status != ContactStatus::found) out.status = side.status;
      out.on_a[i] += weight / (2 * h) * (ahead.on_a - back.on_a);
      out.on_b[i] += weight / (2 * h) * (ahead.on_b - back.on_b);
    };
    if (scheme.extrapolated)
      difference(unit, 4.0 / 3), difference(2 * unit, -1.0 / 3);
    else
      difference(unit, 1);
  }
  return out;
}

void write_differences(const World& world, Island& m, std::size_t block, Want want) {
  const Block& b = m.blocks[block];
  const Contact k = contact_of(world, m, block);
  const bool has_force = !b.lock || (has_rolling(m, block) && may_slip(m.blocks[block + 1]));
  const Jacobians form = has_force ? Jacobians::differences : m.settings.jacobians;
  const ContactSlopes slopes = contact_slopes(world, m, block, {});
  const RowRates change = want.gamma ? rates_of_rates(k, {}, form) : RowRates{};
  for (const ContactStatus status : {slopes.status, change.status})
    if (status != ContactStatus::found && m.scratch.lost_touch == UINT32_MAX)
      m.scratch.lost_touch = b.first_place, m.scratch.lost_how = status;
  if (slopes.status != ContactStatus::found || change.status != ContactStatus::found) return;
  write_jacobian(m, block, k, slopes);
  if (want.gamma) write_gammas(m, block, k, change);
  if (form == Jacobians::squared_distance) square(m, b);
}

}  // namespace pantin::detail::lagrangian
