#pragma once
/// What a NURBS skin needs to be a shape: triangles near it, what it encloses, whether it is
/// convex.
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/manifold.hpp"
#include "engine/geometry/skin_features.hpp"
#include "engine/nurbs/tessellate.hpp"

namespace pantin::detail {

/// Follows from the skin; immutable.
struct SkinModel {
  nurbs::Tessellation tiles;
  AabbTree tree;  // over its triangles, each box grown by the chord
  // Of each triangle: its normal, of a flat piece of a face to rounding, and whether it is of one.
  std::vector<Vec3> normals;
  std::vector<std::uint8_t> flat;
  Real chord = 0;  // m, how far the triangles are from the surface
  Real size = 0;   // m, half the diagonal of the bounds
  bool is_closed = false;
  bool is_convex = false;
  Vec3 low{0}, high{0};               // bounds of the surface, m
  MassProperties enclosed;            // of a closed skin, density 1
  Real doubt = 0;                     // of its volume, as a share of it: see nurbs::Quadrature
  std::vector<std::uint32_t> starts;  // of a convex skin: a vertex for each bin of directions
  // A few places all over it, no place farther than `spacing` (m) from one, to walk down from.
  std::vector<nurbs::Place> seeds;
  std::vector<Vec3> seed_points, seed_normals;
  std::vector<std::uint8_t> seed_is_round;  // not within flat pieces
  AabbTree seed_tree;                       // each grown by the spacing
  Real spacing = 0;
  SkinFeatures features;
};

/// Two skins; the second stands still, the first at a pose in its frame.
struct SkinPair {
  const Surface& a;
  const Surface& b;
  const Pose& a_in_b;
};

/// From the nearest point of a triangle to p.
Vec3 way_from(const SkinModel& model, std::uint32_t triangle, Vec3 p);
/// The nearest triangle, if that is nearer than `limit` (m).
std::optional<std::uint32_t> nearest_tile_of(const SkinModel& model, Vec3 p, Real limit);

SkinModel model_of(const nurbs::Skin& skin);

/// The shape's surface of a skin, which is not null; in the skin's frame. Of a closed skin that is
/// inside out an error: what it encloses has no volume.
Result<std::shared_ptr<const Surface>> make_skin(std::shared_ptr<const nurbs::Skin> skin);

/// A place of a skin and what is there.
struct SkinPoint {
  nurbs::Place at;
  Vec3 point{0}, normal{0};  // m; outwards, unit
  Real distance = 0;         // m, from the surface; below 0 behind it
  bool is_on_rim = false;
};

/// The place nearest to p, found from the nearest triangle: the least distance unless another place
/// is nearer by less than the chord. No heap.
SkinPoint nearest_on(const Surface& surface, Vec3 p);
/// The same from a place that is known to be near.
SkinPoint nearest_on(const Surface& surface, Vec3 p, const nurbs::Place& start);

/// What there is at a place, as seen from p.
SkinPoint place_on(const Surface& surface, const nurbs::Place& at, Vec3 p);

/// The place farthest along a direction; of a skin that is not convex the one its farthest vertex
/// leads to.
SkinPoint farthest_on(const Surface& surface, Vec3 direction);

/// Corners and edges as seen from another frame.
struct FeatureScratch {
  std::vector<Corner> corners;
  std::vector<EdgePart> edges;
  std::vector<std::uint32_t> slots;       // by number of a corner, its place in the list
  std::vector<std::optional<Foot>> feet;  // of the corners
};

/// Memory for contacts with skins.
struct SkinScratch {
  struct Candidate {
    Real gap;
    std::uint32_t seed;
    std::uint32_t tile = 0;  // of the other skin
  };
  std::vector<Candidate> candidates;
  ConvexScratch piece;
  FeatureScratch features;
};

/// Contact points of two skins, in b's frame, where a stands at `a_in_b`.
void collide_skins(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out);

/// Contact points of a skin in its own frame with any shape at `other.at` in that frame: on_a and
/// the normal are the other's, as if the skin were b.
void collide_skin(const Surface& surface, const PlacedShape& other, SkinScratch& scratch,
                  const PointsOut& out);

}  // namespace pantin::detail
