// Hulls, meshes, planes and height fields in pictures.
#include "engine/geometry/surface.hpp"

#include <map>

#include "engine/base/rotation.hpp"
#include "engine/render/eye.hpp"
#include "engine/render/gather.hpp"
#include "engine/render/surface_mesh.hpp"
#include "tests/render/pictures.hpp"
#include "tests/render/surfaces.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::picture;

namespace {

constexpr int kWidth = 320, kHeight = 180;

struct Stage {
  World world;
  View view;
  Stage() {
    world.materials = {{"red", {0.62, 0.05, 0.04}, 0.5, 0}, {"green", {0.04, 0.5, 0.04}, 0.8, 0}};
    view.camera = {{0, 1, 4}, {0, 1, 0}, 0.7, false};
    view.ground = false;
  }
  Entity add(const Shape& shape, const Pose& pose, Motion motion = Motion::fixed) {
    const Entity e = world.create();
    Body body;
    body.pose = pose, body.motion = motion;
    world.bodies.add(e, body);
    world.shapes.add(e, Shapes{{shape}});
    return e;
  }
  Image draw() {
    Image image;
    if (auto renderer = renderer_or_skip({kWidth, kHeight, 4, true, GlPath::automatic}))
      renderer->draw({.world = world, .view = view}, image);
    return image;
  }
  Pixel at(const Image& image, Vec3 place) const {
    const Vec3 p = make_eye(view.camera, kWidth, kHeight).project(place);
    return pixel(image, static_cast<int>(p.x), static_cast<int>(p.y));
  }
};

bool is_red(Pixel p) { return p.r > 2 * p.g && p.r > 2 * p.b && p.r > 40; }
bool is_green(Pixel p) { return p.g > 1.3 * p.r && p.g > 1.3 * p.b; }

Vec3 corner(const SurfaceMesh& mesh, std::size_t index) {
  const float* c = mesh.vertices[mesh.indices[index]].corner;
  return {c[0], c[1], c[2]};
}

Real enclosed(const SurfaceMesh& mesh) {
  Real sum = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    sum += glm::dot(corner(mesh, i), glm::cross(corner(mesh, i + 1), corner(mesh, i + 2))) / 6;
  return sum;
}

}  // namespace

TEST_CASE("the triangles of a hull enclose its volume, with the normals of its faces") {
  const auto hull = double_pyramid(0.3, 0.5);
  const SurfaceMesh mesh = make_surface_mesh(*hull);
  CHECK(mesh.indices.size() == 3 * 8);
  CHECK(enclosed(mesh) == Approx(2 * 2 * 0.3 * 0.3 * 0.5 / 3).epsilon(1e-6));
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Vec3 a = corner(mesh, i), b = corner(mesh, i + 1), c = corner(mesh, i + 2);
    const float* n = mesh.vertices[mesh.indices[i]].normal;
    CHECK(glm::dot(glm::normalize(glm::cross(b - a, c - a)), Vec3{n[0], n[1], n[2]}) > 0.9999);
  }
}

TEST_CASE("a height field faces upwards and has a rim around it that faces outwards") {
  const auto field = wavy_field(9, 6, 0.2, 0.1);
  const SurfaceMesh mesh = make_surface_mesh(*field);
  CHECK(mesh.indices.size() == 3 * (2 * 8 * 5 + 2 * 2 * (8 + 5)));
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Vec3 a = corner(mesh, i), b = corner(mesh, i + 1), c = corner(mesh, i + 2);
    const Vec3 wide = glm::cross(b - a, c - a), middle = (a + b + c) / 3.0;
    const bool rim = i >= std::size_t{3} * 2 * 8 * 5;
    if (rim)
      CHECK(glm::dot(wide, Vec3{middle.x, 0, middle.z}) > 0);
    else
      CHECK(wide.y > 0);
    const float* n = mesh.vertices[mesh.indices[i]].normal;
    CHECK(glm::dot(glm::normalize(wide), Vec3{n[0], n[1], n[2]}) > 0.8);
  }
}

TEST_CASE("a hull is drawn where its points are, and not beside them") {
  Stage s;
  Shape hull;
  hull.kind = ShapeKind::hull;
  hull.surface = double_pyramid(0.3, 0.5);
  const Pose pose{{0.5, 1.1, 0}, from_rotation_vector({0, 0, 0.7})};
  s.add(hull, pose, Motion::dynamic);
  const Image image = s.draw();
  if (image.rgba.empty()) return;
  for (Vec3 point : hull.surface->points) CHECK(is_red(s.at(image, to_world(pose, 0.85 * point))));
  for (Vec3 beside : {Vec3{0.28, 0.4, 0}, {-0.28, 0.4, 0}, {0.28, -0.4, 0}, {-0.28, -0.4, 0}})
    CHECK_FALSE(is_red(s.at(image, to_world(pose, beside))));
}

TEST_CASE("bodies that share a surface are one group, and the card keeps what is held elsewhere") {
  Stage s;
  Shape hull;
  hull.kind = ShapeKind::hull;
  hull.surface = double_pyramid(0.2, 0.2);
  s.add(hull, {{-0.5, 1, 0}, kIdentity}), s.add(hull, {{0.5, 1, 0}, kIdentity});
  DrawList list;
  const Eye eye = make_eye(s.view.camera, kWidth, kHeight);
  gather({s.world}, s.view, eye, list);
  REQUIRE(list.surfaces.size() == 1);
  CHECK(list.surfaces[0].instances.size() == 2);

  auto renderer = renderer_or_skip({kWidth, kHeight, 4, true, GlPath::automatic});
  if (!renderer) return;
  const std::weak_ptr<const Surface> watched = hull.surface;
  list = {}, hull.surface.reset();
  Image first, again, empty;
  renderer->draw({.world = s.world, .view = s.view}, first);
  renderer->draw({.world = s.world, .view = s.view}, again);
  CHECK(first.rgba == again.rgba);
  CHECK(is_red(s.at(first, {-0.5, 1, 0})));
  s.world = {};
  CHECK_FALSE(watched.expired());
  renderer->draw({.world = s.world, .view = s.view}, empty);
  CHECK(watched.expired());
}

TEST_CASE("a plane is a slab of its extent; in the drawn ground it is left out") {
  Stage s;
  s.view.camera = {{0, 2, 4}, {0, 0, 0}, 0.7, false};
  Shape plane;
  plane.kind = ShapeKind::plane;
  plane.size = {1, 0, 0};
  plane.material = 1;
  const Entity body = s.add(plane, {});
  const Image image = s.draw();
  if (image.rgba.empty()) return;
  for (Real x : {-0.9, 0.9}) CHECK(is_green(s.at(image, {x, 0, 0.9})));
  CHECK_FALSE(is_green(s.at(image, {1.1, 0, 0})));
  s.view.ground = true;
  const Image on_ground = s.draw();
  CHECK_FALSE(is_green(s.at(on_ground, {0, 0, 0})));
  s.world.bodies[body].pose.position.y = 0.1;
  CHECK(is_green(s.at(s.draw(), {0, 0.1, 0})));
}

TEST_CASE("a plane that reaches behind the eye fills the picture below the horizon") {
  Stage s;
  Shape plane;
  plane.kind = ShapeKind::plane;
  plane.size = {50, 0, 0};
  plane.material = 1;
  s.add(plane, {});
  const Image image = s.draw();
  if (image.rgba.empty()) return;
  for (int x : {0, 100, kWidth - 1}) CHECK(is_green(pixel(image, x, kHeight - 1)));
}

TEST_CASE("a ball casts its shadow on a height field") {
  Stage s;
  s.view.camera = {{0, 2.5, 3}, {0, 0.3, 0}, 0.7, false};
  s.view.light.direction = {0.4, -1, 0};
  Shape field;
  field.kind = ShapeKind::height_field;
  field.surface = wavy_field(33, 33, 0.1, 0.02);
  field.material = 1;
  s.add(field, {});
  const Image sunny = s.draw();
  if (sunny.rgba.empty()) return;
  Shape ball;
  ball.size.x = 0.15;
  s.add(ball, {{-0.3, 0.8, 0}, kIdentity}, Motion::dynamic);
  const Image shaded = s.draw();
  CHECK(is_green(s.at(sunny, {0, 0.02, 0})));
  CHECK(s.at(shaded, {0, 0.02, 0}).sum() < 0.75 * s.at(sunny, {0, 0.02, 0}).sum());
  CHECK(difference(s.at(shaded, {0.6, 0.02, 0.5}), s.at(sunny, {0.6, 0.02, 0.5})) <= 6);
}

TEST_CASE("a plane does not count for the framing, a wide height field only around the rest") {
  Stage s;
  s.view.camera.automatic = true;
  Shape ball, plane, field;
  s.add(ball, {{0, 1, 0}, kIdentity}, Motion::dynamic);
  const Camera alone = framing_camera(s.world, s.view, 16.0 / 9);
  plane.kind = ShapeKind::plane, plane.size.x = 100;
  s.add(plane, {});
  CHECK(framing_camera(s.world, s.view, 16.0 / 9).eye == alone.eye);
  field.kind = ShapeKind::height_field;
  field.surface = wavy_field(65, 65, 1, 0.1);
  s.add(field, {});
  const Camera with_field = framing_camera(s.world, s.view, 16.0 / 9);
  CHECK(glm::length(with_field.eye) < 10);
  Stage bare;
  bare.view.camera.automatic = true;
  bare.add(field, {});
  CHECK(glm::length(framing_camera(bare.world, bare.view, 16.0 / 9).eye) > 30);
}

TEST_CASE("a shape without its surface is not drawn") {
  Stage s;
  Shape lost;
  lost.kind = ShapeKind::mesh;
  s.add(lost, {{0, 1, 0}, kIdentity});
  const Image image = s.draw();
  if (image.rgba.empty()) return;
  s.world = {};
  CHECK(s.draw().rgba == image.rgba);
}

TEST_CASE("cylinders, cones and ellipsoids are drawn closed, with the normals of their surfaces") {
  const Real r = 0.3, half = 0.4;
  const Vec3 radii(0.5, 0.2, 0.3);
  for (const Shape& shape :
       {Shape{ShapeKind::cylinder, {r, half, 0}, {}, 0},
        Shape{ShapeKind::cone, {r, half, 0}, {}, 0}, Shape{ShapeKind::ellipsoid, radii, {}, 0}}) {
    CAPTURE(static_cast<int>(shape.kind));
    const auto surface = tessellate(shape);
    REQUIRE(surface);
    const SurfaceMesh mesh = make_surface_mesh(*surface, &shape);
    CHECK(enclosed(mesh) == Approx(volume(shape)).epsilon(0.01));
    CHECK(mesh.indices.size() < 3 * 2 * 48 * 25);
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
      const MeshVertex& v = mesh.vertices[mesh.indices[i]];
      const Vec3 p(v.corner[0], v.corner[1], v.corner[2]), n(v.normal[0], v.normal[1], v.normal[2]);
      CHECK(glm::length(n) == Approx(1).epsilon(1e-5));
      const std::size_t first = i - i % 3;
      const Vec3 a = corner(mesh, first), b = corner(mesh, first + 1), c = corner(mesh, first + 2);
      CHECK(glm::dot(glm::normalize(glm::cross(b - a, c - a)), n) > 0.97);
      const bool is_end = std::abs(std::abs(n.y) - 1) < 1e-6;
      const Real out = std::hypot(n.x, n.z);
      if (shape.kind == ShapeKind::cylinder && !is_end) {
        CHECK(std::abs(n.y) < 1e-6);
        CHECK(glm::distance(Vec3(p.x, 0, p.z) / r, n) < 1e-2);  // not that of a flat facet
      } else if (shape.kind == ShapeKind::cone && !is_end) {
        CHECK(n.y / out == Approx(r / (2 * half)).epsilon(1e-4));
      } else if (shape.kind == ShapeKind::ellipsoid) {
        CHECK(glm::distance(glm::normalize(p / (radii * radii)), n) < 0.03);
      }
    }
  }
}
