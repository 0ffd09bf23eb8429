#include "engine/geometry/smooth.hpp"

#include <algorithm>

namespace pantin::detail {
namespace {

constexpr std::uint32_t kOfB = 256;  // features: corners of b are numbered from here
constexpr std::uint32_t kFarthest = 255;
constexpr std::uint64_t kClosest = 0x3ffff;
constexpr std::size_t kMostPoints = 8, kTilts = 8;
// Fractions of the sizes. kAgree: a point deeper than all corners by less is left out, so that
// points do not come and go on a body at rest. kShallow: depth along a face up to which no other
// separating direction is tried.
constexpr Real kAgree = 1e-6, kShallow = 5e-3;
constexpr Real kSnap = 1e-4;  // rad: nearer to a face's normal than this, that normal is tried
// Fraction of the size: support points of tilted directions that are closer count once, since on a
// smooth surface a tilt only rolls the point; also the tolerance beside a line and beyond a rim.
constexpr Real kSame = 0.01;

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

/// The patch of a kind that has a support function only.
void tilted_patch(const Convex& c, const Towards& towards, Patch& p) {
  const auto [u, v] = across(towards.direction);
  const Real same = kSame * c.size;
  for (std::uint32_t k = 0; k < kTilts; ++k) {
    const Real angle = 2 * kPi * (k + 0.5) / kTilts;
    const Vec3 way = std::cos(angle) * u + std::sin(angle) * v;
    const Vec3 at = c.extreme(towards.direction + towards.tilt * way);
    const auto near = [&](std::size_t i) { return glm::distance(p.points[i], at) <= same; };
    if (p.count > 0 && (near(p.count - 1) || near(0))) continue;
    p.add(at, k);
  }
}

void smooth_patch(const Convex& c, const Towards& towards, Patch& p) {
  const auto patch = traits_of(c.smooth->kind).patch;
  if (!patch) return tilted_patch(c, towards, p);
  patch(*c.smooth, {towards.direction * c.rotation, towards.tilt}, p);
  for (std::size_t i = 0; i < p.count; ++i) p.points[i] = c.origin + c.rotation * p.points[i];
}

/// The patch of a piece with corners: a face, both ends of an edge unless it is seen end-on, or a
/// point.
void cornered_patch(const Convex& c, Vec3 direction, Patch& p) {
  const Face* face = nullptr;
  Real most = -2;
  for (const Face& f : c.faces)
    if (const Real m = glm::dot(f.normal, direction); m > most) most = m, face = &f;
  if (face) {
    const std::uint32_t every = 1 + (face->count - 1) / static_cast<std::uint32_t>(Patch::kMost);
    for (std::uint32_t i = 0; i < face->count; i += every) {
      const std::uint32_t corner = c.corners[face->first + i];
      p.add(c.points[corner], corner);
    }
    return;
  }
  if (c.points.size() == 2) {
    const Vec3 edge = c.points[1] - c.points[0];
    if (std::abs(glm::dot(edge, direction)) < 0.7 * glm::length(edge))
      return p.add(c.points[0], 0), p.add(c.points[1], 1);
  }
  const std::uint32_t corner = c.farthest(direction);
  p.add(c.points[corner], corner);
}

void patch_of(const Convex& c, Vec3 direction, Real margin, Patch& p) {
  p.count = 0, p.rim = 0;
  if (c.smooth) return smooth_patch(c, {direction, tilt_of(c, margin)}, p);
  cornered_patch(c, direction, p);
}

/// A patch projected along the normal: corners in its plane, and their heights.
struct Flat {
  struct Corner {
    Real x, y, height;
    std::uint32_t label;
  };
  std::array<Corner, Patch::kMost> corners;
  std::size_t count = 0;
  Real rim = 0;                 // m
  Real area = 0;                // signed, twice
  Real slack = 0;               // m
  Real rise_x = 0, rise_y = 0;  // of the plane through the corners
  Real mean_x = 0, mean_y = 0, mean_height = 0;
};

/// Axes of the patch's plane and the normal, and the first label of its corners.
struct Seen {
  std::array<Vec3, 3> frame;
  std::uint32_t label;
};

void flatten(const Convex& c, const Patch& patch, const Seen& seen, Flat& f) {
  const auto& [frame, label] = seen;
  f.count = patch.count, f.rim = patch.rim, f.slack = 1e-9 * c.size;
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
  if (std::abs(f.area) > 1e-4 * c.size * c.size)
    f.rise_x = -normal.x / f.area, f.rise_y = -normal.y / f.area;
  else
    f.area = 0;
}

/// The height of a patch at (x, y), if that point is on it.
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
  if (f.rim > 0 && std::hypot(x - f.mean_x, y - f.mean_y) > (1 + kSame) * f.rim)
    return std::nullopt;
  for (std::size_t i = 0; i < f.count && f.rim == 0; ++i) {
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

/// Adds corners of one patch over the other, and crossings of their borders unless all corners of
/// one are over the other.
void clip(const Clip& k) {
  const std::size_t first = k.out.size();
  std::size_t over = 0;
  for (std::size_t i = 0; i < k.a.count; ++i) {
    const auto& c = k.a.corners[i];
    if (const auto h = height_at(k.b, c.x, c.y))
      k.add({c.x, c.y, 0}, c.height, *h, c.label), ++over;
  }
  if (over == k.a.count) return;
  const std::size_t of_b = k.out.size();
  over = 0;
  for (std::size_t i = 0; i < k.b.count; ++i) {
    const auto& c = k.b.corners[i];
    if (const auto h = height_at(k.a, c.x, c.y))
      k.add({c.x, c.y, 0}, *h, c.height, c.label), ++over;
  }
  if (over == k.b.count) {
    k.out.erase(k.out.begin() + std::ptrdiff_t(first), k.out.begin() + std::ptrdiff_t(of_b));
    return;
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

/// Two pieces that are near each other.
struct Touch {
  const Convex& a;
  const Convex& b;
  const Facing* facing;
  const PointsOut& out;
  std::size_t first;  // of their points

  Real size() const { return a.size + b.size; }
  Real radii() const { return a.radius + b.radius; }
};

/// The patches that the pieces turn towards each other along a normal.
struct Fronts {
  Fronts(const Touch& k, Vec3 normal) {
    const auto [u, v] = across(normal);
    frame = {u, v, normal};
    Patch patch;
    patch_of(k.a, -normal, k.out.margin, patch);
    flatten(k.a, patch, {frame, 0}, a);
    patch_of(k.b, normal, k.out.margin, patch);
    flatten(k.b, patch, {frame, kOfB}, b);
  }
  /// The height of a patch above or below `p`, if that is on it.
  std::optional<Real> height(const Flat& flat, Vec3 p) const {
    return height_at(flat, glm::dot(frame[0], p), glm::dot(frame[1], p));
  }
  std::array<Vec3, 3> frame;
  Flat a, b;
};

/// Adds the points where the patches overlap. Returns the least gap of the cores there.
Real add_shared(const Touch& k, const Fronts& fronts) {
  auto& points = k.out.points;
  const std::size_t from = points.size();
  clip({fronts.a, fronts.b, fronts.frame, k.a.radius, k.b.radius, k.out.margin, points});
  Real least = 1e300;
  for (std::size_t i = from; i < points.size(); ++i) least = glm::min(least, points[i].gap);
  return least + k.radii();
}

void add_closest(const Touch& k, const Separation& at) {
  const Vec3 n = at.normal;
  const Real gap = at.distance - k.radii();
  if (gap <= k.out.margin)
    k.out.points.push_back({at.on_a - k.a.radius * n, at.on_b + k.b.radius * n, n, gap, kClosest});
}

void finish(const Touch& k) {
  drop_duplicates(k.out.points, k.first, 1e-4 * k.size());
  reduce_points(k.out.points, k.first, kMostPoints, kAgree * k.size());
}

/// The flat face along whose normal the pieces are farthest apart, or overlap least.
struct BestFace {
  Vec3 normal{0};     // from b to a
  Real gap = -1e300;  // m, of the cores
  bool is_of_b = true;
  Vec3 farthest{0};  // support point of the other piece
};

BestFace best_face(const Touch& k) {
  BestFace best;
  for (const Face& f : k.b.faces) {
    const Vec3 p = k.a.extreme(-f.normal);
    const Real gap = glm::dot(f.normal, p) - f.offset;
    if (gap > best.gap) best = {f.normal, gap, true, p};
  }
  for (const Face& f : k.a.faces) {
    const Vec3 p = k.b.extreme(-f.normal);
    const Real gap = glm::dot(f.normal, p) - f.offset;
    if (gap > best.gap + 1e-7 * k.size() && (!k.facing || allows(*k.facing, -f.normal)))
      best = {-f.normal, gap, false, p};
  }
  return best;
}

/// Whether a flat face decides the contact; its points are added then. No direction separates the
/// pieces more than the normal of a face that the other's support point is over.
bool touch_face(const Touch& k) {
  const BestFace face = best_face(k);
  if (face.gap - k.radii() > k.out.margin) return true;
  if (!(face.gap > -kShallow * k.size())) return false;
  const Fronts fronts(k, face.normal);
  const bool agrees = add_shared(k, fronts) <= face.gap + kAgree * k.size();
  const bool is_over = bool(fronts.height(face.is_of_b ? fronts.b : fronts.a, face.farthest));
  if (!agrees && !is_over) {
    k.out.points.resize(k.first);
    return false;
  }
  const Vec3 n = face.normal, p = face.farthest;
  if (!agrees)
    add_closest(k, face.is_of_b ? Separation{p, p - face.gap * n, n, face.gap}
                                : Separation{p + face.gap * n, p, n, face.gap});
  finish(k);
  return true;
}

/// Collides a ball with a kind that computes its nearest points.
void touch_ball(const Touch& k) {
  const bool a_is_ball = !k.a.smooth;
  const Convex &ball = a_is_ball ? k.a : k.b, &other = a_is_ball ? k.b : k.a;
  const Vec3 p = (ball.points[0] - other.origin) * other.rotation;
  const auto near = closest(*other.smooth, p, glm::max(k.out.margin + ball.radius, Real(0)));
  if (!near) return;
  const Vec3 out = other.rotation * near->normal, on = other.origin + other.rotation * near->point;
  add_closest(k, a_is_ball ? Separation{ball.points[0], on, out, near->distance}
                           : Separation{on, ball.points[0], -out, near->distance});
}

/// Replaces the normal by a face's normal if that separates the pieces more, or is almost the same
/// and separates them as much: a face's normal has fewer rounding errors.
void snap_to_face(const Touch& k, Separation& apart) {
  const BestFace face = best_face(k);
  const bool is_same = glm::distance(face.normal, apart.normal) <= kSnap;
  if (face.gap < apart.distance + (is_same ? -1e-9 : 1e-9) * k.size()) return;
  apart.normal = face.normal, apart.distance = face.gap;
  if (face.is_of_b)
    apart.on_a = face.farthest, apart.on_b = apart.on_a - face.gap * face.normal;
  else
    apart.on_b = face.farthest, apart.on_a = apart.on_b + face.gap * face.normal;
}

}  // namespace

Corners corners_towards(const Convex& c, Vec3 direction, Real margin, Patch& scratch) {
  if (!c.smooth) return {c.points};
  patch_of(c, direction, margin, scratch);
  const Vec3 farthest = c.extreme(direction);
  Real most = -1e300;
  for (std::size_t i = 0; i < scratch.count; ++i)
    most = glm::max(most, glm::dot(direction, scratch.points[i]));
  if (glm::dot(direction, farthest) > most + kAgree * c.size) scratch.add(farthest, kFarthest);
  return {{scratch.points.data(), scratch.count}, {scratch.numbers.data(), scratch.count}};
}

void touch_smooth(const Convex& a, const Convex& b, const Facing* facing, const PointsOut& out) {
  const Touch k{a, b, facing, out, out.points.size()};
  const auto is_ball = [](const Convex& c) { return !c.smooth && c.points.size() == 1; };
  if (!facing && (is_ball(a) || is_ball(b))) return touch_ball(k);
  if (touch_face(k)) return;
  Separation apart = separate(a, b, out.margin + k.radii());
  if (apart.is_beyond || apart.distance - k.radii() > out.margin) return;
  if (facing && !allows(*facing, apart.normal)) {
    // A concave or flat edge: only points above the triangle itself count.
    if (apart.distance > 0 && glm::dot(apart.normal, facing->normal) < 0) return;
    const Fronts fronts(k, facing->normal);
    add_shared(k, fronts);
    const Vec3 low = a.extreme(-facing->normal), n = facing->normal;
    if (const auto h = fronts.height(fronts.b, low)) {
      const Real gap = glm::dot(n, low) - *h;
      add_closest(k, {low, low - gap * n, n, gap});
    }
    return finish(k);
  }
  snap_to_face(k, apart);
  if (add_shared(k, Fronts(k, apart.normal)) > apart.distance + kAgree * k.size())
    add_closest(k, apart);
  finish(k);
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
  // The plane at its nearest point separates the piece from the ray up to there.
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
