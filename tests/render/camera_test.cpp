#include <catch2/catch.hpp>

#include "engine/render/bounds.hpp"
#include "engine/render/eye.hpp"
#include "engine/render/renderer.hpp"
#include "tests/render/puppet.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::picture;

namespace {

View looking(Vec3 way, Real field = 0.7) {
  View view;
  view.camera.eye = -way;
  view.camera.target = Vec3{0};
  view.camera.field_of_view = field;
  return view;
}

/// Every ball lies within the four sides, and one of them nearly fills the picture.
void check_inside(const std::vector<Ball>& balls, const Eye& eye) {
  const Real slope_x = std::hypot(1.0, eye.tan_x), slope_y = std::hypot(1.0, eye.tan_y);
  Real fullest = 0;
  for (const Ball& b : balls) {
    const Vec3 d = b.centre - eye.position;
    const Real z = glm::dot(eye.forward, d);
    const Real x = (std::abs(glm::dot(eye.right, d)) + b.radius * slope_x) / (z * eye.tan_x);
    const Real y = (std::abs(glm::dot(eye.up, d)) + b.radius * slope_y) / (z * eye.tan_y);
    REQUIRE(z - b.radius > 0);
    CHECK(x < 1);
    CHECK(y < 1);
    fullest = std::max({fullest, x, y});
  }
  CHECK(fullest > 0.35);
}

std::vector<Ball> balls_of(const World& world) {
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    const Pose& pose = world.bodies[world.shapes.owners()[i]].pose;
    for (const Shape& shape : world.shapes.values()[i].list) add_balls(shape, pose, balls);
  }
  return balls;
}

}  // namespace

TEST_CASE("the framing camera sees every body from any side and in any picture") {
  const World world = puppet_world();
  for (Vec3 way :
       {Vec3{0, 0, -1}, Vec3{-1, -0.3, -1}, Vec3{0.2, 0.8, -1}, Vec3{0, -1, 0}, Vec3{1, -2, 0.1}}) {
    for (Real aspect : {16.0 / 9, 1.0, 0.5}) {
      for (Real field : {0.2, 0.7, 1.6}) {
        const View view = looking(way, field);
        const Camera camera = framing_camera(world, view, aspect);
        CHECK_FALSE(camera.automatic);
        CHECK(camera.field_of_view == field);
        CHECK(glm::length(glm::normalize(camera.target - camera.eye) - glm::normalize(way)) < 1e-9);
        const Eye eye = make_eye(camera, static_cast<int>(1000 * aspect), 1000);
        check_inside(balls_of(world), eye);
      }
    }
  }
}

TEST_CASE("the framing camera keeps the place on the ground below the feet") {
  World world = puppet_world();
  const View view = looking({0, -0.3, -1});
  const Eye eye = make_eye(framing_camera(world, view, 16.0 / 9), 1280, 720);
  const Vec3 foot = eye.project({0.1, 0, 0.1});
  CHECK((foot.y > 360 && foot.y < 720));
  const Vec3 shadow = eye.project({-0.45 * 1.1, 0, -0.35 * 1.1});  // of the chest
  CHECK((shadow.x > 0 && shadow.y < 720));
}

TEST_CASE("the framing camera leaves room for the ways of drives") {
  World world = puppet_world();
  const View view = looking({0, 0, -1});
  const Camera still = framing_camera(world, view, 1);
  auto& curve = std::get<Lissajous>(world.paths.values()[0].curve);
  curve.amplitude = {2, 0, 0};
  const Camera swaying = framing_camera(world, view, 1);
  CHECK(swaying.eye.z > still.eye.z + 2);
  World carried = world;
  for (Real x : {-2.0, 2.0}) {
    for (Body& body : carried.bodies.values()) body.pose.position.x += x;
    check_inside(balls_of(carried), make_eye(swaying, 720, 720));
    for (Body& body : carried.bodies.values()) body.pose.position.x -= x;
  }

  world.paths.values()[0].curve = Keyframes{
      {{0, world.bodies[world.paths.owners()[0]].pose}, {1, {{0, 6, 0}, kIdentity}}}, false};
  const Camera lifted = framing_camera(world, view, 1);
  for (Body& body : carried.bodies.values()) body.pose.position.y += 6 - 2.25;
  check_inside(balls_of(carried), make_eye(lifted, 720, 720));
}

TEST_CASE("the framing camera leaves room for a pendulum's swing") {
  World world;
  PuppetMaker make(world);
  const Entity nail =
      make.body({{0, 3, 0}, kIdentity}, {{ShapeKind::sphere, {0.05, 0, 0}, {}, 0}}, Motion::fixed);
  const Entity bob = make.body({{1.5, 3, 0}, kIdentity}, {{ShapeKind::sphere, {0.1, 0, 0}, {}, 0}});
  make.string(nail, {0, 3, 0}, bob, {1.5, 3, 0});
  const Eye eye = make_eye(framing_camera(world, looking({0, 0, -1}), 1), 720, 720);
  check_inside({{{1.5, 3, 0}, 0.1}, {{-1.5, 3, 0}, 0.1}, {{0, 1.5, 0}, 0.1}}, eye);
}

TEST_CASE("the framing camera keeps the given one when there is nothing to see") {
  const View view = looking({1, -1, -2});
  const Camera camera = framing_camera(World{}, view, 1);
  CHECK(camera.eye == view.camera.eye);
  CHECK(camera.target == view.camera.target);
}

TEST_CASE("bodies with poses that are not numbers do not spoil the frame") {
  World world = puppet_world();
  world.bodies.values()[3].pose.position.x = std::nan("");
  const Camera camera = framing_camera(world, looking({0, 0, -1}), 1);
  CHECK(is_finite(camera.eye));
  CHECK(is_finite(camera.target));
}

TEST_CASE("an eye projects its target to the middle and up to the top, even looking down") {
  for (Vec3 way : {Vec3{0, 0, -1}, Vec3{1, 2, 3}, Vec3{0, -1, 0}, Vec3{0, 1, 0}}) {
    Camera camera;
    camera.eye = {1, 2, 3};
    camera.target = camera.eye + way;
    const Eye eye = make_eye(camera, 640, 360);
    const Vec3 middle = eye.project(camera.target);
    CHECK(middle.x == Approx(320));
    CHECK(middle.y == Approx(180));
    CHECK(eye.project(camera.target + 0.1 * eye.up).y < 180);
    CHECK(eye.project(camera.target + 0.1 * eye.right).x > 320);
    CHECK(glm::dot(eye.right, eye.up) == Approx(0).margin(1e-12));
  }
}
