// Joints of surfaces in the debug view, skins as triangles, and the ways of contacts.
#include "engine/render/trails.hpp"

#include "engine/base/rotation.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/render/marks.hpp"
#include "engine/render/surface_mesh.hpp"
#include "engine/world/ties.hpp"
#include "tests/render/pictures.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::picture;

namespace {

constexpr int kWidth = 480, kHeight = 270;

/// A ball of radius 0.5 on a plate, in contact at the origin.
struct Pair {
  World world;
  Entity a, b, joint;

  Pair() {
    a = body({{0, 0.5, 0}, from_rotation_vector({0, 0, 1})});
    b = body({{0.2, 0, 0}, from_rotation_vector({0, 1, 0})});
    SurfaceContact c;
    c.a = a, c.b = b;
    c.on_a.skin = std::make_shared<nurbs::Skin>(nurbs::Skin::ellipsoid(Vec3(0.5)));
    c.on_b.skin = std::make_shared<nurbs::Skin>(std::vector{nurbs::plane({}, 2, 2)}, 1e-9);
    c.known = c.touches = true;
    c.normal = {0, 1, 0};
    joint = add_surface_contact(world, c);
  }
  Entity body(const Pose& pose) {
    const Entity e = world.create();
    Body made;
    made.pose = pose;
    world.bodies.add(e, made);
    return e;
  }
  SurfaceContact& contact() { return world.surface_contacts[joint]; }
};

}  // namespace

TEST_CASE("trails are kept in the frames of both bodies, without points that are one") {
  Pair p;
  ContactTrails trails;
  for (int i = 0; i <= 10; ++i) {
    p.contact().point = {0.05 * i, 0, 0};
    trails.record(p.world), trails.record(p.world);
  }
  REQUIRE(trails.trails().size() == 2);
  CHECK(trails.trails()[0].body == p.a);
  CHECK(trails.trails()[1].body == p.b);
  for (const Overlay::Trail& trail : trails.trails()) {
    REQUIRE(trail.points.size() == 11);
    const Pose& pose = p.world.bodies[trail.body].pose;
    CHECK(glm::distance(to_world(pose, trail.points[4]), {0.2, 0, 0}) < 1e-12);
  }
  p.contact().touches = false, p.contact().point = {3, 0, 0};
  trails.record(p.world);
  CHECK(trails.trails()[0].points.size() == 11);
}

TEST_CASE("a trail starts anew where surfaces met again, and where a place leapt") {
  Pair p;
  ContactTrails trails;
  const auto go = [&](Real x, bool touches) {
    p.contact().point = {x, 0, 0}, p.contact().touches = touches;
    trails.record(p.world);
  };
  go(0, true), go(0.01, true), go(0.02, false), go(0.02, true), go(0.03, true), go(0.9, true);
  const Overlay::Trail& trail = trails.trails()[1];
  CHECK(trail.points.size() == 5);
  CHECK(trail.starts == std::vector<std::size_t>{2, 4});
  for (int i = 0; i < 5000; ++i) go(0.9 + 0.1 * (i % 2), i % 100 > 0);
  REQUIRE(trails.trails()[1].points.size() <= 4000);
  const Overlay::Trail& full = trails.trails()[1];
  CHECK(full.starts.size() >= 29);
  for (std::size_t i = 1; i < full.starts.size(); ++i)
    CHECK(full.starts[i] - full.starts[i - 1] == 99);
}

TEST_CASE("each place of a joint has trails of its own") {
  Pair p;
  p.contact().spots = 2;
  p.contact().more[0] = {true, false, {0, 0, 0.5}, {0, 1, 0}, Vec3(0), 0};
  ContactTrails trails;
  trails.record(p.world);
  REQUIRE(trails.trails().size() == 4);
  CHECK(glm::distance(trails.trails()[3].points.at(0),
                      to_local(p.world.bodies[p.b].pose, {0, 0, 0.5})) < 1e-12);
}

TEST_CASE("the place where surfaces touch is marked with its tangent plane, its trail drawn") {
  Pair p;
  View view;
  view.camera = {{0, 1, 3}, {0, 0, 0}, 0.7, false};
  view.ground = false;
  const auto differing = [&](bool marks, const std::vector<Overlay::Trail>& trails) {
    const auto renderer = renderer_or_skip({kWidth, kHeight, 4, true, GlPath::automatic});
    if (!renderer) return -1;
    Image plain, marked;
    Overlay overlay;
    renderer->draw({.world = p.world, .view = view, .overlay = &overlay}, plain);
    overlay.joints = marks, overlay.trails = trails;
    renderer->draw({.world = p.world, .view = view, .overlay = &overlay}, marked);
    int count = 0;
    for (std::size_t i = 0; i < plain.rgba.size(); i += 4)
      count += plain.rgba[i] != marked.rgba[i] || plain.rgba[i + 1] != marked.rgba[i + 1];
    return count;
  };
  const int with = differing(true, {});
  if (with < 0) return;
  p.contact().over = true;
  const int without = differing(true, {});  // axes of bodies alone
  CHECK(with > without + 500);
  CHECK(differing(false, {}) == 0);
  CHECK(differing(false, {{p.a, {{0, -0.5, 0}, {0.2, -0.5, 0}, {0.4, -0.4, 0}}}}) > 20);
}

TEST_CASE("a skin is drawn by its triangles with its own normals, an open one from both sides") {
  const auto drawn = [](nurbs::Surface face) {
    return make_surface_mesh(
        **make_skin(std::make_shared<nurbs::Skin>(std::vector{std::move(face)}, 1e-9)));
  };
  const SurfaceMesh torus = drawn(nurbs::torus({}, 0.5, 0.2));
  CHECK(torus.indices.size() > 3000);
  for (const MeshVertex& v : torus.vertices) {
    const Vec3 at(v.corner[0], v.corner[1], v.corner[2]), n(v.normal[0], v.normal[1], v.normal[2]);
    const Vec3 middle = 0.5 * glm::normalize(Vec3(at.x, at.y, 0));
    REQUIRE(glm::distance(n, (at - middle) / 0.2) < 1e-5);
  }
  const SurfaceMesh sheet = drawn(nurbs::plane({}, 1, 1));
  int up = 0, down = 0;
  for (const MeshVertex& v : sheet.vertices) up += v.normal[2] > 0.99, down += v.normal[2] < -0.99;
  CHECK(up > 0);
  CHECK(up == down);
}
