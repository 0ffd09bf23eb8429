// G = dC/dp: the rows of a part by its design variables.
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/assembly/problem.hpp"
#include "engine/joints/cable_path.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/nurbs/net.hpp"
#include "engine/world/belt.hpp"
#include "engine/world/cable_route.hpp"

namespace pantin::detail::assembly {

using lagrangian::Block;
using lagrangian::BlockKind;
using lagrangian::Island;
using lagrangian::RowVectors;

namespace {

/// G of a block for one design variable.
struct Slopes {
  const World& world;
  const Island& m;
  const FreeQuantity& q;
  std::span<const Real> numbers;  // of the variable
  std::span<Real> to;             // by number, then by row of the part

  Real& at(std::size_t number, std::size_t row) const { return to[number * m.rows + row]; }
  void write(std::size_t block) const;
  void write_anchor(const Block& b, std::size_t end) const;
  void write_axis(const Block& b, std::size_t end) const;
  void write_cable(const Block& b) const;
  void write_pitch(std::size_t block) const;
  void write_ratio(std::size_t block) const;
  void write_belt(std::size_t block) const;
  void write_surface(const Block& b) const;
};

/// The residual depends on the anchor only by the point R anchor of the body, as on a displacement.
void Slopes::write_anchor(const Block& b, std::size_t end) const {
  const Mat3 turned = m.scratch.body_states[b.body[end]].rotation_matrix;
  for (std::size_t r = 0; r < b.rows; ++r) {
    const Vec3 v = row_of(b, jacobian_of(m, b), r, end).v * turned;
    for (int i = 0; i < 3; ++i) at(static_cast<std::size_t>(i), b.first_row + r) = v[i];
  }
}

/// And on the axes as on a rotation of the body about the anchor. The rotation vector (0, p) of the
/// axes has the rate J_r(0, p) (0, p') in these axes, J_r: the right Jacobian of SO(3).
void Slopes::write_axis(const Block& b, std::size_t end) const {
  const BodyState& body = m.scratch.body_states[b.body[end]];
  const Joint& joint = world.links[q.of.law].joint;
  const Vec3 arm = body.rotation_matrix * (end == 0 ? joint.anchor_a : joint.anchor_b);
  const Mat3 axes =
      body.rotation_matrix * glm::mat3_cast(end == 0 ? joint.frames.a() : joint.frames.b());
  const Vec3 turn(0, numbers[0], numbers[1]);
  const Real angle2 = glm::dot(turn, turn), angle = std::sqrt(angle2);
  const bool is_small = angle2 < 1e-6;
  const Real p = is_small ? 0.5 - angle2 / 24 : (1 - std::cos(angle)) / angle2;
  const Real s =
      is_small ? Real(1) / 6 - angle2 / 120 : (angle - std::sin(angle)) / (angle2 * angle);
  for (std::size_t i = 0; i < 2; ++i) {
    Vec3 unit(0);
    unit[static_cast<int>(i) + 1] = 1;
    const Vec3 across = glm::cross(turn, unit);
    const Vec3 rate = axes * (unit - p * across + s * glm::cross(turn, across));
    for (std::size_t r = 0; r < b.rows; ++r) {
      const RowVectors row = row_of(b, jacobian_of(m, b), r, end);
      at(i, b.first_row + r) = glm::dot(row.w - glm::cross(arm, row.v), rate);
    }
  }
}

/// C = length - L(path). L has the derivative R^T dL/dcentre by an anchor, and the angle of wrap by
/// a radius: the path is the shortest, so that its ends on the pulley do not count.
void Slopes::write_cable(const Block& b) const {
  const Cable& cable = world.cables[q.of.law];
  Pose poses[kMostPathPoints];
  std::size_t placed = 0;
  const auto pose_of = [&](Entity body) -> const Pose* {
    const auto mine = std::find(m.bodies.begin(), m.bodies.end(), body);
    if (mine == m.bodies.end()) return &world.bodies[body].pose;
    const auto i = static_cast<std::size_t>(mine - m.bodies.begin());
    Pose& pose = poses[placed++ % kMostPathPoints];
    return &(pose = {m.scratch.state.x[i], m.scratch.state.q[i]});
  };
  const std::vector<PathPoint> route = route_of(cable, pose_of);
  if (q.of.quantity == Quantity::radius) {
    Real wraps[kMostPathPoints];
    follow_path(route, 0, wraps);
    at(0, b.first_row) = -std::max(Real(0), wraps[q.of.guide + 1]);
    return;
  }
  PathGradient gradients[kMostPathPoints];
  path_length(route, gradients);
  const bool first = q.of.quantity == Quantity::anchor_a;
  const Pose end = *pose_of(first ? cable.a : cable.b);
  const Vec3 slope =
      glm::conjugate(end.rotation) * gradients[first ? 0 : route.size() - 1].by_centre;
  for (int i = 0; i < 3; ++i) at(static_cast<std::size_t>(i), b.first_row) = -slope[i];
}

/// Rows are linear in the pitch.
void Slopes::write_pitch(std::size_t block) const {
  const Block& b = m.blocks[block];
  const auto rows_at = [&](Real pitch) {
    Joint joint = world.links[q.of.law].joint;
    joint.parameters.edit().pitch = pitch;
    std::array<Real, 6> c{};
    write_rows({joint, m.scratch.body_states[b.body[0]], m.scratch.body_states[b.body[1]],
                m.memory[block].before[0]},
               {c.data(), nullptr, nullptr});
    return c;
  };
  const std::array<Real, 6> one = rows_at(1), none = rows_at(0);
  for (std::size_t r = 0; r < b.rows; ++r) at(0, b.first_row + r) = one[r] - none[r];
}

/// C = q_2 - ratio q_1 - offset
void Slopes::write_ratio(std::size_t block) const {
  const Block& b = m.blocks[block];
  const Gear& gear = world.gears.values()[b.source];
  Real value = 0;
  write_coordinate({world.links[gear.first].joint, m.scratch.body_states[b.body[b.ends[0]]],
                    m.scratch.body_states[b.body[b.ends[1]]], m.memory[block].before[0]},
                   b.coordinate, {&value, nullptr, nullptr});
  at(0, b.first_row) = -value;
}

/// C = L + s R (psi - angle) - s' R' (psi' - angle') - C_0 of a span: L and the direction psi of
/// the span's normal follow the common tangent, so that their changes cancel, and dC/dR = s (psi -
/// angle). C_0 is the same where the belt was laid.
void Slopes::write_belt(std::size_t block) const {
  const Block& b = m.blocks[block];
  const Belt& belt = world.belts.values()[b.source];
  const std::size_t count = belt.pulleys.size();
  const auto slope = [&](const Belt& of, std::span<const Pose> bodies, const Real* angles) {
    const std::size_t i = b.first_place, k = (i + 1) % count;
    BeltPlace places[2] = {place_of(of.pulleys[i], bodies[0]), place_of(of.pulleys[k], bodies[1])};
    for (int end = 0; end < 2 && angles; ++end)
      places[end].angle = angles[end] + std::remainder(places[end].angle - angles[end], 2 * kPi);
    const BeltSpan span = span_between(places[0], places[1], of.pulleys[i].direction);
    if (!span.is_found) return Real(0);
    Real sum = 0;
    for (int end = 0; end < 2; ++end) {
      const Real sense = places[end].sense;
      if ((end == 0 ? i : k) == q.of.guide)
        sum += (end == 0 ? sense : -sense) * (span.angle - sense * kPi / 2 - places[end].angle);
    }
    return sum;
  };
  Pose now[2];
  for (int end = 0; end < 2; ++end) {
    const BodyState& body = m.scratch.body_states[b.body[end]];
    now[end] = {body.position, glm::normalize(glm::quat_cast(body.rotation_matrix))};
  }
  at(0, b.first_row) = slope(belt, now, m.memory[block].before);
  const LaidBelt* laid = laid_of(world, q.of.law);
  if (!laid) return;
  Belt before = belt;
  const Pose were[2] = {laid->bodies[b.first_place], laid->bodies[(b.first_place + 1) % count]};
  if (lay_belt(before, laid->bodies)) at(0, b.first_row) -= slope(before, were, nullptr);
}

/// The gap is stationary in the parameters of its points, so that only the displacement of the
/// point on the surface counts, along the normal of b: dC = n (dS_a - dS_b), dS = R_ij dP_ij and
/// R_ij (P - S) / w dw.
void Slopes::write_surface(const Block& b) const {
  const SurfaceContact& c = world.surface_contacts.values()[b.source];
  const lagrangian::SurfaceFound& found = m.scratch.touching[b.first_place];
  if (!m.touches[b.first_place].known) return;
  const ContactSurface& net = surface_of(world, q.of);
  for (int side = 0; side < 2; ++side) {
    const ContactSurface& on = side == 0 ? c.on_a : c.on_b;
    if (!is_same_net(on, net)) continue;
    const nurbs::Place& place = side == 0 ? found.pair.at.a : found.pair.at.b;
    if (on.skin && place.face != static_cast<int>(q.of.face)) continue;
    const Mat3 turned =
        m.scratch.body_states[b.body[side]].rotation_matrix * glm::mat3_cast(on.pose.rotation);
    const Vec3 normal = (side == 0 ? Real(1) : Real(-1)) * (found.normal * turned);
    const auto add = [&](Real share, const nurbs::Weighted& point, Vec3 at_place) {
      if (is_weight(q.of.quantity)) {
        at(0, b.first_row) += share / point.w * glm::dot(normal, point.point() - at_place);
        return;
      }
      for (int i = 0; i < 3; ++i) at(static_cast<std::size_t>(i), b.first_row) += share * normal[i];
    };
    if (on.curve) {
      const nurbs::Curve& curve = on.curve->curve();
      add(nurbs::share_of(curve, nurbs::images_of(curve, q.of.guide), place.u),
          curve.points[q.of.guide], nurbs::evaluate(curve, place.u, 0)[0]);
      continue;
    }
    const nurbs::Surface& face = on.skin->face(place.face).surface();
    add(nurbs::share_of(face, nurbs::images_of(face, q.of.guide), {place.u, place.v}),
        face.points[q.of.guide], nurbs::evaluate(face, place.u, place.v, 0)[0][0]);
  }
}

void Slopes::write(std::size_t block) const {
  const Block& b = m.blocks[block];
  const Quantity kind = q.of.quantity;
  if (b.kind == BlockKind::gear) return write_ratio(block);
  if (b.kind == BlockKind::belt) return write_belt(block);
  if (b.kind == BlockKind::surface) return write_surface(b);
  if (kind == Quantity::length && b.kind == BlockKind::cable) {
    at(0, b.first_row) = 1;
  } else if (kind == Quantity::length) {
    // C = (d.d - L L) / (2 L)
    const Real length = world.links[q.of.law].joint.parameters->length;
    if (b.kind == BlockKind::joint) at(0, b.first_row) = -1 - m.scratch.c[b.first_row] / length;
  } else if (kind == Quantity::pitch) {
    if (b.kind == BlockKind::joint) write_pitch(block);
  } else if (b.kind == BlockKind::cable) {
    write_cable(b);
  } else if (kind == Quantity::anchor_a || kind == Quantity::anchor_b) {
    write_anchor(b, kind == Quantity::anchor_b);
  } else {
    write_axis(b, kind == Quantity::axis_b);
  }
}

}  // namespace

bool is_of(const Block& b, const DesignVariable& v, const World& world) {
  switch (b.kind) {
    case BlockKind::joint:
    case BlockKind::limit:
      return world.links.owners()[b.source] == v.law;
    case BlockKind::cable:
      return world.cables.owners()[b.source] == v.law;
    case BlockKind::gear:
      return world.gears.owners()[b.source] == v.law;
    case BlockKind::belt:
      return world.belts.owners()[b.source] == v.law;
    case BlockKind::surface: {
      if (!world.surface_contacts.find(v.law)) return false;
      const SurfaceContact& c = world.surface_contacts.values()[b.source];
      const ContactSurface& on = surface_of(world, v);
      return is_same_net(c.on_a, on) || is_same_net(c.on_b, on);
    }
    default:  // without design variables
      return false;
  }
}

namespace {

/// How far the radius of a pulley may grow until the pulley overlaps another one of its belt, m:
/// where the bodies are, and where the belt was laid. Two free radii share the gap.
Real room_of_pulley(const World& world, const Part& part, const DesignVariable& of) {
  const Belt& belt = world.belts[of.law];
  const LaidBelt* laid = laid_of(world, of.law);
  const auto now = [&](std::size_t i) {
    const auto& bodies = part.m.bodies;
    const auto mine = std::find(bodies.begin(), bodies.end(), belt.pulleys[i].body);
    if (mine == bodies.end()) return world.bodies[belt.pulleys[i].body].pose;
    const auto b = static_cast<std::size_t>(mine - bodies.begin());
    return Pose{part.m.scratch.state.x[b], part.m.scratch.state.q[b]};
  };
  Real room = 1e300;
  const BeltOutline& own = belt.pulleys[of.guide].outline;
  for (std::uint32_t k = 0; k < belt.pulleys.size(); ++k) {
    const BeltOutline& other = belt.pulleys[k].outline;
    if (k == of.guide || !other.corners.empty()) continue;
    const auto gap = [&](const Pose& one, const Pose& two) {
      const Vec3 d =
          place_of(belt.pulleys[of.guide], one).centre - place_of(belt.pulleys[k], two).centre;
      return glm::length(d) - own.radius - other.radius;
    };
    Real least = gap(now(of.guide), now(k));
    if (laid) least = std::min(least, gap(laid->bodies[of.guide], laid->bodies[k]));
    const bool is_shared =
        std::any_of(part.design.all.begin(), part.design.all.end(), [&](const FreeQuantity& q) {
          return q.of.law == of.law && q.of.quantity == Quantity::radius && q.of.guide == k;
        });
    room = std::min(room, least / (is_shared ? 2 : 1));
  }
  return room;
}

}  // namespace

void write_slopes(const World& world, Part& part) {
  Design& d = part.design;
  for (const FreeQuantity& q : d.all)
    if (q.of.quantity == Quantity::radius && world.belts.find(q.of.law))
      d.room[q.first] = room_of_pulley(world, part, q.of);
  std::fill(d.slopes.begin(), d.slopes.end(), Real(0));
  for (const FreeQuantity& q : d.all) {
    const std::size_t count = numbers_of(q.of.quantity), rows = part.m.rows;
    const Slopes slopes{world, part.m, q, std::span(d.numbers).subspan(q.first, count),
                        std::span(d.slopes).subspan(q.first * rows, count * rows)};
    for (std::size_t i = 0; i < part.m.blocks.size(); ++i)
      if (is_of(part.m.blocks[i], q.of, world) && lagrangian::is_active(part.m, i)) slopes.write(i);
  }
}

}  // namespace pantin::detail::assembly
