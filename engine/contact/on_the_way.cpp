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
/// Of the smaller shape: what overlaps no deeper along a normal is apart along it. A normal that is
/// between two bodies at the start and somewhat after the end of a step is so all the way: what
/// slides over a seam does not meet the side of the next tile.
constexpr Real kGrazes = 5e-4, kSoon = 1.2, kAhead = 1.37, kSeen = 1e-6;
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
    const std::vector<std::uint8_t>& fallen = s.world.memory.of<Memory>().scratch.has_fallen;
    if (at.slot < fallen.size() && fallen[at.slot])
      fallen_ = s.h * b.gravity_scale * s.world.gravity;
  }
  /// Without the speed that weight has given it in this step: what bears it will take that back.
  void forget_fall() { velocity_ -= fallen_; }
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
  Vec3 velocity_{0}, spin_{0}, fallen_{0};
};

const ContactPoint& nearest_of(const std::vector<ContactPoint>& points) {
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
  m.find_at(kAhead * h);
  if (m.search.points.empty()) return false;
  const ContactPoint& nearest = nearest_of(m.search.points);
  if (!(glm::dot(nearest.normal, at_start) < kOther && nearest.gap >= -kGrazes * m.size) ||
      !m.take_back(kAhead * h, kGrazes * m.size))
    return false;
  return nearest_of(m.search.points).gap <= kGrazes * m.size;
}

}  // namespace

void follow_way(const WayFinder& s, Search& search, const ColliderShape& on_a,
                const ColliderShape& on_b) {
  std::vector<ContactPoint>& points = search.points;
  if (!(s.h > 0) || points.empty() || !is_convex(*on_a.shape) || !is_convex(*on_b.shape)) return;
  const Real size = std::min(on_a.extent, on_b.extent);
  const Real margin = s.reach_of(on_a.slot) + s.reach_of(on_b.slot) + kTouching * size;
  Meeting m{Moving(s, on_a), Moving(s, on_b), size, margin, search};
  Meeting unfallen = m;
  unfallen.a.forget_fall(), unfallen.b.forget_fall();
  const ContactPoint& first = nearest_of(points);
  // Of what is pushed on both sides, ways are not known so well.
  const bool is_led = !s.is_moved(on_a.slot) || !s.is_moved(on_b.slot);
  const bool is_met = is_led && unfallen.closing(first, 0) * kSoon * s.h >
                                    std::max(first.gap, Real(0)) + kSeen * size;
  const Vec3 normal = first.normal;
  if (is_met) search.at_start = points;
  Real t = 0;
  for (int n = 0; n < kMostAdvances && !points.empty(); ++n) {
    const ContactPoint& p = nearest_of(points);
    const Real closing = m.closing(p, t);
    if (!(p.gap > kTouching * size) || !(closing * (s.h - t) > p.gap)) break;
    const Real speed = glm::length(m.a.speed_at(p.on_a, t) - m.b.speed_at(p.on_b, t));
    if (n == 0 && !(speed * p.gap > kShortWay * size * closing)) break;
    t += p.gap / closing;  // no sooner: a plane is between them until then
    m.find_at(t);
  }
  if (is_met) {
    if (passes_by(unfallen, s.h, normal)) return;
    t > 0 ? m.find_at(t) : points.swap(search.at_start);
  }
  if (t > 0 && !m.take_back(t, 0)) m.find_at(0);
}

}  // namespace pantin::detail::contact
