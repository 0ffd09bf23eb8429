#include "engine/geometry/sweep.hpp"

#include "engine/base/invariants.hpp"
#include "engine/geometry/collide.hpp"
#include "engine/geometry/smooth.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/geometry/usable.hpp"

namespace pantin::detail {
namespace {

constexpr int kMostRounds = 200;
constexpr Real kClose = 1e-9;  // of the sizes: nearer counts as touching

struct Slide {
  const Shape& shape;
  Pose at;
  Vec3 way;
};

/// Conservative advancement: each step ends at the plane that separates the two, before which they
/// do not touch. [Bergen 2004, "Ray casting against general convex objects"]
std::optional<SweepHit> sweep_convex(const Slide& k, const Convex& b, Real limit) {
  ConvexScratch scratch;
  SweepHit hit;
  for (int round = 0; round < kMostRounds; ++round) {
    const Pose at{k.at.position + hit.distance * k.way, k.at.rotation};
    const Convex a = convex_piece(k.shape, at, scratch);
    const Separation apart = separate(a, b, 1e300);
    const Real gap = apart.distance - a.radius - b.radius;
    hit.normal = apart.normal, hit.point = apart.on_b + b.radius * apart.normal;
    if (gap <= kClose * (a.size + b.size)) return hit;
    const Real sinks = -glm::dot(apart.normal, k.way);
    if (!(sinks > 0)) return std::nullopt;
    hit.distance += gap / sinks;
    if (!(hit.distance <= limit)) return std::nullopt;
  }
  return hit;
}

std::optional<SweepHit> sweep_half_space(const Slide& k, Real limit) {
  ConvexScratch scratch;
  const Convex a = convex_piece(k.shape, k.at, scratch);
  const Vec3 low = a.extreme({0, -1, 0}) - Vec3(0, a.radius, 0);
  SweepHit hit;
  if (low.y > 0) {
    if (!(k.way.y < 0)) return std::nullopt;
    hit.distance = low.y / -k.way.y;
    if (hit.distance > limit) return std::nullopt;
  }
  hit.point = low + hit.distance * k.way;
  hit.point.y = 0;
  return hit;
}

/// Tests the triangles that face the motion, one by one.
struct OverTriangles {
  const Slide& k;
  const Surface& surface;
  Real limit;
  std::optional<SweepHit> best{};

  void take(std::uint32_t index) {
    const std::array<Vec3, 3> t = triangle_of(surface, index);
    if (glm::dot(normal_of(surface, index), k.way) >= 0) return;
    const Vec3 centre = (t[0] + t[1] + t[2]) / 3.0;
    const Convex tile{t, {}, {}, {}, {}, 0, centre, glm::distance(t[0], centre)};
    const auto hit = sweep_convex(k, tile, limit);
    if (hit && (!best || hit->distance < best->distance)) best = hit, limit = hit->distance;
  }
};

std::optional<SweepHit> sweep_surface(const Slide& k, const Surface& s, Real limit) {
  const Aabb start = bounds_of(k.shape, k.at);
  Aabb swept = start;
  swept.add({start.low + limit * k.way, start.high + limit * k.way});
  if (!swept.overlaps({s.low, s.high})) return std::nullopt;
  OverTriangles over{k, s, limit};
  if (s.columns == 0) {
    s.tree.query(swept, [&](std::uint32_t t) { over.take(t); });
    return over.best;
  }
  const std::uint32_t x0 = cell_at(swept.low.x, s.spacing_x, s.columns),
                      x1 = cell_at(swept.high.x, s.spacing_x, s.columns),
                      z0 = cell_at(swept.low.z, s.spacing_z, s.rows),
                      z1 = cell_at(swept.high.z, s.spacing_z, s.rows);
  for (std::uint32_t z = z0; z <= z1; ++z)
    for (std::uint32_t x = x0; x <= x1; ++x)
      for (std::uint32_t i = 0; i < 2; ++i) over.take(2 * (z * (s.columns - 1) + x) + i);
  return over.best;
}

/// Tests a skin that is not convex: steps as long as the gap, within which nothing is touched.
std::optional<SweepHit> sweep_skin(const Slide& k, const Shape& b, Real limit) {
  NarrowPhaseScratch scratch;
  std::vector<ContactPoint> points;
  const Real close = kClose * (b.surface->model->size + reach_of(k.shape));
  SweepHit hit;
  for (int round = 0; round < 10 * kMostRounds && hit.distance <= limit; ++round) {
    const Pose at{k.at.position + hit.distance * k.way, k.at.rotation};
    points.clear();
    collide({k.shape, at}, {b, Pose{}}, scratch, {limit - hit.distance + close, points});
    const ContactPoint* nearest = nullptr;
    for (const ContactPoint& p : points)
      if (!nearest || p.gap < nearest->gap) nearest = &p;
    if (!nearest) return std::nullopt;
    hit.point = nearest->on_b, hit.normal = nearest->normal;
    if (nearest->gap <= close) return hit;
    hit.distance += nearest->gap;
  }
  return std::nullopt;
}

/// Overlap at the start.
std::optional<SweepHit> overlap_at_start(const Slide& k, const Shape& b) {
  NarrowPhaseScratch scratch;
  std::vector<ContactPoint> points;
  collide({k.shape, k.at}, {b, Pose{}}, scratch, {0, points});
  const ContactPoint* deepest = nullptr;
  for (const ContactPoint& p : points)
    if (!deepest || p.gap < deepest->gap) deepest = &p;
  if (!deepest) return std::nullopt;
  return SweepHit{0, deepest->on_b, deepest->normal};
}

}  // namespace

std::optional<SweepHit> sweep(const PlacedShape& a, const PlacedShape& b, Vec3 way, Real limit) {
  PANTIN_ASSERT(is_convex(a.shape));
  if (!is_unit(way) || !(limit >= 0)) return std::nullopt;  // the square of `way` overflows
  if (!is_usable(a.shape) || !is_usable(b.shape)) return std::nullopt;
  if (!is_unit(a.at) || !is_unit(b.at)) return std::nullopt;
  const Quat back = glm::conjugate(b.at.rotation);
  const Slide k{
      a.shape, {back * (a.at.position - b.at.position), back * a.at.rotation}, back * way};
  std::optional<SweepHit> hit = overlap_at_start(k, b.shape);
  ConvexScratch scratch;
  if (!hit) switch (traits_of(b.shape.kind).shape_class) {
      case ShapeClass::half_space:
        hit = sweep_half_space(k, limit);
        break;
      case ShapeClass::mesh:
      case ShapeClass::heights:
        hit = sweep_surface(k, *b.shape.surface, limit);
        break;
      case ShapeClass::skin:
        if (!is_convex(b.shape)) {
          hit = sweep_skin(k, b.shape, limit);
          break;
        }
        [[fallthrough]];
      case ShapeClass::convex:
        hit = sweep_convex(k, convex_piece(b.shape, Pose{}, scratch), limit);
        break;
    }
  if (!hit || !is_unit(hit->normal) || !is_range(0, hit->distance)) return std::nullopt;
  hit->point = to_world(b.at, hit->point), hit->normal = b.at.rotation * hit->normal;
  return hit;
}

}  // namespace pantin::detail
