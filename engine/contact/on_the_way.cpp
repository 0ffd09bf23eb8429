// Shapes that meet within the step touch where they meet, not where they are nearest at its start.
#include "engine/contact/on_the_way.hpp"

#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/memory.hpp"

namespace pantin::detail::contact {
namespace {

/// Of the smaller shape: bodies so near touch; a way so short turns no normal to speak of.
constexpr Real kTouching = 1e-4, kShortWay = 1e-4;
constexpr int kMostAdvances = 10;

bool is_convex(const Shape& s) { return traits_of(s.kind).shape_class == ShapeClass::convex; }

/// A shape on its way through the step, as its body's velocity and spin have it.
class Moving {
 public:
  Moving(const WayFinder& s, const ColliderShape& at)
      : at_(at), from_(s.world.bodies.values()[at.slot].pose) {
    const Body& b = s.world.bodies.values()[at.slot];
    if (!s.is_moved(at.slot) && !moves(b)) return;
    velocity_ = b.velocity, spin_ = b.angular_velocity;
  }
  Pose body_after(Real t) const {
    return {from_.position + t * velocity_,
            glm::normalize(from_rotation_vector(t * spin_) * from_.rotation)};
  }
  Pose shape_after(Real t) const { return compose(body_after(t), at_.shape->local); }
  Vec3 speed_at(Vec3 point, Real t) const {
    return velocity_ + glm::cross(spin_, point - from_.position - t * velocity_);
  }
  /// Where a point that is touched after a time is at the start: what is round is touched there on
  /// the same side, what has corners with the same one.
  Vec3 at_start(Vec3 point, Vec3 outward, Real t) const {
    const Pose then = shape_after(t);
    const Quat back = glm::conjugate(then.rotation);
    const Vec3 round =
        rounding_of(*at_.shape, {to_local(then, point), back * outward, back * spin_}) * outward;
    return to_world(from_, to_local(body_after(t), point - round)) + round;
  }
  const Shape& shape() const { return *at_.shape; }

 private:
  const ColliderShape& at_;
  Pose from_;
  Vec3 velocity_{0}, spin_{0};
};

const ContactPoint& nearest_of(const std::vector<ContactPoint>& points) {
  return *std::min_element(
      points.begin(), points.end(),
      [](const ContactPoint& p, const ContactPoint& q) { return p.gap < q.gap; });
}

}  // namespace

void follow_way(const WayFinder& s, Search& search, const ColliderShape& on_a,
                const ColliderShape& on_b) {
  std::vector<ContactPoint>& points = search.points;
  if (!(s.h > 0) || points.empty() || !is_convex(*on_a.shape) || !is_convex(*on_b.shape)) return;
  const Moving a(s, on_a), b(s, on_b);
  const Real size = std::min(on_a.extent, on_b.extent);
  const Real margin = s.reach_of(on_a.slot) + s.reach_of(on_b.slot) + kTouching * size;
  const auto find_at = [&](Real time) {
    points.clear();
    const Pose there_a = a.shape_after(time), there_b = b.shape_after(time);
    collide({a.shape(), there_a}, {b.shape(), there_b}, search.scratch, {margin, points});
  };
  Real t = 0;
  for (int n = 0; n < kMostAdvances && !points.empty(); ++n) {
    const ContactPoint& p = nearest_of(points);
    const Vec3 speed = a.speed_at(p.on_a, t) - b.speed_at(p.on_b, t);
    const Real closing = -glm::dot(p.normal, speed);
    if (!(p.gap > kTouching * size) || !(closing * (s.h - t) > p.gap)) break;
    if (n == 0 && !(glm::length(speed) * p.gap > kShortWay * size * closing)) return;
    t += p.gap / closing;  // no sooner: a plane is between them until then
    find_at(t);
  }
  if (t == 0) return;
  bool is_between = true;
  for (ContactPoint& p : points) {
    p.on_a = a.at_start(p.on_a, -p.normal, t), p.on_b = b.at_start(p.on_b, p.normal, t);
    p.gap = glm::dot(p.normal, p.on_a - p.on_b);
    is_between = is_between && p.gap >= 0;
  }
  if (!is_between) find_at(0);
}

}  // namespace pantin::detail::contact
