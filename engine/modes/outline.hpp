#pragma once
/// Outlines of laminas: simple polygons, corners counter-clockwise.
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/modes/lamina.hpp"

namespace pantin::detail::modes {

inline Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
inline Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
inline Vec2 operator*(Real s, Vec2 a) { return {s * a.x, s * a.y}; }
inline Real length(Vec2 a) { return std::sqrt(dot(a, a)); }
/// Turned by an angle whose cosine and sine these are.
inline Vec2 turned(Vec2 a, Real c, Real s) { return {c * a.x - s * a.y, s * a.x + c * a.y}; }

/// Positive where the corners run counter-clockwise, m^2.
Real area(std::span<const Vec2> corners);
/// Middle of the area.
Vec2 centroid(std::span<const Vec2> corners);
/// Largest extent along x or y, m.
Real extent(std::span<const Vec2> corners);
/// Two edges that cross or touch and are no neighbours; numbers of their first corners.
std::optional<std::pair<std::size_t, std::size_t>> crossing(std::span<const Vec2> corners);
bool is_inside(std::span<const Vec2> corners, Vec2 p);
bool is_convex(std::span<const Vec2> corners);
/// The outline itself if it is convex, else triangles.
std::vector<std::vector<Vec2>> convex_pieces(std::span<const Vec2> corners);

/// The edge from a corner to the next.
struct Edge {
  Vec2 from, along, normal;  // unit vectors, normal into the lamina
  Real length = 0;
};
Edge edge_of(std::span<const Vec2> corners, std::size_t edge);

/// The point of an outline that is nearest to a given one.
struct Nearest {
  std::size_t edge = 0;
  Real distance = 0;       // m, 0 or more
  bool is_corner = false;  // both edges at it are equally near
};
Nearest nearest_edge(std::span<const Vec2> corners, Vec2 p, Real tolerance);

}  // namespace pantin::detail::modes
