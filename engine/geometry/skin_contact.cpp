// Contacts of skins that are open or not convex: corners and edges of the other shape against the
// skin, and points of the skin against the other's faces and round sides.
#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/geometry/skin_edges.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/walk.hpp"

namespace pantin::detail {
namespace {

// Feature ids: a feature of the other shape, or the seed of the skin from which it was found.
constexpr std::uint64_t kOfEdge = 1 << 10, kOfFace = 1 << 12;
constexpr int kSamples = 9, kMostRefinements = 12;  // along an edge
constexpr std::size_t kMostPoints = 8, kMostStarts = 12;
constexpr int kMostCrossings = 6;
constexpr Real kApart = 0.15;       // of the skin's size: least distance between starts
constexpr Real kOpposed = 1e-5;     // rad, tolerance of opposed normals at a deepest point
constexpr Real kFlat = 0.05;        // rad, the same beside valleys
constexpr Real kBehind = 2;         // of the other's size: nothing deeper behind a patch touches it
constexpr Real kDifference = 1e-6;  // of a size: finite difference for the other's curvature

struct SkinQuery {
  const Surface& skin;
  const PlacedShape& other;
  SkinScratch& scratch;
  const PointsOut& out;
  Aabb reach;                 // bounds of the other, grown by the margin
  Real size;                  // of the other, m
  bool leaves_flats = false;  // to the corners and edges of both shapes
};

/// A ball about a point of the other shape, tested against the nearest point of the skin.
struct BallTest {
  Vec3 centre;
  Real radius;
  std::uint64_t feature;
};

void add_ball(const SkinQuery& k, const BallTest& ball, const SkinPoint& near) {
  const Real gap = near.distance - ball.radius;
  if (gap > k.out.margin) return;
  if (!k.skin.model->is_closed &&
      (near.distance < -kBehind * k.size || (near.is_on_rim && near.distance < 0)))
    return;
  k.out.points.push_back(
      {ball.centre - ball.radius * near.normal, near.point, near.normal, gap, ball.feature});
}

/// An edge of the other shape, with a radius.
struct EdgeTest {
  Vec3 from, way;
  Real radius;
  std::uint64_t feature;
};

/// A point of an edge, and the derivative of its distance along the edge.
struct Along {
  Real t;
  SkinPoint near;
  Real slope;
};

Along along(const SkinQuery& k, const EdgeTest& e, Real t, const nurbs::Place* start = nullptr) {
  const Vec3 p = e.from + t * e.way;
  const SkinPoint near = start ? nearest_on(k.skin, p, *start) : nearest_on(k.skin, p);
  return {t, near, glm::dot(near.normal, e.way)};
}

/// Finds the minimum between two points where the distance falls and rises. Regula falsi with the
/// value of the retained end halved (Illinois). [Dowell & Jarratt 1971]
void refine_edge(const SkinQuery& k, const EdgeTest& e, Along low, Along high) {
  int stays = 0;
  Along best = low.near.distance < high.near.distance ? low : high;
  for (int round = 0; round < kMostRefinements; ++round) {
    const Real t = (low.t * high.slope - high.t * low.slope) / (high.slope - low.slope);
    if (!(std::abs(t - best.t) > 1e-12)) break;
    best = along(k, e, t, &best.near.at);
    if (best.slope == 0) break;
    if (best.slope < 0) {
      low = best;
      if (stays == 1) high.slope /= 2;
      stays = 1;
    } else {
      high = best;
      if (stays == -1) low.slope /= 2;
      stays = -1;
    }
  }
  const auto part = static_cast<std::uint64_t>(best.t * (kSamples - 1));
  add_ball(k, {e.from + best.t * e.way, e.radius, e.feature | part << 16}, best.near);
}

/// Adds the local minima of the distance along an edge, where the normal is perpendicular to it.
/// Parts that are too far away are skipped: the distance changes no faster than the position.
void touch_edge(const SkinQuery& k, const EdgeTest& e) {
  const Real length = glm::length(e.way), reach = k.out.margin + e.radius;
  const Along middle = along(k, e, 0.5);
  if (middle.near.distance - length / 2 > reach) return;
  std::array<std::optional<Along>, kSamples> samples;
  samples[kSamples / 2] = middle;
  for (int half : {0, 1}) {
    const int quarter = half == 0 ? kSamples / 4 : 3 * (kSamples / 4);
    samples[static_cast<std::size_t>(quarter)] = along(k, e, Real(quarter) / (kSamples - 1));
    if (samples[static_cast<std::size_t>(quarter)]->near.distance - length / 4 > reach) continue;
    for (int i = half * (kSamples / 2); i <= half * (kSamples / 2) + kSamples / 2; ++i)
      if (auto& s = samples[static_cast<std::size_t>(i)]; !s)
        s = along(k, e, Real(i) / (kSamples - 1));
  }
  const std::optional<Along>* last = nullptr;
  for (const std::optional<Along>& s : samples) {
    if (!s) continue;
    if (last && (*last)->slope < 0 && s->slope > 0) refine_edge(k, e, **last, *s);
    last = &s;
  }
}

/// The signed distance of the other shape as a function of the position on the skin.
struct Depth {
  const PlacedShape& other;
  Real step;  // m

  SurfacePoint at(Vec3 p) const {
    const Vec3 local = glm::conjugate(other.at.rotation) * (p - other.at.position);
    if (other.shape.kind == ShapeKind::nurbs && !other.shape.surface->skin->is_solid_ellipsoid()) {
      const SkinPoint on = nearest_on(*other.shape.surface, local);
      return {to_world(other.at, on.point), other.at.rotation * on.normal, on.distance};
    }
    const auto near = closest(other.shape, local, 1e300);
    if (!near) return {p, {0, 1, 0}, 1e300};
    return {to_world(other.at, near->point), other.at.rotation * near->normal, near->distance};
  }
  nurbs::Slope operator()(const nurbs::Jet& j) const {
    const SurfacePoint here = at(j.s);
    const Vec3 n = here.normal;
    // Derivative of the other's normal along the surface.
    const auto turn = [&](Vec3 way) {
      const Real length = glm::length(way);
      if (!(length > 0)) return Vec3(0);
      return (at(j.s + step / length * way).normal - n) * (length / step);
    };
    const Vec3 along_u = turn(j.u), along_v = turn(j.v);
    return {here.distance,
            glm::dot(n, j.u),
            glm::dot(n, j.v),
            glm::dot(n, j.uu) + glm::dot(along_u, j.u),
            glm::dot(n, j.uv) + (glm::dot(along_u, j.v) + glm::dot(along_v, j.u)) / 2,
            glm::dot(n, j.vv) + glm::dot(along_v, j.v)};
  }
};

/// Lists the seeds near the other shape, by number. The deepest point is within the spacing of one.
void find_candidates(const SkinQuery& k, const Depth& depth) {
  const SkinModel& m = *k.skin.model;
  auto& found = k.scratch.candidates;
  found.clear();
  m.seed_tree.query(k.reach, [&](std::uint32_t seed) {
    if (k.leaves_flats && !m.seed_is_round[seed]) return;
    const Real gap = depth.at(m.seed_points[seed]).distance;
    if (gap <= k.out.margin + m.spacing) found.push_back({gap, seed});
  });
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.seed < b.seed; });
}

/// Descends across a valley, not along it, to its floor beside the start.
nurbs::WalkEnd cross_valley(const SkinQuery& k, const Depth& depth, nurbs::Place at) {
  const nurbs::Face& face = k.skin.skin->face(at.face);
  const auto run = [](const nurbs::Knots& knots, Real t) {
    return knots.is_periodic ? knots.inside(t) : knots.domain().clamped(t);
  };
  for (int round = 0; round < kMostCrossings; ++round) {
    const nurbs::Jet j = face.at(at.u, at.v);
    const nurbs::Slope h = depth(j);
    // Direction of the largest principal curvature: the larger root of |H - k G| = 0.
    const Real uu = glm::dot(j.u, j.u), uv = glm::dot(j.u, j.v), vv = glm::dot(j.v, j.v);
    const Real determinant = uu * vv - uv * uv;
    if (!(determinant > 0)) break;
    const Real mean = (h.huu * vv - 2 * h.huv * uv + h.hvv * uu) / (2 * determinant);
    const Real gauss = (h.huu * h.hvv - h.huv * h.huv) / determinant;
    const Real most = mean + std::sqrt(std::max(mean * mean - gauss, Real(0)));
    if (!(most > 0)) break;
    const Real a = h.huu - most * uu, c = h.hvv - most * vv, m = h.huv - most * uv;
    const Vec3 way = std::abs(a) > std::abs(c) ? Vec3(-m, a, 0) : Vec3(c, -m, 0);
    const Real bend = h.huu * way.x * way.x + 2 * h.huv * way.x * way.y + h.hvv * way.y * way.y;
    if (!(bend > 0)) break;
    const Real step = -(h.gu * way.x + h.gv * way.y) / bend;
    at.u = run(face.u(), at.u + step * way.x), at.v = run(face.v(), at.v + step * way.y);
    if (std::abs(step) * glm::length(way.x * j.u + way.y * j.v) < 1e-12 * k.skin.model->size) break;
  }
  return {at, face.at(at.u, at.v), 0, false};
}

/// Acceptance test of a point of the skin: its normal opposes that of the other shape within
/// `angle`, rad.
struct PointTest {
  std::uint64_t feature;
  Real angle;
};

void add_place(const SkinQuery& k, const Depth& depth, const nurbs::WalkEnd& end,
               const PointTest& as) {
  if (!k.skin.skin->holds(end.at)) return;
  const SurfacePoint near = depth.at(end.jet.s);
  if (near.distance > k.out.margin) return;
  const Vec3 own = nurbs::normal_at(k.skin.skin->face(end.at.face), end.at.u, end.at.v);
  if (glm::length(own + near.normal) > as.angle) return;  // belongs to an edge or a rim
  k.out.points.push_back({near.point, end.jet.s, -near.normal, near.distance, as.feature});
}

/// Adds the deepest points of the skin: by descent from the deepest seed, and on the valley floors
/// beside seeds far from one another, so that flat contacts get points all over.
void touch_places(const SkinQuery& k) {
  const SkinModel& m = *k.skin.model;
  const Depth depth{k.other, kDifference * m.size};
  find_candidates(k, depth);
  auto& found = k.scratch.candidates;
  if (found.empty()) return;
  const auto deepest = std::min_element(found.begin(), found.end(),
                                        [](const auto& a, const auto& b) { return a.gap < b.gap; });
  add_place(k, depth, nurbs::Walk(*k.skin.skin, depth).from(m.seeds[deepest->seed]),
            {kOfFace, kOpposed});
  std::uint32_t start = found.front().seed;
  for (auto& c : found) c.gap = 1e300;  // from here on the distance to the starts
  for (std::size_t i = 0; i < kMostStarts; ++i) {
    const nurbs::WalkEnd end = cross_valley(k, depth, m.seeds[start]);
    if (glm::distance(end.jet.s, m.seed_points[start]) < m.spacing + kApart * m.size)
      add_place(k, depth, end, {kOfFace | static_cast<std::uint64_t>(start + 1) << 16, kFlat});
    const auto* farthest = &found.front();
    for (auto& c : found) {
      c.gap = std::min(c.gap, glm::distance(m.seed_points[c.seed], m.seed_points[start]));
      if (c.gap > farthest->gap) farthest = &c;
    }
    if (farthest->gap < kApart * m.size) break;
    start = farthest->seed;
  }
}

/// Collides balls and capsules by their cores.
void touch_core(const SkinQuery& k, const Convex& c) {
  const Aabb box = Aabb{k.skin.low, k.skin.high}.grown(c.radius + std::max(k.out.margin, Real(0)) +
                                                       (k.skin.model->is_closed ? 0 : k.size));
  const auto is_near = [&](Vec3 p) { return box.overlaps({p, p}); };
  for (std::uint32_t i = 0; i < c.points.size(); ++i)
    if (is_near(c.points[i]))
      add_ball(k, {c.points[i], c.radius, i}, nearest_on(k.skin, c.points[i]));
  for (std::uint32_t e = 0; e < c.edges.size(); ++e) {
    const Vec3 from = c.points[c.edges[e][0]], to = c.points[c.edges[e][1]];
    Aabb around;
    around.add(from), around.add(to);
    if (box.overlaps(around)) touch_edge(k, {from, to - from, c.radius, kOfEdge | e});
  }
}

/// Whether a flat face touches a shape by corners and edges of both alone.
bool has_corners(const Shape& shape, const Convex* piece) {
  return piece ? !piece->smooth : traits_of(shape.kind).shape_class == ShapeClass::half_space;
}

void touch(SkinQuery k) {
  const Shape& shape = k.other.shape;
  Convex piece;
  if (is_convex(shape.kind)) piece = convex_piece(shape, k.other.at, k.scratch.piece);
  if (is_convex(shape.kind) && !piece.smooth && piece.faces.empty()) return touch_core(k, piece);
  k.leaves_flats = has_corners(shape, is_convex(shape.kind) ? &piece : nullptr);
  touch_places(k);
  touch_edges(k.skin, k.other, k.scratch, k.out);
}

}  // namespace

void collide_skin(const Surface& surface, const PlacedShape& other, SkinScratch& scratch,
                  const PointsOut& out) {
  const Real margin = std::max(out.margin, Real(0));
  const Aabb own{surface.low, surface.high};
  Aabb reach = own;
  Real size = surface.model->size;
  if (!is_unbounded(other.shape.kind)) {
    const Aabb box = bounds_of(other.shape, other.at);
    size = glm::length(box.high - box.low) / 2;
    reach = box.grown(margin);
    const Real behind = surface.model->is_closed ? 0 : size;
    if (!reach.grown(behind).overlaps(own)) return;
  }
  const SkinQuery k{surface, other, scratch, out, reach, size};
  const std::size_t first = out.points.size();
  touch(k);
  drop_duplicates(out.points, first, 1e-4 * surface.model->size);
  reduce_points(out.points, first, kMostPoints, 1e-6 * surface.model->size);
}

}  // namespace pantin::detail
