// Distance and overlap of convex pieces by their support functions.
#include <algorithm>
#include <optional>

#include "engine/geometry/simplex.hpp"
#include "engine/geometry/smooth.hpp"

namespace pantin::detail {
namespace {

constexpr int kMostRounds = 96, kFirstRounds = 8, kMostSteps = 40, kFewSteps = 8,
              kMostRefinements = 4, kRefiningRounds = 32;
// Fractions of the sizes: below this distance pieces are moved apart for the query, since the
// direction between points that almost coincide is lost to rounding; by how much; and the overlap
// up to which no polytope is needed.
constexpr Real kNear = 2e-3, kApart = 0.02, kShallow = 0.01;
constexpr Real kSettled = 1e-8;   // rad
constexpr Real kTouching = 1e-7;  // of the sizes: below this, the overlap gives the direction
constexpr Real kOverlap = 1e-11;  // of the sizes: accuracy of overlaps
// Fractions of the sizes: the gradient at which the search of a smooth minimum has converged, the
// acceptable one, and the one for accepting a minimum that the polytope could not resolve.
constexpr Real kSlope = 1e-10, kSmooth = 1e-8, kRound = 1e-4;

/// A point of the Minkowski difference of two pieces, and its points on both.
struct Difference {
  Vec3 w{0}, on_a{0}, on_b{0};
};

/// Two pieces; the first is displaced.
struct Pieces {
  const Convex& a;
  const Convex& b;
  Vec3 shift{0};  // m

  Real size() const { return a.size + b.size; }
  /// Whether one of them has faces, where the support function is not smooth.
  bool have_faces() const { return !a.faces.empty() || !b.faces.empty(); }
};

Difference farthest(const Pieces& pieces, Vec3 direction) {
  Difference d;
  d.on_a = pieces.a.extreme(direction), d.on_b = pieces.b.extreme(-direction);
  d.w = d.on_a - d.on_b + pieces.shift;
  return d;
}

/// Local minimum of the support function near a direction, if the gradient there is below
/// `accuracy` (fraction of the sizes). The gradient on the sphere of directions is the tangential
/// part of the support point. Steps by [Barzilai & Borwein 1988], each of which must decrease the
/// function. None if the minimum is at an edge, where the function is not smooth.
std::optional<Separation> polish(const Pieces& pieces, Vec3 normal, Real accuracy) {
  const Real size = pieces.size();
  Difference at = farthest(pieces, normal);
  const auto slope = [](Vec3 n, Vec3 w) { return w - glm::dot(n, w) * n; };
  Vec3 gradient = slope(normal, at.w);
  Real step = 0.1 / size;
  const Real hopeful = 0.5 * glm::length(gradient);
  for (int round = 0; round < kMostSteps && glm::length(gradient) > kSlope * size; ++round) {
    // At a face the gradient does not vanish.
    if (round == kFewSteps && pieces.have_faces() && glm::length(gradient) > hopeful) break;
    const Vec3 to = glm::normalize(normal - step * gradient);
    const Difference next = farthest(pieces, to);
    if (!(glm::dot(to, next.w) < glm::dot(normal, at.w))) {
      step /= 4;
      continue;
    }
    const Vec3 moved = to - normal, other = slope(to, next.w), change = other - gradient;
    const Real along = glm::dot(moved, change);
    step = along > 0 ? glm::dot(moved, moved) / along : 2 * step;
    normal = to, at = next, gradient = other;
  }
  if (!(glm::length(gradient) < accuracy * size)) return std::nullopt;
  Separation found;
  found.normal = -normal, found.distance = -glm::dot(normal, at.w);
  found.on_a = at.on_a, found.on_b = at.on_a - found.distance * found.normal;
  return found;
}

// ---- Overlap -----------------------------------------------------------------------------------

/// EPA: a polytope inside the Minkowski difference that expands where it is nearest to the origin.
class Polytope {
 public:
  explicit Polytope(const Pieces& pieces) : pieces_(pieces), size_(pieces.size()) { start(); }

  Separation grow();

 private:
  static constexpr std::size_t kPoints = 100, kFaces = 4 * kPoints;

  struct Side {
    std::array<std::uint32_t, 3> corners{};
    Vec3 normal{0};
    Real offset = 0;  // m, of its plane along the normal; the origin is inside if all are above 0
  };

  void start();
  bool add(std::uint32_t i, std::uint32_t j, std::uint32_t k);
  bool expand(const Difference& to);
  Separation answer(const Side& side, Real reach) const;

  const Pieces& pieces_;
  Real size_;
  std::array<Difference, kPoints> points_;
  std::array<Side, kFaces> sides_;
  std::size_t point_count_ = 0, side_count_ = 0;
};

bool Polytope::add(std::uint32_t i, std::uint32_t j, std::uint32_t k) {
  const Vec3 p = points_[i].w, n = glm::cross(points_[j].w - p, points_[k].w - p);
  const Real area = glm::length(n);
  if (!(area > 1e-26 * size_ * size_) || side_count_ == kFaces) return false;
  sides_[side_count_++] = {{i, j, k}, n / area, glm::dot(n / area, p)};
  return true;
}

/// A tetrahedron of support points far from one another.
void Polytope::start() {
  const auto most = [&](std::span<const Vec3> directions, auto&& measure) {
    Difference best;
    Real highest = -1;
    for (Vec3 d : directions)
      for (Real sign : {1.0, -1.0}) {
        const Difference p = farthest(pieces_, sign * d);
        if (const Real m = measure(p.w); m > highest) highest = m, best = p;
      }
    return best;
  };
  const std::array<Vec3, 3> axes{Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  points_[0] = farthest(pieces_, {1, 0, 0});
  const Vec3 o = points_[0].w;
  points_[1] = most(axes, [&](Vec3 w) { return glm::distance(w, o); });
  const Vec3 along = points_[1].w - o;
  points_[2] = most(axes, [&](Vec3 w) { return glm::length(glm::cross(along, w - o)); });
  const Vec3 up = glm::cross(along, points_[2].w - o);
  const std::array<Vec3, 1> normal{up};
  points_[3] = most(normal, [&](Vec3 w) { return std::abs(glm::dot(up, w - o)); });
  point_count_ = 4;
  if (glm::dot(up, points_[3].w - o) > 0) std::swap(points_[1], points_[2]);
  add(0, 1, 2), add(0, 2, 3), add(0, 3, 1), add(1, 3, 2);
}

/// Replaces the sides that are visible from a point by a cone to it; false if rounding prevents it.
bool Polytope::expand(const Difference& to) {
  struct Edge {
    std::uint32_t from, to;
  };
  std::array<Edge, 3 * kFaces> rim;
  std::size_t edges = 0, kept = 0;
  const auto toggle = [&](std::uint32_t i, std::uint32_t j) {
    for (std::size_t e = 0; e < edges; ++e)
      if (rim[e].from == j && rim[e].to == i) return void(rim[e] = rim[--edges]);
    rim[edges++] = {i, j};
  };
  for (std::size_t s = 0; s < side_count_; ++s) {
    const Side& side = sides_[s];
    if (glm::dot(side.normal, to.w) - side.offset > 1e-13 * size_)
      for (std::size_t i = 0; i < 3; ++i) toggle(side.corners[i], side.corners[(i + 1) % 3]);
    else
      sides_[kept++] = side;
  }
  side_count_ = kept;
  const auto apex = static_cast<std::uint32_t>(point_count_);
  points_[point_count_++] = to;
  for (std::size_t e = 0; e < edges; ++e)
    if (!add(rim[e].from, rim[e].to, apex)) return false;
  return true;
}

/// A displacement of `reach` along the side's normal separates the pieces.
Separation Polytope::answer(const Side& side, Real reach) const {
  Simplex s;
  for (std::uint32_t i = 0; i < 3; ++i) {
    s.v[i].w = points_[side.corners[i]].w - side.offset * side.normal;
    s.v[i].a = side.corners[i];
  }
  s.count = 3;
  Vec3 nearest;
  shrink(s, nearest);
  Separation found;
  for (int i = 0; i < s.count; ++i) found.on_a += s.v[i].weight * points_[s.v[i].a].on_a;
  found.normal = -side.normal, found.distance = -reach;
  found.on_b = found.on_a - found.distance * found.normal;
  return found;
}

Separation Polytope::grow() {
  Side best;
  Real reach = 0;
  best.normal = {0, -1, 0};  // if the difference has no volume
  while (side_count_ > 0) {
    best =
        *std::min_element(sides_.begin(), sides_.begin() + static_cast<std::ptrdiff_t>(side_count_),
                          [](const Side& p, const Side& q) { return p.offset < q.offset; });
    const Difference next = farthest(pieces_, best.normal);
    reach = glm::dot(best.normal, next.w);
    if (point_count_ == kPoints) {
      if (const auto round = polish(pieces_, best.normal, kRound)) return *round;
      break;
    }
    if (reach - best.offset <= kOverlap * size_) break;
    if (!expand(next)) break;
  }
  return answer(best, reach);
}

// ---- Distance ----------------------------------------------------------------------------------

/// Limits of a GJK run, and its last state.
struct Walk {
  Real limit = 1e300;  // m
  std::uint32_t most = kMostRounds;
  Real far = 1e300;        // m: more rounds are taken at this distance
  Real tolerance = 1e-14;  // of the distance's square
  Vec3 last{0, 1, 0};      // direction from b to a
  bool is_done = true;
};

/// Gilbert, Johnson and Keerthi's algorithm. None if the pieces overlap or almost touch.
std::optional<Separation> walk(const Pieces& pieces, Walk& state) {
  const Real size = pieces.size(), touching = kTouching * size;
  std::array<Difference, kMostRounds> seen;
  Simplex s, kept;
  Vec3 v = pieces.a.centre - pieces.b.centre + pieces.shift, last(0);
  if (v == Vec3(0)) v = Vec3(0, 1, 0);
  Real kept_distance = 1e300;
  for (std::uint32_t round = 0; round < kMostRounds; ++round) {
    state.is_done = round < state.most || kept_distance > state.far * state.far;
    if (!state.is_done) break;
    seen[round] = farthest(pieces, -v);
    const Vec3 w = seen[round].w;
    const Real ahead = glm::dot(v, w), length = glm::length(v);
    state.last = v / length;
    if (ahead > state.limit * length) {
      Separation found;
      found.normal = v / length, found.distance = ahead / length, found.is_beyond = true;
      return found;
    }
    if (s.count > 0 &&
        kept_distance - ahead <= state.tolerance * kept_distance + 1e-16 * length * size)
      break;
    s.v[s.count++] = {w, round, round, 1};
    if (!shrink(s, v) || glm::dot(v, v) <= touching * touching) return std::nullopt;
    if (glm::dot(v, v) >= kept_distance) break;  // no progress: rounding errors dominate
    kept = s, last = v, kept_distance = glm::dot(v, v);
  }
  Separation found;
  for (int i = 0; i < kept.count; ++i) {
    found.on_a += kept.v[i].weight * seen[kept.v[i].a].on_a;
    found.on_b += kept.v[i].weight * seen[kept.v[i].a].on_b;
  }
  found.distance = glm::length(last);
  found.normal = last / found.distance;
  return found;
}

/// Separation of the pieces along a direction from b to a.
Separation along(const Pieces& pieces, Vec3 normal) {
  const Difference d = farthest(pieces, -normal);
  return {d.on_a, d.on_b, normal, glm::dot(normal, d.w)};
}

/// The last GJK direction, or the line of centres, whichever has less overlap.
Vec3 better_of(const Pieces& pieces, Vec3 last) {
  const Vec3 way = pieces.a.centre - pieces.b.centre;
  const Real length = glm::length(way);
  if (!(length > 1e-9 * pieces.size())) return is_finite(last) ? last : Vec3(0, 1, 0);
  const bool is_last = along(pieces, last).distance >= along(pieces, way / length).distance;
  return is_last ? last : way / length;
}

/// Local maximum of the separation near a known direction, or minimum of the overlap.
///
/// Move the pieces apart by s along a separating direction n, and let D be their distance, along m.
/// Without the move their separation along m is D - s (n . m). D is the maximum over all
/// directions, so this is never less than the separation along n. These are steps of a proximal
/// point method; it converges faster the smaller s is relative to the radii of curvature.
/// [Rockafellar 1976]
struct Refined {
  Separation at;
  bool is_settled = false;  // further steps would not rotate the normal
};
Refined refine(const Pieces& pieces, const Separation& start) {
  const Real size = pieces.size();
  Refined found{start};
  for (int round = 0; round < kMostRefinements && !found.is_settled; ++round) {
    const Real free = kApart * size + glm::max(-found.at.distance, Real(0));
    Walk state{.most = kRefiningRounds, .tolerance = 1e-11};
    auto next = walk({pieces.a, pieces.b, free * found.at.normal}, state);
    if (!next) break;
    // A GJK run that stopped early is slightly short: the support points give the exact value.
    next->distance = along(pieces, next->normal).distance;
    if (next->distance < found.at.distance - 1e-12 * size) break;
    found = {*next, glm::distance(next->normal, found.at.normal) < kSettled};
  }
  found.at.on_b = found.at.on_a - found.at.distance * found.at.normal;
  return found;
}

}  // namespace

Separation separate(const Convex& a, const Convex& b, Real limit) {
  const Pieces pieces{a, b};
  const Real size = pieces.size();
  const auto is_shallow = [&](const Separation& s) { return s.distance > -kShallow * size; };
  Walk first{.limit = limit, .most = kFirstRounds};
  if (pieces.have_faces()) first.far = kApart * size;
  auto found = walk(pieces, first);
  if (!found || !first.is_done) {
    // Gradient steps converge faster where both are round, or touch with edges.
    const auto round = polish(pieces, -better_of(pieces, first.last), kSmooth);
    if (round && is_shallow(*round)) return *round;
  }
  // Close pieces are moved apart for the query; others need not be.
  Walk whole{.limit = limit};
  if (found && !first.is_done && found->distance > kApart * size) found = walk(pieces, whole);
  const bool is_far = found && (found->is_beyond || found->distance > kNear * size);
  if (is_far && (first.is_done || found->distance > kApart * size)) return *found;
  const Vec3 last = found ? found->normal : first.last;
  const Refined near = refine(pieces, along(pieces, better_of(pieces, last)));
  if (found && !near.is_settled) {
    // Points and edges that almost touch: the direction rotates too little per step.
    whole = {.limit = limit};
    found = walk(pieces, whole);
    if (found && along(pieces, found->normal).distance > near.at.distance) return *found;
  }
  if (is_shallow(near.at)) return near.at;
  const Separation deep = refine(pieces, Polytope(pieces).grow()).at;
  return deep.distance > near.at.distance ? deep : near.at;
}

}  // namespace pantin::detail
