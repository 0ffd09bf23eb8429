// Where modes are not in general position, and what is refused. A rod on two fingers that close.
#include <catch2/catch.hpp>

#include "engine/modes/feasible.hpp"
#include "tests/modes/grasps.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Level fingers below a rod of weight 10 N whose mass centre is at x.
Grasp rod(Real x, Vec2 at, Vec2 speeds) {
  return {{{{at.x, 0}, {0, 1}, {speeds.x, 0}}, {{at.y, 0}, {0, 1}, {speeds.y, 0}}},
          {0, -10, -10 * x}};
}

struct Rod {
  Real x = 0, time = 0;
  Vec2 at{-1, 0.7};

  Rod after(Real h, Real speed, Vec2 fingers) const {
    return {x + h * speed, time + h, {at.x + h * fingers.x, at.y + h * fingers.y}};
  }
};

constexpr Vec2 kSpeeds{0.05, -0.03};
const std::vector<Real> kRoll{0.45, 0.4}, kSlide{0.3, 0.28};

/// The feasible mode that rolls on finger `roll`, or none.
const Region* rolling(const Prepared& p, std::size_t roll) {
  for (const Region& r : p.regions)
    if (r.contacts[0] == roll && contains(r, own(r, {kRoll, kSlide}))) return &r;
  return nullptr;
}
bool holds(const Rod& s, std::size_t roll) {
  return rolling(prepared(rod(s.x, s.at, kSpeeds)), roll) != nullptr;
}

/// Steps while the rod rolls on one finger; ends where it no longer does, by bisection or after a
/// whole step.
enum class Ending { bisection, whole_step };
Rod run_to_switch(Rod s, std::size_t roll, Real h, Ending ending) {
  for (;;) {
    const Prepared p = prepared(rod(s.x, s.at, kSpeeds));
    const Region* r = rolling(p, roll);
    if (!r) return s;
    const Real speed = r->twist.x;
    const Rod next = s.after(h, speed, kSpeeds);
    if (ending == Ending::whole_step || holds(next, roll)) {
      s = next;
      continue;
    }
    Real low = 0, high = h;
    for (int i = 0; i < 60; ++i) {
      const Real middle = (low + high) / 2;
      (holds(s.after(middle, speed, kSpeeds), roll) ? low : high) = middle;
    }
    return s.after(high, speed, kSpeeds);
  }
}

/// The largest error of the distances at the switches.
Real worst_switch(Real h, Ending ending, std::size_t most) {
  const auto expected = quasistatic_vectors()["rod"]["switches"];
  Rod s;
  std::size_t roll = 1;  // R2S1
  Real worst = 0;
  for (std::size_t i = 0; i < std::min(most, expected.size()); ++i) {
    s = run_to_switch(s, roll, h, ending);
    worst = std::max({worst, std::abs(s.x - s.at.x - expected[i]["l1"].get<Real>()),
                      std::abs(s.at.y - s.x - expected[i]["l2"].get<Real>())});
    roll = 1 - roll;
  }
  return worst;
}

ModeSet modes_of(const Grasp& g, const std::vector<Real>& mu) {
  const Prepared p = prepared(g);
  ModeSet set;
  find_modes(p, Friction::same(mu), set);
  return set;
}

std::string first_error(const Result<Done>& result) {
  return result ? "" : result.errors().front().message;
}

}  // namespace

TEST_CASE("a rod on closing fingers switches where the closed form says, to 1e-9 by bisection") {
  CHECK(worst_switch(0.05, Ending::bisection, 10) < 1e-9);
}

TEST_CASE("without bisection its switches are of first order in the step") {
  const Real coarse = worst_switch(0.02, Ending::whole_step, 4);
  const Real fine = worst_switch(0.002, Ending::whole_step, 4);
  CHECK(coarse > 1e-5);
  CHECK(fine < coarse / 4);
}

TEST_CASE("the rod is carried by either finger in a band that vanishes where friction is one") {
  const Prepared p = prepared(rod(0, {-1, 0.7}, kSpeeds));
  ModeSet set;
  find_modes(p, {kRoll, kSlide}, set);
  CHECK(set.verdict == Verdict::ambiguous);
  for (const FeasibleMode& m : set.modes) CHECK(m.index == 1);
  find_modes(p, {kSlide, kSlide}, set);
  CHECK(set.verdict == Verdict::unique);
}

TEST_CASE("on the line between two modes both are listed as on their boundary") {
  // l1 mu2 = l2 mu1.
  const ModeSet set = modes_of(rod(0, {-1, 0.5}, kSpeeds), {0.6, 0.3});
  REQUIRE(set.modes.size() == 2);
  for (const FeasibleMode& m : set.modes) CHECK(m.boundary);
  CHECK(set.degenerate);
  REQUIRE(set.indeterminate.size() == 1);  // both slide: the speed is not unique
  CHECK_FALSE(set.indeterminate[0].motion_unique);
  const Vec3 free = set.indeterminate[0].free_direction;
  CHECK(std::abs(free.x) > 0);
  CHECK(std::abs(free.y) + std::abs(free.z) < 1e-12 * std::abs(free.x));
}

TEST_CASE("a part that rests on two fingers is stuck to both, its forces not unique") {
  const ModeSet set = modes_of(rod(0.1, {-1, 0.7}, {0, 0}), {0.3, 0.3});
  CHECK(set.verdict == Verdict::unique);
  REQUIRE(set.indeterminate.size() == 1);
  const SignedMode& mode = set.indeterminate[0];
  CHECK(name_of(mode.signs, 2) == "RR");
  CHECK(mode.motion_unique);
  CHECK_FALSE(mode.forces_unique);
  CHECK(glm::dot(mode.twist, mode.twist) < 1e-18);
  CHECK(mode.normal_force[0] + mode.normal_force[1] == Approx(10).epsilon(1e-9));
  CHECK(mode.tangent_force[0] + mode.tangent_force[1] == Approx(0).margin(1e-9));
  CHECK(set.programs > 0);
}

TEST_CASE("without a mode the reason is told: squeezed, or no equilibrium") {
  const Grasp squeeze{{{{-1, 0}, {1, 0}, {0.1, 0}}, {{1, 0}, {-1, 0}, {-0.1, 0}}}, {0, -1, 0}};
  CHECK(modes_of(squeeze, {0.5, 0.5}).verdict == Verdict::squeezed);
  const Grasp tips = rod(2, {-1, 0.7}, kSpeeds);
  CHECK(modes_of(tips, {0.5, 0.5}).verdict == Verdict::no_balance);
}

TEST_CASE("forces without bound are told from forces that are large") {
  // The load pushes across two opposed fingers; where X is 0 no force is enough.
  Random random(1);
  int found = 0;
  for (int i = 0; i < 400 && found < 20; ++i) {
    const Prepared p = prepared(random_grasp(random, 3));
    for (const Region& r : p.regions) {
      if (r.kind != Kind::roll_slide) continue;
      const Real pole = -r.divisor[0] / r.divisor[2];
      if (!(pole > 0.01 && pole < 2)) continue;
      std::vector<Real> mu(3, 0.5);
      mu[r.contacts[1]] = pole;
      ModeSet set;
      find_modes(p, Friction::same(mu), set);
      CHECK(set.near_singular);
      mu[r.contacts[1]] = pole * (1 + 1e-6);
      find_modes(p, Friction::same(mu), set);
      CHECK_FALSE(set.near_singular);
      for (const FeasibleMode& m : set.modes)
        if (&p.regions[static_cast<std::size_t>(m.region)] == &r) CHECK(m.amplification > 1e2);
      ++found;
    }
  }
  CHECK(found >= 20);
}

TEST_CASE("three contacts on one edge are singular, not garbage") {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Real angle = random.between(0, 6);
    const Vec2 along{std::cos(angle), std::sin(angle)};
    Grasp g;
    for (int k = 0; k < 3; ++k) {
      const Real s = k + random.between(0, 0.9);
      const Real u = random.between(-1, 1), v = random.between(-1, 1);
      g.contacts.push_back({{s * along.x, s * along.y}, tangent_of(along), {u, v}});
    }
    g.load = {0, -1, 0};
    CHECK(prepared(g).candidates[0].status == Kinematics::singular);
  }
}

TEST_CASE("laminas and coefficients that mean nothing are refused by name") {
  const Grasp good = rod(0, {-1, 1}, kSpeeds);
  CHECK(check(good.lamina()));
  Grasp bad = good;
  bad.contacts.clear();
  CHECK(first_error(check(bad.lamina())) == "found 0 contacts, expected 1 to 32");
  bad.contacts.assign(33, good.contacts[0]);
  CHECK(first_error(check(bad.lamina())) == "found 33 contacts, expected 1 to 32");
  bad = good, bad.contacts[1].normal = {0, 0};
  CHECK(first_error(check(bad.lamina())) ==
        "contact 2: normal is (0.000000, 0.000000), expected a vector of length 1");
  bad = good, bad.contacts[1].point.x = std::nan("");
  CHECK(first_error(check(bad.lamina())) == "contact 2: point is not finite");
  bad = good, bad.contacts[1] = bad.contacts[0];
  CHECK(first_error(check(bad.lamina())) ==
        "contact 2: repeats contact 1, expected another point or normal");
  bad = good, bad.load = Vec3(0);
  CHECK(first_error(check(bad.lamina())).starts_with("load is 0"));
  const std::vector<Real> fine{0.1, 0}, negative{0.1, -0.2}, none{0.1, std::nan("")};
  CHECK(check(Friction::same(fine), 2));
  CHECK(first_error(check(Friction::same(negative), 2)) ==
        "contact 2: rolling friction is -0.200000, expected 0 or more");
  CHECK(first_error(check({fine, none}, 2)).starts_with("contact 2: sliding friction is nan"));
  CHECK(first_error(check(Friction::same(fine), 3)) ==
        "found 2 coefficients of friction, expected 3");
}
