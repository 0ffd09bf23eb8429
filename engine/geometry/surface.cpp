#include "engine/geometry/surface.hpp"

#include <algorithm>
#include <sstream>
#include <tuple>

#include "engine/base/archive.hpp"
#include "engine/geometry/skin_model.hpp"

namespace pantin::detail {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

std::string text(Vec3 p) {
  std::ostringstream out;
  out << '(' << p.x << ", " << p.y << ", " << p.z << ')';
  return out.str();
}

std::string numbered(const char* what, std::size_t index) {
  return std::string("mesh: ") + what + ' ' + std::to_string(index);
}

/// A directed edge, sorted so that the two triangles of an edge come one after the other.
struct HalfEdge {
  std::uint32_t low, high, triangle, edge;
  bool forward;  // from low to high
};

std::vector<HalfEdge> half_edges(std::span<const Triangle> triangles) {
  std::vector<HalfEdge> all;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t e = 0; e < 3; ++e) {
      const std::uint32_t a = triangles[t][e], b = triangles[t][(e + 1) % 3];
      all.push_back({std::min(a, b), std::max(a, b), t, e, a < b});
    }
  std::sort(all.begin(), all.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return all;
}

/// Errors of single points and triangles.
std::vector<Error> check_triangles(std::span<const Vec3> points,
                                   std::span<const Triangle> triangles) {
  std::vector<Error> errors;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!is_finite(points[i]))
      errors.push_back({numbered("point", i) + " is " + text(points[i]) + ", expected numbers"});
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Triangle& corners = triangles[t];
    const auto wrong = std::find_if(corners.begin(), corners.end(),
                                    [&](std::uint32_t c) { return c >= points.size(); });
    if (wrong != corners.end()) {
      errors.push_back({numbered("triangle", t) + " names point " + std::to_string(*wrong) +
                        ", expected one below " + std::to_string(points.size())});
      continue;
    }
    const Vec3 a = points[corners[0]], b = points[corners[1]] - a, c = points[corners[2]] - a;
    const Real area = glm::length(glm::cross(b, c)),
               long_side = glm::max(glm::dot(b, b), glm::dot(c, c));
    if (is_finite(a + b + c) && !(area > 1e-12 * long_side))
      errors.push_back({numbered("triangle", t) + " has no area, its points are " + text(a) + ", " +
                        text(a + b) + ", " + text(a + c)});
  }
  if (triangles.empty()) errors.push_back({"mesh has no triangles, expected four or more"});
  return errors;
}

/// Errors of edges that are not shared by two triangles in opposite directions.
std::vector<Error> check_edges(std::span<const HalfEdge> edges) {
  std::vector<Error> errors;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high)
      ++end;
    const std::string where = "mesh is not closed: edge " + std::to_string(edges[i].low) + "-" +
                              std::to_string(edges[i].high) + " of triangle " +
                              std::to_string(edges[i].triangle);
    if (end - i == 1)
      errors.push_back({where + " belongs to no other triangle, expected two"});
    else if (end - i > 2)
      errors.push_back(
          {where + " belongs to " + std::to_string(end - i) + " triangles, expected two"});
    else if (edges[i].forward == edges[i + 1].forward)
      errors.push_back({where + " runs the same way in triangle " +
                        std::to_string(edges[i + 1].triangle) +
                        ", expected opposite ways: one of them has the wrong orientation"});
    i = end;
  }
  return errors;
}

Real enclosed_volume(const Surface& s) {
  const Vec3 apex = (s.low + s.high) / 2.0;
  Real sum = 0;
  for (std::uint32_t t = 0; t < s.faces.size(); ++t) {
    const auto [a, b, c] = triangle_of(s, t);
    sum += glm::dot(a - apex, glm::cross(b - apex, c - apex)) / 6;
  }
  return sum;
}

void add_bounds(Surface& s) {
  Aabb bounds;
  for (Vec3 p : s.points) bounds.add(p);
  s.low = bounds.low, s.high = bounds.high;
}

/// The error of a surface that does not equal `made`, or null.
const char* differs(const Result<std::shared_ptr<const Surface>>& made, const Surface& s) {
  return made && same_fields(**made, s) ? nullptr : "is not a complete surface";
}

const char* check_hull(const Surface& s) {
  constexpr const char* kWrong = "names a point or a face that does not exist";
  const auto below = [](const auto& list, std::size_t count) {
    for (const auto& pair : list)
      for (std::uint32_t index : pair)
        if (index >= count) return false;
    return true;
  };
  if (s.points.size() < 4 || s.points.size() > 256 || s.faces.size() < 4) return "is not a hull";
  for (Vec3 p : s.points)
    if (!is_finite(p)) return "has a point that is not finite";
  for (std::uint32_t corner : s.corners)
    if (corner >= s.points.size()) return kWrong;
  for (const Face& f : s.faces)
    if (f.count < 3 || f.first > s.corners.size() || f.count > s.corners.size() - f.first)
      return kWrong;
  if (s.sides.size() != s.edges.size()) return kWrong;
  return below(s.edges, s.points.size()) && below(s.sides, s.faces.size()) ? nullptr : kWrong;
}

}  // namespace

const char* Surface::restored() {
  if (skin) {
    auto made = make_skin(skin);
    if (!made) return "is a skin that is inside out";
    *this = **made;
    return nullptr;
  }
  if (columns > 0 || rows > 0) {
    if (points.size() != static_cast<std::size_t>(columns) * rows)
      return "is not a complete surface";
    std::vector<Real> heights;
    for (Vec3 p : points) heights.push_back(p.y);
    return differs(make_height_field({columns, rows, spacing_x, spacing_z, heights}), *this);
  }
  if (neighbours.empty()) return check_hull(*this);
  if (corners.size() % 3 != 0) return "is not a complete surface";
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < corners.size(); i += 3)
    triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  auto made = make_mesh(points, triangles);
  if (const char* why = differs(made, *this)) return why;
  tree = (*made)->tree;
  return nullptr;
}

std::array<Vec3, 3> triangle_of(const Surface& s, std::uint32_t index) {
  if (s.columns == 0) {
    const std::uint32_t* c = &s.corners[s.faces[index].first];
    return {s.points[c[0]], s.points[c[1]], s.points[c[2]]};
  }
  const std::uint32_t cell = index / 2, row = cell / (s.columns - 1),
                      column = cell % (s.columns - 1);
  const std::uint32_t near = row * s.columns + column, far = near + s.columns;
  if (index % 2 == 0) return {s.points[near], s.points[far], s.points[far + 1]};
  return {s.points[near], s.points[far + 1], s.points[near + 1]};
}

std::uint32_t neighbour_of(const Surface& s, std::uint32_t index, std::uint32_t edge) {
  if (s.columns == 0) return s.neighbours[index][edge];
  const std::uint32_t across = s.columns - 1, cell = index / 2;
  const std::uint32_t row = cell / across, column = cell % across;
  if (index % 2 == 0) {  // edges: at low x, at high z, the diagonal
    if (edge == 0) return column > 0 ? 2 * (cell - 1) + 1 : UINT32_MAX;
    if (edge == 1) return row + 2 < s.rows ? 2 * (cell + across) + 1 : UINT32_MAX;
    return index + 1;
  }
  // Edges: the diagonal, at high x, at low z.
  if (edge == 0) return index - 1;
  if (edge == 1) return column + 2 < s.columns ? 2 * (cell + 1) : UINT32_MAX;
  return row > 0 ? 2 * (cell - across) : UINT32_MAX;
}

Vec3 normal_of(const Surface& s, std::uint32_t triangle) {
  if (s.columns == 0) return s.faces[triangle].normal;
  const auto p = triangle_of(s, triangle);
  return glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
}

Vec3 nearest_in(const std::array<Vec3, 3>& t, Vec3 p) {
  const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const Real d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return t[0];
  const Vec3 bp = p - t[1];
  const Real d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return t[1];
  const Real vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return t[0] + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - t[2];
  const Real d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return t[2];
  const Real vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return t[0] + d2 / (d2 - d6) * ac;
  const Real va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return t[1] + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t[2] - t[1]);
  const Real sum = va + vb + vc;
  return t[0] + vb / sum * ab + vc / sum * ac;
}

NearestTile nearest_tile(const Surface& s, Vec3 p) {
  NearestTile found;
  Real facing = 0, best = 1e300;
  const Real slack = 1e-12 * glm::dot(s.high - s.low, s.high - s.low);
  s.tree.nearest(p, 1e300, [&](std::uint32_t index) {
    const Vec3 way = p - nearest_in(triangle_of(s, index), p);
    const Real d = glm::dot(way, way), up = glm::dot(s.faces[index].normal, way);
    // At an edge or vertex several triangles are equally near; the one with the most frontal normal
    // determines the side.
    const bool better = d < best - slack || (d <= best + slack && std::abs(up) > std::abs(facing));
    if (better) facing = up, found = {index, up < 0};
    best = glm::min(best, d);
    return d + slack;
  });
  return found;
}

std::uint32_t cell_at(Real x, Real spacing, std::uint32_t lines) {
  const Real at = std::floor(x / spacing + (lines - 1) / 2.0);
  return static_cast<std::uint32_t>(glm::clamp(at, Real(0), static_cast<Real>(lines - 2)));
}

std::uint32_t tile_at(const Surface& s, Vec3 p) {
  const std::uint32_t column = cell_at(p.x, s.spacing_x, s.columns),
                      row = cell_at(p.z, s.spacing_z, s.rows);
  const Real u = p.x / s.spacing_x + (s.columns - 1) / 2.0 - column,
             w = p.z / s.spacing_z + (s.rows - 1) / 2.0 - row;
  return 2 * (row * (s.columns - 1) + column) + (u > w ? 1 : 0);
}

Result<std::shared_ptr<const Surface>> make_mesh(std::span<const Vec3> points,
                                                 std::span<const Triangle> triangles) {
  std::vector<Error> errors = check_triangles(points, triangles);
  if (!errors.empty()) return errors;
  const std::vector<HalfEdge> edges = half_edges(triangles);
  errors = check_edges(edges);
  if (!errors.empty()) return errors;

  auto s = std::make_shared<Surface>();
  s->points.assign(points.begin(), points.end());
  s->neighbours.resize(triangles.size());
  for (std::size_t i = 0; i < edges.size(); i += 2) {
    s->neighbours[edges[i].triangle][edges[i].edge] = edges[i + 1].triangle;
    s->neighbours[edges[i + 1].triangle][edges[i + 1].edge] = edges[i].triangle;
  }
  std::vector<Aabb> boxes(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec3 a = points[triangles[t][0]], b = points[triangles[t][1]],
               c = points[triangles[t][2]];
    const Vec3 normal = glm::normalize(glm::cross(b - a, c - a));
    s->faces.push_back({static_cast<std::uint32_t>(3 * t), 3, normal, glm::dot(normal, a)});
    s->corners.insert(s->corners.end(), triangles[t].begin(), triangles[t].end());
    for (Vec3 p : {a, b, c}) boxes[t].add(p);
  }
  add_bounds(*s);
  s->tree.build(boxes);
  const Real inside = enclosed_volume(*s);
  if (!(inside > 0)) {
    std::ostringstream out;
    out << "mesh is inside out: it encloses " << inside
        << " m^3; expected corners anticlockwise seen from outside";
    return Error{out.str()};
  }
  return std::shared_ptr<const Surface>(std::move(s));
}

Result<std::shared_ptr<const Surface>> make_height_field(const HeightGrid& grid) {
  const auto [columns, rows, spacing_x, spacing_z, heights] = grid;
  std::vector<Error> errors;
  const auto complain = [&](const auto&... parts) {
    std::ostringstream out;
    out << "height field";
    (out << ... << parts);
    errors.push_back({out.str()});
  };
  if (columns < 2 || rows < 2)
    complain(" has ", columns, " columns and ", rows, " rows, expected at least 2 of each");
  if (!(spacing_x > 0 && spacing_z > 0 && std::isfinite(spacing_x + spacing_z)))
    complain(" has spacings of ", spacing_x, " and ", spacing_z, " m, expected them above 0");
  if (heights.size() != static_cast<std::size_t>(columns) * rows)
    complain(" has ", heights.size(), " heights, expected columns times rows, ",
             static_cast<std::size_t>(columns) * rows);
  for (std::size_t i = 0; i < heights.size(); ++i)
    if (!std::isfinite(heights[i]))
      complain(": height ", i, " is ", heights[i], ", expected a number");
  if (!errors.empty()) return errors;

  auto s = std::make_shared<Surface>();
  s->columns = columns, s->rows = rows, s->spacing_x = spacing_x, s->spacing_z = spacing_z;
  s->points.reserve(heights.size());
  for (std::uint32_t r = 0; r < rows; ++r)
    for (std::uint32_t c = 0; c < columns; ++c)
      s->points.push_back({(c - (columns - 1) / 2.0) * spacing_x,
                           heights[static_cast<std::size_t>(r) * columns + c],
                           (r - (rows - 1) / 2.0) * spacing_z});
  add_bounds(*s);
  return std::shared_ptr<const Surface>(std::move(s));
}

}  // namespace pantin::detail
