// What pictures show where a scene says nothing: colours, supports, ground, camera.
#include "engine/base/rotation.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/render/belts.hpp"
#include "engine/render/eye.hpp"
#include "engine/render/palette.hpp"
#include "engine/render/springs.hpp"
#include "engine/render/supports.hpp"
#include "engine/world/ties.hpp"
#include "tests/render/pictures.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::picture;

namespace {

Entity add(World& world, const Shape& shape, Vec3 at, Motion motion = Motion::dynamic,
           const char* name = "") {
  Body body;
  body.pose.position = at, body.motion = motion;
  const Entity e = world.add_body(body, name);
  world.shapes.add(e, {{shape}});
  return e;
}

Entity add_frame(World& world) {
  Body fixed;
  fixed.motion = Motion::fixed;
  return world.add_body(fixed, "world");
}

Shape box(Vec3 half) { return {ShapeKind::box, half, {}, 0}; }

Link link_to(World& world, Entity frame, Entity body, JointKind kind, Vec3 at,
             Vec3 axis = {0, 0, 1}) {
  Link link;
  link.a = frame, link.b = body;
  link.joint.kind = kind;
  link.joint.anchor_a = to_world(inverse(world.bodies[frame].pose), at);
  link.joint.anchor_b = to_world(inverse(world.bodies[body].pose), at);
  const Vec3 aside = std::abs(axis.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 0, 1);
  const Vec3 z = glm::normalize(glm::cross(axis, aside));
  const Quat axes = glm::quat_cast(Mat3(axis, glm::cross(z, axis), z));
  link.joint.frames.set(glm::conjugate(world.bodies[frame].pose.rotation) * axes,
                        glm::conjugate(world.bodies[body].pose.rotation) * axes);
  return link;
}

/// CIE L*a*b* of a linear sRGB colour, white D65.
Vec3 lab(Vec3 c) {
  const Vec3 xyz{0.4124 * c.x + 0.3576 * c.y + 0.1805 * c.z,
                 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z,
                 0.0193 * c.x + 0.1192 * c.y + 0.9505 * c.z};
  const auto f = [](Real t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  const Real x = f(xyz.x / 0.9505), y = f(xyz.y), z = f(xyz.z / 1.089);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

/// What observers without one kind of cones see, on linear RGB [Machado, Oliveira & Fernandes
/// 2009].
Vec3 seen_without(int cones, Vec3 c) {
  constexpr Real m[3][3][3] = {{{0.152286, 1.052583, -0.204868},
                                {0.114503, 0.786281, 0.099216},
                                {-0.003882, -0.048116, 1.051998}},
                               {{0.367322, 0.860646, -0.227968},
                                {0.280085, 0.672501, 0.047413},
                                {-0.011820, 0.042940, 0.968881}},
                               {{1.255528, -0.076749, -0.178779},
                                {-0.078411, 0.930809, 0.147602},
                                {0.004733, 0.691367, 0.303900}}};
  if (cones < 0) return c;
  Vec3 out;
  for (int i = 0; i < 3; ++i)
    out[i] =
        std::clamp(m[cones][i][0] * c.x + m[cones][i][1] * c.y + m[cones][i][2] * c.z, 0.0, 1.0);
  return out;
}

}  // namespace

TEST_CASE("the colours of the palette are told apart with any colour vision") {
  // 2.3 is a just noticeable difference.
  for (int cones = -1; cones < 3; ++cones)
    for (std::size_t i = 0; i < kPalette.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        CAPTURE(cones, i, j);
        CHECK(glm::distance(lab(seen_without(cones, kPalette[i])),
                            lab(seen_without(cones, kPalette[j]))) > 10);
      }
}

TEST_CASE("bodies without a material have colours of their own, others keep theirs") {
  World world;
  world.materials.push_back({"red", {0.6, 0, 0}, 0.5, 0});
  Shape red = box(Vec3(0.1));
  red.material = 1;
  const Entity a = add(world, box(Vec3(0.1)), {0, 0, 0}), b = add(world, box(Vec3(0.1)), {1, 0, 0}),
               floor = add(world, box(Vec3(0.1)), {2, 0, 0}, Motion::fixed),
               painted = add(world, red, {3, 0, 0});
  const auto colour = [&](Entity e) {
    return drawn_material({world}, world.bodies.slot(e), world.shapes[e].list[0].material).colour;
  };
  const Vec3 of_b = colour(b);
  CHECK(colour(a) == kPalette[0]);
  CHECK(of_b == kPalette[1]);
  CHECK(colour(floor) == Material{}.colour);
  CHECK(colour(painted) == Vec3(0.6, 0, 0));
  world.destroy(std::vector{a});
  CHECK(colour(b) == of_b);
  world.materials[0].colour = {0.1, 0.2, 0.3};  // a program's own choice for all others
  CHECK(colour(b) == Vec3(0.1, 0.2, 0.3));
  const Vec3 given[] = {Vec3(1), Vec3(0.5), Vec3(0.25)};
  CHECK(drawn_material({world, {}, given}, 1, 1).colour == Vec3(0.5));
}

TEST_CASE("the links of a chain alternate between two shades of one colour") {
  World world;
  add(world, box(Vec3(0.1)), {0, 0, 0});
  Vec3 colours[4];
  for (std::uint32_t i = 0; i < 4; ++i) {
    add(world, box(Vec3(0.1)), {}, Motion::dynamic, ("rope/" + std::to_string(i)).c_str());
    colours[i] = drawn_material({world}, i + 1, 0).colour;
  }
  CHECK(colours[0] == kPalette[1]);
  CHECK((colours[2] == colours[0] && colours[3] == colours[1]));
  CHECK(glm::distance(lab(colours[0]), lab(colours[1])) > 10);
  CHECK(glm::length(glm::cross(colours[0], colours[1])) < 1e-12);
}

TEST_CASE("colours given by slot are seen") {
  World world;
  add(world, box(Vec3(0.5)), {0, 1, 0});
  auto renderer = renderer_or_skip({160, 90, 4, false, GlPath::automatic});
  if (!renderer) return;
  View view;
  view.camera = {{0, 1, 4}, {0, 1, 0}, 0.7, false};
  const Vec3 red[] = {{0.7, 0, 0}};
  Image image;
  renderer->draw({.world = world, .view = view, .colours = red}, image);
  const Pixel p = pixel(image, 80, 45);
  CHECK((p.r > 2 * p.g && p.r > 2 * p.b));
}

TEST_CASE(
    "a pivot on the world is a cone from a plate to the anchor, and stays when the body turns") {
  for (const bool hangs : {false, true}) {
    World world;
    const Entity frame = add_frame(world),
                 rod = add(world, box({0.02, 0.5, 0.02}), {0, hangs ? 0.5 : 1.5, 0});
    add_link(world, link_to(world, frame, rod, JointKind::hinge, {0, 1, 0}));
    std::vector<SupportPart> parts, later;
    add_supports({world}, parts);
    REQUIRE(parts.size() == 2);
    const Real way = hangs ? 1 : -1;  // from the anchor to the plate
    const Vec3 tip = to_world(parts[0].pose, {0, parts[0].shape.size.y, 0});
    CHECK(glm::distance(tip, Vec3(0, 1, 0)) < 1e-12);
    CHECK(way * (parts[1].pose.position.y - 1) > parts[0].shape.size.y);
    Pose turned = world.bodies[rod].pose;
    turned.rotation = from_rotation_vector({0, 0, 2}), turned.position = {0.4, 1.2, 0};
    const Pose poses[] = {world.bodies[frame].pose, turned};
    add_supports({world, poses}, later);
    REQUIRE(later.size() == 2);
    CHECK(glm::distance(later[1].pose.position, parts[1].pose.position) < 1e-12);
    // Nothing where the scene shows what holds the body.
    add(world, box(Vec3(0.05)), {0, 1, 0}, Motion::fixed);
    later.clear(), add_supports({world}, later);
    CHECK(later.empty());
  }
}

TEST_CASE("an axle through the middle of a body has no symbol") {
  World world;
  const Entity frame = add_frame(world), wheel = add(world, box({0.5, 0.5, 0.02}), {0, 1, 0});
  add_link(world, link_to(world, frame, wheel, JointKind::hinge, {0.02, 1, 0}));
  std::vector<SupportPart> parts;
  add_supports({world}, parts);
  CHECK(parts.empty());
}

TEST_CASE("rails run along a translation beside the body, wherever it is") {
  World world;
  const Entity frame = add_frame(world), block = add(world, box({0.1, 0.05, 0.05}), {0, 1, 0});
  add_link(world, link_to(world, frame, block, JointKind::prismatic, {0, 1, 0}, {1, 0, 0}));
  for (const Real x : {0.0, 0.2, 5.0, -5.0}) {
    world.bodies[block].pose.position.x = x;
    std::vector<SupportPart> parts;
    add_supports({world}, parts);
    REQUIRE(parts.size() == 2);
    Real below = 0, above = 0;
    for (const SupportPart& rail : parts) {
      const Aabb bounds = bounds_of(rail.shape, rail.pose);
      CHECK(bounds.low.x < x - 0.1);
      CHECK(bounds.high.x > x + 0.1);
      (rail.pose.position.y < 1 ? below : above) =
          rail.pose.position.y < 1 ? bounds.high.y : bounds.low.y;
    }
    CHECK(below == Approx(0.95));
    CHECK(above == Approx(1.05));
  }
}

TEST_CASE("a wheel that rolls on the world is drawn where its body has no shape") {
  World world;
  const Entity frame = add_frame(world), hub = world.add_body(Body{}, "hub");
  Link link = link_to(world, frame, hub, JointKind::wheel, Vec3(0), {1, 0, 0});
  link.joint.parameters.edit().length = 0.3;
  add_link(world, link);
  std::vector<SupportPart> parts;
  add_supports({world}, parts);
  REQUIRE(parts.size() == 1);
  CHECK(parts[0].shape.kind == ShapeKind::cylinder);
  CHECK(parts[0].shape.size.x == 0.3);
  CHECK(std::abs((parts[0].pose.rotation * Vec3(0, 1, 0)).x) == Approx(1));
}

TEST_CASE("the ground lies below everything, or where a plane is") {
  World world;
  View view;
  view.ground_height = std::numeric_limits<Real>::quiet_NaN();
  const Entity body = add(world, box(Vec3(0.25)), {0, 2, 0});
  CHECK(ground_height_of(world, view) == 0);
  world.bodies[body].pose.position.y = -1;
  CHECK(ground_height_of(world, view) == Approx(-1.25));
  CHECK(framed_view(world, view, 1).ground_height == Approx(-1.25));
  Shape plane;
  plane.kind = ShapeKind::plane;
  add(world, plane, {0, -0.5, 0}, Motion::fixed);
  CHECK(ground_height_of(world, view) == -0.5);
  view.ground_height = 3;
  CHECK(ground_height_of(world, view) == 3);
}

TEST_CASE("the framing camera sees belts and the circles of cranks") {
  World world;
  View view;
  view.camera.eye = {0, 0, 1}, view.camera.target = Vec3(0);
  Shape small = box(Vec3(0.01));
  const Entity a = add(world, small, {-1, 5, 0}), b = add(world, small, {1, 5, 0});
  Belt belt;
  for (const Entity e : {a, b}) {
    belt.pulleys.emplace_back().body = e;
    belt.pulleys.back().outline.radius = 0.4;
  }
  belt.width = 0.05;
  const Pose poses[] = {world.bodies[a].pose, world.bodies[b].pose};
  REQUIRE(lay_belt(belt, poses));
  add_belt(world, belt);
  const auto sees = [&](Vec3 p) {
    const Vec3 at = make_eye(framing_camera(world, view, 1), 100, 100).project(p);
    return at.x > 0 && at.x < 100 && at.y > 0 && at.y < 100;
  };
  CHECK(sees({-1.4, 5, 0}));
  CHECK(sees({1.4, 5, 0}));
  world = {};
  const Entity frame = add_frame(world), crank = add(world, box({0.02, 0.5, 0.02}), {0, 5.5, 0});
  Link link = link_to(world, frame, crank, JointKind::hinge, {0, 5, 0});
  link.joint.parameters.edit().rotation.motor.kind = MotorKind::velocity;
  add_link(world, link);
  CHECK(sees({0.99, 5, 0}));
  CHECK(sees({0, 4.01, 0}));
}

TEST_CASE("what lies in a bowl is seen from above, unless the scene says from where") {
  World world;
  // A square bowl: a thick floor with four walls, as one closed mesh.
  std::vector<Vec3> points;
  for (const Real y : {0.0, 0.5})
    for (const Real r : {0.5, 0.4})
      for (const Vec3 c : {Vec3(-1, 0, -1), Vec3(1, 0, -1), Vec3(1, 0, 1), Vec3(-1, 0, 1)})
        points.push_back({r * c.x, r == 0.4 && y == 0 ? 0.1 : y, r * c.z});
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangles.push_back({a, b, c}), triangles.push_back({a, c, d});
  };
  quad(0, 1, 2, 3);  // below
  quad(7, 6, 5, 4);  // the floor inside
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t j = (i + 1) % 4;
    quad(j, i, 8 + i, 8 + j);            // outside
    quad(4 + i, 4 + j, 12 + j, 12 + i);  // inside
    quad(8 + j, 8 + i, 12 + i, 12 + j);  // the rim
  }
  const auto mesh = make_mesh(points, triangles);
  REQUIRE(mesh);
  Shape bowl;
  bowl.kind = ShapeKind::mesh, bowl.surface = *mesh;
  add(world, bowl, {0, 0, 0}, Motion::fixed);
  const Entity ball = add(world, {ShapeKind::sphere, {0.1, 0, 0}, {}, 0}, {0, 0.3, 0});
  const auto elevation = [&](const View& view) {
    const Camera c = framing_camera(world, view, 1);
    return std::asin(glm::normalize(c.eye - c.target).y);
  };
  CHECK(elevation({}) > 0.7);
  View told;
  told.camera.eye = {0, 0, 3}, told.camera.target = Vec3(0);
  CHECK(std::abs(elevation(told)) < 1e-6);
  world.bodies[ball].pose.position.y = 2;
  CHECK(elevation({}) < 0.3);
}

TEST_CASE("a camera seen from another side keeps its target and distance") {
  const Camera from{{1, 2, 6}, {1, 2, 3}, 0.7, false};
  for (const Vec3 way : {Vec3(0, 0, 1), Vec3(-1, 0, 0), Vec3(0, 1, 0)}) {
    const Camera c = seen_from(way, from);
    CHECK(c.target == from.target);
    CHECK(glm::distance(c.eye, c.target + 3.0 * way) < 1e-12);
  }
  // From above the picture's top is away from the front.
  CHECK(make_eye(seen_from({0, 1, 0}, from), 10, 10).up == Vec3(0, 0, -1));
}

TEST_CASE("a spring is a coil from end to end that is as wide however long it is") {
  World world;
  const Entity frame = add_frame(world);
  const Entity bob = add(world, box(Vec3(0.1)), {0, -1, 0});
  Link link = link_to(world, frame, bob, JointKind::spring, {0, 0, 0});
  link.joint.anchor_b = Vec3(0);
  link.joint.parameters.edit().length = 1;
  std::optional<Coil> coils[3];
  const Vec3 ends[] = {{0, -1, 0}, {0.3, -1.4, 0.2}, {0, -0.6, 0}};
  for (int k = 0; k < 3; ++k) {
    world.bodies[bob].pose.position = ends[k];
    coils[k] = coil_of({world}, link);
    REQUIRE(coils[k]);
    CHECK(coils[k]->radius == coils[0]->radius);
    const std::vector<Vec3> wire = wire_of(*coils[k], 12);
    CHECK(wire.front() == Vec3(0));
    CHECK(glm::distance(wire.back(), ends[k]) < 1e-12);
    const Vec3 way = glm::normalize(ends[k]);
    Real turned = 0;
    for (std::size_t i = 1; i + 1 < wire.size(); ++i) {
      const Vec3 out = wire[i] - glm::dot(wire[i], way) * way;
      CHECK(glm::length(out) == Approx(coils[k]->radius));
      const Vec3 before = wire[i - 1] - glm::dot(wire[i - 1], way) * way;
      if (i > 1)
        turned += std::asin(glm::dot(glm::cross(before, out), way) /
                            (coils[k]->radius * coils[k]->radius));
    }
    CHECK(std::abs(turned) == Approx(2 * kPi * 8));
  }
  link.joint.kind = JointKind::distance;
  CHECK(!coil_of({world}, link));
  link.joint.kind = JointKind::spring, link.joint.parameters.edit().length = 0;
  world.bodies[bob].pose.position = Vec3(0);
  CHECK(!coil_of({world}, link));  // no extent
}
