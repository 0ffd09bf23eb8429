// What regions of friction must obey whatever the grasp.
#include <bit>
#include <catch2/catch.hpp>

#include "engine/modes/feasible.hpp"
#include "engine/modes/path.hpp"
#include "tests/modes/grasps.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

Vec2 turned(Vec2 v, Real angle) {
  const Real c = std::cos(angle), s = std::sin(angle);
  return {c * v.x - s * v.y, s * v.x + c * v.y};
}

/// The grasp turned about the origin and then shifted, with its load.
Grasp moved(const Grasp& g, Real angle, Vec2 by) {
  Grasp out = g;
  for (Contact& c : out.contacts) {
    const Vec2 p = turned(c.point, angle);
    c = {{p.x + by.x, p.y + by.y}, turned(c.normal, angle), turned(c.velocity, angle)};
  }
  const Vec2 f = turned({g.load.x, g.load.y}, angle);
  out.load = {f.x, f.y, g.load.z + cross(by, f)};
  return out;
}

Grasp with_velocities(Grasp g, Real times) {
  for (Contact& c : g.contacts) c.velocity = {times * c.velocity.x, times * c.velocity.y};
  return g;
}

Real largest(const Region& r) {
  Real most = 0;
  for (const Real x : r.divisor) most = std::max(most, std::abs(x));
  for (const auto& f : r.forms)
    for (const Real x : f) most = std::max(most, std::abs(x));
  return most;
}

/// The largest difference of coefficients, relative to the largest of them.
Real difference(const Region& a, const Region& b, Real times = 1) {
  Real most = 0;
  for (std::size_t i = 0; i < 8; ++i)
    most = std::max(most, std::abs(times * a.divisor[i] - b.divisor[i]));
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t i = 0; i < 4; ++i)
      most = std::max(most, std::abs(times * a.forms[k][i] - b.forms[k][i]));
  return most / largest(b);
}

void each_region(int grasps, std::uint64_t seed, auto&& look) {
  Random random(seed);
  for (int i = 0; i < grasps; ++i) {
    const Grasp g = random_grasp(random, 2 + static_cast<std::size_t>(i) % 5);
    const Prepared p = prepared(g);
    for (const Region& r : p.regions) look(g, p, r, random);
  }
}

OwnFriction random_own(Random& random, Real most) {
  OwnFriction m;
  for (Real& x : m) x = random.between(0, most);
  return m;
}

std::size_t place_of(const Prepared& p, const Region& r) {
  return static_cast<std::size_t>(&r - p.regions.data());
}

}  // namespace

TEST_CASE("a box is inside or outside as all of its points are") {
  int inside = 0, outside = 0;
  each_region(3000, 1, [&](const Grasp&, const Prepared&, const Region& r, Random& random) {
    const OwnFriction low = random_own(random, 1);
    OwnFriction high = low;
    for (Real& x : high) x += random.between(0, 0.4);
    const BoxVerdict verdict = box(r, low, high);
    if (verdict == BoxVerdict::undecided) return;
    (verdict == BoxVerdict::inside ? inside : outside) += 1;
    for (int i = 0; i < 30; ++i) {
      OwnFriction m;
      for (std::size_t k = 0; k < 3; ++k) m[k] = random.between(low[k], high[k]);
      if (contains(r, m) != (verdict == BoxVerdict::inside)) FAIL("a point is not as its box");
    }
  });
  CHECK(inside > 300);
  CHECK(outside > 3000);
}

TEST_CASE("coefficients do not change with the frame and scale with length once") {
  Real frame = 0, length = 0;
  int seen = 0;
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    const Grasp g = random_grasp(random, 3);
    const Real angle = random.between(-3, 3);
    const Vec2 by{random.between(-2, 2), random.between(-2, 2)};
    Grasp larger = g;
    for (Contact& c : larger.contacts) c.point = {7 * c.point.x, 7 * c.point.y};
    larger.load.z *= 7;
    const Prepared p = prepared(g), q = prepared(moved(g, angle, by)), l = prepared(larger);
    REQUIRE(p.regions.size() == q.regions.size());
    REQUIRE(p.regions.size() == l.regions.size());
    for (std::size_t k = 0; k < p.regions.size(); ++k, ++seen) {
      frame = std::max(frame, difference(p.regions[k], q.regions[k]));
      length = std::max(length, difference(p.regions[k], l.regions[k], 7));
    }
  }
  CHECK(seen > 500);
  CHECK(frame < 2e-14);
  CHECK(length < 2e-14);
}

TEST_CASE("twice the fingers' speed is twice the motion and the same regions") {
  each_region(300, 3, [](const Grasp& g, const Prepared& p, const Region& r, Random&) {
    const Prepared q = prepared(with_velocities(g, 2));
    const Region& faster = q.regions[place_of(p, r)];
    CHECK(difference(r, faster) == 0);
    CHECK(faster.twist == 2.0 * r.twist);
  });
}

TEST_CASE("fingers that run backwards change the sign of each term by its sliding columns") {
  int compared = 0;
  each_region(300, 4, [&](const Grasp& g, const Prepared&, const Region& r, Random&) {
    if (r.kind != Kind::three_slide || g.contacts.size() != 3) return;
    const Prepared back = prepared(with_velocities(g, -1));
    const Region& b = back.regions.front();
    REQUIRE(b.kind == Kind::three_slide);
    for (unsigned mask = 0; mask < 8; ++mask)
      CHECK(b.divisor[mask] == (std::popcount(mask) % 2 ? -1 : 1) * r.divisor[mask]);
    for (std::size_t k = 0; k < 3; ++k)
      for (unsigned mask = 0; mask < 4; ++mask)
        CHECK(b.forms[k][mask] == (std::popcount(mask) % 2 ? -1 : 1) * r.forms[k][mask]);
    ++compared;
  });
  CHECK(compared > 30);
}

TEST_CASE("forces balance the load, and the fingers' power is what friction takes") {
  int seen = 0;
  each_region(3000, 5, [&](const Grasp& g, const Prepared&, const Region& r, Random& random) {
    const OwnFriction mu = random_own(random, 1);
    if (!contains(r, mu)) return;
    const auto f = forces(r, mu);
    const bool slides = r.kind == Kind::three_slide;
    Vec3 sum = g.load;
    Real power = glm::dot(g.load, r.twist), lost = 0, size = 1;
    for (std::size_t k = 0; k < (slides ? 3u : 2u); ++k) {
      const Contact& c = g.contacts[r.contacts[k]];
      const bool rolls = !slides && k == 0;
      const Real normal = slides || rolls ? f[k] : f[2];
      const Real tangent = rolls ? f[1] : -r.slip_sign[k] * mu[k] * normal;
      const Vec2 t = tangent_of(c.normal);
      const Vec2 force{normal * c.normal.x + tangent * t.x, normal * c.normal.y + tangent * t.y};
      sum += Vec3(force.x, force.y, cross(c.point, force));
      power += dot(force, c.velocity);
      if (!rolls) lost += mu[k] * normal * std::abs(r.slip[k]);
      size += normal * (1 + std::abs(r.slip[k]) + std::hypot(c.velocity.x, c.velocity.y));
      CHECK(normal >= 0);
    }
    CHECK(std::abs(sum.x) + std::abs(sum.y) + std::abs(sum.z) < 1e-12 * size);
    CHECK(std::abs(power - lost) < 1e-11 * size);
    ++seen;
  });
  CHECK(seen > 800);
}

TEST_CASE("without friction one mode of three sliding contacts holds if any motion and forces do") {
  Random random(6);
  const std::vector<Real> none(6, 0);
  int unique = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::size_t n = 3 + static_cast<std::size_t>(i) % 3;
    const Prepared p = prepared(random_grasp(random, n));
    const Friction mu = Friction::same(std::span(none).first(n));
    int modes = 0;
    for (const Region& r : p.regions) {
      if (r.kind != Kind::three_slide || !contains(r, {})) continue;
      ++modes;
      CHECK(index_of(r, branch_of(r, {})) == 1);
    }
    CHECK(modes == (motion_exists(p) && balance_exists(p, mu) ? 1 : 0));
    unique += modes;
  }
  CHECK(unique > 100);
}

TEST_CASE("modes that the motion allows are few: vertices and edges of a polyhedron") {
  Random random(7);
  int most = 0;
  for (int i = 0; i < 600; ++i) {
    const std::size_t n = 3 + static_cast<std::size_t>(i) % 8;
    const Prepared p = prepared(random_grasp(random, n));
    int slides = 0, rolls = 0;
    for (const Region& r : p.regions) (r.kind == Kind::three_slide ? slides : rolls) += 1;
    const int bound = 2 * static_cast<int>(n) - 4;
    CHECK(slides <= bound);
    CHECK(rolls <= 3 * bound);
    most = std::max(most, slides + rolls);
  }
  CHECK(most >= 10);
}

TEST_CASE("intervals of a common coefficient hold where the mode does") {
  int several = 0, seen = 0;
  each_region(3000, 8, [&](const Grasp&, const Prepared&, const Region& r, Random& random) {
    const Intervals all = equal_friction(r);
    seen += all.count > 0, several += all.count > 1;
    for (int i = 0; i < 20; ++i) {
      const Real m = i < 15 ? random.between(0, 2) : random.between(0, 40);
      int branch = 0;
      bool edge = false;
      for (const Interval& part : all) {
        if (m >= part.low && m <= part.high) branch = part.branch;
        edge |= std::abs(m - part.low) < 1e-9 || std::abs(m - part.high) < 1e-9;
      }
      if (!edge && branch_of(r, {m, m, m}) != branch) FAIL("at " << m);
    }
  });
  CHECK(seen > 2000);
  CHECK(several > 30);
}

TEST_CASE("the cube bound holds within and fails just outside") {
  int bounded = 0;
  each_region(4000, 9, [&](const Grasp&, const Prepared&, const Region& r, Random&) {
    const Real bound = cube_bound(r);
    if (!(bound > 0) || std::isinf(bound)) return;
    ++bounded;
    const Real in = 0.9999 * bound, out = 1.0001 * bound;
    CHECK(box(r, {}, {in, in, in}) == BoxVerdict::inside);
    CHECK(box(r, {}, {out, out, out}) != BoxVerdict::inside);
  });
  CHECK(bounded > 200);
}

TEST_CASE("along a path the bounds are those of its tightest pose") {
  Random random(10);
  int held = 0;
  while (held < 20) {
    Grasp g = random_grasp(random, 3);
    PathBound bound;
    std::vector<Prepared> poses;
    for (int k = 0; k <= 20; ++k) {
      poses.push_back(prepared(moved(g, 0, {})));
      bound.add(poses.back());
      for (Contact& c : g.contacts) c.point.x += 0.002 * c.velocity.x;
    }
    if (bound.without_plan > 0 || std::isinf(bound.each)) continue;
    ++held;
    CHECK(bound.each <= bound.common);
    Real each = 10, common = 10;
    int fail = 0;
    for (const Prepared& p : poses)
      for (const Region& r : p.regions) {
        if (r.kind != Kind::three_slide) continue;
        const Real in = 0.999 * bound.each, out = 1.001 * bound.each, m = 0.999 * bound.common;
        CHECK(box(r, {}, {in, in, in}) == BoxVerdict::inside);
        fail += box(r, {}, {out, out, out}) != BoxVerdict::inside;
        CHECK((std::isinf(m) || contains(r, {m, m, m})));
        each = std::min(each, cube_bound(r)), common = std::min(common, m);
      }
    CHECK(fail > 0);
    CHECK(bound.poses == 21);
    CHECK(bound.changes == 0);
  }
}
