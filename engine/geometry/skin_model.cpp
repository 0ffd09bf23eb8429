#include "engine/geometry/skin_model.hpp"

#include <algorithm>
#include <cmath>

#include "engine/geometry/surface.hpp"
#include "engine/nurbs/walk.hpp"

namespace pantin::detail {
namespace {

constexpr Real kChord = 5e-4;   // of the size
constexpr Real kCoarse = 1e-2;  // of the size: chord between seeds
constexpr Real kConvex = 1e-7;  // of the size: how far a vertex may stand out of a tangent plane
constexpr std::size_t kMostCompared = 1500;  // vertices, in the test of convexity
constexpr int kBins = 6;                     // along each edge of a cube of directions
constexpr Real kPlanar = 1e-10;              // of a face's size
constexpr Real kCrease = 1e-6;               // of 1 - cosine

using nurbs::Skin;

/// The bin of a direction: a side of the cube, and a square on it.
std::size_t bin_of(Vec3 d) {
  const Vec3 size = glm::abs(d);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto cell = [&](Real x) {
    const Real at = (x / size[axis] + 1) / 2 * kBins;
    return std::clamp(static_cast<int>(at), 0, kBins - 1);
  };
  const int side = 2 * axis + (d[axis] < 0 ? 1 : 0);
  return static_cast<std::size_t>((side * kBins + cell(d[(axis + 1) % 3])) * kBins +
                                  cell(d[(axis + 2) % 3]));
}

Vec3 middle_of_bin(int bin) {
  const int side = bin / (kBins * kBins), axis = side / 2;
  Vec3 d(0);
  d[axis] = side % 2 == 0 ? 1 : -1;
  d[(axis + 1) % 3] = (bin / kBins % kBins + 0.5) * 2 / kBins - 1;
  d[(axis + 2) % 3] = (bin % kBins + 0.5) * 2 / kBins - 1;
  return glm::normalize(d);
}

std::uint32_t farthest_vertex(const nurbs::Tessellation& tiles, Vec3 direction) {
  std::uint32_t best = 0;
  Real most = -1e300;
  for (std::uint32_t i = 0; i < tiles.points.size(); ++i)
    if (const Real way = glm::dot(direction, tiles.points[i]); way > most) most = way, best = i;
  return best;
}

bool is_singular(const nurbs::Face& face, const nurbs::Place& at) {
  const nurbs::Jet j = face.at(at.u, at.v);
  const Real wide =
      glm::length(glm::cross(j.u, j.v)) * face.u().domain().width() * face.v().domain().width();
  return wide < 1e-9 * face.size() * face.size();
}

/// Whether every vertex is below every tangent plane.
bool is_convex_by(const Skin& skin, const SkinModel& m) {
  const nurbs::Tessellation& t = m.tiles;
  const std::size_t every = 1 + (t.points.size() - 1) / kMostCompared;
  for (std::size_t i = 0; i < t.points.size(); i += every) {
    if (is_singular(skin.face(t.places[i].face), t.places[i])) continue;
    for (std::size_t j = 0; j < t.points.size(); j += every)
      if (glm::dot(t.normals[i], t.points[j] - t.points[i]) > kConvex * m.size) return false;
  }
  return true;
}

/// Bounds of the surface itself, by ascent from all vertices that may lead to an extremum.
void find_bounds(const Skin& skin, SkinModel& m) {
  for (int k = 0; k < 3; ++k)
    for (const Real sign : {-1.0, 1.0}) {
      Vec3 d(0);
      d[k] = sign;
      const Real most = glm::dot(d, m.tiles.points[farthest_vertex(m.tiles, d)]);
      Real reach = most;
      for (std::size_t i = 0; i < m.tiles.points.size(); ++i)
        if (glm::dot(d, m.tiles.points[i]) >= most - m.chord / 4)
          reach = std::max(reach, -nurbs::climb(skin, d, m.tiles.places[i]).f);
      (sign < 0 ? m.low : m.high)[k] = sign * reach;
    }
}

void build_tree(SkinModel& m) {
  std::vector<Aabb> boxes;
  for (const auto& t : m.tiles.triangles) {
    Aabb box;
    for (const std::uint32_t corner : t) box.add(m.tiles.points[corner]);
    boxes.push_back(box.grown(m.chord));
  }
  m.tree.build(boxes);
}

/// The plane of a piece of a face, if the piece is flat; tested on a grid of points.
struct Plane {
  Vec3 normal{0}, point{0};
};
std::optional<Plane> plane_of(const nurbs::Face& face, nurbs::Range u, nurbs::Range v) {
  constexpr int kRows = 5;
  const nurbs::Face::Piece piece = face.piece_at(u.middle(), v.middle());
  const nurbs::Jet middle = face.at(piece, u.middle(), v.middle());
  const Vec3 cross = glm::cross(middle.u, middle.v);
  if (!(glm::length(cross) > 0)) return std::nullopt;
  const Plane plane{glm::normalize(cross), middle.s};
  for (int i = 0; i < kRows; ++i)
    for (int j = 0; j < kRows; ++j) {
      const Vec3 p =
          face.at(piece, u.low + u.width() * i / (kRows - 1), v.low + v.width() * j / (kRows - 1))
              .s;
      if (std::abs(glm::dot(plane.normal, p - plane.point)) > kPlanar * face.size())
        return std::nullopt;
    }
  return plane;
}

std::vector<Plane> planes_of(const nurbs::Face& face) {
  std::vector<Plane> planes;
  const std::vector<Real> us = face.u().breaks(), vs = face.v().breaks();
  for (std::size_t i = 0; i + 1 < us.size(); ++i)
    for (std::size_t j = 0; j + 1 < vs.size(); ++j)
      if (const auto plane = plane_of(face, {us[i], us[i + 1]}, {vs[j], vs[j + 1]}))
        planes.push_back(*plane);
  return planes;
}

/// Finds the normals of triangles, the triangles of flat pieces, and the seeds off flat pieces.
void find_flats(const Skin& skin, SkinModel& m) {
  std::vector<std::vector<Plane>> planes;
  for (const nurbs::Face& face : skin.faces()) planes.push_back(planes_of(face));
  const auto plane_at = [&](std::span<const Vec3> points, int face) -> const Plane* {
    const Real least = 10 * kPlanar * skin.face(face).size();
    for (const Plane& plane : planes[static_cast<std::size_t>(face)])
      if (std::all_of(points.begin(), points.end(), [&](Vec3 p) {
            return std::abs(glm::dot(plane.normal, p - plane.point)) <= least;
          }))
        return &plane;
    return nullptr;
  };
  for (const auto& t : m.tiles.triangles) {
    const Vec3 p[] = {m.tiles.points[t[0]], m.tiles.points[t[1]], m.tiles.points[t[2]]};
    const Vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
    const Real area = glm::length(cross);
    const Plane* plane = plane_at(p, m.tiles.places[t[0]].face);
    m.flat.push_back(plane ? 1 : 0);
    m.normals.push_back(plane ? plane->normal : area > 0 ? cross / area : m.tiles.normals[t[0]]);
  }
  for (std::size_t i = 0; i < m.seeds.size(); ++i)
    m.seed_is_round.push_back(plane_at({&m.seed_points[i], 1}, m.seeds[i].face) ? 0 : 1);
}

void find_cones(SkinModel& m) {
  for (std::uint32_t node = 0; node < m.tree.node_count(); ++node) {
    NormalCone cone;
    for (const std::uint32_t i : m.tree.items_below(node)) cone.axis += m.normals[i];
    const Real length = glm::length(cone.axis);
    cone.axis = length > 0 ? cone.axis / length : Vec3(0);
    Real least = 1;
    for (const std::uint32_t i : m.tree.items_below(node))
      least = std::min(least, glm::dot(cone.axis, m.normals[i]));
    if (length > 0)
      cone.cosine = least, cone.sine = std::sqrt(std::max(1 - least * least, Real(0)));
    m.cones.push_back(cone);
  }
}

void scatter_seeds(const Skin& skin, SkinModel& m) {
  const nurbs::Tessellation coarse = nurbs::tessellate(skin, kCoarse * m.size);
  m.seed_points = coarse.points, m.seed_normals = coarse.normals, m.seeds = coarse.places;
  for (const auto& t : coarse.triangles)
    for (int k = 0; k < 3; ++k)
      m.spacing =
          std::max(m.spacing, glm::distance(coarse.points[t[k]], coarse.points[t[(k + 1) % 3]]));
  std::vector<Aabb> boxes;
  for (const Vec3 p : m.seed_points) boxes.push_back(Aabb{p, p}.grown(m.spacing));
  m.seed_tree.build(boxes);
}

MassProperties mass_of(const nurbs::Enclosed& in) {
  if (!(in.volume > 0)) return {};
  const Vec3 centre = in.first / in.volume;
  const Mat3 second = in.second - in.volume * glm::outerProduct(centre, centre);
  const Real trace = second[0][0] + second[1][1] + second[2][2];
  return {in.volume, centre, trace * Mat3(1) - second};
}

Vec3 place_normal(const Skin& skin, const nurbs::Place& at) {
  return nurbs::normal_at(skin.face(at.face), at.u, at.v);
}

/// On a crease the mean normal of both faces decides the side.
Vec3 side_normal(const Skin& skin, const nurbs::Place& at) {
  const nurbs::Face& face = skin.face(at.face);
  const Vec3 own = place_normal(skin, at);
  Vec3 sum = own;
  const auto add = [&](nurbs::Edge edge) {
    const auto beyond = skin.across(at, edge);
    if (!beyond) return;
    const Vec3 n = place_normal(skin, *beyond);
    if (1 - glm::dot(n, own) > kCrease) sum += n;
  };
  if (skin.half_axes()) return own;
  using enum nurbs::Edge;
  if (!face.u().is_periodic && at.u <= face.u().low()) add(u_low);
  if (!face.u().is_periodic && at.u >= face.u().high()) add(u_high);
  if (!face.v().is_periodic && at.v <= face.v().low()) add(v_low);
  if (!face.v().is_periodic && at.v >= face.v().high()) add(v_high);
  const Real length = glm::length(sum);
  return length > 1e-6 ? sum / length : own;
}

SkinPoint point_at(const Surface& surface, const nurbs::WalkEnd& end, Vec3 p) {
  SkinPoint found{end.at, end.jet.s, {}, 0, end.is_on_rim};
  const Vec3 way = p - found.point, n = side_normal(*surface.skin, end.at);
  const Real apart = glm::length(way);
  const bool is_behind = glm::dot(way, n) < 0;
  found.distance = is_behind ? -apart : apart;
  // Closer than this the direction between the points is lost to rounding.
  found.normal = apart > 1e-9 * surface.model->size ? (is_behind ? -way : way) / apart
                                                    : place_normal(*surface.skin, end.at);
  return found;
}

}  // namespace

SkinModel model_of(const Skin& skin) {
  SkinModel m;
  Aabb box;
  for (const nurbs::Face& face : skin.faces())
    for (const nurbs::Weighted& w : face.surface().points) box.add(w.point());
  m.size = glm::length(box.high - box.low) / 2;
  m.chord = kChord * m.size;
  m.tiles = nurbs::tessellate(skin, m.chord);
  find_bounds(skin, m);
  m.size = glm::length(m.high - m.low) / 2;
  build_tree(m);
  scatter_seeds(skin, m);
  find_flats(skin, m);
  find_cones(m);
  m.features = features_of(skin);
  m.is_closed = nurbs::is_closed(skin);
  if (!m.is_closed) return m;
  const nurbs::Enclosed in = nurbs::enclosed_by(skin);
  m.is_closed = !(in.volume < 0);
  if (!m.is_closed) return m;
  m.enclosed = mass_of(in);
  if (in.volume > 0) m.doubt = in.by.doubt / in.volume;
  m.is_convex = m.enclosed.mass > 0 && is_convex_by(skin, m);
  if (m.is_convex)
    for (int bin = 0; bin < 6 * kBins * kBins; ++bin)
      m.starts.push_back(farthest_vertex(m.tiles, middle_of_bin(bin)));
  return m;
}

Result<std::shared_ptr<const Surface>> make_skin(std::shared_ptr<const Skin> skin) {
  auto surface = std::make_shared<Surface>();
  auto model = std::make_shared<SkinModel>(model_of(*skin));
  surface->low = model->low, surface->high = model->high;
  if (model->is_closed && !(model->enclosed.mass > 0))
    return Error{"found a closed skin that encloses no volume, expected faces around a solid"};
  surface->skin = std::move(skin), surface->model = std::move(model);
  return std::shared_ptr<const Surface>(std::move(surface));
}

Vec3 way_from(const SkinModel& m, std::uint32_t triangle, Vec3 p) {
  const auto& t = m.tiles.triangles[triangle];
  return p - nearest_in({m.tiles.points[t[0]], m.tiles.points[t[1]], m.tiles.points[t[2]]}, p);
}

std::optional<std::uint32_t> nearest_tile_of(const SkinModel& m, Vec3 p, Real limit) {
  std::optional<std::uint32_t> tile;
  Real best = limit < 1e150 ? limit * limit : 1e300;
  m.tree.nearest(p, best, [&](std::uint32_t i) {
    const Vec3 way = way_from(m, i, p);
    const Real d = glm::dot(way, way);
    if (d < best) best = d, tile = i;
    return d;
  });
  return tile;
}

SkinPoint nearest_on(const Surface& surface, Vec3 p) {
  const SkinModel& m = *surface.model;
  const std::uint32_t tile = nearest_tile_of(m, p, 1e300).value_or(0);
  std::uint32_t start = m.tiles.triangles[tile][0];
  for (const std::uint32_t corner : m.tiles.triangles[tile])
    if (glm::distance(p, m.tiles.points[corner]) < glm::distance(p, m.tiles.points[start]))
      start = corner;
  return point_at(surface, nurbs::approach(*surface.skin, p, m.tiles.places[start]), p);
}

SkinPoint nearest_on(const Surface& surface, Vec3 p, const nurbs::Place& start) {
  return point_at(surface, nurbs::approach(*surface.skin, p, start), p);
}

SkinPoint place_on(const Surface& surface, const nurbs::Place& at, Vec3 p) {
  return point_at(surface, {at, surface.skin->face(at.face).at(at.u, at.v), 0, false}, p);
}

SkinPoint farthest_on(const Surface& surface, Vec3 direction) {
  const SkinModel& m = *surface.model;
  const std::uint32_t start =
      m.is_convex ? m.starts[bin_of(direction)] : farthest_vertex(m.tiles, direction);
  const nurbs::WalkEnd end = nurbs::climb(*surface.skin, direction, m.tiles.places[start]);
  return {end.at, end.jet.s, {}, 0, end.is_on_rim};
}

}  // namespace pantin::detail
