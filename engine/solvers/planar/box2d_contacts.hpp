#pragma once
/// Box2D's contact callbacks: filtering, collision decisions, warm start. Included by
/// box2d_plane.cpp alone.
#include <box2d/box2d.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/solvers/planar/plane.hpp"

namespace pantin::detail::planar {

struct FixtureAt {
  std::uint32_t body, outline;
};
constexpr std::uint64_t packed(FixtureAt at) { return std::uint64_t(at.body) << 32 | at.outline; }
inline FixtureAt unpacked(const b2Fixture& f) {
  const std::uint64_t both = const_cast<b2Fixture&>(f).GetUserData().pointer;
  return {static_cast<std::uint32_t>(both >> 32), static_cast<std::uint32_t>(both)};
}

class Filter final : public b2ContactFilter {
 public:
  explicit Filter(const Plane& plane) : plane_(plane) {}
  bool ShouldCollide(b2Fixture* f, b2Fixture* g) override {
    const FixtureAt at = unpacked(*f), bt = unpacked(*g);
    const PlaneBody &a = plane_.bodies[at.body], &b = plane_.bodies[bt.body];
    if (!may_touch(plane_, at.body, bt.body)) return false;
    const Outline &p = plane_.outlines[a.first + at.outline],
                  &q = plane_.outlines[b.first + bt.outline];
    return p.low < q.high && q.low < p.high;
  }

 private:
  const Plane& plane_;
};

/// Support of a fixture along a direction, units.
inline Real reach_along(const b2Fixture& f, Vec3 way) {
  const b2Transform& at = f.GetBody()->GetTransform();
  const auto along = [&](b2Vec2 p) {
    const b2Vec2 q = b2Mul(at, p);
    return q.x * way.x + q.y * way.y;
  };
  if (f.GetType() == b2Shape::e_circle) {
    const auto& disc = static_cast<const b2CircleShape&>(*f.GetShape());
    return along(disc.m_p) + disc.m_radius;
  }
  const auto& polygon = static_cast<const b2PolygonShape&>(*f.GetShape());
  Real most = -1e300;
  for (int i = 0; i < polygon.m_count; ++i) most = std::max(most, along(polygon.m_vertices[i]));
  return most;
}

/// Whether a one-way surface, solid towards `way`, lets a fixture pass that is in its direction
/// `outwards`.
inline bool is_let_pass(const b2Fixture& surface, Vec3 way, Vec3 outwards, const b2Fixture& other) {
  if (way == Vec3(0)) return false;
  return contact::is_let_pass({glm::dot(outwards, way), -reach_along(other, -way),
                               reach_along(other, way), reach_along(surface, way)});
}

/// The contact of a manifold's point, without its impulses.
inline PlaneContact touch_of(b2Contact& contact, const b2ManifoldPoint& point) {
  const FixtureAt a = unpacked(*contact.GetFixtureA()), b = unpacked(*contact.GetFixtureB());
  PlaneContact t;
  t.a = a.body, t.b = b.body, t.outline_a = a.outline, t.outline_b = b.outline;
  t.feature = point.id.key;
  return t;
}

/// Warm-starts the contacts of the first substep from the last step, sums the impulses, and
/// disables contacts that do not collide.
class ContactListener final : public b2ContactListener {
 public:
  /// `origin` (m): Box2D's origin; `to_box2d`: units per metre.
  ContactListener(const Plane& plane, const std::vector<PlaneContact>& before, Vec3 origin,
                  Real to_box2d)
      : plane_(plane), before_(before), origin_(origin), scale_(to_box2d) {}
  void end() {
    if (std::exchange(on_, false)) std::sort(borne_.begin(), borne_.end(), comes_before);
  }
  /// Impulses of the step, sorted; includes contacts that ended in it.
  const std::vector<PlaneContact>& borne() const { return borne_; }
  void PostSolve(b2Contact* contact, const b2ContactImpulse* impulse) override {
    b2WorldManifold at;
    contact->GetWorldManifold(&at);
    for (int i = 0; i < impulse->count; ++i) {
      PlaneContact& sum = sum_of(touch_of(*contact, contact->GetManifold()->points[i]));
      const b2Vec2 on_b = impulse->normalImpulses[i] * at.normal +
                          impulse->tangentImpulses[i] * b2Cross(at.normal, 1.0f);
      sum.impulse -= Vec3(on_b.x, on_b.y, 0) / scale_;
      sum.point = {at.points[i].x, at.points[i].y, 0};
      sum.normal = {-at.normal.x, -at.normal.y, 0};
    }
  }
  void PreSolve(b2Contact* contact, const b2Manifold* old) override {
    if (plane_.near && !collide(*contact)) return contact->SetEnabled(false);
    if (!on_ || old->pointCount > 0) return;
    b2Manifold& m = *contact->GetManifold();
    for (int i = 0; i < m.pointCount; ++i) {
      const PlaneContact t = touch_of(*contact, m.points[i]);
      const auto at = std::lower_bound(before_.begin(), before_.end(), t, comes_before);
      if (at == before_.end() || comes_before(t, *at)) continue;
      m.points[i].normalImpulse = at->normal_impulse * static_cast<float>(scale_);
      m.points[i].tangentImpulse = at->tangent_impulse * static_cast<float>(scale_);
    }
  }

 private:
  /// The list is sorted after the first substep; from then on few contacts are new.
  PlaneContact& sum_of(const PlaneContact& t) {
    auto at = borne_.end();
    if (!on_) at = std::lower_bound(borne_.begin(), at, t, comes_before);
    return at == borne_.end() || comes_before(t, *at) ? *borne_.insert(at, t) : *at;
  }

  bool collide(b2Contact& contact) const {
    const b2Fixture *f = contact.GetFixtureA(), *g = contact.GetFixtureB();
    const FixtureAt at = unpacked(*f), bt = unpacked(*g);
    const PlaneBody &a = plane_.bodies[at.body], &b = plane_.bodies[bt.body];
    b2WorldManifold manifold;
    contact.GetWorldManifold(&manifold);
    const Vec3 normal(-manifold.normal.x, -manifold.normal.y, 0);
    ContactPair pair{a.entity, b.entity, plane_.outlines[a.first + at.outline].shape,
                     plane_.outlines[b.first + bt.outline].shape};
    pair.point = origin_ + Vec3(manifold.points[0].x, manifold.points[0].y, 0) / scale_;
    pair.normal = normal, pair.gap = manifold.separations[0] / scale_;
    if (pair.b.index < pair.a.index) {
      std::swap(pair.a, pair.b), std::swap(pair.shape_a, pair.shape_b);
      pair.normal = -normal;
    }
    contact::NearPair& near = plane_.near->at(pair, plane_.filter);
    if (is_let_pass(*f, a.one_way, -normal, *g) || is_let_pass(*g, b.one_way, normal, *f))
      near.passes = true;
    return near.collides();
  }

  const Plane& plane_;
  const std::vector<PlaneContact>& before_;
  Vec3 origin_;
  Real scale_;
  bool on_ = true;
  std::vector<PlaneContact> borne_;
};

}  // namespace pantin::detail::planar
