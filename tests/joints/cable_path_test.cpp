// Lengths of cables over pulleys: closed forms, and derivatives against differences.
#include "engine/joints/cable_path.hpp"

#include <catch2/catch.hpp>

#include "engine/base/rotation.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

PathPoint end_at(Vec3 at) {
  PathPoint p;
  p.centre = at;
  return p;
}

PathPoint pulley(Vec3 at, Real radius, Vec3 axis = {0, 0, 1}) {
  PathPoint p = end_at(at);
  p.radius = radius, p.axis = axis;
  return p;
}

Real length_of(const std::vector<PathPoint>& path) { return path_length(path, {}).length; }

/// A place on a body that moves steadily but for its turning.
struct Mover {
  Vec3 position, velocity, spin, anchor, axis;
  Real radius = 0;

  PathPoint at(Real time) const {
    BodyState s;
    s.position = position + time * velocity, s.velocity = velocity;
    s.rotation = from_rotation_vector(time * spin), s.angular_velocity = spin;
    s.rotation_matrix = glm::mat3_cast(s.rotation);
    return path_point(s, anchor, axis, radius);
  }
};

std::vector<PathPoint> path_at(const std::vector<Mover>& movers, Real time) {
  std::vector<PathPoint> path;
  for (const Mover& m : movers) path.push_back(m.at(time));
  return path;
}

/// From end to end over one to four pulleys and rings that lie nearly in one plane.
std::vector<Mover> random_route(Random& dice) {
  std::vector<Mover> route;
  const int guides = 1 + static_cast<int>(dice.between(0, 3.999));
  for (int i = 0; i < guides + 2; ++i) {
    Mover m;
    m.position = {i + dice.between(-0.2, 0.2), dice.between(-0.5, 0.5), dice.between(-0.01, 0.01)};
    m.velocity = dice.in_cube(1), m.spin = dice.in_cube(2), m.anchor = dice.in_cube(0.02);
    const bool ring = i == 0 || i == guides + 1 || dice.between(0, 1) < 0.25;
    m.radius = ring ? 0 : dice.between(0.05, 0.35);
    const Real side = dice.between(0, 1) < 0.5 ? -1 : 1;
    m.axis = glm::normalize(Vec3(0.02 * dice.between(-1, 1), 0.02 * dice.between(-1, 1), side));
    route.push_back(m);
  }
  return route;
}

}  // namespace

TEST_CASE("a cable without pulleys is as long as the lines between its rings") {
  CHECK(length_of({end_at({0, 0, 0}), end_at({3, 4, 0})}) == Approx(5).epsilon(1e-15));
  CHECK(length_of({end_at({0, 0, 0}), end_at({3, 4, 0}), end_at({3, 4, 12})}) ==
        Approx(17).epsilon(1e-15));
}

TEST_CASE("over one pulley the cable turns by half a circle") {
  // Up on the left, down on the right: clockwise as seen against z.
  const auto length = [](Vec3 axis) {
    return length_of({end_at({-0.2, -1, 0}), pulley({0, 0, 0}, 0.2, axis), end_at({0.2, -1.5, 0})});
  };
  CHECK(length({0, 0, -1}) == Approx(2.5 + 0.2 * kPi).epsilon(1e-14));
  // The other way round it goes under the pulley, across its own way.
  CHECK(length({0, 0, 1}) > 3);
}

TEST_CASE("a cable passes by a pulley that would have to bend it outwards") {
  const std::vector<PathPoint> path{end_at({-1, -0.5, 0}), pulley({0, 0, 0}, 0.2, {0, 0, 1}),
                                    end_at({1, -0.5, 0})};
  CHECK(length_of(path) == Approx(2).epsilon(1e-15));
  std::vector<Vec3> points;
  trace_path(path, 0.1, points);
  CHECK(points.size() == 2);
}

TEST_CASE("open and crossed belts between two pulleys have their known lengths") {
  // Half a belt: ends far out on the tangents' side, pulleys of radius R and r at distance d.
  const Real big = 0.5, small = 0.2, d = 2;
  for (const bool crosses : {false, true}) {
    const Vec3 axis(0, 0, -1), other = crosses ? -axis : axis;
    const Real sink = crosses ? 3 : -3;
    // From straight below the left side of the first, over both, to straight below or above the
    // right side of the second.
    const Real length = length_of({end_at({-big, -3, 0}), pulley({0, 0, 0}, big, axis),
                                   pulley({d, 0, 0}, small, other),
                                   end_at({d + (crosses ? small : small), sink, 0})});
    const Real shift = crosses ? big + small : big - small;
    const Real lean = std::asin(shift / d), straight = std::sqrt(d * d - shift * shift);
    // Turned from upwards to the common tangent, and from there downwards, or upwards if crossed.
    const Real on_big = kPi / 2 + lean;
    const Real on_small = crosses ? kPi / 2 + lean : kPi / 2 - lean;
    CHECK(length == Approx(3 + big * on_big + straight + small * on_small + 3).epsilon(1e-13));
  }
}

TEST_CASE("gradients and second rates of routes agree with differences") {
  Random dice(11);
  int wrapped = 0;
  for (int n = 0; n < 400; ++n) {
    const std::vector<Mover> route = random_route(dice);
    const std::vector<PathPoint> path = path_at(route, 0);
    std::vector<PathGradient> g(path.size());
    const PathLength now = path_length(path, g);
    Real rate = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const Vec3 arm = path[i].centre - route[i].position;
      rate += glm::dot(g[i].by_centre, route[i].velocity) +
              glm::dot(glm::cross(arm, g[i].by_centre) + g[i].by_turn, route[i].spin);
    }
    const Real h = 1e-4;
    const auto at = [&](Real time) { return length_of(path_at(route, time)); };
    const Real first = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
    CHECK(rate == Approx(first).margin(1e-8).epsilon(1e-8));
    // Where a pulley is reached or left the curvature jumps.
    const Real second =
        (16 * (at(h) + at(-h)) - (at(2 * h) + at(-2 * h)) - 30 * at(0)) / (12 * h * h);
    const Real coarse = (at(2 * h) + at(-2 * h) - 2 * at(0)) / (4 * h * h);
    if (std::abs(second - coarse) > 1e-3 * (1 + std::abs(second))) continue;
    ++wrapped;
    CHECK(now.second_rate == Approx(second).margin(2e-5).epsilon(1e-5));
  }
  CHECK(wrapped > 380);
}

TEST_CASE("the length does not jump where a pulley is reached or left") {
  const auto at = [](Real height) {
    std::vector<PathGradient> g(3);
    const std::vector<PathPoint> path{end_at({-1, height, 0}), pulley({0, 0, 0}, 0.2, {0, 0, -1}),
                                      end_at({1, height, 0})};
    const Real length = path_length(path, g).length;
    return std::pair{length, g[0].by_centre};
  };
  const Real touch = 0.2;  // the line at this height touches the pulley's top
  const auto [below, gradient_below] = at(touch - 1e-9);
  const auto [above, gradient_above] = at(touch + 1e-9);
  CHECK(std::abs(below - above) <= 1e-15);
  CHECK(glm::length(gradient_below - gradient_above) <= 1e-8);
  CHECK(at(0.5).first == Approx(2).epsilon(1e-15));
  CHECK(at(0).first > 2.01);
}

TEST_CASE("the drawn cable is as long as the computed one") {
  Random dice(3);
  for (int n = 0; n < 100; ++n) {
    std::vector<Mover> route = random_route(dice);
    for (Mover& m : route) m.position.z = 0, m.anchor.z = 0, m.axis = {0, 0, m.axis.z > 0 ? 1 : -1};
    const std::vector<PathPoint> path = path_at(route, 0);
    std::vector<Vec3> points;
    trace_path(path, 0.01, points);
    Real sum = 0;
    for (std::size_t i = 1; i < points.size(); ++i) sum += glm::length(points[i] - points[i - 1]);
    CHECK(sum == Approx(length_of(path)).epsilon(1e-5));
  }
}

TEST_CASE("turns round a pulley count both ways, and past it") {
  const Real radius = 0.2, arm = 1;
  std::vector<PathPoint> path{end_at({-radius, -2, 0}), pulley({0, 0, 0}, radius, {0, 0, -1}),
                              end_at({})};
  // Clockwise from the line that leaves the pulley at its top.
  const auto turned_by = [&](Real angle) {
    const Vec3 out(std::sin(angle), std::cos(angle), 0),
        along(std::cos(angle), -std::sin(angle), 0);
    path[2].centre = radius * out + arm * along;
    std::vector<Real> wraps(3);
    follow_path(path, 0, wraps);
    path[1].wrap = wraps[1];
    return length_of(path);
  };
  const auto wound = [&](Real angle) { return 2 + radius * (kPi / 2 + angle) + arm; };
  for (Real angle = 0; angle < 20; angle += 0.7)
    CHECK(turned_by(angle) == Approx(wound(angle)).epsilon(1e-14));
  CHECK(path[1].wrap > 3 * 2 * kPi);
  for (Real angle = 20; angle > -1.5; angle -= 0.7)
    CHECK(turned_by(angle) == Approx(wound(angle)).epsilon(1e-14));
  // Farther back the cable leaves the pulley, and comes to lie on it again as it left.
  for (const Real angle : {-2.0, -2.7, -3.4, -4.1, -4.8, -4.1, -3.4, -2.7, -2.0}) {
    const Real length = turned_by(angle);
    CHECK(length == Approx(glm::length(path[2].centre - path[0].centre)).epsilon(1e-15));
  }
  CHECK(turned_by(-1) == Approx(wound(-1)).epsilon(1e-14));
}
