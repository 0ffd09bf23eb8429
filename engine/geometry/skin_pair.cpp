// Contacts of two skins of which at least one is not convex: deepest points between round faces,
// and corners and edges.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "engine/geometry/skin_edges.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kMostPoints = 16, kMostStarts = 12;
constexpr int kMostSteps = 8;
constexpr Real kApart = 0.15;    // of the smaller size: least distance between starts
constexpr Real kNear = 0.06;     // of the seeds' skin: largest distance of a seed beside a contact
constexpr Real kDeepest = 0.1;   // of the smaller size: deeper points are on the far side
constexpr Real kShallow = 1e-3;  // likewise: deeper points are tested for being inside
constexpr Real kFacing = -0.7;   // cosine between normals at a start
constexpr Real kAlong = 0.05;    // rad, tolerance of opposed normals at a contact
constexpr Real kFits = 0.02;     // of 1 / size: smaller differences of curvatures count as zero
constexpr Real kMeets = 1e-5;    // of the size: tangential offset of the two points at convergence
constexpr std::uint64_t kOfA = 6ull << 40, kOfB = 7ull << 40;

// ---- Deepest points between two faces -----------------------------------------------------------

/// A point of a skin, in b's frame.
struct Local {
  nurbs::Place at;
  nurbs::Jet jet;
  Vec3 normal{0};
};

/// A skin and its pose in b's frame.
struct Standing {
  const Surface& surface;
  Mat3 rotation;
  Vec3 origin;

  Local at(const nurbs::Place& place) const {
    const nurbs::Jet j = surface.skin->face(place.face).at(place.u, place.v);
    Local l{place,
            {rotation * j.s + origin, rotation * j.u, rotation * j.v, rotation * j.uu,
             rotation * j.uv, rotation * j.vv}};
    const Vec3 n = glm::cross(l.jet.u, l.jet.v);
    const Real length = glm::length(n);
    l.normal = length > 0 ? n / length : Vec3(0);
    return l;
  }
  /// The parameters after a displacement `way` along the face, or on the next face beyond its edge.
  nurbs::Place moved(const Local& from, Vec3 way) const {
    const nurbs::Jet& j = from.jet;
    const Real uu = glm::dot(j.u, j.u), uv = glm::dot(j.u, j.v), vv = glm::dot(j.v, j.v);
    const Real determinant = uu * vv - uv * uv, u = glm::dot(way, j.u), v = glm::dot(way, j.v);
    nurbs::Place to = from.at;
    if (!(determinant > 0)) return to;
    const nurbs::Face& face = surface.skin->face(to.face);
    to.u += (vv * u - uv * v) / determinant, to.v += (uu * v - uv * u) / determinant;
    using enum nurbs::Edge;
    std::optional<nurbs::Edge> over;
    const auto keep = [&](const nurbs::Knots& k, Real& t, nurbs::Edge low, nurbs::Edge high) {
      if (!k.is_periodic && t < k.low()) over = low;
      if (!k.is_periodic && t > k.high()) over = high;
      t = k.is_periodic ? k.inside(t) : k.domain().clamped(t);
    };
    keep(face.u(), to.u, u_low, u_high), keep(face.v(), to.v, v_low, v_high);
    if (!over) return to;
    return surface.skin->across(to, *over).value_or(to);
  }
};

/// A height over a plane to second order: first and second derivatives.
struct Height {
  Real x, y, xx, xy, yy;
};

struct Frame {
  Vec3 x, y, n;
};

/// Height of a surface along n: parametric derivatives expressed in the plane's coordinates.
Height height_of(const Local& l, const Frame& f) {
  const nurbs::Jet& j = l.jet;
  const Real ux = glm::dot(j.u, f.x), uy = glm::dot(j.u, f.y), vx = glm::dot(j.v, f.x),
             vy = glm::dot(j.v, f.y), determinant = ux * vy - uy * vx;
  const Vec3 n = l.normal;
  const Real rises = glm::dot(n, f.n);
  const Height slope{-glm::dot(n, f.x) / rises, -glm::dot(n, f.y) / rises, 0, 0, 0};
  // Second derivatives off the tangent plane, divided by the component along n.
  const Real a = glm::dot(n, j.uu) / rises, b = glm::dot(n, j.uv) / rises,
             c = glm::dot(n, j.vv) / rises;
  const Real xu = vy / determinant, xv = -uy / determinant, yu = -vx / determinant,
             yv = ux / determinant;
  return {slope.x, slope.y, a * xu * xu + 2 * b * xu * xv + c * xv * xv,
          a * xu * yu + b * (xu * yv + xv * yu) + c * xv * yv,
          a * yu * yu + 2 * b * yu * yv + c * yv * yv};
}

/// Newton step to the minimum of a quadratic function: along directions of positive curvature, and
/// zero along those of no curvature. None where a curvature is negative.
std::optional<std::array<Real, 2>> least_of(const Height& h, Real least_bend) {
  const Real mean = (h.xx + h.yy) / 2, half = (h.xx - h.yy) / 2;
  const Real apart = std::hypot(half, h.xy);
  const Real angle = apart > 0 ? std::atan2(h.xy, half) / 2 : 0;
  std::array<Real, 2> step{0, 0};
  for (const int k : {0, 1}) {
    const Real bend = k == 0 ? mean + apart : mean - apart;
    if (bend < -least_bend) return std::nullopt;
    if (bend < least_bend) continue;
    const Real c = std::cos(angle + k * kPi / 2), s = std::sin(angle + k * kPi / 2);
    const Real t = -(h.x * c + h.y * s) / bend;
    step[0] += t * c, step[1] += t * s;
  }
  return step;
}

Frame frame_about(Vec3 n) {
  const Vec3 side = std::abs(n.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 x = glm::normalize(glm::cross(n, side));
  return {x, glm::cross(n, x), n};
}

/// Two skins in b's frame.
struct Meeting {
  Standing a, b;
  Real size;  // of the smaller
};

/// The two points on a common normal near a start. Where the faces fit along a line, the nearest of
/// those. Newton's method on the gap along b's normal.
struct Met {
  Local a, b;
  Real gap;
};
std::optional<Met> meet(const Meeting& m, const nurbs::Place& on_a, const nurbs::Place& on_b) {
  Local a = m.a.at(on_a), b = m.b.at(on_b);
  for (int step = 0;; ++step) {
    if (!(glm::dot(a.normal, b.normal) < -0.2)) return std::nullopt;
    const Frame f = frame_about(b.normal);
    const Vec3 apart = a.jet.s - b.jet.s;
    const Real x = glm::dot(apart, f.x), y = glm::dot(apart, f.y);
    const Height of_a = height_of(a, f), of_b = height_of(b, f);
    // The gap above b's point, with a's quadratic approximation extended to there.
    const Height gap{of_a.x - of_a.xx * x - of_a.xy * y, of_a.y - of_a.xy * x - of_a.yy * y,
                     of_a.xx - of_b.xx, of_a.xy - of_b.xy, of_a.yy - of_b.yy};
    const auto to = least_of(gap, kFits / m.size);
    if (!to) return std::nullopt;
    const Real move_a = std::hypot((*to)[0] - x, (*to)[1] - y),
               move_b = std::hypot((*to)[0], (*to)[1]);
    if (std::max(move_a, move_b) > m.size) return std::nullopt;
    if (std::max(move_a, move_b) < 1e-12 * m.size || step == kMostSteps) {
      if (std::hypot(x, y) > kMeets * m.size || glm::length(a.normal + b.normal) > kAlong)
        return std::nullopt;
      return Met{a, b, glm::dot(apart, b.normal)};
    }
    a = m.a.at(m.a.moved(a, ((*to)[0] - x) * f.x + ((*to)[1] - y) * f.y));
    b = m.b.at(m.b.moved(b, (*to)[0] * f.x + (*to)[1] * f.y));
  }
}

// ---- Starts -------------------------------------------------------------------------------------

/// Seeds of one skin against the faces of another, in the frame of the latter.
struct Seeking {
  const Surface& from;
  const Surface& to;
  Pose at;  // of `from`
  Real margin, size;
};

/// The nearest triangle that faces a seed, and the gap.
std::optional<SkinScratch::Candidate> facing(const Seeking& k, std::uint32_t seed) {
  constexpr Real kRounding = 1e-9;
  const SkinModel &m = *k.from.model, &other = *k.to.model;
  const Real far = k.margin + kNear * m.size;
  const Vec3 p = to_world(k.at, m.seed_points[seed]), n = k.at.rotation * m.seed_normals[seed];
  std::optional<std::uint32_t> tile;
  Real best = far * far;
  other.tree.nearest(
      p, best,
      [&](std::uint32_t i) {
        if (glm::dot(other.normals[i], n) > kFacing) return Real(1e300);
        const Vec3 way = way_from(other, i, p);
        if (glm::dot(way, way) < best) best = glm::dot(way, way), tile = i;
        return best;
      },
      [&](std::uint32_t node) { return other.cones[node].least_cosine(n) <= kFacing + kRounding; });
  if (!tile) return std::nullopt;
  return SkinScratch::Candidate{glm::dot(other.normals[*tile], way_from(other, *tile, p)), seed,
                                *tile};
}

/// Lists the seeds on round faces that are near and face the other's faces, deepest first.
void find_seeds(const Seeking& k, std::vector<SkinScratch::Candidate>& found) {
  found.clear();
  const SkinModel& m = *k.from.model;
  const Pose back = inverse(k.at);
  Aabb box;
  for (int i = 0; i < 8; ++i)
    box.add(to_world(back, {i & 1 ? k.to.high.x : k.to.low.x, i & 2 ? k.to.high.y : k.to.low.y,
                            i & 4 ? k.to.high.z : k.to.low.z}));
  m.seed_tree.query(box.grown(k.margin), [&](std::uint32_t seed) {
    if (!m.seed_is_round[seed]) return;
    if (const auto candidate = facing(k, seed)) found.push_back(*candidate);
  });
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a.gap != b.gap ? a.gap < b.gap : a.seed < b.seed;
  });
}

bool holds(const Surface& surface, Vec3 p) {
  return !surface.model->is_closed || nearest_on(surface, p).distance <= 0;
}

/// A start, and the feature id of its contact.
struct Start {
  nurbs::Place on_a, on_b;
  std::uint64_t feature;
};

void add_met(const Meeting& m, const Start& start, const PointsOut& out) {
  const auto met = meet(m, start.on_a, start.on_b);
  if (!met || met->gap > out.margin || met->gap < -kDeepest * m.size) return;
  if (met->gap < -kShallow * m.size && !holds(m.b.surface, met->a.jet.s)) return;
  out.points.push_back({met->a.jet.s, met->b.jet.s, met->b.normal, met->gap, start.feature});
}

/// Calls `start` with the deepest seeds that are apart from one another.
template <class Start>
void start_apart(const Seeking& k, std::span<const SkinScratch::Candidate> found,
                 const Start& start) {
  std::array<Vec3, kMostStarts> taken;
  std::size_t count = 0;
  for (const auto& c : found) {
    const Vec3 p = k.from.model->seed_points[c.seed];
    const auto is_near = [&](Vec3 q) { return glm::distance(p, q) < kApart * k.size; };
    if (std::any_of(taken.begin(), taken.begin() + std::ptrdiff_t(count), is_near)) continue;
    start(c);
    taken[count++] = p;
    if (count == kMostStarts) return;
  }
}

nurbs::Place place_of_tile(const Surface& s, std::uint32_t tile) {
  return s.model->tiles.places[s.model->tiles.triangles[tile][0]];
}

void touch_rounds(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out) {
  const Surface &a = pair.a, &b = pair.b;
  const Pose& a_in_b = pair.a_in_b;
  const Real size = std::min(a.model->size, b.model->size), margin = std::max(out.margin, Real(0));
  const Meeting m{
      {a, glm::mat3_cast(a_in_b.rotation), a_in_b.position}, {b, Mat3(1), Vec3(0)}, size};
  const Seeking from_a{a, b, a_in_b, margin, size}, from_b{b, a, inverse(a_in_b), margin, size};
  find_seeds(from_a, scratch.candidates);
  start_apart(from_a, scratch.candidates, [&](const SkinScratch::Candidate& c) {
    add_met(m, {a.model->seeds[c.seed], place_of_tile(b, c.tile), kOfA | (c.seed + 1)}, out);
  });
  find_seeds(from_b, scratch.candidates);
  start_apart(from_b, scratch.candidates, [&](const SkinScratch::Candidate& c) {
    add_met(m, {place_of_tile(a, c.tile), b.model->seeds[c.seed], kOfB | (c.seed + 1)}, out);
  });
}

}  // namespace

void collide_skins(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out) {
  const std::size_t first = out.points.size();
  const Real size = std::min(pair.a.model->size, pair.b.model->size);
  touch_rounds(pair, scratch, out);
  touch_edges(pair, scratch, out);
  drop_duplicates(out.points, first, 1e-4 * size);
  reduce_directed(out.points, first, kMostPoints, size);
}

}  // namespace pantin::detail
