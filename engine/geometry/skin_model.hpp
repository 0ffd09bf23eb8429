#pragma once
/// Data that a NURBS skin needs to be a shape: triangles, enclosed mass, convexity.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/manifold.hpp"
#include "engine/geometry/skin_features.hpp"
#include "engine/nurbs/tessellate.hpp"

namespace pantin::detail {

/// Directions within an angle of an axis.
struct NormalCone {
  Vec3 axis{0};
  Real cosine = -1, sine = 0;  // of that angle

  /// The least cosine between a unit vector and a direction of the cone.
  Real least_cosine(Vec3 n) const {
    const Real c = glm::dot(axis, n);
    return c <= -cosine ? Real(-1) : c * cosine - std::sqrt(std::max(1 - c * c, Real(0))) * sine;
  }
};

/// Derived from the skin; immutable.
struct SkinModel {
  nurbs::Tessellation tiles;
  AabbTree tree;                  // over its triangles, each box grown by the chord
  std::vector<NormalCone> cones;  // by node of the tree: the normals of its triangles
  // By triangle: its normal, exact to rounding on flat pieces of faces, and whether it is on one.
  std::vector<Vec3> normals;
  std::vector<std::uint8_t> flat;
  Real chord = 0;          // m, how far the triangles are from the surface
  Real size = 0;           // m, half the diagonal of the bounds
  bool is_closed = false;  // a cavity, whose outer side is inwards, counts as an open patch
  bool is_convex = false;
  Vec3 low{0}, high{0};               // bounds of the surface, m
  MassProperties enclosed;            // of a closed skin, density 1
  Real doubt = 0;                     // relative uncertainty of the volume: see nurbs::Quadrature
  std::vector<std::uint32_t> starts;  // of a convex skin: a vertex for each bin of directions
  // Starts for descents, spread over the surface: every point is within `spacing` (m) of one.
  std::vector<nurbs::Place> seeds;
  std::vector<Vec3> seed_points, seed_normals;
  std::vector<std::uint8_t> seed_is_round;  // not within flat pieces
  AabbTree seed_tree;                       // boxes of seeds, grown by the spacing
  Real spacing = 0;
  SkinFeatures features;
};

/// Two skins in b's frame, where a has the pose `a_in_b`.
struct SkinPair {
  const Surface& a;
  const Surface& b;
  const Pose& a_in_b;
};

/// The vector from the nearest point of a triangle to p.
Vec3 way_from(const SkinModel& model, std::uint32_t triangle, Vec3 p);
/// The nearest triangle, if it is closer than `limit` (m).
std::optional<std::uint32_t> nearest_tile_of(const SkinModel& model, Vec3 p, Real limit);

SkinModel model_of(const nurbs::Skin& skin);

/// The surface of a shape, in the skin's frame; the skin is not null. Fails for a closed skin that
/// encloses no volume.
Result<std::shared_ptr<const Surface>> make_skin(std::shared_ptr<const nurbs::Skin> skin);

/// A point of a skin: its parameters, position and normal.
struct SkinPoint {
  nurbs::Place at;
  Vec3 point{0}, normal{0};  // m; outwards, unit
  Real distance = 0;         // m, from the surface; below 0 behind it
  bool is_on_rim = false;
};

/// The point nearest to p, found from the nearest triangle. It is the global minimum unless another
/// point is closer by less than the chord. No heap.
SkinPoint nearest_on(const Surface& surface, Vec3 p);
/// The same, from a start that is known to be near.
SkinPoint nearest_on(const Surface& surface, Vec3 p, const nurbs::Place& start);

/// The surface at given parameters, as seen from p.
SkinPoint place_on(const Surface& surface, const nurbs::Place& at, Vec3 p);

/// The support point along a direction; of a skin that is not convex the local maximum found from
/// its farthest vertex.
SkinPoint farthest_on(const Surface& surface, Vec3 direction);

/// Corners and edges, transformed to another frame.
struct FeatureScratch {
  std::vector<Corner> corners;
  std::vector<EdgePart> edges;
  std::vector<std::uint32_t> slots;       // by number of a corner: its index in the list
  std::vector<std::optional<Foot>> feet;  // of the corners
};

/// Scratch memory of contacts with skins.
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

/// Contact points of two skins, in b's frame, where a has the pose `a_in_b`.
void collide_skins(const SkinPair& pair, SkinScratch& scratch, const PointsOut& out);

/// Whether a contact point of two skins is on round faces of both, by its feature: it moves over
/// them while the skins do.
bool is_of_rounds(std::uint64_t feature);

/// Two points of skins on a common normal, in b's frame.
struct SkinTouch {
  nurbs::Place on_a, on_b;
  Vec3 at_a{0}, at_b{0}, normal{0};  // m, m, of b
};
/// The two points near places where the skins were closest; none where an edge takes over.
std::optional<SkinTouch> follow_touch(const SkinPair& pair, const nurbs::Place& on_a,
                                      const nurbs::Place& on_b);

/// Contact points of a skin in its own frame with any shape at `other.at` in that frame: on_a and
/// the normal are the other's, as if the skin were b.
void collide_skin(const Surface& surface, const PlacedShape& other, SkinScratch& scratch,
                  const PointsOut& out);

}  // namespace pantin::detail
