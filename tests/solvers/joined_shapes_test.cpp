// What is joined does not touch as shapes, whatever joins it and whatever solver steps it.
#include <catch2/catch.hpp>

#include "engine/nurbs/makers.hpp"
#include "engine/world/surface_start.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

void give_shape(World& w, Entity e, ShapeKind kind, Vec3 size, Vec3 at = Vec3(0)) {
  Shape shape;
  shape.kind = kind, shape.size = size, shape.local.position = at;
  w.shapes.add(e, {{shape}}), w.collisions.add(e, {});
}

/// Steps for a second; energy and the number of steps with contacts.
struct Run {
  Real change = 0;  // relative
  int touched = 0;
};
Run run(World world, Real h) {
  Simulation sim(std::move(world), {h});
  const Real start = measure(sim.world).energy();
  Run out;
  for (int i = 0; i < std::lround(0.5 / h); ++i) {
    REQUIRE(sim.step().status == Status::ok);
    out.touched += !contacts_of(sim.world).empty();
  }
  out.change = measure(sim.world).energy() / start - 1;
  return out;
}

/// Two wheels of 0.1 m on axes 0.2 m apart; as shapes they are a millimetre larger.
struct Wheels {
  World world;
  Entity one, two, on_one, on_two;
};
Wheels wheels(Solver solver) {
  Wheels s{exact_world(Integrator::rk4, Vec3(0)), {}, {}, {}, {}};
  s.world.default_settings.solver = solver;
  const Entity ground = add_ground(s.world);
  const auto wheel = [&](Real x, Real rate, Entity& link) {
    Body b = solid(1, {0.01, 0.01, 0.02}, {{x, 0, 0}, kIdentity});
    b.angular_velocity = {0, 0, rate};
    const Entity e = s.world.add_body(b);
    give_shape(s.world, e, ShapeKind::cylinder, {0.101, 0.01, 0});
    s.world.shapes[e].list[0].local.rotation = from_rotation_vector({kPi / 2, 0, 0});
    link = add_link(s.world, {ground, e,
                              joint_at(s.world, ground, e, JointKind::hinge, {x, 0, 0},
                                       frame_along({0, 0, 1}))});
    return e;
  };
  s.one = wheel(0, 3, s.on_one), s.two = wheel(0.2, -3, s.on_two);
  return s;
}

}  // namespace

TEST_CASE("joined: an ellipsoid rolls on a plane by its joint alone, though both are solid") {
  for (const Integrator integrator : {Integrator::rk4, Integrator::radau}) {
    INFO(name_of(integrator));
    World w = exact_world(integrator);
    const Entity floor = add_ground(w);
    give_shape(w, floor, ShapeKind::box, {2, 0.02, 2}, {0, -0.02, 0});
    const Vec3 h(0.3, 0.15, 0.2);
    Body b = solid_ellipsoid(2, h, {{0, h.y, 0}, kIdentity});
    b.velocity = {0.3, 0, 0}, b.angular_velocity = {0, 1.5, -0.3 / h.y};
    const Entity body = w.add_body(b);
    give_shape(w, body, ShapeKind::ellipsoid, h);
    touch(w, {body, ball_skin(h), floor, flat_skin(8)}, SurfaceMotion::rolling);
    const Run found = run(std::move(w), 1e-3);
    CHECK(found.touched == 0);
    CHECK(std::abs(found.change) <= 1e-8);
  }
}

TEST_CASE("joined: wheels that roll on one another by curves do not touch as shapes") {
  for (const Solver solver : {Solver::lagrangian, Solver::planar}) {
    INFO(name_of(solver));
    Wheels s = wheels(solver);
    SurfaceContact c;
    c.a = s.one, c.b = s.two, c.motion = SurfaceMotion::rolling;
    c.on_a.curve = c.on_b.curve = contact_curve(nurbs::circle({}, 0.1), OuterSide::right);
    REQUIRE(place_surfaces(c, {s.world.bodies[c.a].pose, s.world.bodies[c.b].pose}).empty());
    add_surface_contact(s.world, c);
    const Run found = run(std::move(s.world), 1e-3);
    CHECK(found.touched == 0);
    CHECK(std::abs(found.change) <= 1e-8);
  }
}

TEST_CASE("joined: wheels of a gear do not touch as shapes, wheels without one do") {
  Wheels s = wheels(Solver::lagrangian);
  Gear gear;
  gear.first = s.on_one, gear.second = s.on_two, gear.ratio = -1;
  World loose = s.world;
  add_gear(s.world, gear);
  const Run found = run(std::move(s.world), 1e-3);
  CHECK(found.touched == 0);
  CHECK(std::abs(found.change) <= 1e-8);
  CHECK(run(std::move(loose), 1e-3).touched > 0);
}
