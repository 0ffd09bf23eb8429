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
constexpr int kMostSteps = 8, kMostStepsDown = 40;
constexpr Real kApart = 0.15;  // of the smaller size: least distance between starts
constexpr Real kNear = 0.06;   // of the seeds' skin: largest distance of a seed beside a contact
// Of the smaller size: deeper points are on the far side; have to be of two closed skins and inside
// each other; have to be inside b.
constexpr Real kDeepest = 0.25, kDeep = 0.1, kShallow = 1e-3;
constexpr Real kFacing = -0.7;   // cosine between normals at a start
constexpr Real kAlong = 0.05;    // rad, tolerance of opposed normals at a contact
constexpr Real kFits = 0.02;     // of 1 / size: smaller differences of curvatures count as zero
constexpr Real kMeets = 1e-5;    // of the size: tangential offset of the two points at convergence
constexpr Real kDownhill = 0.1;  // of the size: largest step away from a maximum of the gap
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
  /// A point in the skin's own frame.
  Vec3 own(Vec3 p) const { return glm::transpose(rotation) * (p - origin); }
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

/// Displacements in the plane of two points, m.
struct Moves {
  std::array<Real, 2> a, b;
};

/// Newton step of two points of faces to their common normal, given the heights over the plane
/// through b's point and a's point at (x, y, gap) there: along the directions in which the gap is
/// curved, and none along those in which the faces fit. Where the gap has a maximum along some
/// direction: downhill, as far as `longest`; none if that is 0.
struct Step {
  Height of_a, of_b;
  Real x, y, gap, least_bend, longest;

  std::optional<Moves> moves() const {
    // Gradient and second derivatives of the gap above b's point, by a's height extended to there.
    const Height h{of_a.x - of_a.xx * x - of_a.xy * y, of_a.y - of_a.xy * x - of_a.yy * y,
                   of_a.xx - of_b.xx, of_a.xy - of_b.xy, of_a.yy - of_b.yy};
    const Real mean = (h.xx + h.yy) / 2, apart = std::hypot((h.xx - h.yy) / 2, h.xy);
    if (mean - apart >= least_bend) return to_normal(h);
    const bool is_hill = mean - apart < -least_bend;
    if (is_hill && !(longest > 0)) return std::nullopt;
    return along_curved(h, mean, apart, is_hill ? longest : 1e300);
  }

 private:
  /// Both points over the same place, downhill where the gap has a maximum.
  Moves along_curved(const Height& h, Real mean, Real apart, Real most) const {
    const Real angle = apart > 0 ? std::atan2(h.xy, (h.xx - h.yy) / 2) / 2 : 0;
    Real to[2] = {0, 0};
    for (const int k : {0, 1}) {
      const Real bend = std::abs(k == 0 ? mean + apart : mean - apart);
      if (bend < least_bend) continue;
      const Real c = std::cos(angle + k * kPi / 2), s = std::sin(angle + k * kPi / 2);
      const Real t = -(h.x * c + h.y * s) / bend;
      to[0] += t * c, to[1] += t * s;
    }
    if (const Real way = std::hypot(to[0], to[1]); way > most)
      to[0] *= most / way, to[1] *= most / way;
    return {{to[0] - x, to[1] - y}, {to[0], to[1]}};
  }
  /// The line between the points is normal to both faces: with the heights' second derivatives A
  /// and B and the point q over which b is then, a is over q - gap B q.
  Moves to_normal(const Height& h) const {
    const Height &a = of_a, &b = of_b;
    const Real xx = h.xx - gap * (a.xx * b.xx + a.xy * b.xy),
               xy = h.xy - gap * (a.xx * b.xy + a.xy * b.yy),
               yx = h.xy - gap * (a.xy * b.xx + a.yy * b.xy),
               yy = h.yy - gap * (a.xy * b.xy + a.yy * b.yy);
    const Real determinant = xx * yy - xy * yx;
    const Real to_x = (xy * h.y - yy * h.x) / determinant,
               to_y = (yx * h.x - xx * h.y) / determinant;
    return {{to_x - gap * (b.xx * to_x + b.xy * to_y) - x,
             to_y - gap * (b.xy * to_x + b.yy * to_y) - y},
            {to_x, to_y}};
  }
};

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
/// Beside a maximum of the gap: given up, or left downhill.
enum class Hills : std::uint8_t { end, leads_down };
std::optional<Met> meet(const Meeting& m, const nurbs::Place& on_a, const nurbs::Place& on_b,
                        Hills hills = Hills::end) {
  const bool leaves = hills == Hills::leads_down;
  const int most_steps = leaves ? kMostStepsDown : kMostSteps;
  Local a = m.a.at(on_a), b = m.b.at(on_b);
  for (int step = 0;; ++step) {
    if (!(glm::dot(a.normal, b.normal) < -0.2)) return std::nullopt;
    const Frame f = frame_about(b.normal);
    const Vec3 apart = a.jet.s - b.jet.s;
    const Real x = glm::dot(apart, f.x), y = glm::dot(apart, f.y);
    const Real high = glm::dot(apart, b.normal);
    const Step of{height_of(a, f),
                  height_of(b, f),
                  x,
                  y,
                  high,
                  kFits / m.size,
                  leaves ? kDownhill * m.size : 0};
    const auto by = of.moves();
    if (!by) return std::nullopt;
    const Real most = std::max(std::hypot(by->a[0], by->a[1]), std::hypot(by->b[0], by->b[1]));
    if (!(most <= m.size)) return std::nullopt;
    if (most < 1e-12 * m.size || step == most_steps) {
      if (std::hypot(x, y) > kMeets * m.size || glm::length(a.normal + b.normal) > kAlong)
        return std::nullopt;
      return Met{a, b, high};
    }
    a = m.a.at(m.a.moved(a, by->a[0] * f.x + by->a[1] * f.y));
    b = m.b.at(m.b.moved(b, by->b[0] * f.x + by->b[1] * f.y));
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
  // A tile that the seed is in front of, or behind as deep as a contact may be, lies along the
  // seed's normal within the angle of kFacing.
  const auto lies_along = [&](const Aabb& box) {
    const Vec3 way = 0.5 * (box.low + box.high) - p;
    const Real radius = 0.5 * glm::distance(box.low, box.high), along = glm::dot(way, n);
    return along + radius + m.spacing > -kDeepest * k.size &&
           std::abs(along) + radius + m.spacing > -kFacing * (glm::length(way) - radius);
  };
  other.tree.nearest(
      p, best,
      [&](std::uint32_t i) {
        if (glm::dot(other.normals[i], n) > kFacing) return Real(1e300);
        const Vec3 way = way_from(other, i, p);
        if (glm::dot(way, way) < best) best = glm::dot(way, way), tile = i;
        return best;
      },
      [&](std::uint32_t node) {
        return other.cones[node].least_cosine(n) <= kFacing + kRounding &&
               lies_along(other.tree.box_of(node));
      });
  if (!tile) return std::nullopt;
  const Vec3 way = way_from(other, *tile, p);
  const Real gap = glm::dot(other.normals[*tile], way);
  // Beside the faces, not in front of them.
  if (glm::dot(way, way) > gap * gap + m.spacing * m.spacing) return std::nullopt;
  return SkinScratch::Candidate{gap, seed, *tile};
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

/// Whether a candidate may be of a contact: a seed deep behind the face that it faces has to be
/// inside the other skin, not beyond it. By the triangles.
bool is_inside(const Seeking& k, const SkinScratch::Candidate& c) {
  const SkinModel& other = *k.to.model;
  if (c.gap > -kShallow * k.size || !other.is_closed) return true;
  const Vec3 p = to_world(k.at, k.from.model->seed_points[c.seed]);
  const auto tile = nearest_tile_of(other, p, -c.gap + other.chord);
  return !tile || glm::dot(other.normals[*tile], way_from(other, *tile, p)) <= other.chord;
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
  const bool encloses = m.a.surface.model->is_closed && m.b.surface.model->is_closed;
  if (met->gap < -kDeep * m.size && !(encloses && holds(m.a.surface, m.a.own(met->b.jet.s))))
    return;
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
    if (!is_inside(k, c)) continue;
    start(c);
    taken[count++] = p;
    if (count == kMostStarts) return;
  }
}

nurbs::Place place_of_tile(const Surface& s, std::uint32_t tile) {
  return s.model->tiles.places[s.model->tiles.triangles[tile][0]];
}

Meeting meeting_of(const SkinPair& pair) {
  return {{pair.a, glm::mat3_cast(pair.a_in_b.rotation), pair.a_in_b.position},
          {pair.b, Mat3(1), Vec3(0)},
          std::min(pair.a.model->size, pair.b.model->size)};
}

void touch_rounds(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out) {
  const Surface &a = pair.a, &b = pair.b;
  const Pose& a_in_b = pair.a_in_b;
  const Meeting m = meeting_of(pair);
  const Real size = m.size, margin = std::max(out.margin, Real(0));
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

bool is_of_rounds(std::uint64_t feature) { return (feature >> 40 & 7) >= kOfA >> 40; }

std::optional<SkinTouch> follow_touch(const SkinPair& pair, const nurbs::Place& on_a,
                                      const nurbs::Place& on_b) {
  const auto met = meet(meeting_of(pair), on_a, on_b, Hills::leads_down);
  if (!met) return std::nullopt;
  return SkinTouch{met->a.at, met->b.at, met->a.jet.s, met->b.jet.s, met->b.normal};
}

void collide_skins(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out) {
  const std::size_t first = out.points.size();
  const Real size = std::min(pair.a.model->size, pair.b.model->size);
  touch_rounds(pair, scratch, out);
  touch_edges(pair, scratch, out);
  drop_duplicates(out.points, first, 1e-4 * size);
  reduce_directed(out.points, first, kMostPoints, size);
}

}  // namespace pantin::detail
