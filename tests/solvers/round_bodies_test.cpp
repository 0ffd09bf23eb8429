// Cylinders, cones and ellipsoids in motion and at rest, against closed forms.
#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/contact/contact.hpp"
#include "engine/geometry/kinds.hpp"
#include "tests/base/random.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81;

Shape cylinder(Real r, Real half) { return {ShapeKind::cylinder, {r, half, 0}, {}, 0}; }
Shape cone(Real r, Real half) { return {ShapeKind::cone, {r, half, 0}, {}, 0}; }
Shape ellipsoid(Vec3 radii) { return {ShapeKind::ellipsoid, radii, {}, 0}; }

Quat about(Vec3 axis, Real angle) { return from_rotation_vector(angle * axis); }
/// A cylinder's axis along z.
const Quat kLying = about({1, 0, 0}, kPi / 2);

Collision surface(Real friction, Real rolling = 0) {
  Collision c;
  c.friction = friction, c.rolling = rolling, c.others = true;
  return c;
}

/// A solid with its own frame at `pose`; its mass centre may lie elsewhere.
Entity put(World& w, Shape shape, const Pose& pose, Real friction = 0.6) {
  const Vec3 centre = mass_properties(shape, 1000).centre;
  shape.local.position = -centre;
  return add_solid(w, shape, {to_world(pose, centre), pose.rotation}, Motion::dynamic,
                   surface(friction));
}

/// A floor whose top is at y = 0: a plane or a box.
void put_floor(World& w, ShapeKind kind, Quat turn = kIdentity, Real friction = 0.6) {
  if (kind == ShapeKind::plane) return void(add_ground(w, surface(friction), turn));
  add_solid(w, box_shape({30, 0.5, 30}), {turn * Vec3(0, -0.5, 0), turn}, Motion::fixed,
            surface(friction));
}
constexpr ShapeKind kFloors[] = {ShapeKind::plane, ShapeKind::box};

World awake(Solver solver = Solver::articulated) {
  World w;
  w.default_settings.sleep_speed = 0;
  w.default_settings.solver = solver;
  return w;
}

void run(Simulation& sim, Real seconds) {
  for (int i = 0; i < std::lround(seconds / sim.settings.h); ++i)
    REQUIRE(sim.step().status == Status::ok);
}

int asleep_after(Simulation& sim, Real seconds) {
  run(sim, seconds - sim.settings.h);
  return sim.step().asleep;
}

}  // namespace

TEST_CASE("a cylinder rolls down a slope with two thirds of g sin, straight") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian})
    for (const ShapeKind floor : kFloors)
      for (const Real h : {1.0 / 60, 1.0 / 240}) {
        CAPTURE(name_of(floor), h, name_of(solver));
        World w = awake(solver);
        const Real angle = kPi / 12, r = 0.15;
        const Quat slope = about({0, 0, 1}, -angle);
        put_floor(w, floor, slope);
        const Entity e = put(w, cylinder(r, 0.3), {slope * Vec3(0, r, 0), slope * kLying});
        Simulation sim = Simulation::copy_of(w, {h});
        const Real seconds = 2;
        run(sim, seconds);
        const Body& b = sim.world.bodies[e];
        const Vec3 v = glm::conjugate(slope) * b.velocity;
        const Real speed = 2.0 / 3 * kG * std::sin(angle) * seconds;
        CHECK(v.x == Approx(speed).epsilon(2e-3));
        CHECK(b.angular_velocity.z == Approx(-v.x / r).epsilon(1e-3));
        CHECK(std::abs(v.y) < 1e-4 * speed);
        const Vec3 at = glm::conjugate(slope) * b.pose.position;
        CHECK(at.x == Approx(speed * seconds / 2).epsilon(0.02));
        CHECK(at.y == Approx(r).margin(1e-4));
        CHECK(std::abs(at.z) < 1e-6);
        CHECK(std::abs((b.pose.rotation * Vec3(0, 1, 0)).x) < 1e-6);
      }
}

TEST_CASE("a cylinder rolls ten metres on the level without drift or loss") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian})
    for (const ShapeKind floor : kFloors) {
      CAPTURE(name_of(floor), name_of(solver));
      World w = awake(solver);
      put_floor(w, floor);
      const Real r = 0.2;
      const Entity e = put(w, cylinder(r, 0.3), {{0, r, 0}, kLying});
      w.bodies[e].velocity = {2, 0, 0}, w.bodies[e].angular_velocity = {0, 0, -2 / r};
      Simulation sim = Simulation::copy_of(w, {1.0 / 60});
      run(sim, 5);
      const Body& b = sim.world.bodies[e];
      CHECK(b.pose.position.x == Approx(10).epsilon(1e-4));
      CHECK(b.pose.position.y == Approx(r).margin(1e-4));
      CHECK(std::abs(b.pose.position.z) < 1e-6);
      CHECK(b.velocity.x == Approx(2).epsilon(1e-4));
      CHECK(std::abs((b.pose.rotation * Vec3(0, 1, 0)).x) < 1e-6);
    }
}

TEST_CASE("an ellipsoid of three like radii rolls as a ball does") {
  const Quat slope = about({0, 0, 1}, -0.2);
  World round = awake(), ball = awake();
  for (World* w : {&round, &ball}) put_floor(*w, ShapeKind::plane, slope);
  const Pose start{slope * Vec3(0, 0.1, 0), about({0.6, 0, 0.8}, 1)};
  const Entity e = put(round, ellipsoid(Vec3(0.1)), start);
  put(ball, ball_shape(0.1), start);
  Simulation one = Simulation::copy_of(round, {1.0 / 60}),
             two = Simulation::copy_of(ball, {1.0 / 60});
  run(one, 2), run(two, 2);
  const Body &b = one.world.bodies[e], &c = two.world.bodies[e];
  CHECK(glm::distance(b.pose.position, c.pose.position) < 1e-9);
  CHECK(glm::distance(b.angular_velocity, c.angular_velocity) < 1e-9);
}

TEST_CASE("an ellipsoid rocks on its flat side with the period of its curvature") {
  // w^2 = g (a^2 / c - c) / ((a^2 + c^2) / 5 + c^2), where it does not slip.
  const Real a = 0.3, c = 0.15,
             period = 2 * kPi * std::sqrt(((a * a + c * c) / 5 + c * c) / (kG * (a * a / c - c)));
  for (const Solver solver : {Solver::articulated, Solver::lagrangian}) {
    CAPTURE(name_of(solver));
    World w = awake(solver);
    put_floor(w, ShapeKind::plane, kIdentity, 2);
    const Real lean = 0.05, height = std::hypot(c * std::cos(lean), a * std::sin(lean));
    const Entity e = put(w, ellipsoid({a, c, 0.2}), {{0, height, 0}, about({0, 0, 1}, lean)}, 2);
    Simulation sim = Simulation::copy_of(w, {1.0 / 240});
    std::vector<Real> crossings;
    Real before = lean, most = 0;
    for (int i = 0; i < 240 * 4; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Vec3 x = sim.world.bodies[e].pose.rotation * Vec3(1, 0, 0);
      const Real now = std::atan2(x.y, x.x);
      if (before < 0 && now >= 0) crossings.push_back((i + before / (before - now)) / 240.0);
      before = now;
      if (i > 240 * 3) most = std::max(most, std::abs(now));
    }
    REQUIRE(crossings.size() > 3);
    const Real found = (crossings.back() - crossings.front()) / Real(crossings.size() - 1);
    CHECK(found == Approx(period).epsilon(0.01));
    CHECK(most < 1.05 * lean);
    CHECK(most > (solver == Solver::articulated ? 0.9 : 0.6) * lean);  // of first order
  }
}

TEST_CASE("a cone on its side rolls about its tip") {
  // Its axis goes round with W; it turns about the line that touches with W / tan(half angle).
  const Real r = 0.1, height = 0.3, half_angle = std::atan2(r, height), turning = 2;
  for (const ShapeKind floor : kFloors) {
    CAPTURE(name_of(floor));
    World w = awake();
    put_floor(w, floor);
    const Quat lying = about({0, 0, 1}, -(kPi / 2 + half_angle));
    const Shape shape = cone(r, height / 2);
    const Vec3 tip = lying * Vec3(0, height / 2, 0);
    const Entity e = put(w, shape, {-tip, lying}, 0.8);
    Body& b = w.bodies[e];
    // Along the line from the tip, with the tip at rest.
    b.angular_velocity = Vec3(turning / std::tan(half_angle), 0, 0);
    const Vec3 out = b.pose.position;
    b.velocity = glm::cross(b.angular_velocity, out);
    Simulation sim = Simulation::copy_of(w, {1.0 / 240});
    const auto tip_now = [&] {
      const Body& now = sim.world.bodies[e];
      return to_world(now.pose, Vec3(0, 0.75 * height, 0));
    };
    CHECK(glm::length(tip_now()) < 1e-12);
    Real way = 0, before = std::atan2(-out.z, out.x), farthest = 0;
    const int steps = static_cast<int>(std::lround(2 * kPi / turning * 240));
    for (int i = 0; i < steps; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Vec3 at = sim.world.bodies[e].pose.position;
      const Real now = std::atan2(-at.z, at.x);
      way += std::remainder(now - before, 2 * kPi), before = now;
      farthest = std::max(farthest, glm::length(tip_now()));
    }
    CHECK(std::abs(way) == Approx(2 * kPi).epsilon(0.01));
    CHECK(farthest < 2e-3);
    CHECK(sim.world.bodies[e].pose.position.y == Approx(out.y).margin(1e-4));
  }
}

TEST_CASE("what stands on its end falls asleep; leaning too far it tips over") {
  for (const ShapeKind floor : kFloors)
    for (const Shape& shape : {cylinder(0.1, 0.3), cylinder(0.3, 0.05), cone(0.2, 0.25)})
      for (const Real lean : {0.0, 0.05, 0.5}) {
        CAPTURE(name_of(floor), name_of(shape.kind), shape.size.y, lean);
        World w;
        put_floor(w, floor);
        const Quat turn = about({1, 0, 0}, lean);
        const Real r = shape.size.x, half = shape.size.y;
        const Real height = half * std::cos(lean) + r * std::sin(lean);
        const Entity e = put(w, shape, {{0, height, 0}, turn});
        Simulation sim = Simulation::copy_of(w, {1.0 / 60});
        CHECK(asleep_after(sim, 8) == 1);
        const Vec3 mass_centre = mass_properties(shape, 1000).centre;
        const bool stands = std::tan(lean) < r / (half + mass_centre.y);
        const Vec3 axis = sim.world.bodies[e].pose.rotation * Vec3(0, 1, 0);
        if (stands)
          CHECK(axis.y > 1 - 1e-6);
        else
          CHECK(std::abs(axis.y) < 0.7);
      }
}

TEST_CASE("a stack of cylinders stands and falls asleep, whatever they are turned by") {
  World w;
  put_floor(w, ShapeKind::plane);
  std::vector<Entity> all;
  for (int i = 0; i < 6; ++i)
    all.push_back(put(w, cylinder(0.2, 0.15), {{0, 0.15 + 0.3 * i, 0}, about({0, 1, 0}, 0.7 * i)}));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  CHECK(asleep_after(sim, 6) == 6);
  for (int i = 0; i < 6; ++i) {
    const Vec3 at = sim.world.bodies[all[std::size_t(i)]].pose.position;
    CHECK(std::hypot(at.x, at.z) < 1e-3);
    CHECK(at.y == Approx(0.15 + 0.3 * i).margin(2e-3));
  }
}

TEST_CASE("round bodies thrown on a heap come to rest, and no number of threads alters a bit") {
  Random dice(11);
  World w;
  add_solid(w, box_shape({30, 0.5, 30}), {{0, -0.5, 0}, kIdentity}, Motion::fixed,
            surface(0.6, 0.003));
  for (int side = 0; side < 4; ++side) {
    const Quat turn = about({0, 1, 0}, side * kPi / 2);
    add_solid(w, box_shape({0.05, 1, 0.8}), {turn * Vec3(0.75, 1, 0), turn}, Motion::fixed,
              surface(0.6));
  }
  for (int i = 0; i < 27; ++i) {
    const Real s = dice.between(0.7, 1.2);
    const Shape shapes[] = {cylinder(0.1 * s, 0.12 * s), cone(0.13 * s, 0.11 * s),
                            ellipsoid(s * Vec3(0.16, 0.08, 0.1))};
    const Vec3 at(0.4 * (i % 3 - 1), 0.4 + 0.35 * (i / 9), 0.4 * (i / 3 % 3 - 1));
    put(w, shapes[i % 3], {at, dice.orientation()});
  }
  Simulation one = Simulation::copy_of(w, {1.0 / 60}), many = Simulation::copy_of(w, {1.0 / 60});
  one.settings.threads = 1, many.settings.threads = 3;
  for (int i = 0; i < 60 * 8; ++i) {
    REQUIRE(one.step().status == Status::ok);
    if (i >= 120) continue;
    many.step();
    REQUIRE(state_hash(one.world) == state_hash(many.world));
  }
  Real fastest = 0, deepest = 0;
  for (const Body& b : one.world.bodies.values()) {
    if (b.motion == Motion::fixed) continue;
    fastest = std::max(fastest, glm::length(b.velocity));
    CHECK(b.pose.position.y > 0.03);
    CHECK(std::max(std::abs(b.pose.position.x), std::abs(b.pose.position.z)) < 0.7);
  }
  each_contact(one.world, [&](const Contact& c) { deepest = std::max(deepest, c.depth); });
  CHECK(fastest < 0.1);
  CHECK(deepest < 5e-3);
}
