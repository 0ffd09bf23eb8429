#pragma once
/// The functions that a shape kind provides, and the table of all kinds.
///
/// A kind is one file, engine/geometry/kinds/WORD.cpp, that fills in a ShapeTraits, and one word
/// in kind_list.hpp. Contacts, mass, queries, pictures, scene files and their schema follow from
/// that. A convex kind may leave out every function that can be had from `support`.
#include <optional>
#include <span>
#include <string_view>

#include "engine/geometry/convex.hpp"
#include "engine/geometry/patch.hpp"
#include "engine/geometry/shape.hpp"

namespace pantin::detail {

/// Collision class of a kind.
enum class ShapeClass : std::uint8_t {
  convex,      // one convex piece
  half_space,  // all below y = 0, unbounded
  mesh,        // the inside of Surface::faces, a closed surface of triangles
  heights,     // all below a grid of heights, Surface::columns by Surface::rows
  skin,        // the inside of Surface::skin, convex or not, or an open patch of it
};

/// What a surface is made of, for kinds that have one.
enum class SurfaceSource : std::uint8_t { none, points, triangles, heights, skin };

/// A length that a scene file gives, or three of them.
struct SizeKey {
  std::string_view key;            // "radius"
  std::string_view about;          // for the schema
  int first = 0;                   // components of Shape::size: this one, and those behind it
  int count = 1;                   // 1 or 3
  Real scale = 1;                  // what the number is multiplied by: 0.5 for whole edges
  Real otherwise = 0;              // m, the default; 0: the key is required
  std::string_view expected = {};  // for error messages; empty: a size
};

/// Where a ray in a shape's own frame enters it.
struct RayEntry {
  Real distance = 0;  // m
  Vec3 normal{0, 1, 0};
};

/// The place of a shape's surface nearest to a point, in the shape's own frame.
struct SurfacePoint {
  Vec3 point{0};
  Vec3 normal{0, 1, 0};  // outwards, unit
  Real distance = 0;     // m, from the surface to the point; below 0 inside
};

/// The contact of a rolling shape, in its own frame.
struct Rolling {
  Vec3 point{0};           // m, of the surface
  Vec3 outward{0, -1, 0};  // unit
  Vec3 spin{0};            // rad/s, the shape's angular velocity
};

/// A box about the origin, grown by a radius: spheres, capsules and boxes.
struct RoundedBox {
  Vec3 core{0};     // m, half extents
  Real radius = 0;  // m
};

/// One row of the table. Functions get shapes in their own frame; `Shape::local` is ignored.
struct ShapeTraits {
  std::string_view about;  // one line, for the schema
  ShapeClass shape_class = ShapeClass::convex;
  SurfaceSource source = SurfaceSource::none;
  bool is_round = false;   // invariant under rotations
  bool is_turned = false;  // invariant under rotations about y
  bool is_ground = false;  // drawn, but of less interest than what stands on it
  std::span<const SizeKey> sizes = {};

  // Of a convex kind: the farthest point along a direction, which need not have unit length.
  Vec3 (*support)(const Shape&, Vec3 direction) = nullptr;

  // Volume (m^3) and principal moments for a mass of 1 kg (m^2), of a kind whose mass centre is its
  // origin and whose principal axes are its own; else `enclosed`, at density 1. None: no mass.
  Real (*volume)(const Shape&) = nullptr;
  Vec3 (*unit_moments)(const Shape&) = nullptr;
  MassProperties (*enclosed)(const Shape&) = nullptr;

  // Exact where the kind is a rounded box.
  std::optional<RoundedBox> (*rounded)(const Shape&) = nullptr;

  // Radius of a ball about the origin that lies within the shape, m. None: 0.
  Real (*inner_radius)(const Shape&) = nullptr;

  // Bounds at a pose. None: from `support`.
  Aabb (*bounds)(const Shape&, const Pose&) = nullptr;

  // The shape as corners with flat faces and a radius. None: contacts follow from `support`.
  Convex (*convex_piece)(const Shape&, const Pose&, ConvexScratch&) = nullptr;

  // Where a ray, `way` of unit length, first enters within `limit` (m) of where it starts, which
  // is outside. None: from `support`.
  std::optional<RayEntry> (*cast)(const Shape&, Vec3 from, Vec3 way, Real limit) = nullptr;

  // The nearest point of the surface if that is nearer than `limit` (m), or if `p` is inside.
  // None: from `support`.
  std::optional<SurfacePoint> (*closest)(const Shape&, Vec3 p, Real limit) = nullptr;

  // Of a convex kind without corners: its patch towards a direction. None: from `support` in tilted
  // directions.
  void (*patch)(const Shape&, const Towards&, Patch&) = nullptr;

  // Its flat faces, by normal and offset alone; how many. None: it has none.
  std::size_t (*flat_faces)(const Shape&, std::span<Face, 2>) = nullptr;

  // Radius of curvature (m) of the path that the contact point follows on the rolling shape; 0 at
  // corners. None: that of `rounded`, or 0.
  Real (*rounding)(const Shape&, const Rolling&) = nullptr;
};

/// One constant for each word of the list, defined in the kind's file.
namespace shape_kinds {
#define PANTIN_DECLARE(word) extern const ShapeTraits word;
PANTIN_SHAPE_KINDS(PANTIN_DECLARE)
#undef PANTIN_DECLARE
}  // namespace shape_kinds

/// The words of the list: names of the kinds, in the order of ShapeKind.
inline constexpr std::string_view kShapeNames[] = {
#define PANTIN_NAME(word) #word,
    PANTIN_SHAPE_KINDS(PANTIN_NAME)
#undef PANTIN_NAME
};

inline constexpr const ShapeTraits* kShapeTraits[] = {
#define PANTIN_ROW(word) &shape_kinds::word,
    PANTIN_SHAPE_KINDS(PANTIN_ROW)
#undef PANTIN_ROW
};

inline const ShapeTraits& traits_of(ShapeKind kind) {
  return *kShapeTraits[static_cast<std::size_t>(kind)];
}
inline std::string_view name_of(ShapeKind kind) {
  return kShapeNames[static_cast<std::size_t>(kind)];
}

/// Whether all shapes of a kind are convex.
inline bool is_convex(ShapeKind kind) { return traits_of(kind).shape_class == ShapeClass::convex; }
/// Whether a shape is convex: of a skin, whether it is closed and convex.
bool is_convex(const Shape& shape);
/// Whether dynamic bodies may have shapes of a kind.
inline bool can_move(ShapeKind kind) {
  return is_convex(kind) || traits_of(kind).shape_class == ShapeClass::skin;
}
/// Whether it is solid without bound below its surface, so that its bounds do not limit contacts.
inline bool is_unbounded(ShapeKind kind) {
  const ShapeClass c = traits_of(kind).shape_class;
  return c == ShapeClass::half_space || c == ShapeClass::heights;
}
inline bool has_surface(ShapeKind kind) { return traits_of(kind).source != SurfaceSource::none; }
/// Grounds are drawn, but matter less than what stands on them.
inline bool is_ground(ShapeKind kind) { return traits_of(kind).is_ground; }
/// Whether the shape has the surface that its kind needs.
inline bool is_complete(const Shape& shape) { return !has_surface(shape.kind) || shape.surface; }

/// Distance of the farthest point from the shape's origin, m; of a half-space 0.
Real reach_of(const Shape& shape);

/// Radius of a ball about the origin that lies within the shape, m; 0 if there is none.
Real inner_radius(const Shape& shape);

/// Where a ray in the shape's own frame, `way` of unit length, enters it within `limit` (m) of its
/// start. A ray that starts inside does not enter, unless it leaves and comes back.
std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit);

/// The point of the surface nearest to `p`, in the shape's own frame, if that is nearer than
/// `limit` (m) or if `p` is inside.
std::optional<SurfacePoint> closest(const Shape& shape, Vec3 p, Real limit);

/// Whether `p`, in the shape's own frame, is inside.
bool contains(const Shape& shape, Vec3 p);

}  // namespace pantin::detail
