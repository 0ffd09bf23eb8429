// Contact modes under friction that is known by its distribution or its bounds only.
#include "engine/modes/uncertain.hpp"

#include <catch2/catch.hpp>

#include "engine/modes/feasible.hpp"
#include "tests/modes/grasps.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

void each_region(int grasps, std::uint64_t seed, auto&& look) {
  Random random(seed);
  for (int i = 0; i < grasps; ++i) {
    const std::size_t n = 2 + static_cast<std::size_t>(i) % 3;
    const Prepared p = prepared(random_grasp(random, n));
    for (const Region& r : p.regions) look(p, r, random);
  }
}

/// The part of a fine grid of quantiles at which the mode is feasible.
Real by_grid(const Region& r, std::span<const Spread> spreads, int size) {
  long inside = 0, all = 0;
  const auto at = [&](std::size_t k, int i) {
    return quantile(spreads[r.contacts[k]], (i + 0.5) / size);
  };
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < size; ++j, ++all) inside += contains(r, {at(0, i), at(1, j), 0});
  return static_cast<Real>(inside) / static_cast<Real>(all);
}

}  // namespace

TEST_CASE("the probability of a roll and a slide of uniform friction is exact") {
  int partly = 0;
  each_region(250, 1, [&](const Prepared& p, const Region& r, Random& random) {
    if (r.kind != Kind::roll_slide) return;
    std::vector<Spread> spreads(p.count);
    for (Spread& s : spreads) {
      const Real low = random.between(0, 0.5);
      s = Spread::between(low, low + random.between(0.1, 1));
    }
    const Probability exact = probability(r, spreads, {});
    CHECK(exact.samples == 0);
    CHECK(exact.error == 0);
    CHECK(std::abs(exact.value - by_grid(r, spreads, 400)) < 5e-3);
    partly += exact.value > 0.01 && exact.value < 0.99;
  });
  CHECK(partly > 40);
}

TEST_CASE("with one uncertain coefficient the probability is that of its intervals") {
  int partly = 0;
  each_region(600, 2, [&](const Prepared& p, const Region& r, Random& random) {
    std::vector<Spread> spreads;
    for (std::size_t i = 0; i < p.count; ++i) spreads.push_back(Spread::at(random.between(0, 1)));
    const std::size_t k = random.below(static_cast<std::size_t>(r.variables()));
    spreads[r.contacts[k]] = Spread::around(0.4, 0.2, 0.05, 1);
    const Probability exact = probability(r, spreads, {});
    CHECK(exact.error == 0);
    int inside = 0;
    constexpr int kCount = 500;
    for (int i = 0; i < kCount; ++i) {
      OwnFriction mu{};
      for (std::size_t v = 0; v < static_cast<std::size_t>(r.variables()); ++v)
        mu[v] = quantile(spreads[r.contacts[v]], (i + 0.5) / kCount);
      inside += contains(r, mu);
    }
    CHECK(std::abs(exact.value - Real(inside) / kCount) < 6.0 / kCount);
    partly += exact.value > 0.01 && exact.value < 0.99;
  });
  CHECK(partly > 50);
}

TEST_CASE("sampled probabilities keep their error bars, and their seed gives them again") {
  int within = 0, all = 0;
  each_region(300, 3, [&](const Prepared& p, const Region& r, Random&) {
    if (r.kind != Kind::roll_slide) return;
    // A normal distribution as wide as this is uniform, and is sampled.
    std::vector<Spread> wide(p.count, Spread::around(0.5, 1e6, 0.1, 0.9));
    const std::vector<Spread> uniform(p.count, Spread::between(0.1, 0.9));
    const Sampling sampling{400, 7};
    const Probability sampled = probability(r, wide, sampling);
    CHECK(sampled.samples == 400);
    CHECK(sampled.error > 0);
    CHECK(sampled.value == probability(r, wide, sampling).value);
    const Real exact = probability(r, uniform, {}).value;
    within += std::abs(sampled.value - exact) <= sampled.error, ++all;
  });
  CHECK(all > 150);
  CHECK(within >= 0.92 * all);
}

TEST_CASE("probabilities of three sliding contacts are the shares of joint samples") {
  int compared = 0;
  each_region(200, 4, [&](const Prepared& p, const Region& r, Random& random) {
    if (r.kind != Kind::three_slide) return;
    const std::vector<Spread> spreads(p.count, Spread::between(0, 1));
    const Probability found = probability(r, spreads, {4000, 1});
    int inside = 0;
    constexpr int kCount = 4000;
    for (int i = 0; i < kCount; ++i) {
      OwnFriction mu;
      for (Real& m : mu) m = random.between(0, 1);
      inside += contains(r, mu);
    }
    CHECK(std::abs(found.value - Real(inside) / kCount) < found.error + 0.03);
    ++compared;
  });
  CHECK(compared > 40);
}

TEST_CASE("the outlook counts what holds together") {
  Random random(5);
  for (int i = 0; i < 40; ++i) {
    const Prepared p = prepared(random_grasp(random, 3));
    const std::vector<Spread> spreads(3, Spread::between(0, 1));
    const Outlook all = outlook(p, spreads, {2000, 1});
    CHECK(all.modes.size() == p.regions.size());
    CHECK(std::abs(all.none.value + all.unique.value + all.ambiguous.value - 1) < 1e-12);
    Real expected = 0;  // modes at once, on average
    for (const Probability& m : all.modes) expected += m.value;
    CHECK(expected >= all.unique.value + 2 * all.ambiguous.value - 0.05);
    if (p.regions.empty()) CHECK(all.none.value == 1);
  }
}

TEST_CASE("cumulative distributions and quantiles are inverse") {
  for (const Spread& s : {Spread::between(0.2, 0.7), Spread::around(0.4, 0.1, 0.1, 0.9),
                          Spread::around(0.1, 0.05, 0.5, 0.9)}) {
    CHECK(cumulative(s, s.low) == 0);
    CHECK(cumulative(s, s.high) == 1);
    CHECK(cumulative(s, s.low - 0.1) == 0);
    for (const Real part : {0.001, 0.2, 0.5, 0.9, 0.999})
      CHECK(cumulative(s, quantile(s, part)) == Approx(part).epsilon(1e-6));
  }
  // 68.27 % within one deviation.
  const Spread s = Spread::around(0.5, 0.05, 0, 1);
  CHECK(cumulative(s, 0.55) - cumulative(s, 0.45) == Approx(0.6826894921).epsilon(1e-9));
}

TEST_CASE("over a box a mode is always, sometimes or never there, with a witness") {
  std::array<int, 4> seen{};
  each_region(400, 6, [&](const Prepared&, const Region& r, Random& random) {
    OwnFriction low{}, high{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(r.variables()); ++k)
      low[k] = random.between(0, 0.8), high[k] = low[k] + random.between(0, 0.3);
    const WorstCase w = worst_case(r, low, high);
    ++seen[static_cast<std::size_t>(w.occurrence)];
    const bool has = w.occurrence == Occurrence::always || w.occurrence == Occurrence::sometimes;
    if (has) CHECK(contains(r, w.with));
    if (w.occurrence == Occurrence::sometimes) {
      const Real near_zero = std::abs(values(r, w.without).divisor);
      CHECK((!contains(r, w.without) || near_zero <= 1e-12 * magnitudes(r, w.without).divisor));
    }
    for (int i = 0; i < 100; ++i) {
      OwnFriction mu{};
      for (std::size_t k = 0; k < 3; ++k) mu[k] = random.between(low[k], high[k]);
      const bool inside = contains(r, mu);
      if (w.occurrence == Occurrence::always) {
        if (!inside) FAIL("always, but not here");
        const auto f = forces(r, mu);
        if (std::max(f[0], f[2]) > w.largest_force * (1 + 1e-12)) FAIL("a larger force");
      }
      if (w.occurrence == Occurrence::never && inside) FAIL("never, but here");
    }
  });
  CHECK(seen[0] > 20);
  CHECK(seen[1] > 20);
  CHECK(seen[2] > 100);
}

TEST_CASE("spreads that say nothing are refused") {
  const auto refused = [](const Spread& s) { return !check(std::vector<Spread>{s}, 1); };
  CHECK(check(std::vector<Spread>{Spread::between(0.1, 0.4)}, 1));
  CHECK(check(std::vector<Spread>{Spread::at(0)}, 1));
  CHECK(refused(Spread::between(-0.1, 0.4)));
  CHECK(refused(Spread::between(0.5, 0.4)));
  CHECK(refused(Spread::between(0.5, std::numeric_limits<Real>::infinity())));
  CHECK(refused(Spread::at(std::nan(""))));
  CHECK(refused(Spread::around(0.4, 0, 0, 1)));
  CHECK(refused(Spread::around(0.4, 0.01, 5, 6)));
  CHECK_FALSE(check(std::vector<Spread>{}, 1));
}
