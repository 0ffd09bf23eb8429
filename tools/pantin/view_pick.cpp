#include "tools/pantin/view_pick.hpp"

#ifdef PANTIN_HAS_VIEW
#include <cmath>

#include "engine/geometry/kinds.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr Real kFarthest = 1e6;  // m; precision is insufficient beyond

/// A half-space is drawn as a square: hits outside it are invisible.
bool is_drawn(const PosedWorld& scene, const RayHit& hit) {
  const Shape& shape = scene.world.shapes[hit.body].list[hit.shape];
  if (traits_of(shape.kind).shape_class != ShapeClass::half_space) return true;
  const Pose at = compose(scene.pose_of(scene.world.bodies.slot(hit.body)), shape.local);
  const Vec3 local = to_local(at, hit.point);
  return std::abs(local.x) <= shape.size.x && std::abs(local.z) <= shape.size.x;
}

/// A query by one click.
struct Click {
  const PosedWorld& scene;
  Queries shapes;
  std::vector<RayHit> hits;
};

std::optional<Picked> pick_exactly(Click& click, Ray ray) {
  ray.way *= kFarthest;
  const QueryFilter all{.bodies = QueryBodies::all};
  click.shapes.cast_ray_through(ray, all, click.hits);
  for (const RayHit& hit : click.hits)
    if (is_drawn(click.scene, hit)) {
      const Pose& pose = click.scene.pose_of(click.scene.world.bodies.slot(hit.body));
      return Picked{hit.body, hit.point, to_local(pose, hit.point)};
    }
  return std::nullopt;
}

}  // namespace

Ray ray_through(const SeenPixel& pixel) {
  const auto& [eye, x, y] = pixel;
  const Real right = (2 * (x + 0.5) / eye.width - 1) * eye.tan_x;
  const Real up = (1 - 2 * (y + 0.5) / eye.height) * eye.tan_y;
  return {eye.position, glm::normalize(eye.forward + right * eye.right + up * eye.up),
          StartInside::pass};
}

std::optional<Picked> pick(const PosedWorld& scene, const SeenPixel& pixel) {
  if (scene.poses.size() < scene.world.bodies.size()) return std::nullopt;
  Click click{scene, {}, {}};
  click.shapes.refit(scene.world, scene.poses);
  if (auto hit = pick_exactly(click, ray_through(pixel))) return hit;
  constexpr int kAround = 12;
  for (const double pixels : {2.0, 4.0, 6.0})
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2 * kPi * i / kAround;
      const Ray ray = ray_through(
          {pixel.eye, pixel.x + pixels * std::cos(angle), pixel.y + pixels * std::sin(angle)});
      if (auto hit = pick_exactly(click, ray)) return hit;
    }
  return std::nullopt;
}

Vec3 on_plane(const SeenPixel& pixel, Vec3 point) {
  const Eye& eye = pixel.eye;
  const Ray ray = ray_through(pixel);
  // All rays of the picture point forwards, so none is parallel to a plane perpendicular to the
  // view.
  return ray.origin + eye.depth(point) / glm::dot(ray.way, eye.forward) * ray.way;
}

}  // namespace pantin::program
#endif
