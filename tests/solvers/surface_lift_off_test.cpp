// A ball rolls down a sphere, begins to slip, and leaves it. Until it slips energy is kept; then
// u = phi'^2 obeys du/dphi = 2 mu u + 2 g / L (sin phi - mu cos phi), which is linear.
#include <catch2/catch.hpp>

#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81, kStart = 0.1, kPart = 0.4;  // rad; of m r^2

struct Hill {
  Real radius, ball, mass, friction;

  Real way() const { return radius + ball; }
};

template <class F>
Real root_of(const F& f, Real low, Real high) {
  for (int i = 0; i < 200; ++i) (f(0.5 * (low + high)) > 0 ? high : low) = 0.5 * (low + high);
  return high;
}

template <class F>
Real integral_of(const F& f, Real high) {
  constexpr int kParts = 4000;
  Real sum = f(0) + f(high);
  for (int i = 1; i < kParts; ++i) sum += (i % 2 == 1 ? 4 : 2) * f(i * high / kParts);
  return sum * high / (3 * kParts);
}

/// Level speed and spin after it has left.
struct Flight {
  Real speed = 0, spin = 0;
};
Flight exact_flight(const Hill& hill) {
  const Real mu = hill.friction, g = kG / hill.way();
  const auto rolling = [&](Real phi) {
    return 2 * g / (1 + kPart) * (std::cos(kStart) - std::cos(phi));
  };
  const Real slips = root_of(
      [&](Real phi) {
        return kPart / (1 + kPart) * g * std::sin(phi) - mu * (g * std::cos(phi) - rolling(phi));
      },
      kStart, kPi / 2);
  const Real b = -6 * mu * g / (1 + 4 * mu * mu), a = g * (4 * mu * mu - 2) / (1 + 4 * mu * mu);
  const Real c = rolling(slips) - a * std::cos(slips) - b * std::sin(slips);
  const auto u = [&](Real phi) {
    return a * std::cos(phi) + b * std::sin(phi) + c * std::exp(2 * mu * (phi - slips));
  };
  const auto pressing = [&](Real phi) { return g * std::cos(phi) - u(phi); };  // N / (m L)
  const Real leaves = root_of([&](Real phi) { return -pressing(phi); }, slips, kPi / 2);
  const Real gained =
      integral_of([&](Real phi) { return mu * pressing(slips + phi) / std::sqrt(u(slips + phi)); },
                  leaves - slips);
  return {hill.way() * std::sqrt(u(leaves)) * std::cos(leaves),
          hill.way() / hill.ball * (std::sqrt(rolling(slips)) + gained / kPart)};
}

/// How far off it is, relative, after three times the square root of L / g times 1.2.
Real error_of(const Hill& hill, Integrator integrator, Real rate) {
  World w = exact_world(integrator);
  const Entity ground = add_ground(w);
  const Real r = hill.ball;
  const Entity ball =
      w.add_body(solid(hill.mass, Vec3(kPart * hill.mass * r * r),
                       {hill.way() * Vec3(std::sin(kStart), std::cos(kStart), 0), kIdentity}));
  const Entity contact = touch(w, {ball, ball_skin(Vec3(r)), ground, ball_skin(Vec3(hill.radius))},
                               SurfaceMotion::rolling);
  w.surface_contacts[contact].friction = hill.friction;
  w.surface_contacts[contact].lifts = true;
  const Real unit = std::sqrt(hill.way() / 1.1);
  Simulation sim(std::move(w), {unit / rate});
  for (int i = 0; i < std::lround(1.3 * rate); ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK_FALSE(sim.world.surface_contacts[contact].touches);
  const Flight exact = exact_flight(hill);
  const Body& b = sim.world.bodies[ball];
  return std::max(std::abs(b.velocity.x / exact.speed - 1),
                  std::abs(-b.angular_velocity.z / exact.spin - 1));
}

/// The error that is let pass at 240 steps a unit, and the order.
struct Bound {
  Real error;
  int order;
};
Bound bound_of(Integrator integrator) {
  switch (integrator) {
    case Integrator::euler:
      return {2e-2, 1};
    case Integrator::rk4:
    case Integrator::radau:
      return {1e-8, 4};
    default:
      return {1e-3, 2};
  }
}

}  // namespace

TEST_CASE("surfaces: a ball leaves a sphere with friction as the closed form tells") {
  for (const Real friction : {0.05, 0.3, 0.8})
    for (const Integrator integrator : kAll)
      for (const Real rate : {240.0, 480.0}) {
        const Bound bound = bound_of(integrator);
        const Real most = bound.error * std::pow(240 / rate, bound.order);
        INFO(name_of(integrator) << ", friction " << friction << ", rate " << rate);
        CHECK(error_of({1, 0.1, 1, friction}, integrator, rate) <= most);
      }
}

TEST_CASE("surfaces: balls of all sizes and masses leave a sphere alike") {
  for (const Hill& hill : {Hill{1e-2, 4e-3, 1e-3, 0.2}, Hill{200, 3, 500, 0.5}})
    for (const Integrator integrator : kAll) {
      INFO(name_of(integrator) << ", radius " << hill.radius);
      CHECK(error_of(hill, integrator, 240) <= bound_of(integrator).error);
    }
}
