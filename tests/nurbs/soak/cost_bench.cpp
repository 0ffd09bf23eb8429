// What evaluation, tracking and search cost, beside their errors: pantin_tests "nurbs: what it
// costs"
#include <catch2/catch.hpp>
#include <cstdio>
#include <ctime>

#include "engine/nurbs/closest.hpp"
#include "engine/nurbs/common_normal.hpp"
#include "engine/nurbs/makers.hpp"
#include "tests/nurbs/long.hpp"
#include "tests/nurbs/samples.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

namespace {

// Nanoseconds of CPU time a call, the least of some rounds: other work on the machine only adds.
template <class Work>
Real cost_of(int calls, Work&& work) {
  Real least = 1e300;
  for (int round = 0; round < 15; ++round) {
    const std::clock_t begin = std::clock();
    for (int i = 0; i < calls; ++i) work(i);
    least = std::min(least, static_cast<Real>(std::clock() - begin) / CLOCKS_PER_SEC * 1e9 / calls);
  }
  return least;
}

void line(const char* what, Real ns, Real error) {
  std::printf("%-52s %9.1f ns   error %.1e\n", what, ns, error);
}

void evaluation(const char* what, const Surface& s) {
  Random dice(1);
  const Face face(s);
  std::array<std::array<Real, 2>, 1024> at;
  Real error = 0;
  for (auto& [u, v] : at) {
    u = s.u.low() + s.u.domain().width() * dice.between(0, 1);
    v = s.v.low() + s.v.domain().width() * dice.between(0, 1);
    const Jet j = face.at(u, v);
    const SurfaceDerivatives d = evaluate(s, u, v, 2);
    error = std::max({error, glm::distance(j.s, d[0][0]),
                      glm::distance(j.uv, d[1][1]) / std::max(1.0, glm::length(d[1][1]))});
  }
  Real sum = 0;
  const Real ns = cost_of(100000, [&](int i) {
    const auto& [u, v] = at[static_cast<std::size_t>(i) % at.size()];
    const Jet j = face.at(u, v);
    sum += j.s.x + j.uv.y + j.vv.z;
  });
  CHECK(std::isfinite(sum));
  line(what, ns, error);
}

void tracking(const char* what, const Skin& a, const Skin& b, const Pose& pose, PlacePair start) {
  const CommonNormal exact = track({a, b, pose}, start);
  REQUIRE(exact.status == ContactStatus::found);
  start = exact.at;
  start.a.u += 1e-3 * a.face(start.a.face).u().domain().width();
  start.b.v += 1e-3 * b.face(start.b.face).v().domain().width();
  int iterations = 0, calls = 0;
  Real gap = 0;
  const Real ns = cost_of(20000, [&](int) {
    const CommonNormal pair = track_newton({a, b, pose}, start);
    iterations += pair.iterations, ++calls, gap = pair.gap;
  });
  char text[96];
  std::snprintf(text, sizeof text, "%s: a track of %.1f iterations", what,
                Real(iterations) / calls);
  line(text, ns, std::abs(gap - exact.gap));
  line("  an iteration of it", ns * calls / iterations, std::abs(gap - exact.gap));
}

void search(const char* what, const Face& face) {
  Random dice(2);
  const Ball ball = bounding_ball(face.surface().points);
  std::array<Vec3, 256> points;
  for (Vec3& p : points) p = ball.centre + 1.5 * ball.radius * dice.in_cube(1);
  Real error = 0;
  for (Vec3 p : points) {
    const NearestPoint found = closest_point(face, p);
    error =
        std::max(error, std::abs(glm::distance(face.at(found.u, found.v).s, p) - found.distance));
  }
  Real sum = 0;
  const Real ns = cost_of(512, [&](int i) {
    sum += closest_point(face, points[static_cast<std::size_t>(i) % points.size()]).distance;
  });
  CHECK(std::isfinite(sum));
  line(what, ns, error);
}

// An ellipsoid that stands on a long surface in 64 places, found anew in each.
void search_on(const Named& on) {
  Random dice(3);
  const Skin ball = Skin::ellipsoid({0.02, 0.03, 0.015}), surface = single(on.surface);
  std::vector<Pose> places;
  for (int i = 0; i < 64; ++i) places.push_back(standing_on(ball, surface, 1e-4, dice));
  std::array<CommonNormal, 16> found;
  Real error = 0;
  const Real ns = cost_of(64, [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    const std::size_t count = find_contacts({ball, surface, places[at]}, on.reach, found);
    Real nearest = 1e300;
    for (std::size_t k = 0; k < count; ++k)
      nearest = std::min(nearest, std::abs(found[k].gap - 1e-4));
    error = std::max(error, nearest);
  });
  line((std::string("contacts with an ellipsoid: ") + on.name).c_str(), ns, error);
}

}  // namespace

TEST_CASE("nurbs: what it costs", "[.bench]") {
  Random dice(7);
  evaluation("order 2, rational biquadratic", random_surface(2, 2, 8, 8, dice));
  evaluation("order 2, rational bicubic, 8 x 8 points", bumpy_surface(3, 8, 0.3, dice));
  evaluation("order 2, rational bicubic, 32 x 32 points", bumpy_surface(3, 32, 0.3, dice));
  evaluation("order 2, degree 4 x 4 (plain evaluation)", random_surface(4, 4, 8, 8, dice));
  const Skin one = Skin::ellipsoid({1, 0.7, 0.5}), two = Skin::ellipsoid({0.8, 1.1, 0.6});
  const Pose pose{{1.2, 1.3, 0.4}, from_rotation_vector({0.3, 0.2, 0.1})};
  tracking("ellipsoids", one, two, pose, closest_pair({one, two, pose}).at);
  const Skin cubic({bumpy_surface(3, 8, 0.05, dice)}, 1e-9),
      other({bumpy_surface(3, 8, 0.05, dice)}, 1e-9);
  const Pose over{{0.05, 0.02, 0.4}, from_rotation_vector({kPi, 0, 0})};
  std::array<CommonNormal, 8> found;
  REQUIRE(find_contacts({cubic, other, over}, 1, found) > 0);
  tracking("bicubic on bicubic", cubic, other, over, found[0].at);
  search("nearest of all, bicubic 8 x 8", Face(bumpy_surface(3, 8, 0.3, dice)));
  search("nearest of all, random folded bicubic 6 x 6", Face(random_surface(3, 3, 6, 6, dice)));
  search("nearest of all, torus", Face(torus({}, 2, 0.6)));
  for (const Named& on : long_surfaces()) search_on(on);
}
