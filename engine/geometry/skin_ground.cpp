#include "engine/geometry/skin_ground.hpp"

#include <algorithm>
#include <cmath>

#include "engine/geometry/surface.hpp"
#include "engine/nurbs/tessellate.hpp"

namespace pantin::detail {
namespace {

constexpr Real kTilt = 0.3;    // rad, by which a corner's directions may lead behind a face
constexpr Real kFacet = 0.15;  // rad, between a round face and its triangles
// Fractions of the smaller size: greatest depth in a closed skin; depth from which a point must be
// inside the other body to count; how far beside a face a corner is still over it.
constexpr Real kDeepest = 0.2, kShallow = 1e-3, kBeside = 1e-4;
constexpr Real kBehind = 2;  // of the other's size: greatest depth behind a patch

bool admits(const Corner& corner, Vec3 normal, Real tilt) {
  for (std::uint32_t i = 0; i < corner.count; ++i)
    if (glm::dot(corner.ways[i], normal) < -tilt) return false;
  return true;
}

}  // namespace

Reach reach_between(Real margin, Real size_a, Real size_b) {
  const Real size = std::min(size_a, size_b);
  return {margin, kDeepest * size, kShallow * size, kBeside * size};
}

Reach reach_into(const Surface& surface, Real size, Real margin) {
  Reach r = reach_between(margin, surface.model->size, size);
  if (!surface.model->is_closed) r.deepest = kBehind * size;
  return r;
}

bool SkinTarget::holds(Vec3 p) const {
  return !surface.model->is_closed || nearest_on(surface, p).distance <= reach.beside;
}

bool SkinTarget::is_round_near(const Aabb& box) const {
  const SkinModel& m = *surface.model;
  bool found = false;
  m.tree.query(box.grown(reach.farthest()), [&](std::uint32_t i) { found |= !m.flat[i]; });
  return found;
}

std::optional<Foot> SkinTarget::over(std::uint32_t tile, const Corner& corner) const {
  const SkinModel& m = *surface.model;
  const Vec3 p = corner.point;
  if (m.flat[tile]) {
    const Vec3 n = m.normals[tile];
    const Real gap = glm::dot(n, p - m.tiles.points[m.tiles.triangles[tile][0]]);
    return Foot{p - gap * n, n, gap};
  }
  std::uint32_t start = m.tiles.triangles[tile][0];
  for (const std::uint32_t k : m.tiles.triangles[tile])
    if (glm::distance(p, m.tiles.points[k]) < glm::distance(p, m.tiles.points[start])) start = k;
  const SkinPoint on = nearest_on(surface, p, m.tiles.places[start]);
  const Vec3 n = nurbs::normal_at(surface.skin->face(on.at.face), on.at.u, on.at.v);
  const Real gap = glm::dot(n, p - on.point);
  if (!admits(corner, n, kTilt) || glm::distance(p, on.point + gap * n) > reach.beside)
    return std::nullopt;
  return Foot{on.point, n, gap};
}

/// The nearest triangle that a corner is over and may touch.
std::optional<std::uint32_t> SkinTarget::tile_under(const Corner& corner, Real far) const {
  const SkinModel& m = *surface.model;
  const Vec3 p = corner.point;
  std::optional<std::uint32_t> tile;
  m.tree.nearest(p, far * far, [&](std::uint32_t i) {
    constexpr Real kNone = 1e300;
    const Vec3 n = m.normals[i];
    const bool is_flat = m.flat[i];
    if (!admits(corner, n, kTilt + (is_flat ? 0 : kFacet))) return kNone;
    const Vec3 way = way_from(m, i, p);
    const Real along = glm::dot(way, n), square = glm::dot(way, way);
    const Real beside =
        reach.beside + (is_flat ? 0 : m.chord + kFacet * (std::abs(along) + m.chord));
    if (square - along * along > beside * beside || along > reach.margin + m.chord) return kNone;
    if (square < far * far) tile = i;
    return square;
  });
  return tile;
}

std::optional<Foot> SkinTarget::foot(const Corner& corner) const {
  const SkinModel& m = *surface.model;
  const Vec3 p = corner.point;
  const Real far = reach.farthest() + m.chord;
  const auto nearest = nearest_tile_of(m, p, far);
  if (!nearest) return std::nullopt;
  const Vec3 way = way_from(m, *nearest, p);
  const Real apart = glm::length(way);
  if (apart > reach.margin + 2 * m.chord && glm::dot(way, m.normals[*nearest]) > 0)
    return std::nullopt;
  auto tile = tile_under(corner, std::min(far, 1.1 * apart + reach.beside + m.chord));
  if (!tile) tile = tile_under(corner, far);
  if (!tile) return std::nullopt;
  const auto found = over(*tile, corner);
  if (!found || found->gap > reach.margin || found->gap < -reach.deepest) return std::nullopt;
  if (found->gap < -reach.shallow && !holds(p)) return std::nullopt;
  return found;
}

bool ConvexTarget::holds(Vec3 p) const {
  return std::all_of(piece.faces.begin(), piece.faces.end(), [&](const Face& f) {
    return glm::dot(f.normal, p) - f.offset <= reach.beside;
  });
}

bool ConvexTarget::is_over(const Face& face, Vec3 p) const {
  for (std::uint32_t i = 0; i < face.count; ++i) {
    const Vec3 from = piece.points[piece.corners[face.first + i]];
    const Vec3 way = piece.points[piece.corners[face.first + (i + 1) % face.count]] - from;
    if (glm::dot(glm::cross(face.normal, way), p - from) < -reach.beside * glm::length(way))
      return false;
  }
  return true;
}

std::optional<Foot> ConvexTarget::foot(const Corner& corner) const {
  const Vec3 p = corner.point;
  std::optional<Foot> best;
  for (const Face& f : piece.faces) {
    const Real gap = glm::dot(f.normal, p) - f.offset;
    if (gap > reach.margin || gap < -reach.deepest || (best && gap < best->gap)) continue;
    if (admits(corner, f.normal, kTilt) && is_over(f, p))
      best = Foot{p - gap * f.normal, f.normal, gap};
  }
  if (best && best->gap < -reach.shallow && !holds(p)) return std::nullopt;
  return best;
}

std::optional<Foot> ShapeTarget::foot(const Corner& corner) const {
  const Vec3 local = glm::conjugate(shape.at.rotation) * (corner.point - shape.at.position);
  const auto near = closest(shape.shape, local, std::max(reach.margin, Real(0)));
  if (!near || near->distance > reach.margin) return std::nullopt;
  const Vec3 n = shape.at.rotation * near->normal;
  if (!admits(corner, n, kTilt)) return std::nullopt;
  return Foot{to_world(shape.at, near->point), n, near->distance};
}

}  // namespace pantin::detail
