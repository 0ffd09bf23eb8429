#pragma once
/// Tracked pairs of surface joints: shared by their files.
#include <algorithm>
#include <cmath>

#include "engine/solvers/lagrangian/internal.hpp"
#include "engine/world/surface_start.hpp"

namespace pantin::detail::lagrangian {

/// Relative rotation (rad), and displacement as a fraction of the smaller surface, after which all
/// pairs are searched again.
constexpr Real kSearchTurn = 0.3, kSearchWay = 0.05;
/// Pairs that one search compares.
constexpr std::size_t kMostPairs = 16;
/// Largest initial overlap, as a fraction of the smaller surface. A pair that is deeper, and deeper
/// than the motion since the last search, is one of far sides.
constexpr Real kDeepest = 0.05;
/// Pairs nearer than this fraction of the smaller surface are the same.
constexpr Real kAlike = 1e-5;

inline Real size_of(const ContactSurface& s) { return s.curve ? s.curve->size() : s.skin->size(); }
inline Real smaller_size(const SurfaceContact& c) {
  return std::min(size_of(c.on_a), size_of(c.on_b));
}

/// How far a's surface extends from the origin of its frame, m.
inline Real extent_of(const ContactSurface& surface) {
  Real most = 0;
  const auto take = [&](const nurbs::BallTree& tree) {
    const nurbs::Ball& ball = tree.nodes().front().ball;
    most = std::max(most, glm::length(ball.centre) + ball.radius);
  };
  if (surface.curve) take(surface.curve->tree());
  if (surface.skin)
    for (const nurbs::Face& face : surface.skin->faces()) take(face.tree());
  return most;
}

/// Motion of a as seen from b.
struct Moved {
  Real turn = 0, way = 0;  // rad, m

  /// Upper bound of the displacement of a's points, m.
  Real most(const SurfaceContact& c) const { return way + turn * extent_of(c.on_a); }
};
inline Moved moved(const Pose& from, const Pose& to) {
  const Real cosine = std::min(std::abs(glm::dot(to.rotation, from.rotation)), Real(1));
  return {2 * std::acos(cosine), glm::distance(to.position, from.position)};
}
/// Whether all pairs have to be searched again.
inline bool is_far(const Moved& since, const SurfaceContact& c) {
  return since.turn > kSearchTurn || since.way > kSearchWay * smaller_size(c);
}

/// The tracked pairs of one contact: consecutive slots of an island.
struct Spots {
  const World& world;
  Island& m;
  std::size_t first, count;

  const SurfaceContact& contact() const {
    return world.surface_contacts.values()[m.touch_sources[first]];
  }
  SurfaceMemory& memory(std::size_t n) const { return m.touches[first + n]; }
  std::uint32_t block(std::size_t n) const { return m.touch_blocks[first + n]; }
  bool bears(std::size_t n) const { return m.memory[block(n)].active && memory(n).known; }
  bool is_open(std::size_t n) const { return !memory(n).known && !memory(n).is_over(); }
};

template <class Do>
void for_each_contact(const World& world, Island& m, const Do& act) {
  for (std::size_t first = 0; first < m.touch_sources.size();) {
    std::size_t end = first + 1;
    while (end < m.touch_sources.size() && m.touch_sources[end] == m.touch_sources[first]) ++end;
    act(Spots{world, m, first, end - first});
    first = end;
  }
}

inline Vec3 point_on(const ContactSurface& s, const nurbs::Place& at) {
  if (s.curve) return nurbs::evaluate(s.curve->curve(), at.u, 0)[0];
  return s.skin->face(at.face).at(at.u, at.v).s;
}
inline bool are_alike(const SurfaceContact& c, const nurbs::PlacePair& x,
                      const nurbs::PlacePair& y) {
  const auto near = [&](const ContactSurface& s, const nurbs::Place& p, const nurbs::Place& q) {
    return glm::distance(point_on(s, p), point_on(s, q)) <= kAlike * smaller_size(c);
  };
  return near(c.on_a, x.a, y.a) && near(c.on_b, x.b, y.b);
}

/// Whether a pair may be a contact no deeper than `most`, rather than one of far sides.
inline bool may_have_met(const nurbs::CommonNormal& pair, Real most) {
  return pair.gap >= -most && 2 * pair.gap * pair.least_curvature >= -1;
}

/// Two convex surfaces have one pair.
inline bool is_convex(const SurfaceContact& c) {
  return c.on_a.skin && c.on_b.skin && c.on_a.skin->is_convex() && c.on_b.skin->is_convex();
}
/// Whether a tracked pair is no longer a minimum of the gap, or is lost.
inline bool has_ended(const Spots& s, std::size_t n) {
  const nurbs::CommonNormal& pair = s.m.scratch.touching[s.first + n].pair;
  return s.memory(n).known &&
         !(pair.status == nurbs::ContactStatus::found && pair.least_curvature > 0);
}
/// Whether the contact that ended an attempt is one to be released where it does.
bool may_release(const World& world, const Island& m);
/// Releases a contact at the present state.
void release(const World& world, Island& m, std::uint32_t touch, nurbs::ContactStatus how);
/// Pose of a in b in the present state of the solver.
Pose a_in_b_now(const Spots& s);
/// Pose of a body or frame in the present state of the solver. Euler's step moves frames by their
/// rotation matrix, so that of a moving frame is read from it (surfaces.cpp).
Pose pose_of(const Island& m, std::uint32_t body);
/// A tangent of b and its rate as seen from b, for the normal n and its rate: across the normal,
/// towards an axis of b; for planar curves, within their plane.
struct Tangent {
  Vec3 t{0}, rate{0};
};
Tangent tangent_of(const SurfaceContact& c, Vec3 n, Vec3 n_rate);
/// Whether the block after that of a gap is its rolling.
inline bool has_rolling(const Island& m, std::size_t block) {
  return block + 1 < m.blocks.size() && m.blocks[block + 1].kind == BlockKind::roll;
}

}  // namespace pantin::detail::lagrangian
