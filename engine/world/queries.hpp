#pragma once
/// Geometric queries of a World: ray casts, shape casts, overlaps, closest points. Rays hit meshes
/// and height fields from outside only; everything below a height field is inside it.
///
///   Queries queries(world);
///   if (const RayAnswer seen = queries.cast_ray({eye, 50.0 * forward})) use(seen.hit->point);
///   ... the world moves ...
///   queries.refit(world);
///
/// The object copies all it reads, so it never refers to a World that has changed; results are
/// those of the last refit(). It reads components only.
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/geometry/shape.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

struct World;
namespace detail {
struct QueryIndex;
}

/// Which bodies a query tests.
enum class QueryBodies : std::uint8_t {
  solid,  // those with a Collision that is no sensor
  all,    // all bodies with shapes; one without a Collision is in all groups
};

/// The filter of a query. As between two bodies, the groups must match both ways.
struct QueryFilter {
  std::uint32_t groups = UINT32_MAX;  // bits: groups of the query, tested against a body's `with`
  std::uint32_t with = UINT32_MAX;    // bits: the groups it sees
  QueryBodies bodies = QueryBodies::solid;
  Entity except{};  // a body to skip
};

/// Why an answer is empty.
enum class QueryStatus : std::uint8_t {
  ok,          // the query was valid; the result may be empty
  not_finite,  // a number of the query is not finite, or a distance is below 0
  bad_shape,   // the shape is not convex, or lacks its surface
};

/// How a ray treats a solid that it starts in.
enum class StartInside : std::uint8_t {
  hit,   // hit at once: fraction 0, the ray's origin, the normal of the nearest surface
  pass,  // skipped, unless the ray enters it again
};

/// The segment from `origin` to `origin + way`. If its length is 0 it is a point, which hits the
/// shapes that contain it.
struct Ray {
  Vec3 origin{0}, way{0, 0, -1};  // m
  StartInside start_inside = StartInside::hit;
};

struct RayHit {
  Entity body;
  std::uint32_t shape = 0;  // in the body's Shapes
  Vec3 point{0};            // world
  Vec3 normal{0, 1, 0};     // unit, out of the shape
  Real fraction = 0;        // of the ray's length, 0..1
};

struct RayAnswer {
  std::optional<RayHit> hit;
  QueryStatus status = QueryStatus::ok;
  explicit operator bool() const { return hit.has_value(); }
};

/// A shape that overlaps the query shape.
struct Overlap {
  Entity body;
  std::uint32_t shape = 0;
  Real depth = 0;        // m: how far the query shape must move along `normal` to separate
  Vec3 normal{0, 1, 0};  // unit, out of the body's shape
  Vec3 point{0};         // world, on the body's shape, where the overlap is deepest
};

struct ClosestPoint {
  Entity body;
  std::uint32_t shape = 0;
  Vec3 point{0};         // world, on the surface
  Vec3 normal{0, 1, 0};  // unit, out of the shape
  Real distance = 0;     // m; below 0: the query point is inside
};

struct ClosestAnswer {
  std::optional<ClosestPoint> hit;
  QueryStatus status = QueryStatus::ok;
  explicit operator bool() const { return hit.has_value(); }
};

/// Cost: construction sorts the boxes of n shapes, O(n log n), about 0.3 us a shape. refit() is
/// O(n) as long as bodies do not move far and none is added or removed. A query visits O(log n)
/// boxes and the shapes near it; half-spaces and height fields are always tested. Queries allocate
/// only if they return lists, or involve a hull, a shape cast or an overlap test.
class Queries {
 public:
  Queries();
  explicit Queries(const World& world) : Queries() { refit(world); }
  Queries(const Queries& other);
  Queries(Queries&& other) noexcept;
  Queries& operator=(const Queries& other);
  Queries& operator=(Queries&& other) noexcept;
  ~Queries();

  /// Updates to the present shapes; with `poses` (by slot in World::bodies) to the drawn poses.
  /// Bodies with non-finite poses, and shapes without a surface, are left out.
  void refit(const World& world, std::span<const Pose> poses = {});
  /// The number of shapes left out at the last refit().
  std::size_t left_out() const;

  /// The nearest hit of the ray. Ties go to the body with the lowest index, and to its first shape.
  RayAnswer cast_ray(const Ray& ray, const QueryFilter& filter = {}) const;
  /// The first hit on each shape along the ray, nearest first.
  QueryStatus cast_ray_through(const Ray& ray, const QueryFilter& filter,
                               std::vector<RayHit>& out) const;
  /// The first hit of a convex shape that moves along `way` without rotating; `point` is on the
  /// shape that it hits. `Shape::local` is applied.
  RayAnswer cast_shape(const Shape& shape, const Pose& from, Vec3 way,
                       const QueryFilter& filter = {}) const;
  /// All shapes that overlap a convex shape at `at`, in the order of the World. `Shape::local` is
  /// applied; touching without depth is an overlap.
  QueryStatus overlap(const Shape& shape, const Pose& at, const QueryFilter& filter,
                      std::vector<Overlap>& out) const;
  /// The surface point nearest to `place` within `within` (m). If `place` is inside a shape: the
  /// point of the shape in which it is deepest.
  ClosestAnswer closest_point(Vec3 place, Real within, const QueryFilter& filter = {}) const;

 private:
  std::unique_ptr<detail::QueryIndex> index_;
};

}  // namespace pantin
