#include "engine/geometry/skin_features.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <tuple>

#include "engine/nurbs/tessellate.hpp"
#include "engine/nurbs/trim.hpp"

namespace pantin::detail {
namespace {

constexpr Real kSmooth = 0.02;     // rad: smaller creases count as smooth
constexpr Real kTurn = 0.25;       // rad, rotation of the tangent over a part of a round edge
constexpr Real kStraight = 1e-10;  // of the skin's size
constexpr Real kOn = -0.999;       // cosine between directions where an edge continues
constexpr int kMostParts = 32;     // of a polynomial piece
constexpr int kAround = 8;         // directions sampled at a pole
constexpr int kLooks = 64;         // along a line, for where a trim cuts it off
constexpr int kBisections = 48;
constexpr Real kBeside = 1e-6;  // of the domain: from a loop to the side that it keeps

using nurbs::Along;
using nurbs::Face;
using nurbs::Jet;
using nurbs::Skin;
enum class Fold { convex, hollow, smooth };
enum class Side { here, beyond };  // of a knot

bool is_of_u(const EdgeLine& line) { return line.stays == Along::u; }
bool is_loop(const EdgeLine& line) { return line.loop >= 0; }
Along other_of(Along way) { return way == Along::u ? Along::v : Along::u; }

/// A line of constant parameter on a face, and its neighbour across: another face, the same face
/// beyond a crease knot, or nothing.
struct Line {
  EdgeLine on;
  bool is_low = false;     // the face is on the side of higher parameters
  bool is_inside = false;  // a crease knot inside the face, not its end
};

/// A point of such a line. A rim has one side only.
struct Station {
  Vec3 point{0}, tangent{0};
  std::array<Vec3, 2> normals, into;
  bool is_rim = false;
};

const nurbs::Knots& knots_of(const Face& face, Along way) {
  return way == Along::u ? face.u() : face.v();
}

/// A place of a loop, and the derivatives of its parameters. By the part in the middle of the line:
/// at its ends one-sided.
nurbs::CurveDerivatives on_loop(const Face& face, const EdgeLine& line, Real s) {
  const nurbs::Trim& trim = *face.trim();
  nurbs::OnTrim at = trim.on(static_cast<std::size_t>(line.loop), line.along.middle());
  at.t = s;
  nurbs::CurveDerivatives c = trim.at(at);
  c[0] = {face.u().domain().clamped(c[0].x), face.v().domain().clamped(c[0].y), 0};
  return c;
}

std::array<Real, 2> place_at(const EdgeLine& line, Real s) {
  return is_of_u(line) ? std::array{line.fixed, s} : std::array{s, line.fixed};
}

Vec3 unit(Vec3 v) {
  const Real length = glm::length(v);
  return length > 0 ? v / length : Vec3(0);
}

class Finder {
 public:
  explicit Finder(const Skin& skin) : skin_(skin) {}
  SkinFeatures run();

 private:
  struct End {
    Vec3 point, way;
    std::size_t part, side;  // of parts_, and which end of that
  };
  struct Part {
    EdgePart edge;
    Fold fold;
  };

  void add_face(int face);
  void add_creases(int face, Along stays);
  void add_line(const Line& line);
  void add_kept_parts(const Line& line, const nurbs::Range& span);
  void add_loops(int face);
  void add_pole(const Line& line);
  void add_parts(const Line& line, const nurbs::Range& span);
  void add_part(const Line& line, const Station& from, const Station& to);
  void add_nodes();
  void add_node(std::span<const End> node);
  void add_edge_ends(std::span<const End> node);
  void build_trees();

  bool is_pole(const Line& line) const;
  bool is_counted_across(const Line& line) const;
  Jet jet(const Line& line, Real s, Side side) const;
  Station station(const Line& line, Real s) const;
  Station loop_station(const Line& line, Real s) const;

  const Skin& skin_;
  SkinFeatures made_;
  std::vector<Part> parts_;
  std::vector<End> ends_;
};

/// Evaluates the face on its own side of the line's knot, or beyond the knot.
Jet Finder::jet(const Line& line, Real s, Side side) const {
  const Face& face = skin_.face(line.on.face);
  if (is_loop(line.on)) {
    const Vec3 on = on_loop(face, line.on, s)[0];
    return face.at(on.x, on.y);
  }
  const nurbs::Knots& own = knots_of(face, line.on.stays);
  auto at = place_at(line.on, s);
  Face::Piece piece = face.piece_at(at[0], at[1]);
  if (line.is_inside && side == Side::beyond) {  // below the knot; at a seam, at the other end
    Real& t = is_of_u(line.on) ? at[0] : at[1];
    std::size_t& which = is_of_u(line.on) ? piece.u : piece.v;
    if (t > own.low())
      --which;
    else
      t = own.high(), piece = face.piece_at(at[0], at[1]);
  }
  return face.at(piece, at[0], at[1]);
}

/// A point of a loop is one of a rim: the face is on the side that the trim keeps.
Station Finder::loop_station(const Line& line, Real s) const {
  const Face& face = skin_.face(line.on.face);
  const nurbs::CurveDerivatives c = on_loop(face, line.on, s);
  const Jet here = face.at(c[0].x, c[0].y);
  Station found;
  found.point = here.s, found.is_rim = true;
  found.tangent = unit(c[1].x * here.u + c[1].y * here.v);
  found.normals[0] = found.normals[1] = nurbs::normal_at(face, c[0].x, c[0].y);
  const Real wide = face.u().domain().width(), high = face.v().domain().width();
  const Vec3 left = kBeside * unit({-c[1].y / high, c[1].x / wide, 0});
  const bool is_left = face.holds(c[0].x + left.x * wide, c[0].y + left.y * high);
  found.into[0] = (is_left ? 1.0 : -1.0) * glm::cross(found.normals[0], found.tangent);
  found.into[1] = found.into[0];
  return found;
}

Station Finder::station(const Line& line, Real s) const {
  if (is_loop(line.on)) return loop_station(line, s);
  const Face& face = skin_.face(line.on.face);
  const auto at = place_at(line.on, s);
  const Jet here = jet(line, s, Side::here);
  Station found;
  found.point = here.s;
  found.tangent = unit(is_of_u(line.on) ? here.v : here.u);
  const Vec3 inwards = (line.is_low ? 1.0 : -1.0) * (is_of_u(line.on) ? here.u : here.v);
  const Vec3 cross = glm::cross(here.u, here.v);
  found.normals[0] = line.is_inside ? unit(cross) : nurbs::normal_at(face, at[0], at[1]);
  const Vec3 side = glm::cross(found.normals[0], found.tangent);
  const Real sign = glm::dot(side, inwards) < 0 ? -1 : 1;
  found.into[0] = sign * side;
  if (line.is_inside) {
    const Jet beyond = jet(line, s, Side::beyond);
    found.normals[1] = unit(glm::cross(beyond.u, beyond.v));
  } else {
    using enum nurbs::Edge;
    const nurbs::Edge edge =
        is_of_u(line.on) ? (line.is_low ? u_low : u_high) : (line.is_low ? v_low : v_high);
    const auto to = skin_.across({line.on.face, at[0], at[1]}, edge);
    found.is_rim = !to;
    if (!to) {
      found.normals[1] = found.normals[0], found.into[1] = found.into[0];
      return found;
    }
    found.normals[1] = nurbs::normal_at(skin_.face(to->face), to->u, to->v);
  }
  found.into[1] = -sign * glm::cross(found.normals[1], found.tangent);
  return found;
}

bool Finder::is_pole(const Line& line) const {
  const Vec3 first = jet(line, line.on.along.low, Side::here).s;
  for (const Real share : {0.3, 0.7, 1.0}) {
    const Real s = line.on.along.low + share * line.on.along.width();
    if (glm::distance(jet(line, s, Side::here).s, first) > skin_.tolerance() + 1e-9 * skin_.size())
      return false;
  }
  return true;
}

/// An edge shared by two faces is added once, by the first face.
bool Finder::is_counted_across(const Line& line) const {
  using enum nurbs::Edge;
  const nurbs::Edge edge =
      is_of_u(line.on) ? (line.is_low ? u_low : u_high) : (line.is_low ? v_low : v_high);
  const auto other = skin_.neighbour(line.on.face, edge);
  return other && (*other < line.on.face || (*other == line.on.face && !line.is_low));
}

void Finder::add_face(int face) {
  const Face& f = skin_.face(face);
  for (const Along stays : {Along::u, Along::v}) {
    const nurbs::Knots& own = knots_of(f, stays);
    const nurbs::Range other = knots_of(f, other_of(stays)).domain();
    add_creases(face, stays);
    if (own.is_periodic) continue;
    for (const bool is_low : {true, false}) {
      const Line line{{face, stays, is_low ? own.low() : own.high(), other}, is_low, false};
      const auto middle = place_at(line.on, other.middle());
      if (is_pole(line) && !f.holds(middle[0], middle[1])) continue;
      if (is_pole(line))
        add_pole(line);
      else if (!is_counted_across(line))
        add_line(line);
    }
  }
  if (f.trim()) add_loops(face);
}

/// The parts of all loops, except along the ends of the domain, which are lines.
void Finder::add_loops(int face) {
  const nurbs::Trim& trim = *skin_.face(face).trim();
  for (std::size_t k = 0; k < trim.loops().size(); ++k)
    for (const auto& leaf : trim.loops()[k].leaves()) {
      const Vec3 at = nurbs::evaluate(trim.loops()[k].curve(), leaf.t.middle(), 0)[0];
      const Real inside = std::min({at.x, 1 - at.x, at.y, 1 - at.y});
      if (inside > kBeside)
        add_parts({{face, Along::u, 0, leaf.t, static_cast<int>(k)}, false, false}, leaf.t);
    }
}

void Finder::add_creases(int face, Along stays) {
  const Face& f = skin_.face(face);
  const nurbs::Knots& own = knots_of(f, stays);
  for (const Real knot : own.breaks()) {
    const bool is_end = knot <= own.low() || knot >= own.high();
    if (is_end && !(own.is_periodic && knot <= own.low())) continue;
    if (!is_end && own.multiplicity(knot) < own.degree) continue;
    add_line({{face, stays, knot, knots_of(f, other_of(stays)).domain()}, true, true});
  }
}

/// A pole: an edge of a face that is one point. It is a corner unless the surface is flat around
/// it.
void Finder::add_pole(const Line& line) {
  Corner tip;
  tip.point = jet(line, line.on.along.low, Side::here).s;
  Vec3 sum(0);
  for (int i = 0; i < kAround; ++i) {
    const Real s = line.on.along.low + line.on.along.width() * (i + 0.5) / kAround;
    const Jet here = jet(line, s, Side::here);
    const Vec3 way = unit((line.is_low ? 1.0 : -1.0) * (is_of_u(line.on) ? here.u : here.v));
    sum += nurbs::normal_at(skin_.face(line.on.face), place_at(line.on, s)[0],
                            place_at(line.on, s)[1]);
    tip.add(way);
  }
  const Vec3 mean = unit(sum);
  Real rise = 0;
  for (const Vec3 way : tip.ways) rise = std::min(rise, glm::dot(mean, way));
  if (rise < -kSmooth) made_.corners.push_back(tip);
}

void Finder::add_line(const Line& line) {
  const nurbs::Knots& free = knots_of(skin_.face(line.on.face), other_of(line.on.stays));
  const std::vector<Real> breaks = free.breaks();
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
    add_kept_parts(line, {breaks[i], breaks[i + 1]});
}

/// Without what a trim cuts off.
void Finder::add_kept_parts(const Line& line, const nurbs::Range& span) {
  const Face& face = skin_.face(line.on.face);
  if (!face.trim()) return add_parts(line, span);
  const auto is_kept = [&](Real s) {
    const auto at = place_at(line.on, s);
    return face.holds(at[0], at[1]);
  };
  const auto change = [&](Real from, Real to) {
    const bool was = is_kept(from);
    for (int round = 0; round < kBisections; ++round) {
      const Real middle = (from + to) / 2;
      (is_kept(middle) == was ? from : to) = middle;
    }
    return (from + to) / 2;
  };
  Real begin = span.low;
  for (int i = 0; i < kLooks; ++i) {
    const Real from = span.low + span.width() * i / kLooks;
    const Real to = i + 1 < kLooks ? span.low + span.width() * (i + 1) / kLooks : span.high;
    if (is_kept(from) != is_kept(to)) {
      const Real at = change(from, to);
      if (is_kept(from)) add_parts(line, {begin, at});
      begin = at;
    }
    if (i + 1 == kLooks && is_kept(to)) add_parts(line, {begin, to});
  }
}

void Finder::add_parts(const Line& line, const nurbs::Range& span) {
  const auto at = [&](Real share) {
    // Just inside the piece, to tell the two sides of a knot apart.
    const Real inside = std::clamp(share, 1e-9, 1 - 1e-9);
    Station found = station(line, span.low + inside * span.width());
    found.point = jet(line, span.low + share * span.width(), Side::here).s;
    return found;
  };
  const Station low = at(0), high = at(1);
  Real turn = 0;
  Station last = low;
  for (const Real share : {0.25, 0.5, 0.75, 1.0}) {
    const Station here = share < 1 ? at(share) : high;
    turn += std::acos(std::clamp(glm::dot(last.tangent, here.tangent), Real(-1), Real(1)));
    last = here;
  }
  const bool is_straight = turn < 1e-6;
  const int parts =
      is_straight ? 1 : std::clamp(static_cast<int>(std::ceil(turn / kTurn)), 1, kMostParts);
  Station from = low;
  for (int k = 1; k <= parts; ++k) {
    const Station to = k < parts ? at(Real(k) / parts) : high;
    Line part = line;
    part.on.along = {span.low + span.width() * (k - 1) / parts,
                     span.low + span.width() * k / parts};
    add_part(part, from, to);
    from = to;
  }
}

void Finder::add_part(const Line& line, const Station& from, const Station& to) {
  const Station middle = station(line, line.on.along.middle());
  const Real depth = glm::dot(middle.normals[0], middle.into[1]);
  const Fold fold = middle.is_rim || depth < -kSmooth ? Fold::convex
                    : depth > kSmooth                 ? Fold::hollow
                                                      : Fold::smooth;
  if (fold == Fold::smooth) return;
  EdgePart edge;
  edge.from = from.point, edge.to = to.point;
  edge.normals = middle.normals, edge.into = middle.into;
  edge.line = line.on;
  const Real length = glm::distance(edge.from, edge.to);
  edge.is_straight =
      glm::distance(middle.point, (edge.from + edge.to) / 2.0) <= kStraight * skin_.size() &&
      glm::dot(from.tangent, to.tangent) > 1 - 1e-12;
  if (!(length > kStraight * skin_.size())) return;
  ends_.push_back({from.point, from.tangent, parts_.size(), 0});
  ends_.push_back({to.point, -to.tangent, parts_.size(), 1});
  parts_.push_back({edge, fold});
}

/// Groups the ends of parts that coincide.
void Finder::add_nodes() {
  const Real same = 2 * skin_.tolerance() + 1e-7 * skin_.size();
  std::sort(ends_.begin(), ends_.end(), [](const End& a, const End& b) {
    return std::tie(a.point.x, a.part) < std::tie(b.point.x, b.part);
  });
  std::vector<bool> is_taken(ends_.size(), false);
  std::vector<End> node;
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    if (is_taken[i]) continue;
    node.clear();
    for (std::size_t j = i; j < ends_.size() && ends_[j].point.x <= ends_[i].point.x + same; ++j)
      if (!is_taken[j] && glm::distance(ends_[j].point, ends_[i].point) <= same)
        node.push_back(ends_[j]), is_taken[j] = true;
    add_node(node);
  }
}

void Finder::add_node(std::span<const End> node) {
  Corner corner;
  corner.point = node[0].point;
  bool is_convex = false, is_round = false, is_hollow = false;
  for (const End& end : node) {
    is_hollow = is_hollow || parts_[end.part].fold == Fold::hollow;
    is_convex = is_convex || parts_[end.part].fold == Fold::convex;
    is_round = is_round || !parts_[end.part].edge.is_straight;
    bool is_new = true;
    for (std::uint32_t k = 0; k < corner.count; ++k)
      is_new = is_new && glm::dot(corner.ways[k], end.way) < 1 - 1e-6;
    if (is_new) corner.add(end.way);
  }
  if (!is_convex) return;
  const bool goes_on =
      corner.count == 1 || (corner.count == 2 && glm::dot(corner.ways[0], corner.ways[1]) < kOn);
  if (goes_on) {
    if (corner.count == 2 && !is_round) return;
    if (corner.count == 1) corner.add(-corner.ways[0]);
    for (const Vec3 way : parts_[node[0].part].edge.into) corner.add(way);
  }
  if (is_hollow && !goes_on) return add_edge_ends(node);
  for (const End& end : node)
    parts_[end.part].edge.ends[end.side] = static_cast<std::uint32_t>(made_.corners.size());
  made_.corners.push_back(corner);
}

/// At a node with a concave edge, each convex edge gets a corner of its own: a body may rest on one
/// of them and reach beyond its end.
void Finder::add_edge_ends(std::span<const End> node) {
  for (const End& end : node) {
    Part& part = parts_[end.part];
    if (part.fold != Fold::convex) continue;
    Corner corner;
    corner.point = end.point;
    for (const Vec3 way : {end.way, part.edge.into[0], part.edge.into[1]}) corner.add(way);
    part.edge.ends[end.side] = static_cast<std::uint32_t>(made_.corners.size());
    made_.corners.push_back(corner);
  }
}

void Finder::build_trees() {
  std::vector<Aabb> boxes;
  for (std::uint32_t i = 0; i < made_.corners.size(); ++i) {
    made_.corners[i].number = i;
    boxes.push_back({made_.corners[i].point, made_.corners[i].point});
  }
  made_.corner_tree.build(boxes);
  boxes.clear();
  for (std::uint32_t i = 0; i < made_.edges.size(); ++i) {
    EdgePart& edge = made_.edges[i];
    edge.number = i;
    Aabb box;
    box.add(edge.from), box.add(edge.to);
    if (!edge.is_straight) box.add(point_of(skin_, edge, 0.5).point);
    boxes.push_back(edge.is_straight ? box
                                     : box.grown(kTurn * glm::distance(edge.from, edge.to) / 8));
  }
  made_.edge_tree.build(boxes);
}

SkinFeatures Finder::run() {
  if (skin_.half_axes()) return {};
  for (int f = 0; f < static_cast<int>(skin_.faces().size()); ++f) add_face(f);
  add_nodes();
  for (const Part& part : parts_)
    if (part.fold == Fold::convex) made_.edges.push_back(part.edge);
  build_trees();
  return std::move(made_);
}

}  // namespace

SkinFeatures features_of(const Skin& skin) { return Finder(skin).run(); }

EdgePoint point_of(const Skin& skin, const EdgePart& edge, Real share) {
  if (edge.is_straight) return {glm::mix(edge.from, edge.to, share), edge.to - edge.from};
  const Real s = edge.line.along.low + share * edge.line.along.width();
  const Face& face = skin.face(edge.line.face);
  if (is_loop(edge.line)) {
    const nurbs::CurveDerivatives c = on_loop(face, edge.line, s);
    const Jet j = face.at(c[0].x, c[0].y);
    return {j.s, edge.line.along.width() * (c[1].x * j.u + c[1].y * j.v)};
  }
  const auto at = place_at(edge.line, s);
  const Jet j = face.at(at[0], at[1]);
  return {j.s, edge.line.along.width() * (is_of_u(edge.line) ? j.v : j.u)};
}

}  // namespace pantin::detail
