// Maps over two coefficients of friction. "[.bench]" times them, and the preparation of a grasp.
#include "engine/modes/map.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <set>
#include <sstream>

#include "engine/modes/feasible.hpp"
#include "tests/modes/grasps.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

Grasp figure_grasp(const std::string& name) {
  const auto all = quasistatic_vectors();
  for (const auto& g : all["figure_grasps"])
    if (g["name"] == name) return read_grasp(g);
  FAIL("no grasp " << name);
  return {};
}

/// Whether X or a form is a rounding error there.
bool on_boundary(const Cut& c, Real x, Real y) {
  const auto zero = [&](const Bilinear& f) {
    const Real size = std::abs(f.a * x * y) + std::abs(f.b * x) + std::abs(f.c * y) + std::abs(f.d);
    return std::abs(f.at(x, y)) <= 1e-12 * size;
  };
  bool any = zero(c.divisor);
  for (int i = 0; i < c.form_count; ++i) any |= zero(c.forms[static_cast<std::size_t>(i)]);
  return any;
}

struct Difference {
  long pixels = 0, boundary = 0, elsewhere = 0;
};

void compare(const Prepared& p, const Slice& slice, Difference& sum) {
  ModeMap spans, pixels;
  draw_by_spans(p, slice, spans);
  draw_by_pixels(p, slice, pixels);
  REQUIRE(spans.complete);
  REQUIRE(spans.regions == pixels.regions);
  for (std::size_t j = 0; j < slice.size; ++j)
    for (std::size_t i = 0; i < slice.size; ++i) {
      ++sum.pixels;
      const std::uint32_t differ = spans.cell(i, j) ^ pixels.cell(i, j);
      if (differ == 0) continue;
      bool edge = true;
      for (std::size_t k = 0; k < spans.regions.size(); ++k)
        if (differ >> k & 1) {
          const Region& r = p.regions[static_cast<std::size_t>(spans.regions[k])];
          edge &= on_boundary(cut(r, slice), slice.at(i), slice.at(j));
        }
      (edge ? sum.boundary : sum.elsewhere) += 1;
    }
}

/// Microseconds of one call: the least mean of many short rounds, which a busy machine leaves alone
/// now and then.
template <class Work>
double microseconds(int calls, Work work) {
  double least = 1e300;
  for (int round = 0; round < 400; ++round) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < calls; ++i) work(i);
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - start;
    least = std::min(least, took.count() / calls);
  }
  return least;
}

}  // namespace

TEST_CASE("maps by spans are maps by pixels, but for pixels on a boundary") {
  Random random(1);
  Difference sum;
  for (int i = 0; i < 200; ++i) {
    const std::size_t n = 2 + static_cast<std::size_t>(i) % 5;
    const Prepared p = prepared(random_grasp(random, n));
    const auto fixed = random_friction(random, n, 1);
    Slice slice;
    slice.size = 101, slice.fixed = Friction::same(fixed);
    slice.up = 1 + random.below(n - 1);
    if (i % 3 == 0) slice.low = 0.2, slice.high = 3.7;
    compare(p, slice, sum);
  }
  CHECK(sum.elsewhere == 0);
  CHECK(sum.boundary < sum.pixels / 1000);
}

TEST_CASE("pixels exactly on a boundary: closed where a force is 0, open where X is") {
  // Forms of whole numbers at whole coefficients, 0 to 4: no rounding anywhere.
  Prepared p;
  p.count = 3;
  const auto add = [&](std::array<Real, 8> x, std::array<std::array<Real, 4>, 3> y) {
    Region r;
    r.contacts = {0, 1, 2}, r.slip_sign = {1, 1, 1}, r.determinant = 1;
    r.divisor = x;
    for (std::size_t k = 0; k < 3; ++k) r.forms[k] = y[k];
    p.regions.push_back(r);
  };
  const std::array<Real, 4> one{1}, minus_one{-1};
  // X = 2 - mu1, forms 1, mu1 - 1, 2 - mu2: the column mu1 = 1, up to mu2 = 2.
  add({2, -1}, {one, {-1, 1}, {2, 0, -1}});
  // X = 2 - mu1, forms -1, 3 - mu1, 1 - mu2: from mu1 = 3 and mu2 = 1 on.
  add({2, -1}, {minus_one, {3, -1}, {1, 0, -1}});
  // X = mu2 - 1, constant along a row, forms 1: beyond mu2 = 1.
  add({-1, 0, 1}, {one, one, one});
  // X = 1 - mu2, forms -1: the same on the other branch.
  add({1, 0, -1}, {minus_one, minus_one, minus_one});
  // X = mu1 mu2 - 4, forms 1: beyond a hyperbola through pixels.
  add({-4, 0, 0, 1}, {one, one, one});
  // X = 1, forms 1, 2 - mu1, 1: up to mu1 = 2. X = -1, forms -1, mu1 - 2, -1: likewise.
  add({1}, {one, {2, -1}, one});
  add({-1}, {minus_one, {-2, 1}, minus_one});
  const auto expected = [](std::size_t region, std::size_t i, std::size_t j) {
    switch (region) {
      case 0:
        return i == 1 && j <= 2;
      case 1:
        return i >= 3 && j >= 1;
      case 4:
        return i * j > 4;
      case 5:
      case 6:
        return i <= 2;
      default:
        return j >= 2;
    }
  };
  const std::vector<Real> fixed{0, 0, 0};
  Slice slice;
  slice.low = 0, slice.high = 4, slice.size = 5, slice.fixed = Friction::same(fixed);
  for (const auto draw : {draw_by_spans, draw_by_pixels}) {
    ModeMap map;
    draw(p, slice, map);
    REQUIRE(map.regions.size() == 7);
    for (std::size_t j = 0; j < 5; ++j)
      for (std::size_t i = 0; i < 5; ++i)
        for (std::size_t k = 0; k < 7; ++k) {
          CAPTURE(i, j, k);
          CHECK((map.cell(i, j) >> k & 1) == expected(k, i, j));
          CHECK(contains(p.regions[k], {Real(i), Real(j), 0}) == expected(k, i, j));
        }
  }
}

TEST_CASE("a cell of a map says which regions hold its coefficients") {
  Random random(2);
  long feasible = 0;
  for (int i = 0; i < 60; ++i) {
    const Prepared p = prepared(random_grasp(random, 4));
    auto mu = random_friction(random, 4, 1);
    Slice slice;
    slice.across = 2, slice.up = 0, slice.size = 17, slice.fixed = Friction::same(mu);
    ModeMap map;
    draw_by_spans(p, slice, map);
    for (std::size_t j = 0; j < 17; ++j)
      for (std::size_t k = 0; k < 17; ++k) {
        auto here = mu;
        here[2] = slice.at(k), here[0] = slice.at(j);
        std::set<std::int32_t> expected, found;
        for (std::size_t r = 0; r < p.regions.size(); ++r)
          if (contains(p.regions[r], own(p.regions[r], Friction::same(here))))
            expected.insert(static_cast<std::int32_t>(r));
        for (std::size_t bit = 0; bit < map.regions.size(); ++bit)
          if (map.cell(k, j) >> bit & 1) found.insert(map.regions[bit]);
        if (found != expected) FAIL("cell " << k << ", " << j);
        feasible += static_cast<long>(found.size());
      }
  }
  CHECK(feasible > 500);
}

TEST_CASE("the grasp of figure 8 shows four modes, all of them at once in its upper corner") {
  const Prepared p = prepared(figure_grasp("fig8"));
  const std::vector<Real> fixed{0, 0, 0.7};
  Slice slice;
  slice.size = 101, slice.fixed = Friction::same(fixed);
  ModeMap map;
  draw_by_spans(p, slice, map);
  CHECK(legend_of(p, map) == "1 3S\n3 R1S3\n4 R2S1\n6 R3S1\n");
  CHECK(as_text(p, map, 5, 5) ==
        ".    1346 1346 1346 1346\n"
        ".    1346 1346 1346 1346\n"
        ".    36   1346 1346 1346\n"
        ".    36   36   1346 1346\n"
        ".    36   36   36   36\n");
}

TEST_CASE("a map's characters, legend and table are what its cells say") {
  const Prepared p = prepared(figure_grasp("fig3"));
  const std::vector<Real> fixed{0, 0, 0.5};
  Slice slice;
  slice.size = 3, slice.fixed = Friction::same(fixed);
  ModeMap map;
  draw_by_spans(p, slice, map);
  CHECK(as_text(p, map, 3, 3) == "6 4 4\n6 1 4\n6 1 1\n");
  CHECK(legend_of(p, map) == "1 3S\n4 R2S1\n6 R3S1\n");
  std::istringstream csv(as_csv(p, slice, map));
  std::string line;
  std::getline(csv, line);
  CHECK(line == "mu1,mu2,count,modes");
  std::getline(csv, line);
  CHECK(line == "0,0,1,R3S1");
  int lines = 1;
  for (std::string next; std::getline(csv, next); ++lines) line = next;
  CHECK(lines == 9);
  CHECK(line == "1,1,1,R2S1");
}

TEST_CASE("what bounds a region in a map is a hyperbola in closed form") {
  Random random(3);
  int crossed = 0;
  for (int i = 0; i < 300; ++i) {
    const Prepared p = prepared(random_grasp(random, 3));
    const auto fixed = random_friction(random, 3, 1);
    Slice slice;
    slice.fixed = Friction::same(fixed);
    for (const Region& r : p.regions) {
      const Cut c = cut(r, slice);
      const Real x = random.between(0, 1);
      for (int f = 0; f < c.form_count; ++f) {
        const Real y = c.forms[static_cast<std::size_t>(f)].up_at(x);
        if (!(y > 1e-3 && y < 1)) continue;
        // Where only this form is on the way, the mode ends there.
        const bool below = c.branch_at(x, y - 1e-7) != 0, above = c.branch_at(x, y + 1e-7) != 0;
        if (below == above) continue;
        ++crossed;
        auto mu = fixed;
        mu[0] = x, mu[1] = y - 1e-7;
        CHECK(contains(r, own(r, Friction::same(mu))) == below);
        mu[1] = y + 1e-7;
        CHECK(contains(r, own(r, Friction::same(mu))) == above);
      }
    }
  }
  CHECK(crossed > 50);
}

TEST_CASE("maps and preparations that are filled again take no memory") {
  Random random(4);
  const Grasp g = random_grasp(random, 6);
  const auto fixed = random_friction(random, 6, 1);
  Prepared p;
  prepare(g.lamina(), p);
  Slice slice;
  slice.fixed = Friction::same(fixed);
  ModeMap map;
  draw_by_spans(p, slice, map);
  const void *candidates = p.candidates.data(), *regions = p.regions.data();
  const void* cells = map.cells.data();
  for (int i = 0; i < 3; ++i) prepare(g.lamina(), p), draw_by_spans(p, slice, map);
  CHECK(candidates == p.candidates.data());
  CHECK(regions == p.regions.data());
  CHECK(cells == map.cells.data());
}

TEST_CASE("what preparations, tests and maps take, beside their error", "[.bench]") {
  std::ostringstream out;
  for (const std::size_t n : {2u, 3u, 4u, 6u, 10u, 20u}) {
    Random random(5);
    std::vector<Grasp> grasps;
    for (int i = 0; i < 64; ++i) grasps.push_back(random_grasp(random, n));
    Prepared p;
    const double took = microseconds(
        64, [&](int i) { prepare(grasps[static_cast<std::size_t>(i) % 64].lamina(), p); });
    out << "prepare, n = " << n << ": " << took << " us\n";
  }
  const Prepared p = prepared(figure_grasp("fig8"));
  const std::vector<Real> fixed{0, 0, 0.7};
  Slice slice;
  slice.fixed = Friction::same(fixed);
  ModeMap map;
  Difference sum;
  compare(p, slice, sum);
  const double spans = microseconds(2, [&](int) { draw_by_spans(p, slice, map); });
  const double pixels = microseconds(1, [&](int) { draw_by_pixels(p, slice, map); });
  out << "map 256 x 256, " << map.regions.size() << " modes, by spans: " << 1e6 / spans
      << " a second, by pixels: " << 1e6 / pixels << "; " << sum.boundary << " of " << sum.pixels
      << " pixels differ on a boundary, " << sum.elsewhere << " elsewhere\n";
  const std::vector<Real> mu{0.6, 0.7, 0.7};
  ModeSet set;
  const double modes = microseconds(100, [&](int) { find_modes(p, Friction::same(mu), set); });
  out << "modes with forces and margins, n = 3: " << modes << " us\n";
  long inside = 0;
  const Region& r = p.regions.front();
  std::array<OwnFriction, 128> tried;
  for (std::size_t i = 0; i < tried.size(); ++i) tried[i] = {0.01 * Real(i % 100), 0.5, 0.7};
  const double test = microseconds(
      1024, [&](int i) { inside += contains(r, tried[static_cast<std::size_t>(i) % 128]); });
  out << "test of one mode: " << 1e3 * test << " ns (" << inside << " inside)\n";
  WARN(out.str());
  CHECK(sum.elsewhere == 0);
}
