// What linkages and curve contacts of the plane cost. Run by name:
// pantin_tests "planar: what linkages and curves cost".
#include <catch2/catch.hpp>
#include <ctime>
#include <iostream>

#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/plane_curves.hpp"
#include "engine/scene/scene.hpp"
#include "engine/world/surface_start.hpp"
#include "engine/world/ties.hpp"
#include "tests/paths.hpp"
#include "tests/solvers/planar.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr int kCount = 20;

enum class Kind { none, circle, lifting, spline, ellipses };

Entity add_part(World& w, Vec3 at) {
  Body b;
  b.mass = 1, b.inertia = Vec3(1), b.pose.position = at, b.drag = 0;
  return w.add_body(b);
}

void touch(World& w, SurfaceContact c, const nurbs::Curve& a, const nurbs::Curve& b) {
  c.on_a.curve = contact_curve(a, OuterSide::right);
  c.on_b.curve = contact_curve(b, OuterSide::right);
  const std::string why = place_surfaces(c, {w.bodies[c.a].pose, w.bodies[c.b].pose});
  INFO(why);
  REQUIRE(why.empty());
  add_surface_contact(w, c);
}

nurbs::Curve egg() {
  std::vector<Vec3> points;
  for (int i = 0; i < 12; ++i) {
    const Real t = i * kPi / 6, r = 0.04 + 0.008 * std::sin(t) + 0.003 * std::cos(2 * t);
    points.push_back({r * std::cos(t), r * std::sin(t), 0});
  }
  const auto made = nurbs::interpolated(points, 3, nurbs::Ends::periodic);
  REQUIRE(made);
  return *made;
}

/// Shafts with cams under flat faces, or pairs of equal ellipses about their foci.
World many(Kind kind) {
  World w = planar_world();
  w.default_settings.sleep_speed = 0;
  const Entity ground = add_fixed(w);
  for (int i = 0; i < kCount; ++i) {
    const Real x = 2.0 * i;
    const bool gears = kind == Kind::ellipses;
    const Real a = 0.1, focus = 0.04, b = std::sqrt(a * a - focus * focus);
    const Entity cam = add_part(w, {x + (gears ? focus : 0), 0, 0});
    const Entity other = add_part(w, {x + (gears ? 2 * a + focus : 0), gears ? 0 : 0.04, 0});
    SurfaceContact c;
    c.a = cam, c.b = other, c.lifts = kind == Kind::lifting;
    const Vec3 at = w.bodies[cam].pose.position, to = w.bodies[other].pose.position;
    const nurbs::Curve face = nurbs::line({-0.1, 0, 0}, {0.1, 0, 0});
    w.bodies[cam].angular_velocity.z = 5;
    if (gears) {
      w.bodies[other].angular_velocity.z = -5;
      add_hinge(w, ground, cam, at - Vec3(focus, 0, 0));
      add_hinge(w, ground, other, to - Vec3(focus, 0, 0));
      c.motion = SurfaceMotion::rolling;
      touch(w, c, nurbs::ellipse({}, a, b), nurbs::ellipse({}, a, b));
      continue;
    }
    add_hinge(w, ground, cam, at);
    add_link(w,
             {ground, other, planar_joint(w, ground, other, JointKind::prismatic, to, {0, 1, 0})});
    if (kind == Kind::none) continue;
    touch(w, c, kind == Kind::spline ? egg() : nurbs::circle({.origin = {0.015, 0, 0}}, 0.04),
          face);
  }
  return w;
}

/// CPU time of a step, the least of some rounds, us.
Real cost(const World& start, Real h = 1.0 / 60) {
  Simulation sim = Simulation::copy_of(start, {h});
  for (int i = 0; i < 20; ++i) REQUIRE(sim.step().status == Status::ok);
  Real least = 1e300;
  for (int round = 0; round < 15; ++round) {
    const std::clock_t from = std::clock();
    for (int i = 0; i < 40; ++i) sim.step();
    least = std::min(least, Real(std::clock() - from) / CLOCKS_PER_SEC);
  }
  return least / 40 * 1e6;
}

}  // namespace

TEST_CASE("planar: what linkages and curves cost", "[.]") {
  const std::pair<const char*, Kind> kinds[] = {{"without a contact", Kind::none},
                                                {"a circle under a face", Kind::circle},
                                                {"one that may lift", Kind::lifting},
                                                {"a spline under a face", Kind::spline},
                                                {"ellipses that roll", Kind::ellipses}};
  const Real without = cost(many(Kind::none)) / kCount;
  for (const auto& [name, kind] : kinds) {
    const Real with = cost(many(kind)) / kCount;
    std::cout << name << ": " << with << " us a mechanism and step, " << with - without
              << " us more than without\n";
  }
  for (const char* name : {"geneva", "cam_follower", "spline_cam", "elliptical_gears"}) {
    auto scene = load_scene(asset("scenes/" + std::string(name) + ".json"));
    REQUIRE(scene);
    std::cout << name << ".json: " << cost(scene->world, scene->step) << " us a step\n";
  }
  CHECK(without > 0);
}
