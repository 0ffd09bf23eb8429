#pragma once
/// Convex hulls, triangle meshes, height fields and NURBS skins. Immutable, so that copies of a
/// World may share them.
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/base/result.hpp"
#include "engine/geometry/aabb_tree.hpp"
#include "engine/nurbs/skin.hpp"

namespace pantin::detail {

struct SkinModel;  // see skin_model.hpp

/// One planar face, vertices anticlockwise seen from outside: a range of `corners`.
struct Face {
  std::uint32_t first = 0, count = 0;
  Vec3 normal{0};   // unit, outwards
  Real offset = 0;  // normal . point of the face, m

  static void fields(auto& self, auto&& field) {
    field("first", self.first);
    field("count", self.count);
    field("normal", self.normal);
    field("offset", self.offset);
  }
};

struct Surface {
  std::vector<Vec3> points;            // m, in the shape's frame
  std::vector<std::uint32_t> corners;  // of all faces, one after the other
  std::vector<Face> faces;             // hull: its flat faces; mesh and height field: triangles
  std::vector<std::array<std::uint32_t, 2>> edges;       // hull: each once
  std::vector<std::array<std::uint32_t, 2>> sides;       // hull: faces left and right of each edge
  std::vector<std::array<std::uint32_t, 3>> neighbours;  // mesh: triangle across each edge
  AabbTree tree;                                         // mesh: over its triangles
  Vec3 low{0}, high{0};                                  // bounds, m
  // height_field: `columns` (along x) by `rows` (along z) heights, spaced by `spacing`; its middle
  // lies at the origin. Triangles follow from the grid.
  std::uint32_t columns = 0, rows = 0;
  Real spacing_x = 0, spacing_z = 0;
  // nurbs: the faces, and data derived from them; all else but the bounds is empty.
  std::shared_ptr<const nurbs::Skin> skin;
  std::shared_ptr<const SkinModel> model;

  static void fields(auto& self, auto&& field) {
    field("points", self.points);
    field("corners", self.corners);
    field("faces", passive(self.faces));
    field("edges", passive(self.edges));
    field("sides", passive(self.sides));
    field("neighbours", passive(self.neighbours));
    field("tree", derived(self.tree));
    field("low", passive(self.low));
    field("high", passive(self.high));
    field("columns", self.columns);
    field("rows", self.rows);
    field("spacing_x", self.spacing_x);
    field("spacing_z", self.spacing_z);
    field("skin", self.skin);
    field("model", derived(self.model));
  }
  /// Makes the tree, or the model of a skin, after reading; null, or the error.
  const char* restored();
};

/// Three corners of a triangle of a mesh or a height field, anticlockwise seen from outside.
///
/// A height field has two a cell: triangle 2 c holds the corners at (x, z), (x, z + 1) and
/// (x + 1, z + 1) of cell c = row * (columns - 1) + column, triangle 2 c + 1 the other two.
std::array<Vec3, 3> triangle_of(const Surface& surface, std::uint32_t index);

/// The triangle across edge `edge` (from corner `edge` to the next), or UINT32_MAX at the rim of a
/// height field.
std::uint32_t neighbour_of(const Surface& surface, std::uint32_t index, std::uint32_t edge);

/// The outward normal of a triangle.
Vec3 normal_of(const Surface& surface, std::uint32_t index);

/// The point of a triangle that is nearest to p. [Ericson 2005, sec. 5.1.5]
Vec3 nearest_in(const std::array<Vec3, 3>& triangle, Vec3 p);

/// The triangle of a mesh nearest to p, and whether p is on its inner side.
struct NearestTile {
  std::uint32_t index = UINT32_MAX;
  bool inside = false;
};
NearestTile nearest_tile(const Surface& mesh, Vec3 p);

/// Number of the cell at `x` along one side of a grid of `lines`, kept within it.
std::uint32_t cell_at(Real x, Real spacing, std::uint32_t lines);

/// The triangle of a height field above or below p; beside the field, one of its rim.
std::uint32_t tile_at(const Surface& height_field, Vec3 p);

/// The convex hull of at least four points that are not coplanar; coplanar triangles are merged. An
/// error for numbers that are not finite and for hulls without volume. At most 256 vertices.
Result<std::shared_ptr<const Surface>> make_hull(std::span<const Vec3> points);

/// A closed triangle mesh, anticlockwise seen from outside. An error for numbers that are not
/// finite, indices out of range, degenerate triangles, edges not shared by exactly two triangles in
/// opposite directions ("mesh is not closed: ..."), and inverted surfaces.
Result<std::shared_ptr<const Surface>> make_mesh(
    std::span<const Vec3> points, std::span<const std::array<std::uint32_t, 3>> triangles);

/// Heights over the points of a grid, `columns` along x by `rows` along z.
struct HeightGrid {
  std::uint32_t columns, rows;
  Real spacing_x, spacing_z;      // m, from point to point
  std::span<const Real> heights;  // [row * columns + column], m
};

/// Terrain. At least 2 by 2, spacings above zero.
Result<std::shared_ptr<const Surface>> make_height_field(const HeightGrid& grid);

}  // namespace pantin::detail
