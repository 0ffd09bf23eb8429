#include "engine/assembly/surfaces.hpp"

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/surface_spots.hpp"

namespace pantin::detail::assembly {

using lagrangian::Island;
using lagrangian::kMostPairs;
using lagrangian::Spots;

namespace {

/// A point of a surface in its frame, and its outward normal; 0 for a curve in space.
struct Spot {
  Vec3 at{0}, normal{0};
};

enum class Curves : std::uint8_t { planar, in_space };

Spot spot_on(const ContactSurface& s, const nurbs::Place& at, Curves curves) {
  if (s.curve) {
    const auto d = nurbs::evaluate(s.curve->curve(), at.u, 1);
    return {d[0], curves == Curves::planar ? glm::normalize(Vec3(d[1].y, -d[1].x, 0)) : Vec3(0)};
  }
  const nurbs::Jet jet = s.skin->face(at.face).at(at.u, at.v);
  return {jet.s, glm::normalize(glm::cross(jet.u, jet.v))};
}

/// The shortest rotation of one unit vector to another.
Quat shortest(Vec3 from, Vec3 to) {
  const Vec3 axis = glm::cross(from, to);
  const Real sine = glm::length(axis), cosine = glm::dot(from, to);
  if (sine > 1e-12) return from_rotation_vector(std::atan2(sine, cosine) / sine * axis);
  if (cosine > 0) return kIdentity;
  const Vec3 across = std::abs(from.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  return from_rotation_vector(kPi * glm::normalize(glm::cross(from, across)));
}

}  // namespace

bool find_pairs_anywhere(const World& world, Part& part) {
  Island& m = part.m;
  bool all = true;
  lagrangian::for_each_contact(world, m, [&](const Spots& s) {
    const SurfaceContact& c = s.contact();
    if (c.lifts || s.memory(0).is_over() || s.memory(0).known) return;
    const Pose at = lagrangian::a_in_b_now(s);
    const Real reach =
        glm::length(at.position) + lagrangian::extent_of(c.on_a) + lagrangian::extent_of(c.on_b);
    nurbs::CommonNormal found[kMostPairs];
    const std::size_t count = find_pairs(c, at, {reach, found});
    all = all && count > 0;
    if (count == 0) return;
    const auto nearest = std::min_element(found, found + count, [](const auto& x, const auto& y) {
      return std::abs(x.gap) < std::abs(y.gap);
    });
    s.memory(0).known = s.memory(0).is_least = true;
    s.memory(0).touch = {nearest->at, {}, world.time, 0};
    m.scratch.state.touches[s.first] = s.memory(0).touch;
    m.scratch.touching[s.first].is_fresh = false;
  });
  return all;
}

int bring_into_contact(const World& world, Part& part, Bring which) {
  Island& m = part.m;
  int moved = 0;
  lagrangian::for_each_contact(world, m, [&](const Spots& s) {
    const SurfaceContact& c = s.contact();
    if (c.lifts || s.memory(0).is_over() || !c.known) return;
    if (s.memory(0).known && which == Bring::lost) return;
    const lagrangian::Block& b = m.blocks[s.block(0)];
    const Curves curves = c.on_a.curve && c.on_b.curve ? Curves::planar : Curves::in_space;
    const auto placed = [&](std::size_t k, const ContactSurface& on, const nurbs::Place& at) {
      const BodyState& body = m.scratch.body_states[b.body[k]];
      const Pose surface = compose({body.position, body.rotation}, on.pose);
      const Spot spot = spot_on(on, at, curves);
      return Spot{to_world(surface, spot.at), surface.rotation * spot.normal};
    };
    const Spot on_a = placed(0, c.on_a, c.at.a), on_b = placed(1, c.on_b, c.at.b);
    const bool moves_a = b.body[0] < m.count();
    const Spot &from = moves_a ? on_a : on_b, &to = moves_a ? on_b : on_a;
    const std::uint32_t body = b.body[moves_a ? 0 : 1];
    const bool opposes = from.normal != Vec3(0) && to.normal != Vec3(0);
    const Quat turn = opposes ? shortest(from.normal, -to.normal) : kIdentity;
    lagrangian::Motions& state = m.scratch.state;
    state.x[body] = to.at + turn * (state.x[body] - from.at);
    state.q[body] = glm::normalize(turn * state.q[body]);
    s.memory(0).known = s.memory(0).is_least = true;
    s.memory(0).touch = {c.at, {}, world.time, 0};
    state.touches[s.first] = s.memory(0).touch;
    m.scratch.touching[s.first].is_fresh = false;
    lagrangian::update_kinematics(m);
    ++moved;
  });
  if (moved > 0) look(world, part), count(world, part);
  return moved;
}

}  // namespace pantin::detail::assembly
