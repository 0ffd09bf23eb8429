#include "engine/geometry/smooth.hpp"

#include <algorithm>

namespace pantin::detail {
namespace {

constexpr std::uint32_t kOfB = 256;  // features: corners of b count from here
constexpr std::uint64_t kClosest = 0x3ffff;
constexpr std::size_t kMostPoints = 8, kTilts = 8;

/// Two directions at right angles to a unit vector.
std::array<Vec3, 2> across(Vec3 n) {
  const Vec3 side = std::abs(n.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 u = glm::normalize(glm::cross(n, side));
  return {u, glm::cross(n, u)};
}

/// Angle by which a piece may rotate until features within the margin come into contact, rad.
Real tilt_of(const Convex& c, Real margin) {
  return glm::clamp(c.size > 0 ? 2 * margin / c.size : Real(0), Real(2e-3), Real(0.3));
}

/// What a piece turns towards another: corners in order around the direction, with their numbers.
struct Patch {
  std::array<Vec3, 16> points;
  std::array<std::uint32_t, 16> numbers{};
  std::size_t count = 0;
  Real size = 0;
};

/// Points that are nearer to their neighbours than this part of the size count once: on a smooth
/// place tilting the piece only rolls it.
constexpr Real kSame = 0.01;

Patch patch_of(const Convex& c, Vec3 direction, Real margin) {
  Patch p;
  p.size = c.size;
  if (c.faces.size() == 1) {  // a triangle of a surface
    for (std::uint32_t i = 0; i < 3; ++i) p.points[i] = c.points[i], p.numbers[i] = i;
    p.count = 3;
    return p;
  }
  const auto [u, v] = across(direction);
  const Real tilt = tilt_of(c, margin), same = kSame * c.size;
  for (std::uint32_t k = 0; k < kTilts; ++k) {
    const Real angle = 2 * kPi * (k + 0.5) / kTilts;
    const Vec3 at = c.extreme(direction + tilt * (std::cos(angle) * u + std::sin(angle) * v));
    const auto near = [&](std::size_t i) { return glm::distance(p.points[i], at) <= same; };
    if (p.count > 0 && (near(p.count - 1) || near(0))) continue;
    p.points[p.count] = at, p.numbers[p.count++] = k;
  }
  return p;
}

/// A patch seen along the normal: corners in its plane, and their heights.
struct Flat {
  struct Corner {
    Real x, y, height;
    std::uint32_t label;
  };
  std::array<Corner, 16> corners{};
  std::size_t count = 0;
  Real area = 0;                // signed, twice
  Real slack = 0;               // m
  Real rise_x = 0, rise_y = 0;  // of the plane through the corners
  Real mean_x = 0, mean_y = 0, mean_height = 0;
};

Flat flatten(const Patch& patch, const std::array<Vec3, 3>& frame, std::uint32_t label) {
  Flat f;
  f.count = patch.count, f.slack = 1e-9 * patch.size;
  for (std::size_t i = 0; i < f.count; ++i) {
    const Vec3 p = patch.points[i];
    f.corners[i] = {glm::dot(frame[0], p), glm::dot(frame[1], p), glm::dot(frame[2], p),
                    label + patch.numbers[i]};
    f.mean_x += f.corners[i].x, f.mean_y += f.corners[i].y;
    f.mean_height += f.corners[i].height;
  }
  const Real n = static_cast<Real>(f.count);
  f.mean_x /= n, f.mean_y /= n, f.mean_height /= n;
  Vec3 normal(0);
  for (std::size_t i = 0; i < f.count; ++i) {
    const auto &p = f.corners[i], &q = f.corners[(i + 1) % f.count];
    normal += glm::cross(Vec3(p.x - f.mean_x, p.y - f.mean_y, p.height - f.mean_height),
                         Vec3(q.x - f.mean_x, q.y - f.mean_y, q.height - f.mean_height));
  }
  f.area = normal.z;
  if (std::abs(f.area) > 1e-4 * patch.size * patch.size)
    f.rise_x = -normal.x / f.area, f.rise_y = -normal.y / f.area;
  else
    f.area = 0;
  return f;
}

/// The height of a patch over (x, y), if that is on it.
std::optional<Real> height_at(const Flat& f, Real x, Real y) {
  if (f.area == 0) {
    if (f.count != 2) return std::nullopt;
    const auto &p = f.corners[0], &q = f.corners[1];
    const Real dx = q.x - p.x, dy = q.y - p.y, whole = dx * dx + dy * dy;
    const Real t = ((x - p.x) * dx + (y - p.y) * dy) / whole;
    const Real beside = std::abs((x - p.x) * dy - (y - p.y) * dx) / std::sqrt(whole);
    if (t < 0 || t > 1 || beside > kSame * std::sqrt(whole)) return std::nullopt;
    return p.height + t * (q.height - p.height);
  }
  for (std::size_t i = 0; i < f.count; ++i) {
    const auto &p = f.corners[i], &q = f.corners[(i + 1) % f.count];
    const Real side = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
    const Real length = std::hypot(q.x - p.x, q.y - p.y);
    if ((f.area > 0 ? side : -side) < -f.slack * length) return std::nullopt;
  }
  return f.mean_height + f.rise_x * (x - f.mean_x) + f.rise_y * (y - f.mean_y);
}

struct Clip {
  const Flat& a;
  const Flat& b;
  const std::array<Vec3, 3>& frame;
  Real radius_a, radius_b, margin;
  std::vector<ContactPoint>& out;

  void add(Vec3 at, Real on_a, Real on_b, std::uint64_t feature) const {
    const Real gap = on_a - on_b - radius_a - radius_b;
    if (gap > margin) return;
    const Vec3 foot = at.x * frame[0] + at.y * frame[1], n = frame[2];
    out.push_back({foot + (on_a - radius_a) * n, foot + (on_b + radius_b) * n, n, gap, feature});
  }
};

/// Corners of one patch over the other, and crossings of their borders.
void clip(const Clip& k) {
  for (std::size_t i = 0; i < k.a.count; ++i) {
    const auto& c = k.a.corners[i];
    if (const auto h = height_at(k.b, c.x, c.y)) k.add({c.x, c.y, 0}, c.height, *h, c.label);
  }
  for (std::size_t i = 0; i < k.b.count; ++i) {
    const auto& c = k.b.corners[i];
    if (const auto h = height_at(k.a, c.x, c.y)) k.add({c.x, c.y, 0}, *h, c.height, c.label);
  }
  const auto borders = [](const Flat& f) { return f.count == 2 ? 1 : f.count < 2 ? 0 : f.count; };
  for (std::size_t i = 0; i < borders(k.a); ++i)
    for (std::size_t j = 0; j < borders(k.b); ++j) {
      const auto &p = k.a.corners[i], &q = k.a.corners[(i + 1) % k.a.count];
      const auto &r = k.b.corners[j], &s = k.b.corners[(j + 1) % k.b.count];
      const Real ax = q.x - p.x, ay = q.y - p.y, bx = s.x - r.x, by = s.y - r.y;
      const Real rotation = ax * by - ay * bx;
      if (std::abs(rotation) < 1e-9 * std::hypot(ax, ay) * std::hypot(bx, by)) continue;
      const Real t = ((r.x - p.x) * by - (r.y - p.y) * bx) / rotation,
                 u = ((r.x - p.x) * ay - (r.y - p.y) * ax) / rotation;
      if (!(t > 0 && t < 1 && u > 0 && u < 1)) continue;
      k.add({p.x + t * ax, p.y + t * ay, 0}, p.height + t * (q.height - p.height),
            r.height + u * (s.height - r.height),
            static_cast<std::uint64_t>(p.label + 1) << 9 | r.label);
    }
}

}  // namespace

std::span<const Vec3> corners_towards(const Convex& c, Vec3 direction, Real margin,
                                      CornerRoom& scratch) {
  if (!c.smooth) return c.points;
  const Patch patch = patch_of(c, direction, margin);
  scratch[0] = c.extreme(direction);
  std::size_t count = 1;
  for (std::size_t i = 0; i < patch.count; ++i)
    if (glm::distance(patch.points[i], scratch[0]) > kSame * c.size)
      scratch[count++] = patch.points[i];
  return {scratch.data(), count};
}

void touch_smooth(const Convex& a, const Convex& b, const Facing* facing, const PointsOut& out) {
  const auto& [margin, points] = out;
  const Real radii = a.radius + b.radius, size = a.size + b.size;
  Separation apart = separate(a, b, margin + radii);
  if (apart.is_beyond || apart.distance - radii > margin) return;
  bool over_only = false;
  if (facing && !allows(*facing, apart.normal)) {
    // A concave or flat edge: only points above the triangle itself count.
    if (apart.distance > 0 && glm::dot(apart.normal, facing->normal) < 0) return;
    apart.normal = facing->normal, over_only = true;
  }
  const Vec3 n = apart.normal;
  const auto [u, v] = across(n);
  const std::array<Vec3, 3> frame{u, v, n};
  const Flat on_a = flatten(patch_of(a, -n, margin), frame, 0),
             on_b = flatten(patch_of(b, n, margin), frame, kOfB);
  const std::size_t first = points.size();
  clip({on_a, on_b, frame, a.radius, b.radius, margin, points});
  if (over_only) {
    const Vec3 low = a.extreme(-n);
    if (const auto h = height_at(on_b, glm::dot(u, low), glm::dot(v, low)))
      apart = {low, low - (glm::dot(n, low) - *h) * n, n, glm::dot(n, low) - *h, false};
    else
      return reduce_points(points, first, kMostPoints);
  }
  const Real gap = apart.distance - radii;
  Real least = 1e300;
  for (std::size_t i = first; i < points.size(); ++i) least = glm::min(least, points[i].gap);
  if (least > gap + 1e-9 * size && gap <= margin)
    points.push_back({apart.on_a - a.radius * n, apart.on_b + b.radius * n, n, gap, kClosest});
  drop_duplicates(points, first, 1e-4 * size);
  reduce_points(points, first, kMostPoints);
}

namespace {

Separation from_point(const Convex& piece, Vec3 p, Real limit) {
  const Convex point{{&p, 1}, {}, {}, {}, {}, 0, p, 0};
  Separation apart = separate(point, piece, limit + piece.radius);
  apart.distance -= piece.radius, apart.on_b += piece.radius * apart.normal;
  return apart;
}

}  // namespace

std::optional<RayEntry> cast_at(const Convex& piece, Vec3 from, Vec3 way, Real limit) {
  const Real close = 1e-10 * piece.size;
  RayEntry entry;
  // The piece lies beyond the plane at its nearest point: as far as that nothing is met.
  for (int round = 0; round < 200; ++round) {
    const Separation apart = from_point(piece, from + entry.distance * way, 1e300);
    if (round == 0 && apart.distance < 0) return std::nullopt;
    entry.normal = apart.normal;
    if (apart.distance <= close) return entry;
    const Real sinks = -glm::dot(apart.normal, way);
    if (!(sinks > 0)) return std::nullopt;
    entry.distance += apart.distance / sinks;
    if (entry.distance > limit) return std::nullopt;
  }
  return entry;
}

std::optional<SurfacePoint> closest_of(const Convex& piece, Vec3 p, Real limit) {
  const Separation apart = from_point(piece, p, glm::max(limit, Real(0)));
  if (apart.is_beyond || apart.distance > limit) return std::nullopt;
  return SurfacePoint{apart.on_b, apart.normal, apart.distance};
}

}  // namespace pantin::detail
