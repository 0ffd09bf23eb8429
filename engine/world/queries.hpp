#pragma once
/// Questions to the shapes in a World: rays, sliding shapes, overlaps, nearest points. Meshes and
/// height fields are met from outside; all that lies below a field is inside of it.
///
///   Queries queries(world);
///   if (const RayAnswer seen = queries.cast_ray({eye, 50.0 * forward})) use(seen.hit->point);
///   ... the world moves ...
///   queries.refit(world);
///
/// The object holds a copy of all that it reads, so it never refers to a World that has changed;
/// the answers are those of the last refit(). Components are all that it reads.
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

/// Which bodies take part.
enum class QueryBodies : std::uint8_t {
  solid,  // those with a Collision that is no sensor
  all,    // whatever has shapes; a body without a Collision is in all groups
};

/// What a query sees. As with two bodies, both sides have to agree.
struct QueryFilter {
  std::uint32_t groups = UINT32_MAX;  // bits: what the query is, for a body's `with`
  std::uint32_t with = UINT32_MAX;    // bits: the groups it sees
  QueryBodies bodies = QueryBodies::solid;
  Entity except{};  // a body that is passed over
};

/// Why an answer is empty.
enum class QueryStatus : std::uint8_t {
  ok,          // nothing there, or the answer is in place
  not_finite,  // a number of the question is not finite, or a distance is below 0
  bad_shape,   // the shape is not convex, or lacks its surface
};

/// What a ray does with a solid that it starts in.
enum class StartInside : std::uint8_t {
  hit,   // is met at once: fraction 0, the ray's origin, the normal of the nearest surface
  pass,  // is not seen, except where the ray comes back into it
};

/// A piece of a line from `origin` to `origin + way`. Of length 0 it is a point, which meets what
/// it is inside of.
struct Ray {
  Vec3 origin{0}, way{0, 0, -1};  // m
  StartInside start_inside = StartInside::hit;
};

struct RayHit {
  Entity body;
  std::uint32_t shape = 0;  // in the body's Shapes
  Vec3 point{0};            // world
  Vec3 normal{0, 1, 0};     // unit, out of the shape
  Real fraction = 0;        // of the way, 0..1
};

struct RayAnswer {
  std::optional<RayHit> hit;
  QueryStatus status = QueryStatus::ok;
  explicit operator bool() const { return hit.has_value(); }
};

/// A shape that overlaps the one asked for.
struct Overlap {
  Entity body;
  std::uint32_t shape = 0;
  Real depth = 0;        // m: how far the asked shape has to move along `normal` to be free of it
  Vec3 normal{0, 1, 0};  // unit, out of the body's shape
  Vec3 point{0};         // world, of the body's shape, where the overlap is deepest
};

struct ClosestPoint {
  Entity body;
  std::uint32_t shape = 0;
  Vec3 point{0};         // world, on the surface
  Vec3 normal{0, 1, 0};  // unit, out of the shape
  Real distance = 0;     // m, below 0: the place is inside
};

struct ClosestAnswer {
  std::optional<ClosestPoint> hit;
  QueryStatus status = QueryStatus::ok;
  explicit operator bool() const { return hit.has_value(); }
};

/// Costs: making one sorts the boxes of n shapes, n log n, about 0.3 us a shape; refit() is linear
/// as long as bodies do not wander far and none comes or goes. A question visits log n boxes and
/// the shapes near its way; half-spaces and height fields are always asked. Questions allocate only
/// where they return lists, or involve a hull, a shape cast or an overlap test.
class Queries {
 public:
  Queries();
  explicit Queries(const World& world) : Queries() { refit(world); }
  Queries(const Queries& other);
  Queries(Queries&& other) noexcept;
  Queries& operator=(const Queries& other);
  Queries& operator=(Queries&& other) noexcept;
  ~Queries();

  /// Takes the shapes as they are now; with `poses` (by slot in World::bodies) as they are drawn.
  /// Bodies with poses that are not finite, and shapes without a surface, are left out.
  void refit(const World& world, std::span<const Pose> poses = {});
  /// Shapes left out at the last refit().
  std::size_t left_out() const;

  /// The nearest place where the ray enters a shape; of equally near ones the body with the lowest
  /// index, and its first shape.
  RayAnswer cast_ray(const Ray& ray, const QueryFilter& filter = {}) const;
  /// The first entry into every shape on the way, nearest first.
  QueryStatus cast_ray_through(const Ray& ray, const QueryFilter& filter,
                               std::vector<RayHit>& out) const;
  /// The first contact of a convex shape that slides along `way` without turning; `point` is of the
  /// shape that it meets. `Shape::local` counts.
  RayAnswer cast_shape(const Shape& shape, const Pose& from, Vec3 way,
                       const QueryFilter& filter = {}) const;
  /// All shapes that overlap a convex shape at `at`, in the order of the World. `Shape::local`
  /// counts; contact without depth is an overlap.
  QueryStatus overlap(const Shape& shape, const Pose& at, const QueryFilter& filter,
                      std::vector<Overlap>& out) const;
  /// The point of all surfaces nearest to `place`, if nearer than `within` (m), or if `place` is
  /// inside: then the one it is deepest in.
  ClosestAnswer closest_point(Vec3 place, Real within, const QueryFilter& filter = {}) const;

 private:
  std::unique_ptr<detail::QueryIndex> index_;
};

}  // namespace pantin
