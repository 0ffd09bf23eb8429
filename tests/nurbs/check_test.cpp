// What is wrong with a curve or a surface is told with its place, and where it is not smooth.
#include "engine/nurbs/check.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "engine/nurbs/makers.hpp"
#include "tests/nurbs/samples.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

namespace {

std::string first_error(const Surface& s) {
  const auto errors = errors_of(s, "roof");
  return errors.empty() ? "" : errors[0].message;
}

std::vector<FlawKind> kinds_of(const std::vector<Flaw>& flaws) {
  std::vector<FlawKind> kinds;
  for (const Flaw& f : flaws) kinds.push_back(f.kind);
  return kinds;
}

// Two parabolic arches side by side: a crease, or with equal slopes a jump of second derivatives.
Surface arches(Real height) {
  const Curve profile{{.degree = 2, .values = {0, 0, 0, 1, 1, 2, 2, 2}},
                      {{Vec3(0, 0, 0), 1},
                       {Vec3(1, 0, 1), 1},
                       {Vec3(2, 0, 0), 1},
                       {Vec3(3, 0, height), 1},
                       {Vec3(4, 0, 0), 1}}};
  return extruded(profile, {0, 1, 0});
}

}  // namespace

TEST_CASE("bad input is told with surface, direction, knot and what was expected") {
  Random dice(1);
  const Surface good = random_surface(2, 3, 5, 6, dice);
  CHECK(errors_of(good, "roof").empty());
  Surface s = good;
  s.u.values[3] = 2;
  CHECK(first_error(s).starts_with("roof, u: knot 4 is "));
  CHECK(first_error(s).ends_with(" after 2, expected knots that do not decrease"));
  s = good, s.v.values.pop_back();
  CHECK(first_error(s) == "roof, u: found 8 knots for 6 control points of degree 2, expected 9");
  s = good, s.v.values.insert(s.v.values.begin(), 0);
  CHECK_FALSE(errors_of(s, "roof").empty());
  s = good, s.u.degree = 0;
  CHECK(first_error(s) == "roof, u: found degree 0, expected 1 to 25");
  s = good, s.points[7].w = 0;
  CHECK(first_error(s) == "roof: control point 7 has weight 0, expected one above 0");
  s = good, s.points[7].w = -2;
  CHECK(first_error(s) == "roof: control point 7 has weight -2, expected one above 0");
  s = good, s.points[7].w = 1e-20, s.points[2].w = 1e3;
  CHECK(first_error(s) ==
        "roof: control point 7 has weight 1e-20, expected at least 1e-09: the largest is 1000");
  s = good, s.points[3].x = std::numeric_limits<Real>::quiet_NaN();
  CHECK(first_error(s) == "roof: control point 3 has a number that is not finite");
  s = good, s.v.values[4] = std::numeric_limits<Real>::infinity();
  CHECK(first_error(s) == "roof, v: knot 4 is not a finite number");
  s = good, s.u.values.assign(8, 1);
  CHECK(first_error(s) ==
        "roof, u: found a domain from 1 to 1, expected a range of more than 1e-12");
  s = good, s.v.is_periodic = true;
  CHECK(first_error(s).starts_with("roof: is periodic along v, but its ends are "));
  Curve c = random_curve(3, 6, dice);
  c.points.pop_back();
  CHECK(errors_of(c, "rail")[0].message ==
        "rail: found 10 knots for 5 control points of degree 3, expected 9");
  c = random_curve(1, 4, dice), c.knots.values = {0, 0, 0.5, 0.5, 1, 1};
  CHECK(errors_of(c, "rail")[0].message == "rail: knot 0.5 has multiplicity 2, expected at most 1");
  c = circle({}, 1), c.points.back() = {Vec3(1, 0.5, 0), 1};
  CHECK(errors_of(c, "ring")[0].message == "ring: is periodic, but its ends are 0.5 m apart");
}

TEST_CASE(
    "knots that no span fits between are refused, and pieces of those that are not can be cut") {
  const auto bent_at = [](Real first, Real second) {
    Curve c{{.degree = 1, .values = {0, 0, first, second, 1, 1}}, {}};
    for (int i = 0; i < 4; ++i) c.points.push_back({Vec3(i, i * i, 0), 1});
    return c;
  };
  for (const Real gap : {6e-17, 1e-16, 1e-14, 9e-13}) {
    INFO("gap " << gap);
    const auto errors = errors_of(bent_at(0.25, 0.25 + gap), "rail");
    REQUIRE(errors.size() == 1);
    CHECK(errors[0].message.starts_with("rail: knots 2 and 3 are "));
    CHECK(errors[0].message.ends_with(" apart, expected equal ones, or at least 1e-12"));
  }
  CHECK(errors_of(bent_at(0.25, 0.25 + 1e-11), "rail").empty());
  Curve c = bent_at(0.25, 0.5);
  for (Real& t : c.knots.values) t *= 5e-324;
  CHECK(errors_of(c, "rail")[0].message ==
        "rail: found a domain from 0 to 4.94065646e-324, expected a range of more than 1e-12");
  c = bent_at(0.25, 0.5);
  for (Real& t : c.knots.values) t = 1e9 + 2e-6 * t;
  CHECK(errors_of(c, "rail")[0].message.find(" apart, expected ") != std::string::npos);
}

TEST_CASE("every mistake is told, not only the first") {
  Random dice(2);
  Surface s = random_surface(2, 2, 5, 5, dice);
  s.points[1].w = -1, s.points[2].w = 0, s.u.values[3] = 9;
  CHECK(errors_of(s, "roof").size() == 3);
}

TEST_CASE("creases, jumps and singular places are found, and only they") {
  for (const Surface& s : {torus({}, 2, 0.6), cylinder({}, 1, 2), plane({}, 1, 1)})
    for (const Flaw& f : flaws_of(s, "s")) CHECK(f.kind == FlawKind::jump_of_bend);
  const auto crease = flaws_of(arches(1), "roof");
  REQUIRE(crease.size() == 1);
  CHECK(crease[0].kind == FlawKind::crease);
  CHECK(crease[0].knot == 1);
  CHECK(crease[0].size == Approx(2 * std::atan(1.0)).epsilon(1e-12));  // slopes -1 and 1
  CHECK(crease[0].text.starts_with("roof, u, knot 1: the tangent plane jumps by 1.57"));
  // The next arch hangs: no jump of the slope, one of the bend.
  CHECK(kinds_of(flaws_of(arches(-1), "roof")) == std::vector{FlawKind::jump_of_bend});
  // A quarter of the speed from there on.
  Surface slow = arches(-1);
  for (int i = 0; i < 2; ++i)
    for (const std::size_t k : {6u + i, 8u + i}) {
      const Weighted joint = slow.points[4 + static_cast<std::size_t>(i)];
      slow.points[k] = joint + 0.25 * (slow.points[k] - joint);
    }
  const auto jump = flaws_of(slow, "roof");
  REQUIRE(jump.size() == 1);
  CHECK(jump[0].kind == FlawKind::jump_of_speed);
}

TEST_CASE("poles and points without a normal are found") {
  const auto poles = flaws_of(sphere({}, 1), "ball");
  int edges = 0;
  for (const Flaw& f : poles) edges += f.kind == FlawKind::degenerate_edge ? 1 : 0;
  CHECK(edges == 2);
  bool has_text = false;
  for (const Flaw& f : poles) has_text |= f.text == "ball: edge v = 1 is one point";
  CHECK(has_text);
  const auto tip = flaws_of(cone({}, {1, 0}, 2), "hat");
  CHECK(std::any_of(tip.begin(), tip.end(), [](const Flaw& f) {
    return f.kind == FlawKind::degenerate_edge && f.knot == 1;
  }));
  // A sheet folded to a cusp in the middle: u x v vanishes along u = 0.5, where x(u) = 4 (u -
  // 0.5)^3 and z(u) = (u - 0.5)^2.
  const Curve cusp{{.degree = 3, .values = {0, 0, 0, 0, 1, 1, 1, 1}},
                   {{Vec3(-0.5, 0, 0.25), 1},
                    {Vec3(0.5, 0, -1 / 12.0), 1},
                    {Vec3(-0.5, 0, -1 / 12.0), 1},
                    {Vec3(0.5, 0, 0.25), 1}}};
  const auto found = flaws_of(extruded(cusp, {0, 1, 0}), "sheet");
  REQUIRE_FALSE(found.empty());
  CHECK(found[0].kind == FlawKind::singular_point);
  CHECK(found[0].at[0] == Approx(0.5).margin(1e-4));
  CHECK(found[0].text.starts_with("sheet, u = 0.5"));
}

TEST_CASE("kinks of curves are found") {
  const Curve bent{{.degree = 1, .values = {0, 0, 1, 2, 2}},
                   {{Vec3(0), 1}, {Vec3(1, 0, 0), 1}, {Vec3(1, 1, 0), 1}}};
  const auto flaws = flaws_of(bent, "rail");
  REQUIRE(flaws.size() == 1);
  CHECK(flaws[0].kind == FlawKind::crease);
  CHECK(flaws[0].size == Approx(kPi / 2));
  CHECK(flaws[0].text.starts_with("rail, knot 1: the tangent plane jumps by 1.57"));
  for (const Flaw& f : flaws_of(circle({}, 1), "ring")) CHECK(f.kind == FlawKind::jump_of_bend);
}
