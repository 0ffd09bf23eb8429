// Contact modes against routes that share no formula with them: elimination with pivots, plane
// geometry, linear programmes. "[.soak]" tries 100,000 grasps.
#include <catch2/catch.hpp>
#include <set>

#include "engine/modes/corollary.hpp"
#include "engine/modes/feasible.hpp"
#include "tests/modes/grasps.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

using Rows = std::array<std::array<Real, 4>, 3>;

struct Solution {
  bool unique = false;
  std::array<Real, 3> x{};
  Real determinant = 0;
};

/// Elimination with partial pivots of [A | b].
Solution eliminate(Rows m) {
  Solution s;
  s.determinant = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < 3; ++i)
      if (std::abs(m[i][k]) > std::abs(m[pivot][k])) pivot = i;
    if (m[pivot][k] == 0) return {};
    if (pivot != k) std::swap(m[pivot], m[k]), s.determinant = -s.determinant;
    s.determinant *= m[k][k];
    for (std::size_t i = k + 1; i < 3; ++i) {
      const Real f = m[i][k] / m[k][k];
      for (std::size_t j = k; j < 4; ++j) m[i][j] -= f * m[k][j];
    }
  }
  for (std::size_t k = 3; k-- > 0;) {
    Real sum = m[k][3];
    for (std::size_t j = k + 1; j < 3; ++j) sum -= m[k][j] * s.x[j];
    s.x[k] = sum / m[k][k];
  }
  s.unique = true;
  return s;
}

std::array<Real, 3> wrench(Vec2 point, Vec2 force) {
  return {force.x, force.y, cross(point, force)};
}

Vec2 along(const Contact& c, Real tangent) {
  const Vec2 t = tangent_of(c.normal);
  return {c.normal.x + tangent * t.x, c.normal.y + tangent * t.y};
}

struct Brute {
  bool feasible = false;
  int index = 0;
};

struct Rates {
  Real normal, tangent;
};
Rates rates(const Contact& c, const std::array<Real, 3>& q) {
  const Vec2 v{q[0] - q[2] * c.point.y - c.velocity.x, q[1] + q[2] * c.point.x - c.velocity.y};
  return {dot(c.normal, v), dot(tangent_of(c.normal), v)};
}

/// The mode by its definition, about the world origin.
Brute brute(const Grasp& g, const Candidate& c, const Friction& mu) {
  const bool slides = c.kind == Kind::three_slide;
  const auto& all = g.contacts;
  const auto& at = c.contacts;
  Rows kinematics;
  const auto set = [&](std::size_t row, std::size_t contact, Vec2 direction) {
    const auto w = wrench(all[contact].point, direction);
    kinematics[row] = {w[0], w[1], w[2], dot(direction, all[contact].velocity)};
  };
  set(0, at[0], all[at[0]].normal);
  set(1, at[1], all[at[1]].normal);
  if (slides)
    set(2, at[2], all[at[2]].normal);
  else
    set(2, at[0], tangent_of(all[at[0]].normal));
  const Solution q = eliminate(kinematics);
  if (!q.unique) return {};
  std::uint32_t kept = 1u << at[0] | 1u << at[1];
  if (slides) kept |= 1u << at[2];
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!(kept >> i & 1) && rates(all[i], q.x).normal <= 0) return {};
  Rows forces;
  const auto column = [&](std::size_t k, const std::array<Real, 3>& w) {
    for (std::size_t i = 0; i < 3; ++i) forces[i][k] = w[i];
  };
  const auto sliding = [&](std::size_t i) {
    const Real friction = rates(all[i], q.x).tangent > 0 ? -mu.slide[i] : mu.slide[i];
    return wrench(all[i].point, along(all[i], friction));
  };
  column(0, slides ? sliding(at[0]) : wrench(all[at[0]].point, all[at[0]].normal));
  column(1, sliding(at[1]));
  column(2, slides ? sliding(at[2]) : wrench(all[at[0]].point, tangent_of(all[at[0]].normal)));
  for (std::size_t i = 0; i < 3; ++i) forces[i][3] = -g.load[static_cast<int>(i)];
  const Solution f = eliminate(forces);
  if (!f.unique || f.x[0] < 0 || f.x[1] < 0) return {};
  if (slides ? f.x[2] < 0 : std::abs(f.x[2]) > mu.roll[at[0]] * f.x[0]) return {};
  return {true, f.determinant * q.determinant > 0 ? 1 : -1};
}

struct Tally {
  long modes = 0, feasible = 0, singular = 0, disagreements = 0;
  long geometric = 0, concurrent = 0;
};

void compare(const Grasp& g, const Friction& mu, Tally& tally) {
  const Prepared p = prepared(g);
  for (const Candidate& c : p.candidates) {
    if (c.status == Kinematics::singular) {
      ++tally.singular;
      continue;
    }
    const Brute expected = brute(g, c, mu);
    int branch = 0;
    const Region* r = c.region < 0 ? nullptr : &p.regions[static_cast<std::size_t>(c.region)];
    if (r) branch = branch_of(*r, own(*r, mu));
    ++tally.modes, tally.feasible += branch != 0;
    if ((branch != 0) != expected.feasible)
      ++tally.disagreements;
    else if (branch != 0 && index_of(*r, branch) != expected.index)
      ++tally.disagreements;
    if (!r) continue;
    const Geometric seen = by_moments(g.lamina(), *r, own(*r, mu));
    ++tally.geometric;
    if (seen == Geometric::concurrent)
      ++tally.concurrent;
    else if ((seen == Geometric::feasible) != (branch != 0))
      ++tally.disagreements;
  }
}

Tally compare_random(int grasps, std::uint64_t seed) {
  Random random(seed);
  Tally tally;
  for (int i = 0; i < grasps; ++i) {
    const std::size_t n = 2 + static_cast<std::size_t>(i) % 4;
    const Grasp g = random_grasp(random, n);
    for (const Real most : {0.3, 1.0, 5.0}) {
      const auto slide = random_friction(random, n, most);
      auto roll = slide;
      if (i % 2)
        for (Real& m : roll) m *= random.between(1, 2);
      compare(g, {roll, slide}, tally);
    }
  }
  return tally;
}

std::multiset<std::string> names(const Prepared& p, const ModeSet& set) {
  std::multiset<std::string> all;
  for (const FeasibleMode& m : set.modes)
    all.insert(name_of(signs_of(p.regions[static_cast<std::size_t>(m.region)]), p.count));
  return all;
}

}  // namespace

TEST_CASE("regions agree with elimination and with plane geometry on random grasps") {
  const Tally t = compare_random(10000, 1);
  CHECK(t.disagreements == 0);
  CHECK(t.feasible > 5000);
  CHECK(t.geometric > 50000);
  CHECK(t.concurrent < t.geometric / 100);
  CHECK(t.singular < t.modes / 5);
}

TEST_CASE("regions agree with elimination and geometry on 100,000 random grasps", "[.soak]") {
  const Tally t = compare_random(100000, 2);
  WARN(t.modes << " modes, " << t.feasible << " feasible, " << t.singular << " singular, "
               << t.geometric << " by geometry, " << t.concurrent << " concurrent, "
               << t.disagreements << " disagreements");
  CHECK(t.disagreements == 0);
}

TEST_CASE("linear programmes find the same modes and no others in general position") {
  Random random(3);
  int modes = 0, resolved = 0;
  for (int i = 0; i < 600; ++i) {
    const std::size_t n = 2 + static_cast<std::size_t>(i) % 3;
    const Prepared p = prepared(random_grasp(random, n));
    const auto mu = random_friction(random, n, 1);
    ModeSet set;
    find_modes(p, Friction::same(mu), set);
    SignedModes search;
    find_signed_modes(p, Friction::same(mu), search);
    REQUIRE(search.complete);
    std::multiset<std::string> found;
    for (const SignedMode& m : search.list) {
      found.insert(name_of(m.signs, n));
      CHECK(m.motion_unique);
      CHECK(m.forces_unique);
    }
    CHECK(found == names(p, set));
    CHECK(set.indeterminate.empty());
    modes += static_cast<int>(found.size()), ++resolved;
  }
  CHECK(resolved == 600);
  CHECK(modes > 150);
}

TEST_CASE("linear programmes give the motion and the forces of a mode that has no other") {
  Random random(4);
  int compared = 0;
  for (int i = 0; i < 300; ++i) {
    const Grasp g = random_grasp(random, 3);
    const Prepared p = prepared(g);
    const auto mu = random_friction(random, 3, 1);
    ModeSet set;
    find_modes(p, Friction::same(mu), set);
    SignedModes search;
    find_signed_modes(p, Friction::same(mu), search);
    for (const FeasibleMode& m : set.modes)
      for (const SignedMode& s : search.list) {
        const Region& r = p.regions[static_cast<std::size_t>(m.region)];
        if (m.margin < 1e-6 || !(signs_of(r) == s.signs)) continue;
        const Real size = 1 + std::abs(r.twist.x) + std::abs(r.twist.y) + std::abs(r.twist.z);
        for (int k = 0; k < 3; ++k) CHECK(std::abs(r.twist[k] - s.twist[k]) < 1e-8 * size);
        const Real force = s.normal_force[r.contacts[0]];
        CHECK(std::abs(force - m.force[0]) < 1e-8 * (1 + m.amplification));
        ++compared;
      }
  }
  CHECK(compared > 50);
}
