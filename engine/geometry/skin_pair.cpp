// Contacts of two skins of which one at least is not convex: common normals near one another, and
// corners and edges.
#include <algorithm>
#include <cmath>

#include "engine/geometry/skin_edges.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/common_normal.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kMostPoints = 8, kMostStarts = 12;
constexpr Real kApart = 0.15;    // of the smaller size, between starts
constexpr Real kDeepest = 0.1;   // likewise: overlaps deeper than this are of the far side
constexpr Real kShallow = 1e-3;  // likewise: below, a look whether it is inside
constexpr Real kFacing = -0.7;   // cosine between normals where to start
constexpr std::uint64_t kOfA = 6ull << 40, kOfB = 7ull << 40;

/// Seeds of one skin against the faces of another, in the frame of that.
struct Seeking {
  const Surface& from;
  const Surface& to;
  Pose at;  // of `from`
  Real margin, size;
};

/// The seeds of round places near the other skin's faces that face them, by number, with gaps.
/// `only_flat`: those near its flat places, since the others are sought from the other side.
template <class Counts>
void find_seeds(const Seeking& k, std::vector<SkinScratch::Candidate>& found,
                const Counts& counts) {
  found.clear();
  const SkinModel &m = *k.from.model, &other = *k.to.model;
  const Quat back = glm::conjugate(k.at.rotation);
  Aabb box;
  for (int i = 0; i < 8; ++i)
    box.add(back * (Vec3(i & 1 ? k.to.high.x : k.to.low.x, i & 2 ? k.to.high.y : k.to.low.y,
                         i & 4 ? k.to.high.z : k.to.low.z) -
                    k.at.position));
  const Real near = k.margin + m.spacing, far = std::max(near, kDeepest * k.size);
  m.seed_tree.query(box.grown(k.margin), [&](std::uint32_t seed) {
    if (!m.seed_is_round[seed]) return;
    const Vec3 p = to_world(k.at, m.seed_points[seed]);
    const nurbs::Place& at = m.seeds[seed];
    const Vec3 n =
        k.at.rotation * nurbs::normal_at(k.from.skin->face(at.face), at.u, at.v);
    std::uint32_t tile = UINT32_MAX;
    Real best = 1e300;
    other.tree.nearest(p, far * far, [&](std::uint32_t i) {
      constexpr Real kNone = 1e300;
      if (!counts(i) || glm::dot(other.normals[i], n) > kFacing) return kNone;
      const auto& t = other.tiles.triangles[i];
      const auto& v = other.tiles.points;
      const Vec3 way = p - nearest_in({v[t[0]], v[t[1]], v[t[2]]}, p);
      const Real square = glm::dot(way, way);
      if (square < best) best = square, tile = i;
      return square;
    });
    if (tile == UINT32_MAX || best > far * far) return;
    const Real gap =
        glm::dot(other.normals[tile], p - other.tiles.points[other.tiles.triangles[tile][0]]);
    if (gap <= near) found.push_back({gap, seed, tile});
  });
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a.gap != b.gap ? a.gap < b.gap : a.seed < b.seed;
  });
}

bool holds(const Surface& surface, Vec3 p) {
  return !surface.model->is_closed || nearest_on(surface, p).distance <= 0;
}

/// The common normal near a start, if there is one that is of use.
void add_normal(const SkinPair& pair, const nurbs::PlacePair& start, Real size,
                const PointsOut& out, std::uint64_t feature) {
  const nurbs::CommonNormal c =
      nurbs::track_newton({*pair.a.skin, *pair.b.skin, pair.a_in_b}, start);
  if (c.status != nurbs::ContactStatus::found || !(c.least_curvature > 0)) return;
  if (c.gap > out.margin || c.gap < -kDeepest * size) return;
  if (c.gap < -kShallow * size && !holds(pair.b, c.on_a)) return;
  out.points.push_back({c.on_a, c.on_b, c.normal, c.gap, feature});
}

/// From the deepest seeds that are apart from one another.
template <class Start>
void start_apart(const Seeking& k, std::span<const SkinScratch::Candidate> found,
                 const Start& start) {
  std::array<Vec3, kMostStarts> taken;
  std::size_t count = 0;
  for (const auto& c : found) {
    const Vec3 p = k.from.model->seed_points[c.seed];
    const bool is_new = std::none_of(taken.begin(), taken.begin() + std::ptrdiff_t(count), [&](Vec3 q) {
      return glm::distance(p, q) < kApart * k.size;
    });
    if (!is_new) continue;
    start(c);
    taken[count++] = p;
    if (count == kMostStarts) return;
  }
}

nurbs::Place place_of_tile(const Surface& s, std::uint32_t tile) {
  return s.model->tiles.places[s.model->tiles.triangles[tile][0]];
}

void touch_normals(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out) {
  const auto& [a, b, a_in_b] = pair;
  const Real size = std::min(a.model->size, b.model->size), margin = std::max(out.margin, Real(0));
  const Seeking from_a{a, b, a_in_b, margin, size};
  find_seeds(from_a, scratch.candidates, [](std::uint32_t) { return true; });
  start_apart(from_a, scratch.candidates, [&](const SkinScratch::Candidate& c) {
    add_normal(pair, {a.model->seeds[c.seed], place_of_tile(b, c.tile)}, size, out,
               kOfA | (c.seed + 1));
  });
  const Seeking from_b{b, a, inverse(a_in_b), margin, size};
  find_seeds(from_b, scratch.candidates,
             [&](std::uint32_t tile) { return a.model->flat[tile] != 0; });
  start_apart(from_b, scratch.candidates, [&](const SkinScratch::Candidate& c) {
    add_normal(pair, {place_of_tile(a, c.tile), b.model->seeds[c.seed]}, size, out,
               kOfB | (c.seed + 1));
  });
}

}  // namespace

void collide_skins(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out) {
  const std::size_t first = out.points.size();
  const Real size = std::min(pair.a.model->size, pair.b.model->size);
  touch_normals(pair, scratch, out);
  touch_edges(pair, scratch, out);
  drop_duplicates(out.points, first, 1e-4 * size);
  reduce_points(out.points, first, kMostPoints, 1e-6 * size);
}

}  // namespace pantin::detail
