// Whether a World stays in the plane of x and y.
#include <catch2/catch.hpp>

#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/plane_curves.hpp"
#include "engine/world/flat.hpp"
#include "engine/world/surface_start.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/planar.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

World any_four_bar() {
  World w = planar_four_bar();
  w.default_settings.solver = Solver::lagrangian;
  return w;
}
Entity rocker_of(const World& w) { return w.bodies.owners().back(); }

}  // namespace

TEST_CASE("a four-bar linkage in space stays in its plane, and what leads out of it is named") {
  World w = any_four_bar();
  CHECK(plane_fault(w, rocker_of(w)) == "");
  const auto why = [&] { return plane_fault(w, rocker_of(w)); };
  Body& b = w.bodies.values()[1];
  SECTION("a motion") {
    b.velocity.z = 1e-3;
    CHECK(why().find("moves along z") != std::string::npos);
    b.velocity.z = 1e-20;  // rounding
    CHECK(why() == "");
  }
  SECTION("a spin") {
    b.angular_velocity.x = 0.1;
    CHECK(why().find("rotates about an axis") != std::string::npos);
  }
  SECTION("gravity") {
    w.gravity = {0, -9, 0.1};
    CHECK(why().find("falls along z") != std::string::npos);
    for (Body& each : w.bodies.values()) each.gravity_scale = 0;
    CHECK(why() == "");
  }
  SECTION("a push") {
    w.push(w.bodies.owners()[1], {0, 0, 1}, b.pose.position);
    CHECK(why().find("is pushed") != std::string::npos);
  }
  SECTION("a cable") {
    add_cable(w, {w.bodies.owners()[0], w.bodies.owners()[1], {}});
    CHECK(why().find("a cable") != std::string::npos);
  }
  SECTION("a joint") {
    Joint& joint = w.links.values()[0].joint;
    joint.kind = JointKind::universal;
    CHECK(why().find("a kind that has no planar form") != std::string::npos);
  }
  SECTION("curve contacts that slide, and one with friction") {
    SurfaceContact c;
    c.a = w.bodies.owners()[0], c.b = w.bodies.owners()[1];
    c.on_a.curve = c.on_b.curve = contact_curve(nurbs::circle({}, 0.1), OuterSide::right);
    const Entity touch = add_surface_contact(w, c);
    CHECK(why() == "");
    w.surface_contacts[touch].friction = 0.3;
    CHECK(why().find("friction of a curve contact") != std::string::npos);
  }
  SECTION("a curve contact in another plane") {
    SurfaceContact c;
    c.a = w.bodies.owners()[0], c.b = w.bodies.owners()[1];
    c.on_a.curve = c.on_b.curve = contact_curve(nurbs::circle({}, 0.1), OuterSide::right);
    c.on_b.pose.rotation = from_rotation_vector({0.2, 0, 0});
    add_surface_contact(w, c);
    CHECK(why().find("has a curve of \"b\"") != std::string::npos);
  }
  SECTION("a spring pin") {
    Pin pin;
    pin.body = w.bodies.owners()[1], pin.kind = PinKind::spring;
    w.add_pin(pin);
    CHECK(why().find("a spring pin") != std::string::npos);
  }
}

TEST_CASE("what an island may touch counts where it is solid") {
  World w = planar_stack(1);
  CHECK(plane_fault(w, w.bodies.owners()[1]) == "");
  w.bodies.values()[0].pose.rotation = from_rotation_vector({0.2, 0, 0});
  CHECK(plane_fault(w, w.bodies.owners()[1]).find("may touch") != std::string::npos);
  CHECK(plane_fault(w, w.bodies.owners()[0]) == "is not a dynamic body");
}

TEST_CASE("what stays in the plane moves there alike by the planar and the exact solver") {
  World w = any_four_bar(), flat = w;
  REQUIRE(plane_fault(w, rocker_of(w)) == "");
  flat.default_settings.solver = Solver::planar;
  run(w, 1e-3, 500), run(flat, 1.0 / 1920, 960);
  for (std::size_t i = 0; i < w.bodies.size(); ++i)
    CHECK(glm::length(w.bodies.values()[i].pose.position - flat.bodies.values()[i].pose.position) <
          1e-5);
}
