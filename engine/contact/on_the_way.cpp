// Shapes that meet within the step touch where they meet, not where they are closest at its start.
#include "engine/contact/on_the_way.hpp"

#include <algorithm>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/memory.hpp"

namespace pantin::detail::contact {
namespace {

/// m: a body that moves farther within a step has diverged.
constexpr Real kFarthest = 1e12;
/// Fractions of the smaller shape: distance at which shapes touch; displacement too short to change
/// the normal noticeably.
constexpr Real kTouching = 1e-4, kShortWay = 1e-4;
constexpr int kMostAdvances = 10;
/// Fractions of the smaller shape: distance from a plane within which a body slides along it;
/// approach per step below which it rests.
constexpr Real kGrazes = 5e-4, kRests = 1e-6;
/// In steps: shapes that would meet sooner are tested for passing each other; time of that test.
constexpr Real kSoon = 1.2, kAhead = 1.37;
/// Cosine between two normals, below which they belong to different features.
constexpr Real kOther = 0.9;
/// Of two skins, fractions of the smaller one: displacement between two looks; overlap that counts.
constexpr Real kLook = 0.1, kLeft = 1e-3;
constexpr int kMostLooks = 15;

bool is_skin(const Shape& s) { return s.kind == ShapeKind::nurbs; }
bool is_convex(const Shape& s) { return traits_of(s.kind).shape_class == ShapeClass::convex; }

/// A shape that moves through the step with its body's velocity and angular velocity.
class Moving {
 public:
  Moving(const SweptSearch& s, const ColliderShape& at)
      : at_(at), from_(s.world.bodies.values()[at.slot].pose) {
    const Body& b = s.world.bodies.values()[at.slot];
    if (!s.is_moved(at.slot) && !moves(b)) return;
    velocity_ = b.velocity, spin_ = b.angular_velocity;
  }
  /// Removes the speed that gravity has already added in this step, if the body's solver moves
  /// first: the support of the body will cancel it.
  void remove_gravity(const SweptSearch& s) {
    const std::vector<std::uint8_t>& fallen = s.world.memory.of<Memory>().scratch.has_gravity;
    if (at_.slot < fallen.size() && fallen[at_.slot])
      velocity_ -= s.h * s.world.bodies.values()[at_.slot].gravity_scale * s.world.gravity;
  }
  Pose body_after(Real t) const {
    return {from_.position + t * velocity_,
            glm::normalize(from_rotation_vector(t * spin_) * from_.rotation)};
  }
  Pose shape_after(Real t) const { return compose(body_after(t), at_.shape->local); }
  Vec3 speed_at(Vec3 point, Real t) const {
    return velocity_ + glm::cross(spin_, point - from_.position - t * velocity_);
  }
  /// Where the contact point of time t is at the start. A rounded shape is touched on the same side
  /// there, a shape with corners at the same corner.
  Vec3 at_start(Vec3 point, Vec3 outward, Real t) const {
    const Pose then = shape_after(t);
    const Quat back = glm::conjugate(then.rotation);
    const Vec3 round =
        rounding_of(*at_.shape, {to_local(then, point), back * outward, back * spin_}) * outward;
    return to_world(from_, to_local(body_after(t), point - round)) + round;
  }
  const Shape& shape() const { return *at_.shape; }
  Vec3 velocity() const { return velocity_; }
  /// rad/s
  Real turning() const { return glm::length(spin_); }

 private:
  const ColliderShape& at_;
  Pose from_;
  Vec3 velocity_{0}, spin_{0};
};

const ContactPoint& nearest_of(const std::vector<ContactPoint>& points) {
  PANTIN_ASSERT(!points.empty());
  return *std::min_element(
      points.begin(), points.end(),
      [](const ContactPoint& p, const ContactPoint& q) { return p.gap < q.gap; });
}

/// Two moving shapes and the points between them.
struct MovingPair {
  Moving a, b;
  Real size, margin;  // m: of the smaller shape; search distance of points
  PointSearch& at;

  /// Closing speed at a point, m/s.
  Real closing(const ContactPoint& p, Real t) const {
    return -glm::dot(p.normal, a.speed_at(p.on_a, t) - b.speed_at(p.on_b, t));
  }
  /// Bound on the relative speed of their points, m/s, given their extents.
  Real fastest(Real extent_a, Real extent_b) const {
    return glm::length(a.velocity() - b.velocity()) + extent_a * a.turning() +
           extent_b * b.turning();
  }
  void find_at(Real time) {
    at.points.clear();
    const Pose there_a = a.shape_after(time), there_b = b.shape_after(time);
    collide({a.shape(), there_a}, {b.shape(), there_b}, at.scratch, {margin, at.points});
  }
  /// Maps the points of a time back to the start and keeps their normals. False if one of them
  /// overlaps deeper than `most` there.
  bool take_back(Real time, Real most) {
    bool is_between = true;
    for (ContactPoint& p : at.points) {
      p.on_a = a.at_start(p.on_a, -p.normal, time), p.on_b = b.at_start(p.on_b, p.normal, time);
      p.gap = glm::dot(p.normal, p.on_a - p.on_b);
      is_between = is_between && p.gap >= -most;
    }
    return is_between;
  }
};

/// Whether the bodies slide past each other along a normal that differs from the one at the start.
/// Such a normal separates them at the start and somewhat after the end of the step, so during all
/// of it. A body that slides over a seam then does not collide with the side of the next tile. If
/// true, the points are those with that normal; otherwise they are undefined.
bool passes_by(MovingPair m, Real h, Vec3 at_start) {
  PANTIN_ASSERT(is_unit(at_start));
  const Real near = kGrazes * m.size;
  m.find_at(kAhead * h);
  if (m.at.points.empty()) return false;
  const ContactPoint& then = nearest_of(m.at.points);
  if (then.gap < -near || glm::dot(then.normal, at_start) >= kOther) return false;
  return m.take_back(kAhead * h, near) && nearest_of(m.at.points).gap <= near;
}

/// If two shapes that would soon meet slide past each other, replaces their points by those along
/// which they slide; otherwise leaves the points as they were.
bool slides_past(const SweptSearch& s, MovingPair m) {
  m.a.remove_gravity(s), m.b.remove_gravity(s);
  const ContactPoint first = nearest_of(m.at.points);
  if (!(m.closing(first, 0) * kSoon * s.h > std::max(first.gap, Real(0)) + kRests * m.size))
    return false;
  m.at.at_start = m.at.points;
  if (passes_by(m, s.h, first.normal)) return true;
  m.at.points.swap(m.at.at_start);
  return false;
}

/// Skins have a point at each place where they are closest. Of two that have none at the start of
/// the step, finds those of the first pose on the way at which they would overlap.
void look_ahead(const SweptSearch& s, const MovingPair& m, Real way) {
  const int looks = static_cast<int>(std::min(way / (kLook * m.size), Real(kMostLooks)));
  std::vector<ContactPoint>& points = m.at.points;
  for (int look = 1; look <= looks && points.empty(); ++look) {
    MovingPair then = m;
    then.find_at(s.h * look / looks);
    std::erase_if(points, [&](const ContactPoint& p) { return p.gap > -kLeft * m.size; });
    then.take_back(s.h * look / looks, 0);
    // Without the far side of what it would have to pass through.
    std::erase_if(points, [&](const ContactPoint& p) { return p.gap < -kLeft * m.size; });
  }
}

}  // namespace

void advance_to_impact(const Swept& with, PointSearch& at, const ColliderShape& on_a,
                       const ColliderShape& on_b) {
  const SweptSearch& s = with.s;
  std::vector<ContactPoint>& points = at.points;
  if (!(s.h > 0)) return;
  PANTIN_ASSERT(on_a.slot != on_b.slot);
  const Real size = std::min(on_a.extent, on_b.extent);
  // A plane has no size: what comes within reach of it has a point at the start.
  if (points.empty() && size > 0 && (is_skin(*on_a.shape) || is_skin(*on_b.shape))) {
    const MovingPair m{Moving(s, on_a), Moving(s, on_b), size, 0, at};
    look_ahead(s, m, s.h * m.fastest(on_a.extent, on_b.extent));
  }
  if (points.empty() || !is_convex(*on_a.shape) || !is_convex(*on_b.shape)) return;
  const Real reach = s.reach_between(with.search, on_a.slot, on_b.slot, s.reach_of(on_a.slot));
  const Real margin = reach + kTouching * size;
  if (!(margin < kFarthest)) return;
  MovingPair m{Moving(s, on_a), Moving(s, on_b), size, margin, at};
  // If contacts move both bodies, their paths are too uncertain for this test.
  const bool asks = !s.is_moved(on_a.slot) || !s.is_moved(on_b.slot);
  if (asks && slides_past(s, m)) return;
  Real t = 0;
  for (int n = 0; n < kMostAdvances && !points.empty(); ++n) {
    const ContactPoint& p = nearest_of(points);
    const Real closing = m.closing(p, t);
    if (!(p.gap > kTouching * size) || !(closing * (s.h - t) > p.gap)) break;
    const Real speed = glm::length(m.a.speed_at(p.on_a, t) - m.b.speed_at(p.on_b, t));
    if (n == 0 && !(speed * p.gap > kShortWay * size * closing)) return;
    t += p.gap / closing;  // conservative: a plane separates them until then
    m.find_at(t);
  }
  if (t > 0 && !m.take_back(t, 0)) m.find_at(0);
}

}  // namespace pantin::detail::contact
