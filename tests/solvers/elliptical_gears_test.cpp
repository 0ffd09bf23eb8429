// Elliptical gears about their foci. Where they touch along the line of centres the gap follows
// from the rolling, so one row is redundant; at the ends of their axes the gap alone says nothing.
// Energy is kept: (I + J (r / (2 a - r))^2) w^2 is constant, r(phi) the ellipse from its focus.
#include <catch2/catch.hpp>

#include "engine/nurbs/makers.hpp"
#include "engine/world/surface_start.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kHalf = 0.1, kOne = 0.02, kTwo = 0.002;  // m; kg m^2

struct Gears {
  Real eccentricity, start, rate;  // rad from the pericentre, rad/s

  Real arm(Real phi) const {
    return kHalf * (1 - eccentricity * eccentricity) / (1 + eccentricity * std::cos(phi));
  }
  Real ratio(Real phi) const { return arm(phi) / (2 * kHalf - arm(phi)); }
  Real inertia(Real phi) const { return kOne + kTwo * ratio(phi) * ratio(phi); }
  Real rate_at(Real phi) const { return rate * std::sqrt(inertia(start) / inertia(phi)); }
  /// The angle after a time.
  Real after(Real time) const {
    const int steps = static_cast<int>(std::ceil(2000 * time));
    const Real h = time / steps;
    Real phi = start;
    for (int i = 0; i < steps; ++i) {
      const Real a = rate_at(phi), b = rate_at(phi + h / 2 * a), c = rate_at(phi + h / 2 * b),
                 d = rate_at(phi + h * c);
      phi += h / 6 * (a + 2 * b + 2 * c + d);
    }
    return phi;
  }
  /// The other one's angle: their arms add up to the distance of the centres.
  Real other(Real phi) const {
    const Real half = std::remainder(phi, 2 * kPi) / 2;
    const Real k = (1 + eccentricity) / (1 - eccentricity);
    return -2 * std::atan2(std::sin(half), k * std::cos(half));
  }
};

Quat turned(Real angle) { return from_rotation_vector({0, 0, angle}); }

/// How far the first wheel is off its angle after a time, of what it turned.
Real error_of(const Gears& g, Integrator integrator, Real h, Real time) {
  World w = exact_world(integrator, Vec3(0));
  const Entity ground = add_ground(w);
  const auto wheel = [&](Real inertia, Vec3 at, Real angle, Real rate) {
    Body b = solid(1, {inertia / 2, inertia / 2, inertia}, {at, turned(angle)});
    b.angular_velocity = {0, 0, rate};
    const Entity e = w.add_body(b);
    add_link(w, {ground, e, joint_at(w, ground, e, JointKind::hinge, at, frame_along({0, 0, 1}))});
    return e;
  };
  const Entity one = wheel(kOne, Vec3(0), g.start, g.rate);
  const Entity two = wheel(kTwo, {2 * kHalf, 0, 0}, g.other(g.start), -g.rate * g.ratio(g.start));
  SurfaceContact c;
  c.a = one, c.b = two, c.motion = SurfaceMotion::rolling;
  for (ContactSurface* on : {&c.on_a, &c.on_b}) {
    const Real minor = kHalf * std::sqrt(1 - g.eccentricity * g.eccentricity);
    on->curve = contact_curve(nurbs::ellipse({}, kHalf, minor), OuterSide::right);
    on->pose.position = {-g.eccentricity * kHalf, 0, 0};
  }
  REQUIRE(place_surfaces(c, {w.bodies[c.a].pose, w.bodies[c.b].pose}).empty());
  add_surface_contact(w, c);
  Simulation sim(std::move(w), {h});
  const int steps = static_cast<int>(std::lround(time / h));
  for (int i = 0; i < steps; ++i) {
    const StepReport report = sim.step();
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.rescued == 0);
  }
  const auto angle = [&](Entity e) {
    const Quat q = sim.world.bodies[e].pose.rotation;
    return 2 * std::atan2(q.z, q.w);
  };
  const Real now = g.after(steps * h);
  CHECK(std::abs(std::remainder(angle(two) - g.other(angle(one)), 2 * kPi)) <= 1e-8);
  return std::abs(std::remainder(angle(one) - now, 2 * kPi)) / (now - g.start);
}

/// What is let pass at 240 Hz, and the order.
struct Bound {
  Real error;
  int order;
};
Bound bound_of(Integrator integrator) {
  switch (integrator) {
    case Integrator::euler:
      return {0.1, 1};
    case Integrator::rk4:
    case Integrator::radau:
      return {1e-7, 4};
    default:
      return {1e-4, 2};
  }
}

}  // namespace

TEST_CASE("surfaces: elliptical gears turn as their arms tell, from any start") {
  for (const Integrator integrator : kAll)
    for (const Real eccentricity : {0.3, 0.6, 0.85})
      for (const Real start : {0.0, 1.0, kPi}) {
        INFO(name_of(integrator) << ", eccentricity " << eccentricity << ", from " << start);
        const Gears gears{eccentricity, start, 1};
        const Bound bound = bound_of(integrator);
        CHECK(error_of(gears, integrator, 1.0 / 240, 7) <= bound.error);
      }
}

TEST_CASE("surfaces: elliptical gears turn to the order of their integrator") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    const Gears gears{0.6, 0.5, 2};
    const Real coarse = error_of(gears, integrator, 1.0 / 60, 4),
               fine = error_of(gears, integrator, 1.0 / 240, 4);
    INFO(coarse << " " << fine);
    CHECK(fine <= std::max(1e-12, 1.5 * coarse * std::pow(0.25, bound_of(integrator).order)));
  }
}
