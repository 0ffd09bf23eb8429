// Surface joints: their contact points, and the rows of gap, rolling and spin. [Nelson & Cohen]
//
//   gap      J = [ n, r_a x n, -n, -(r_b x n) ]     gamma = -(n'.v + n.b)
//   rolling  J = [ t, r_a x t, -t, -(r_b x t) ]     gamma = -(t'.v + t.b)    two tangents t
//   spin     J = [ 0, n, 0, -n ]                    gamma = -n'.w
//
// with n the outward normal of b, r from the mass centres to the points, v and w the relative
// velocities there, b = w_a x r_a' - w_b x r_b'. The gap is stationary in the four parameters, so
// its row needs no parameter rates; gamma does.
//
// Planar curves that are held to roll have rolled equal arc lengths on both, so this row constrains
// poses. Gears on fixed axes need it: at the vertices of elliptical gears the gap is stationary in
// the rotation, so the gap row alone would not hold them.
#include <algorithm>

#include "engine/nurbs/curve_pair.hpp"
#include "engine/solvers/lagrangian/surface_differences.hpp"
#include "engine/solvers/lagrangian/surface_spots.hpp"

namespace pantin::detail::lagrangian {

Pose pose_of(const Island& m, std::uint32_t body) {
  const BodyState& at = m.scratch.body_states[body];
  const bool has_rotation = body < m.count() || at.angular_velocity == Vec3(0);
  return {at.position,
          has_rotation ? at.rotation : glm::normalize(glm::quat_cast(at.rotation_matrix))};
}

Tangent tangent_of(const SurfaceContact& c, Vec3 n, Vec3 n_rate) {
  if (c.on_b.curve) return {{-n.y, n.x, 0}, {-n_rate.y, n_rate.x, 0}};
  Vec3 e(0);
  const Vec3 size = glm::abs(n);
  e[size.x <= size.y && size.x <= size.z ? 0 : size.y <= size.z ? 1 : 2] = 1;
  const Vec3 p = e - glm::dot(n, e) * n;
  const Vec3 rate = -(glm::dot(n, e) * n_rate + glm::dot(n_rate, e) * n);
  const Real inverse = 1 / glm::length(p);
  const Vec3 t = inverse * p;
  return {t, inverse * (rate - glm::dot(t, rate) * t)};
}

namespace {

using nurbs::ContactStatus;

/// Gap of surfaces that are not near one another, m.
constexpr Real kGapWhereApart = 1e3;

using Pair = nurbs::CommonNormal;

nurbs::Moving moving_pair(const SurfaceContact& c, const nurbs::CurveMotion& of) {
  if (!c.on_a.curve) return nurbs::moving({*c.on_a.skin, *c.on_b.skin, of.a_in_b}, of.at, of.twist);
  return c.on_b.curve ? nurbs::moving_planar(*c.on_a.curve, *c.on_b.curve, of)
                      : nurbs::moving_on_face(*c.on_a.curve, *c.on_b.skin, of);
}

/// Extrapolates the parameters by their rates, clamped to the domain.
nurbs::PlacePair predicted(const SurfaceContact& c, const SurfaceCoordinates& t, Real time) {
  nurbs::PlacePair to = t.at;
  const auto go = [&](const ContactSurface& s, nurbs::Place& place, const Real* rate) {
    if (s.curve) {
      place.u = s.curve->knots().inside(place.u + time * rate[0]);
      return;
    }
    const nurbs::Face& face = s.skin->face(place.face);
    place.u = face.u().inside(place.u + time * rate[0]);
    place.v = face.v().inside(place.v + time * rate[1]);
  };
  go(c.on_a, to.a, &t.rates[0]), go(c.on_b, to.b, &t.rates[2]);
  return to;
}

/// A contact at the current state.
struct Contact3 {
  const SurfaceContact& c;
  const BodyState &a, &b;
  Pose surface_a, surface_b, a_in_b;  // world, world, in b's
};
Contact3 contact_at(const World& world, const Island& m, const Block& block) {
  PANTIN_ASSERT(block.kind == BlockKind::surface && block.count == 2);
  const SurfaceContact& c = world.surface_contacts.values()[block.source];
  const Pose a = compose(pose_of(m, block.body[0]), c.on_a.pose);
  const Pose b = compose(pose_of(m, block.body[1]), c.on_b.pose);
  return {c,
          m.scratch.body_states[block.body[0]],
          m.scratch.body_states[block.body[1]],
          a,
          b,
          compose(inverse(b), a)};
}

/// The motion of a's surface as seen from b's.
nurbs::Twist twist_of(const Contact3& k) {
  const auto velocity = [](const BodyState& at, Vec3 point) {
    return at.velocity + glm::cross(at.angular_velocity, point - at.position);
  };
  const Quat back = glm::conjugate(k.surface_b.rotation);
  const Vec3 origin = k.surface_a.position;
  return {back * (velocity(k.a, origin) - velocity(k.b, origin)),
          back * (k.a.angular_velocity - k.b.angular_velocity)};
}

void write_row(const Vec3 (&arm)[2], Vec3 along, Vec3* j) {
  j[0] = along, j[1] = glm::cross(arm[0], along);
  j[2] = -along, j[3] = -glm::cross(arm[1], along);
}

void clear_rows(Island& m, const Block& b) {
  Vec3* j = &m.scratch.jacobian[b.first_vector];
  std::fill(j, j + vectors_of(b), Vec3(0));
  std::fill_n(&m.scratch.gamma[b.first_row], b.rows, 0.0);
  std::fill_n(&m.scratch.c[b.first_row], b.rows, 0.0);
}

/// The rolling block that follows a gap block, or null.
const Block* roll_of(const Island& m, std::size_t block) {
  return has_rolling(m, block) ? &m.blocks[block + 1] : nullptr;
}

/// Tracks the pair to the current poses and stores its parameters. False: the pair is lost.
bool follow(Island& m, const Contact3& k, std::size_t block, Pair& now) {
  const Block& b = m.blocks[block];
  StepScratch& scratch = m.scratch;
  PANTIN_ASSERT(b.first_place < scratch.state.touches.size() &&
                b.first_place < scratch.touching.size());
  SurfaceCoordinates& touch = scratch.state.touches[b.first_place];
  SurfaceFound& found = scratch.touching[b.first_place];
  if (!(found.is_fresh && found.a_in_b.position == k.a_in_b.position &&
        found.a_in_b.rotation == k.a_in_b.rotation)) {
    now = track_pair(k.c, k.a_in_b, predicted(k.c, touch, scratch.time - touch.time));
    if (now.status != ContactStatus::found && now.status != ContactStatus::degenerate)
      now = track_pair(k.c, k.a_in_b, touch.at);
    found.pair = now, found.a_in_b = k.a_in_b, found.is_fresh = true;
  } else {
    now = found.pair;
  }
  if (now.status == ContactStatus::found) {
    if (const SurfaceWays& ways = m.touch_ways[b.first_place]; ways.a)
      touch.slip += ways.a->way(touch.at.a.u, now.at.a.u) + ways.b->way(touch.at.b.u, now.at.b.u);
    touch.at = now.at, touch.time = scratch.time;
    return true;
  }
  if (!is_active(m, block)) return false;
  if (scratch.lost_touch == UINT32_MAX)
    scratch.lost_touch = b.first_place, scratch.lost_how = now.status;
  return false;
}

/// How the normal turns as seen from either body.
void note_turning(const Contact3& k, const nurbs::Moving& moving, SurfaceFound& found) {
  const Vec3 turns = moving.normal - glm::cross(twist_of(k).angular, found.pair.normal);
  found.normal_rate[0] = glm::conjugate(k.a_in_b.rotation) * turns;
  found.normal_rate[1] = moving.normal;
  found.knows_rate = true;
}

/// gamma of the rows, and the parameter rates.
void write_gammas(Island& m, const Contact3& k, std::size_t block, const Pair& now) {
  const Block& b = m.blocks[block];
  const Block* roll = roll_of(m, block);
  StepScratch& scratch = m.scratch;
  SurfaceCoordinates& touch = scratch.state.touches[b.first_place];
  const nurbs::Moving moving = moving_pair(k.c, {k.a_in_b, touch.at, twist_of(k)});
  touch.rates = moving.rates;
  note_turning(k, moving, scratch.touching[b.first_place]);
  const Quat turn = k.surface_b.rotation;
  const Vec3 n = turn * now.normal, wa = k.a.angular_velocity, wb = k.b.angular_velocity;
  const Vec3 arm_a = to_world(k.surface_b, now.on_a) - k.a.position;
  const Vec3 arm_b = to_world(k.surface_b, now.on_b) - k.b.position;
  const Vec3 n_rate = glm::cross(wb, n) + turn * moving.normal;
  const Vec3 v = k.a.velocity + glm::cross(wa, arm_a) - k.b.velocity - glm::cross(wb, arm_b);
  const Vec3 bend = glm::cross(wa, glm::cross(wa, arm_a) + turn * moving.on_a) -
                    glm::cross(wb, glm::cross(wb, arm_b) + turn * moving.on_b);
  scratch.gamma[b.first_row] = -(glm::dot(n_rate, v) + glm::dot(n, bend));
  if (!roll || !is_active(m, block + 1)) return;
  const Tangent own = tangent_of(k.c, now.normal, moving.normal);
  const Vec3 t[2] = {turn * own.t, turn * glm::cross(now.normal, own.t)};
  const Vec3 rate[2] = {turn * own.rate, turn * (glm::cross(moving.normal, own.t) +
                                                 glm::cross(now.normal, own.rate))};
  Real* gamma = &scratch.gamma[roll->first_row];
  const std::size_t tangents = std::min<std::size_t>(roll->rows, k.c.on_b.curve ? 1 : 2);
  for (std::size_t i = 0; i < tangents; ++i)
    gamma[i] = -(glm::dot(glm::cross(wb, t[i]) + rate[i], v) + glm::dot(t[i], bend));
  if (roll->rows > tangents) gamma[tangents] = -glm::dot(n_rate, wa - wb);
}

void write_rolling(Island& m, const Contact3& k, const Block& roll, const Pair& now) {
  StepScratch& scratch = m.scratch;
  SurfaceFound& found = scratch.touching[roll.first_place];
  const Quat turn = k.surface_b.rotation;
  const Vec3 arms[2] = {to_world(k.surface_b, now.on_a) - k.a.position, found.on_b - k.b.position};
  const Tangent own = tangent_of(k.c, now.normal, Vec3(0));
  found.tangent[0] = turn * own.t, found.tangent[1] = glm::cross(found.normal, found.tangent[0]);
  Vec3* j = &scratch.jacobian[roll.first_vector];
  std::fill_n(&scratch.c[roll.first_row], roll.rows, 0.0);
  if (roll.holonomic) scratch.c[roll.first_row] = scratch.state.touches[roll.first_place].slip;
  const std::size_t tangents = std::min<std::size_t>(roll.rows, k.c.on_b.curve ? 1 : 2);
  for (std::size_t i = 0; i < tangents; ++i) write_row(arms, found.tangent[i], j + 4 * i);
  if (roll.rows == tangents) return;
  j += 4 * tangents;
  j[0] = Vec3(0), j[1] = found.normal, j[2] = Vec3(0), j[3] = -found.normal;
}

}  // namespace

nurbs::CommonNormal track_pair(const SurfaceContact& c, const Pose& a_in_b,
                               const nurbs::PlacePair& from) {
  if (!c.on_a.curve) return nurbs::track({*c.on_a.skin, *c.on_b.skin, a_in_b}, from);
  const nurbs::CurveContact f =
      c.on_b.curve ? nurbs::track_planar(*c.on_a.curve, *c.on_b.curve, a_in_b, {from.a.u, from.b.u})
                   : nurbs::track_on_face(*c.on_a.curve, *c.on_b.skin, a_in_b, {from.a.u, from.b});
  return {f.status, {{0, f.t, 0}, f.b}, f.on_a, f.on_b, f.normal, f.gap, f.least_curvature};
}

void find_turning(const World& world, Island& m, std::size_t block) {
  SurfaceFound& found = m.scratch.touching[m.blocks[block].first_place];
  if (found.knows_rate) return;
  const Contact3 k = contact_at(world, m, m.blocks[block]);
  note_turning(k, moving_pair(k.c, {k.a_in_b, found.pair.at, twist_of(k)}), found);
}

void clear_rolling(Island& m) {
  for (const Block& b : m.blocks)
    if (binds_no_poses(b)) clear_rows(m, b);
}

void write_surface(const World& world, Island& m, std::size_t block, Want want) {
  const Block& b = m.blocks[block];
  const Block* roll = roll_of(m, block);
  StepScratch& scratch = m.scratch;
  SurfaceFound& found = scratch.touching[b.first_place];
  const SurfaceMemory& memory = m.touches[b.first_place];
  const auto bind_nothing = [&](Real gap) {
    clear_rows(m, b);
    if (roll) clear_rows(m, *roll);
    scratch.c[b.first_row] = gap;
  };
  if (memory.is_over() || !memory.known) return bind_nothing(kGapWhereApart);
  const Contact3 k = contact_at(world, m, b);
  Pair now;
  // The gap of an inactive pair that is no longer tracked keeps its last value.
  const bool near = follow(m, k, block, now);
  if (near) {
    found.on_b = to_world(k.surface_b, now.on_b), found.normal = k.surface_b.rotation * now.normal;
    found.gap = now.gap;
  }
  const Real gap = near || b.lock ? found.gap : std::max(found.gap, Real(1e-6));
  if (!near || !is_active(m, block)) return bind_nothing(gap);
  scratch.c[b.first_row] = gap;
  const Vec3 arms[2] = {to_world(k.surface_b, now.on_a) - k.a.position, found.on_b - k.b.position};
  write_row(arms, found.normal, &scratch.jacobian[b.first_vector]);
  const bool rolls = roll && is_active(m, block + 1);
  if (roll && (rolls || !roll->lock)) write_rolling(m, k, *roll, now);
  found.arm[0] = arms[0], found.arm[1] = arms[1];
  if (roll && !rolls) clear_rows(m, *roll);
  scratch.gamma[b.first_row] = 0;
  if (roll) std::fill_n(&scratch.gamma[roll->first_row], roll->rows, 0.0);
  if (want.gamma) write_gammas(m, k, block, now);
  if (m.settings.jacobians != Jacobians::analytic) write_differences(world, m, block, want);
  if (scratch.leaves_gaps && found.gap_follows) {
    clear_rows(m, b);
    scratch.c[b.first_row] = gap;
  }
}

}  // namespace pantin::detail::lagrangian
