// Shapes that meet within the step touch where they meet, not where they are nearest at its start.
#include "engine/contact/on_the_way.hpp"

#include <algorithm>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/memory.hpp"

namespace pantin::detail::contact {
namespace {

/// m: what would go further in a step is lost at its end.
constexpr Real kFarthest = 1e12;
/// Of the smaller shape: bodies so near touch; a way so short turns no normal to speak of.
constexpr Real kTouching = 1e-4, kShortWay = 1e-4;
constexpr int kMostAdvances = 10;
/// Of the smaller shape: what is so near along a normal slides along it; what closes by less rests.
constexpr Real kGrazes = 5e-4, kRests = 1e-6;
/// Steps: what meets so soon is asked whether it passes by, and where it is looked for then.
constexpr Real kSoon = 1.2, kAhead = 1.37;
/// Cosine between two normals that are not of one place.
constexpr Real kOther = 0.9;

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
  /// Takes back the speed that its weight has given it in this step already, if its solver moves
  /// first: what bears it will.
  void forget_fall(const WayFinder& s) {
    const std::vector<std::uint8_t>& fallen = s.world.memory.of<Memory>().scratch.has_fallen;
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
  PANTIN_ASSERT(!points.empty());
  return *std::min_element(
      points.begin(), points.end(),
      [](const ContactPoint& p, const ContactPoint& q) { return p.gap < q.gap; });
}

/// Two shapes on their way, and the points between them.
struct Meeting {
  Moving a, b;
  Real size, margin;  // m: of the smaller one; how near points are looked for
  Search& search;

  /// How fast a point closes, m/s.
  Real closing(const ContactPoint& p, Real t) const {
    return -glm::dot(p.normal, a.speed_at(p.on_a, t) - b.speed_at(p.on_b, t));
  }
  void find_at(Real time) {
    search.points.clear();
    const Pose there_a = a.shape_after(time), there_b = b.shape_after(time);
    collide({a.shape(), there_a}, {b.shape(), there_b}, search.scratch, {margin, search.points});
  }
  /// As the points would be at the start with the normals of a time. False: one of them overlaps
  /// deeper than `most` there.
  bool take_back(Real time, Real most) {
    bool is_between = true;
    for (ContactPoint& p : search.points) {
      p.on_a = a.at_start(p.on_a, -p.normal, time), p.on_b = b.at_start(p.on_b, p.normal, time);
      p.gap = glm::dot(p.normal, p.on_a - p.on_b);
      is_between = is_between && p.gap >= -most;
    }
    return is_between;
  }
};

/// Whether another normal than that at the start is between two bodies then and somewhat after the
/// end of the step, so all the way, and they slide along it: what slides over a seam does not meet
/// the side of the next tile. The points are then those with that normal, else undefined.
bool passes_by(Meeting m, Real h, Vec3 at_start) {
  PANTIN_ASSERT(is_unit(at_start));
  const Real near = kGrazes * m.size;
  m.find_at(kAhead * h);
  if (m.search.points.empty()) return false;
  const ContactPoint& then = nearest_of(m.search.points);
  if (then.gap < -near || glm::dot(then.normal, at_start) >= kOther) return false;
  return m.take_back(kAhead * h, near) && nearest_of(m.search.points).gap <= near;
}

/// Whether the points of two that would soon meet are now those along which they slide; else they
/// are as they were.
bool slides_past(const WayFinder& s, Meeting m) {
  m.a.forget_fall(s), m.b.forget_fall(s);
  const ContactPoint first = nearest_of(m.search.points);
  if (!(m.closing(first, 0) * kSoon * s.h > std::max(first.gap, Real(0)) + kRests * m.size))
    return false;
  m.search.at_start = m.search.points;
  if (passes_by(m, s.h, first.normal)) return true;
  m.search.points.swap(m.search.at_start);
  return false;
}

}  // namespace

void follow_way(const WayFinder& s, Search& search, const ColliderShape& on_a,
                const ColliderShape& on_b) {
  std::vector<ContactPoint>& points = search.points;
  if (!(s.h > 0) || points.empty() || !is_convex(*on_a.shape) || !is_convex(*on_b.shape)) return;
  PANTIN_ASSERT(on_a.slot != on_b.slot);
  const Real size = std::min(on_a.extent, on_b.extent);
  const Real margin = s.reach_of(on_a.slot) + s.reach_of(on_b.slot) + kTouching * size;
  if (!(margin < kFarthest)) return;
  Meeting m{Moving(s, on_a), Moving(s, on_b), size, margin, search};
  // Of what contacts move on both sides, ways are not known so well.
  const bool asks = !s.is_moved(on_a.slot) || !s.is_moved(on_b.slot);
  if (asks && slides_past(s, m)) return;
  Real t = 0;
  for (int n = 0; n < kMostAdvances && !points.empty(); ++n) {
    const ContactPoint& p = nearest_of(points);
    const Real closing = m.closing(p, t);
    if (!(p.gap > kTouching * size) || !(closing * (s.h - t) > p.gap)) break;
    const Real speed = glm::length(m.a.speed_at(p.on_a, t) - m.b.speed_at(p.on_b, t));
    if (n == 0 && !(speed * p.gap > kShortWay * size * closing)) return;
    t += p.gap / closing;  // no sooner: a plane is between them until then
    m.find_at(t);
  }
  if (t > 0 && !m.take_back(t, 0)) m.find_at(0);
}

}  // namespace pantin::detail::contact
