// Convex hulls: quickhull on triangles, then coplanar neighbours are merged.
#include <algorithm>
#include <map>
#include <numeric>

#include "engine/base/invariants.hpp"
#include "engine/geometry/surface.hpp"

namespace pantin::detail {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;
constexpr std::size_t kMostCorners = 256;
constexpr std::size_t kMostRaised = 16 * kMostCorners;  // before flat neighbours are joined

struct Facet {
  std::array<std::uint32_t, 3> corners;
  std::array<std::uint32_t, 3> across;  // facet beyond the edge from corner i to the next
  Vec3 normal{0};
  Real offset = 0;
  std::vector<std::uint32_t> above;  // points that see it and no earlier facet
  bool gone = false;
};

class Quickhull {
 public:
  Quickhull(std::span<const Vec3> points, Real flat) : points_(points), flat_(flat) {}

  /// False if the points lie in a plane.
  bool start();
  /// False if there are far more corners than a hull may have.
  bool grow();
  const std::vector<Facet>& facets() const { return facets_; }

 private:
  Real height(const Facet& f, std::uint32_t p) const {
    return glm::dot(f.normal, points_[p]) - f.offset;
  }
  std::uint32_t add(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void share(std::span<const std::uint32_t> orphans, std::uint32_t from);
  void raise(std::uint32_t facet, std::uint32_t apex);

  std::span<const Vec3> points_;
  Real flat_;  // m: closer points count as in a plane
  std::vector<Facet> facets_;
};

std::uint32_t Quickhull::add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  Facet f{{a, b, c}, {kNone, kNone, kNone}, Vec3(0), 0, {}, false};
  f.normal = glm::normalize(glm::cross(points_[b] - points_[a], points_[c] - points_[a]));
  f.offset = glm::dot(f.normal, points_[a]);
  facets_.push_back(std::move(f));
  return static_cast<std::uint32_t>(facets_.size() - 1);
}

bool Quickhull::start() {
  const auto farthest = [&](auto&& measure) {
    std::uint32_t best = 0;
    Real most = -1;
    for (std::uint32_t i = 0; i < points_.size(); ++i)
      if (const Real m = measure(points_[i]); m > most) most = m, best = i;
    return best;
  };
  const auto a = farthest([&](Vec3 p) { return glm::distance(p, points_[0]); });
  const Vec3 pa = points_[a];
  const auto b = farthest([&](Vec3 p) { return glm::distance(p, pa); });
  if (!(glm::distance(points_[b], pa) > flat_)) return false;
  const Vec3 along = glm::normalize(points_[b] - pa);
  const auto c = farthest([&](Vec3 p) { return glm::length(glm::cross(along, p - pa)); });
  if (!(glm::length(glm::cross(along, points_[c] - pa)) > flat_)) return false;
  const Vec3 up = glm::normalize(glm::cross(along, points_[c] - pa));
  const auto d = farthest([&](Vec3 p) { return std::abs(glm::dot(up, p - pa)); });
  const Real height = glm::dot(up, points_[d] - pa);
  if (!(std::abs(height) > flat_)) return false;
  const std::uint32_t e = height < 0 ? b : c, f = height < 0 ? c : b;  // (a, e, f) seen from below
  add(a, e, f), add(a, d, e), add(e, d, f), add(f, d, a);
  for (Facet& x : facets_)
    for (std::uint32_t i = 0; i < 3; ++i)
      for (std::uint32_t y = 0; y < 4; ++y)
        for (std::uint32_t j = 0; j < 3; ++j)
          if (facets_[y].corners[j] == x.corners[(i + 1) % 3] &&
              facets_[y].corners[(j + 1) % 3] == x.corners[i])
            x.across[i] = y;
  std::vector<std::uint32_t> all(points_.size());
  std::iota(all.begin(), all.end(), 0u);
  share(all, 0);
  return true;
}

/// Assigns each point to the first facet from number `from` on that it lies above; others are
/// inside.
void Quickhull::share(std::span<const std::uint32_t> orphans, std::uint32_t from) {
  for (std::uint32_t p : orphans)
    for (std::uint32_t f = from; f < facets_.size(); ++f)
      if (!facets_[f].gone && height(facets_[f], p) > flat_) {
        facets_[f].above.push_back(p);
        break;
      }
}

bool Quickhull::grow() {
  std::size_t raised = 0;
  for (std::uint32_t f = 0; f < facets_.size(); ++f) {
    if (facets_[f].gone || facets_[f].above.empty()) continue;
    if (++raised > kMostRaised) return false;
    std::uint32_t apex = facets_[f].above[0];
    for (std::uint32_t p : facets_[f].above)
      if (height(facets_[f], p) > height(facets_[f], apex)) apex = p;
    raise(f, apex);
  }
  return true;
}

/// Replaces the facets visible from `apex` by a cone to it. Coplanar facets are replaced too, so
/// that no new triangle is coplanar with a remaining one.
void Quickhull::raise(std::uint32_t facet, std::uint32_t apex) {
  std::vector<std::uint32_t> seen{facet}, orphans;
  facets_[facet].gone = true;
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::uint32_t next : facets_[seen[i]].across)
      if (!facets_[next].gone && height(facets_[next], apex) > -flat_)
        facets_[next].gone = true, seen.push_back(next);

  const auto first_new = static_cast<std::uint32_t>(facets_.size());
  std::map<std::uint32_t, std::uint32_t> leaving;  // by the first corner of the rim's edge
  for (std::uint32_t s : seen) {
    orphans.insert(orphans.end(), facets_[s].above.begin(), facets_[s].above.end());
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t beyond = facets_[s].across[i];
      if (facets_[beyond].gone) continue;
      const std::uint32_t a = facets_[s].corners[i], b = facets_[s].corners[(i + 1) % 3];
      const std::uint32_t made = add(a, b, apex);
      facets_[made].across[0] = beyond;
      for (std::uint32_t j = 0; j < 3; ++j)
        if (facets_[beyond].corners[j] == b && facets_[beyond].corners[(j + 1) % 3] == a)
          facets_[beyond].across[j] = made;
      leaving[a] = made;
    }
  }
  for (std::uint32_t f = first_new; f < facets_.size(); ++f) {
    const std::uint32_t next = leaving[facets_[f].corners[1]];
    facets_[f].across[1] = next, facets_[next].across[2] = f;
  }
  share(orphans, first_new);
}

/// Coplanar facets get the same number; removed facets none.
std::vector<std::uint32_t> group_flat(const std::vector<Facet>& facets,
                                      std::span<const Vec3> points, Real flat) {
  std::vector<std::uint32_t> group(facets.size(), kNone), stack;
  std::uint32_t groups = 0;
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    if (facets[f].gone || group[f] != kNone) continue;
    stack.assign(1, f);
    group[f] = groups;
    while (!stack.empty()) {
      const std::uint32_t at = stack.back();
      stack.pop_back();
      for (std::uint32_t next : facets[at].across) {
        if (group[next] != kNone) continue;
        const auto in_plane = [&](std::uint32_t c) {
          return std::abs(glm::dot(facets[f].normal, points[c]) - facets[f].offset) <= flat;
        };
        if (glm::dot(facets[f].normal, facets[next].normal) > 0.9 &&
            std::all_of(facets[next].corners.begin(), facets[next].corners.end(), in_plane))
          group[next] = groups, stack.push_back(next);
      }
    }
    ++groups;
  }
  return group;
}

using Loop = std::vector<std::uint32_t>;

/// The rim of each group, anticlockwise.
std::vector<Loop> rims(const std::vector<Facet>& facets, const std::vector<std::uint32_t>& group) {
  std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> next;  // group, corner, corner
  for (std::uint32_t f = 0; f < facets.size(); ++f)
    for (std::uint32_t i = 0; i < 3 && group[f] != kNone; ++i)
      if (group[facets[f].across[i]] != group[f])
        next[group[f]][facets[f].corners[i]] = facets[f].corners[(i + 1) % 3];
  std::vector<Loop> loops;
  for (const auto& [g, edges] : next) {
    Loop loop;
    std::uint32_t at = edges.begin()->first;
    do loop.push_back(at), at = edges.at(at);
    while (at != loop.front() && loop.size() <= edges.size());
    loops.push_back(std::move(loop));
  }
  return loops;
}

void add_edges(Surface& s) {
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> left;
  for (std::uint32_t f = 0; f < s.faces.size(); ++f)
    for (std::uint32_t i = 0; i < s.faces[f].count; ++i)
      left[{s.corners[s.faces[f].first + i],
            s.corners[s.faces[f].first + (i + 1) % s.faces[f].count]}] = f;
  for (const auto& [edge, face] : left)
    if (edge[0] < edge[1]) {
      const auto right = left.find({edge[1], edge[0]});
      s.edges.push_back(edge);
      s.sides.push_back({face, right == left.end() ? face : right->second});
    }
}

Surface assemble(std::span<const Vec3> points, std::vector<Loop> loops) {
  std::map<std::uint32_t, std::uint32_t> faces_at, index;
  for (const Loop& loop : loops)
    for (std::uint32_t c : loop) ++faces_at[c];
  Surface s;
  for (Loop& loop : loops) {
    // A vertex of only two faces lies on a straight edge.
    std::erase_if(loop, [&](std::uint32_t c) { return faces_at[c] < 3; });
    if (loop.size() < 3) continue;
    for (std::uint32_t c : loop) index[c] = 0;
  }
  for (auto& [from, to] : index) {
    to = static_cast<std::uint32_t>(s.points.size());
    s.points.push_back(points[from]);
  }
  for (const Loop& loop : loops) {
    if (loop.size() < 3) continue;
    Face face{static_cast<std::uint32_t>(s.corners.size()), static_cast<std::uint32_t>(loop.size()),
              Vec3(0), 0};
    for (std::uint32_t c : loop) s.corners.push_back(index[c]);
    for (std::size_t i = 1; i + 1 < loop.size(); ++i)
      face.normal +=
          glm::cross(points[loop[i]] - points[loop[0]], points[loop[i + 1]] - points[loop[0]]);
    face.normal = glm::normalize(face.normal);
    face.offset = -1e300;
    for (Vec3 p : s.points) face.offset = glm::max(face.offset, glm::dot(face.normal, p));
    PANTIN_ASSERT(is_unit(face.normal));
    s.faces.push_back(face);
  }
  add_edges(s);
  return s;
}

}  // namespace

Result<std::shared_ptr<const Surface>> make_hull(std::span<const Vec3> points) {
  if (points.size() < 4)
    return Error{"hull has " + std::to_string(points.size()) + " points, expected at least 4"};
  Aabb bounds;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_finite(points[i]))
      return Error{"hull: point " + std::to_string(i) + " is not finite, expected numbers"};
    bounds.add(points[i]);
  }
  const Vec3 wide = bounds.high - bounds.low;
  // Round-off of a plane through three of the points, with a safety margin.
  const Real flat =
      1e-10 * glm::max(glm::length(wide), 1e-3 * glm::length(bounds.high + bounds.low));
  Quickhull hull(points, flat);
  if (!hull.start())
    return Error{"hull has no volume: its points are coplanar, collinear or coincident"};
  if (!hull.grow())
    return Error{"hull has more than " + std::to_string(kMostRaised) +
                 " corners, expected at most 256: give fewer points"};
  auto s = std::make_shared<Surface>(
      assemble(points, rims(hull.facets(), group_flat(hull.facets(), points, 4 * flat))));
  if (s->points.size() > kMostCorners)
    return Error{"hull has " + std::to_string(s->points.size()) +
                 " corners, expected at most 256: give fewer points"};
  // The faces of a very thin hull merge.
  if (s->points.size() < 4 || s->faces.size() < 4)
    return Error{"hull is too thin: relative to its length, its sides are coplanar to rounding"};
  bounds = Aabb{};
  for (Vec3 p : s->points) bounds.add(p);
  s->low = bounds.low, s->high = bounds.high;
  return std::shared_ptr<const Surface>(std::move(s));
}

}  // namespace pantin::detail
