#include "engine/geometry/skin_edges.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/skin_ground.hpp"
#include "engine/geometry/smooth.hpp"
#include "engine/geometry/surface.hpp"

namespace pantin::detail {
namespace {

// Feature ids: the owner of the feature, and its number.
constexpr std::uint64_t kCornerOfA = 1ull << 40, kCornerOfB = 2ull << 40, kAcross = 3ull << 40,
                        kEdgeOfA = 4ull << 40, kEdgeOfB = 5ull << 40;
constexpr std::uint64_t kNumber = (1u << 20) - 1;
constexpr Real kFlat = 0.05;      // rad, between parallel edges and faces
constexpr Real kCrossing = 0.02;  // rad, least angle between edges for their common normal to count
constexpr Real kBend = 0.15;      // of its length: largest sagitta of a round part
constexpr int kSamples = 9, kMostRefinements = 12, kMostSteps = 6;

// ---- Corners, and edges along faces -----------------------------------------------------------

/// Which body owns the corners, and the pose of their frame in b's.
struct Emit {
  enum class Whose { a, b } whose;
  Pose frame;
  const PointsOut& out;

  void add(Vec3 at, const Foot& foot, std::uint64_t feature) const {
    const Vec3 p = to_world(frame, at), q = to_world(frame, foot.point),
               n = frame.rotation * foot.normal;
    if (whose == Whose::a)
      out.points.push_back({p, q, n, foot.gap, feature});
    else
      out.points.push_back({q, p, -n, foot.gap, feature});
  }
};

/// Corners and edges in the frame of the body that they are tested against.
struct Features {
  std::span<const Corner> corners;
  std::span<const EdgePart> edges;
  FeatureScratch* feet = nullptr;     // feet of the corners, output
  const nurbs::Skin* skin = nullptr;  // of edges that are round
  Pose at = {};                       // of the skin

  EdgePoint point(const EdgePart& edge, Real share) const {
    if (edge.is_straight) return {glm::mix(edge.from, edge.to, share), edge.to - edge.from};
    const EdgePoint own = point_of(*skin, edge, share);
    return {to_world(at, own.point), at.rotation * own.rate};
  }
};

/// Tests edges along faces. Runs after the corners: round edges reuse the feet of their end
/// corners.
template <class Ground>
class Slide {
 public:
  Slide(const Ground& ground, const Features& of, const Emit& emit)
      : ground_(ground), of_(of), emit_(emit) {}

  /// Adds the points of an edge where the distance is least, and those where it is constant.
  void run(const EdgePart& edge) const {
    const int samples = edge.is_straight ? kSamples : 2;
    std::optional<Place> last;
    for (int i = 0; i < samples; ++i) {
      std::optional<Place> here =
          edge.is_straight ? look(edge, Real(i) / (samples - 1)) : look_at_end(edge, i);
      if (here && edge.is_straight &&
          std::abs(here->slope) <= kFlat * glm::length(edge.to - edge.from))
        add(edge, *here);
      else if (here && last && last->slope < 0 && here->slope > 0)
        refine(edge, *last, *here);
      last = here;
    }
  }

 private:
  struct Place {
    Real share, slope;
    Vec3 point;
    Foot foot;
  };
  std::optional<Place> look(const EdgePart& edge, Real share) const {
    const EdgePoint at = of_.point(edge, share);
    return look(edge, share, at);
  }
  std::optional<Place> look(const EdgePart& edge, Real share, const EdgePoint& at) const {
    Corner corner;
    corner.point = at.point;
    corner.add(edge.into[0]), corner.add(edge.into[1]);
    const auto foot = ground_.foot(corner);
    if (!foot) return std::nullopt;
    return Place{share, glm::dot(foot->normal, at.rate), at.point, *foot};
  }
  std::optional<Place> look_at_end(const EdgePart& edge, int end) const {
    const EdgePoint at = of_.point(edge, end);
    const std::uint32_t corner = edge.ends[static_cast<std::size_t>(end)];
    const std::uint32_t slot =
        corner < of_.feet->slots.size() ? of_.feet->slots[corner] : UINT32_MAX;
    if (slot == UINT32_MAX) return look(edge, end, at);
    const auto& foot = of_.feet->feet[slot];
    if (!foot) return std::nullopt;
    return Place{Real(end), glm::dot(foot->normal, at.rate), at.point, *foot};
  }
  /// Regula falsi with the value of the retained end halved (Illinois). [Dowell & Jarratt 1971]
  void refine(const EdgePart& edge, Place low, Place high) const {
    Place best = low.foot.gap < high.foot.gap ? low : high;
    int stays = 0;
    for (int round = 0; round < kMostRefinements; ++round) {
      const Real share =
          (low.share * high.slope - high.share * low.slope) / (high.slope - low.slope);
      if (!(std::abs(share - best.share) > 1e-12)) break;
      const auto here = look(edge, share);
      if (!here) break;
      best = *here;
      if (best.slope == 0) break;
      Place &stayed = best.slope < 0 ? high : low, &moved = best.slope < 0 ? low : high;
      const int side = best.slope < 0 ? 1 : -1;
      moved = best;
      if (stays == side) stayed.slope /= 2;
      stays = side;
    }
    add(edge, best);
  }
  void add(const EdgePart& edge, const Place& at) const {
    if (at.foot.gap > emit_.out.margin) return;
    const auto part = static_cast<std::uint64_t>(at.share * (kSamples - 1));
    const std::uint64_t whose = emit_.whose == Emit::Whose::a ? kEdgeOfA : kEdgeOfB;
    emit_.add(at.point, at.foot, whose | (edge.number & kNumber) << 8 | part);
  }

  const Ground& ground_;
  const Features& of_;
  const Emit& emit_;
};

template <class Ground>
void touch_faces(Ground ground, const Features& of, const Emit& emit) {
  // The ends of a round part may be farther than the margin where its middle is not.
  Real longest = 0;
  for (const EdgePart& edge : of.edges)
    if (!edge.is_straight) longest = std::max(longest, glm::distance(edge.from, edge.to));
  ground.reach.margin = emit.out.margin + kBend * longest;
  const std::uint64_t whose = emit.whose == Emit::Whose::a ? kCornerOfA : kCornerOfB;
  of.feet->feet.clear();
  for (const Corner& corner : of.corners) {
    const auto foot = of.feet->feet.emplace_back(ground.foot(corner));
    if (foot && foot->gap <= emit.out.margin) emit.add(corner.point, *foot, whose | corner.number);
  }
  const Slide slide(ground, of, emit);
  for (const EdgePart& edge : of.edges) {
    Aabb box;
    box.add(edge.from), box.add(edge.to);
    if (!edge.is_straight || ground.is_round_near(box)) slide.run(edge);
  }
}

// ---- Edges across edges -------------------------------------------------------------------------

/// Where two edges cross as seen along a normal, from b to a.
struct Crossing {
  Vec3 normal{0};
  Real gap = -1e300, on_a = 0, on_b = 0;  // m; shares
  Vec3 at_a{0}, at_b{0};
};

class Cross {
 public:
  Cross(const EdgePart& a, const EdgePart& b, const Features& of_a, const Features& of_b)
      : a_(a), b_(b), of_a_(of_a), of_b_(of_b), way_a_(a.to - a.from), way_b_(b.to - b.from) {}

  /// Uses the normal of a face of either body that contains both edges, else the common normal of
  /// the edges.
  std::optional<Crossing> find() const {
    std::optional<Crossing> best;
    const auto take = [&](const std::optional<Crossing>& found) {
      if (found && (!best || found->gap > best->gap)) best = found;
    };
    for (const Vec3 n : {b_.normals[0], b_.normals[1], -a_.normals[0], -a_.normals[1]})
      if (lies_along(way_a_, n) && lies_along(way_b_, n) && parts(n)) take(along(n));
    if (best) return best;
    const Vec3 cross = glm::cross(way_a_, way_b_);
    const Real sine = glm::length(cross);
    if (sine <= kCrossing * glm::length(way_a_) * glm::length(way_b_)) return best;
    for (const Vec3 n : {cross / sine, -cross / sine})
      if (parts(n)) take(along(n));
    return best;
  }

 private:
  static bool lies_along(Vec3 way, Vec3 n) {
    return std::abs(glm::dot(way, n)) <= kFlat * glm::length(way);
  }
  /// Whether the plane separates the two bodies beside the edges.
  bool parts(Vec3 n) const {
    return glm::dot(a_.into[0], n) >= -kFlat && glm::dot(a_.into[1], n) >= -kFlat &&
           glm::dot(b_.into[0], n) <= kFlat && glm::dot(b_.into[1], n) <= kFlat;
  }
  std::optional<Crossing> along(Vec3 n) const {
    const bool is_straight = a_.is_straight && b_.is_straight;
    Crossing c{n};
    EdgePoint p{a_.from, way_a_}, q{b_.from, way_b_};
    for (int step = 0; step < (is_straight ? 1 : kMostSteps); ++step) {
      const Vec3 apart = q.point - p.point;
      const Real turn = glm::dot(n, glm::cross(p.rate, q.rate));
      if (std::abs(turn) < 1e-6 * glm::length(p.rate) * glm::length(q.rate)) return std::nullopt;
      c.on_a += glm::dot(n, glm::cross(apart, q.rate)) / turn;
      c.on_b += glm::dot(n, glm::cross(apart, p.rate)) / turn;
      constexpr Real kBeyond = 0.5;
      if (!is_within(c.on_a, step == 0 && !is_straight ? kBeyond : 1e-6) ||
          !is_within(c.on_b, step == 0 && !is_straight ? kBeyond : 1e-6))
        return std::nullopt;
      c.on_a = std::clamp(c.on_a, Real(0), Real(1)), c.on_b = std::clamp(c.on_b, Real(0), Real(1));
      p = of_a_.point(a_, c.on_a), q = of_b_.point(b_, c.on_b);
    }
    c.at_a = p.point, c.at_b = q.point, c.gap = glm::dot(n, p.point - q.point);
    return c;
  }
  static bool is_within(Real share, Real slack) { return share >= -slack && share <= 1 + slack; }

  const EdgePart &a_, &b_;
  const Features &of_a_, &of_b_;
  Vec3 way_a_, way_b_;
};

Aabb box_of(const EdgePart& edge, Real reach) {
  Aabb box;
  box.add(edge.from), box.add(edge.to);
  const Real bend = edge.is_straight ? 0 : glm::distance(edge.from, edge.to) / 8;
  return box.grown(reach + bend);
}

/// Tests edges of a across those of a skin that are closer than `far` (m).
void touch_across(const SkinTarget& b, const Features& of_a, Real far, const PointsOut& out) {
  const SkinFeatures& all = b.surface.model->features;
  const Features of_b{all.corners, all.edges, nullptr, b.surface.skin.get()};
  for (const EdgePart& one : of_a.edges)
    all.edge_tree.query(box_of(one, far), [&](std::uint32_t i) {
      const EdgePart& two = all.edges[i];
      const auto c = Cross(one, two, of_a, of_b).find();
      if (!c || c->gap > b.reach.margin || c->gap < -b.reach.deepest) return;
      if (c->gap < -b.reach.shallow && !b.holds(c->at_a)) return;
      out.points.push_back({c->at_a, c->at_b, c->normal, c->gap,
                            kAcross | (one.number & kNumber) << 20 | (two.number & kNumber)});
    });
}

// ---- Where features come from -------------------------------------------------------------------

/// The features of a skin near a box in its own frame, transformed by the skin's pose `at`.
Features features_near(const Surface& surface, const Aabb& near, const Pose& at,
                       FeatureScratch& scratch) {
  const SkinFeatures& all = surface.model->features;
  scratch.corners.clear(), scratch.edges.clear();
  scratch.slots.assign(all.corners.size(), UINT32_MAX);
  all.corner_tree.query(near, [&](std::uint32_t i) {
    scratch.slots[i] = static_cast<std::uint32_t>(scratch.corners.size());
    Corner& c = scratch.corners.emplace_back(all.corners[i]);
    c.point = to_world(at, c.point);
    for (std::uint32_t k = 0; k < c.count; ++k) c.ways[k] = at.rotation * c.ways[k];
  });
  all.edge_tree.query(near, [&](std::uint32_t i) {
    EdgePart& e = scratch.edges.emplace_back(all.edges[i]);
    e.from = to_world(at, e.from), e.to = to_world(at, e.to);
    for (int k = 0; k < 2; ++k)
      e.normals[k] = at.rotation * e.normals[k], e.into[k] = at.rotation * e.into[k];
  });
  return {scratch.corners, scratch.edges, &scratch, surface.skin.get(), at};
}

/// The features of a piece with flat faces.
Features features_of(const Convex& piece, FeatureScratch& scratch) {
  scratch.corners.clear(), scratch.edges.clear();
  for (std::uint32_t i = 0; i < piece.points.size(); ++i) {
    Corner& c = scratch.corners.emplace_back();
    c.point = piece.points[i], c.number = i;
  }
  for (std::uint32_t i = 0; i < piece.edges.size(); ++i) {
    const auto [from, to] = piece.edges[i];
    EdgePart& e = scratch.edges.emplace_back();
    e.from = piece.points[from], e.to = piece.points[to], e.number = i;
    const Vec3 way = glm::normalize(e.to - e.from);
    scratch.corners[from].add(way), scratch.corners[to].add(-way);
    // The left face is the one whose loop traverses the edge forward.
    for (int k = 0; k < 2; ++k) {
      e.normals[k] = piece.faces[piece.sides[i][k]].normal;
      e.into[k] = (k == 0 ? 1.0 : -1.0) * glm::cross(e.normals[k], way);
    }
  }
  return {scratch.corners, scratch.edges, &scratch};
}

/// The support features of a smooth piece towards the flat faces of a skin near a box: a rim, a
/// line or a point for each direction of these faces.
Features fronts_of(const Convex& piece, const SkinTarget& skin, const Aabb& near,
                   FeatureScratch& scratch) {
  constexpr std::size_t kMostWays = 6;
  const SkinModel& m = *skin.surface.model;
  std::array<Vec3, kMostWays> ways;
  std::size_t count = 0;
  m.tree.query(near, [&](std::uint32_t i) {
    const auto is_known = [&](Vec3 n) { return glm::dot(n, m.normals[i]) > 1 - 1e-6; };
    const auto end = ways.begin() + static_cast<std::ptrdiff_t>(count);
    if (m.flat[i] && count < kMostWays && std::none_of(ways.begin(), end, is_known))
      ways[count++] = m.normals[i];
  });
  scratch.corners.clear(), scratch.edges.clear();
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 n = ways[i], side = std::abs(n.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const Vec3 u = glm::normalize(glm::cross(n, side)), v = glm::cross(n, u);
    Patch patch;
    const Corners front = corners_towards(piece, -n, skin.reach.margin, patch);
    for (std::uint32_t k = 0; k < front.points.size(); ++k) {
      Corner& c = scratch.corners.emplace_back();
      c.point = front.points[k], c.number = i << 10 | front.number(k);
      for (const Vec3 way : {n, u, -u, v, -v}) c.add(way);
    }
  }
  return {scratch.corners, scratch.edges, &scratch};
}

Aabb box_of(const Surface& surface) { return {surface.low, surface.high}; }

Aabb bounds_in(const Surface& surface, const Pose& at) {
  Aabb box;
  for (int i = 0; i < 8; ++i)
    box.add(to_world(
        at, {i & 1 ? surface.high.x : surface.low.x, i & 2 ? surface.high.y : surface.low.y,
             i & 4 ? surface.high.z : surface.low.z}));
  return box;
}

}  // namespace

void touch_edges(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out) {
  const auto& [a, b, a_in_b] = pair;
  const Pose b_in_a = inverse(a_in_b);
  const Reach into_a = reach_into(a, b.model->size, out.margin),
              into_b = reach_into(b, a.model->size, out.margin);
  const SkinTarget ground_a{a, into_a}, ground_b{b, into_b};
  const Features of_b =
      features_near(b, bounds_in(a, a_in_b).grown(into_a.farthest()), b_in_a, scratch.features);
  touch_faces(ground_a, of_b, {Emit::Whose::b, a_in_b, out});
  const Features of_a =
      features_near(a, bounds_in(b, b_in_a).grown(into_b.farthest()), a_in_b, scratch.features);
  touch_faces(ground_b, of_a, {Emit::Whose::a, {}, out});
  const Real far = std::max(out.margin, std::min(into_a.deepest, into_b.deepest) / 2);
  touch_across(ground_b, of_a, far, out);
}

void touch_edges(const Surface& skin, const PlacedShape& other, SkinScratch& scratch,
                 const PointsOut& out) {
  const bool is_bounded = !is_unbounded(other.shape.kind);
  Aabb box = box_of(skin);
  Real size = skin.model->size;
  if (is_bounded) {
    box = bounds_of(other.shape, other.at);
    size = glm::length(box.high - box.low) / 2;
  }
  const Reach into_other = reach_between(out.margin, skin.model->size, size);
  const Features of_skin = features_near(skin, is_bounded ? box.grown(into_other.farthest()) : box,
                                         Pose{}, scratch.features);
  const Emit by_skin{Emit::Whose::b, {}, out};
  if (!is_convex(other.shape.kind))
    return touch_faces(ShapeTarget{other, into_other}, of_skin, by_skin);
  const Convex piece = convex_piece(other.shape, other.at, scratch.piece);
  const SkinTarget ground{skin, reach_into(skin, size, out.margin)};
  if (piece.smooth) {
    touch_faces(ShapeTarget{other, into_other}, of_skin, by_skin);
    const Aabb near = box.grown(std::max(out.margin, Real(0)));
    const Features fronts = fronts_of(piece, ground, near, scratch.features);
    return touch_faces(ground, fronts, {Emit::Whose::a, {}, out});
  }
  touch_faces(ConvexTarget{piece, into_other}, of_skin, by_skin);
  const Features of_piece = features_of(piece, scratch.features);
  touch_faces(ground, of_piece, {Emit::Whose::a, {}, out});
  touch_across(ground, of_piece, std::max(out.margin, into_other.deepest / 2), out);
}

}  // namespace pantin::detail
