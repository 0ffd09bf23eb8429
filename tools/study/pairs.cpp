#include "tools/study/pairs.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <vector>

#include "engine/geometry/collide.hpp"
#include "tests/geometry/brute_force.hpp"

namespace pantin::study {
namespace {

using namespace detail;

constexpr Real kMargin = 0.01;  // m
constexpr int kRounds = 5;

struct Named {
  const char* name;
  Shape shape;
};

/// Solids of about 0.4 m.
std::vector<Named> solids() {
  return {{"sphere", {ShapeKind::sphere, {0.2, 0, 0}, {}, 0}},
          {"capsule", {ShapeKind::capsule, {0.1, 0.15, 0}, {}, 0}},
          {"box", {ShapeKind::box, {0.2, 0.15, 0.18}, {}, 0}},
          {"cylinder", {ShapeKind::cylinder, {0.15, 0.2, 0}, {}, 0}},
          {"cone", {ShapeKind::cone, {0.2, 0.2, 0}, {}, 0}},
          {"ellipsoid", {ShapeKind::ellipsoid, {0.2, 0.12, 0.16}, {}, 0}}};
}

/// Two shapes in touch.
struct Placed {
  Pose a, b;
  Real gap = 0;  // m, by brute force
};

/// By how much the search found a direction that parts the two farther, or the gap is not that
/// along its own normal.
Real error_of(const Placed& at, const Shape& a, const Shape& b,
              const std::vector<ContactPoint>& points) {
  if (points.empty()) return 1e300;
  const ContactPoint& p =
      *std::min_element(points.begin(), points.end(),
                        [](const ContactPoint& l, const ContactPoint& r) { return l.gap < r.gap; });
  const Real along = test::gap_along({a, at.a}, {b, at.b}, p.normal);
  return std::max(at.gap - p.gap, std::abs(along - p.gap));
}

/// Poses at which two shapes are within a few millimetres of touching, turned at random.
std::vector<Placed> place(const Shape& a, const Shape& b, int count, test::Random& dice) {
  std::vector<Placed> all;
  while (static_cast<int>(all.size()) < count) {
    Placed at{{Vec3(0), dice.orientation()}, {Vec3(0), dice.orientation()}};
    const Vec3 way = dice.direction();
    Real low = 0, high = 1;
    for (int i = 0; i < 40; ++i) {
      const Real middle = (low + high) / 2;
      at.a.position = middle * way;
      (test::brute_force_gap({a, at.a}, {b, at.b}, dice, {.directions = 200, .starts = 2}) > 0
           ? high
           : low) = middle;
    }
    at.a.position = (high + dice.between(-0.004, 0.004)) * way;
    at.gap = test::brute_force_gap({a, at.a}, {b, at.b}, dice);
    all.push_back(at);
  }
  return all;
}

struct Measured {
  double nanoseconds = 0;  // of CPU time, median of the rounds
  double spread = 0;       // of them, part of the median
  Real error = 0;          // m, the largest
  double points = 0;       // mean
};

Measured measure(const Shape& a, const Shape& b, const std::vector<Placed>& poses) {
  NarrowPhaseScratch scratch;
  std::vector<ContactPoint> points;
  Measured m;
  const auto collide_at = [&](const Placed& at) {
    points.clear();
    collide({a, at.a}, {b, at.b}, scratch, {kMargin, points});
  };
  for (const Placed& at : poses) {
    collide_at(at);
    m.points += static_cast<double>(points.size()) / static_cast<double>(poses.size());
    m.error = std::max(m.error, error_of(at, a, b, points));
  }
  std::vector<double> times;
  for (int round = 0; round < kRounds; ++round) {
    const std::clock_t start = std::clock();
    std::clock_t took = 0;
    std::size_t calls = 0;
    while (took < CLOCKS_PER_SEC / 50) {
      for (const Placed& at : poses) collide_at(at);
      calls += poses.size(), took = std::clock() - start;
    }
    times.push_back(1e9 * static_cast<double>(took) / CLOCKS_PER_SEC / static_cast<double>(calls));
  }
  std::sort(times.begin(), times.end());
  m.nanoseconds = times[times.size() / 2];
  m.spread = (times.back() - times.front()) / m.nanoseconds;
  return m;
}

}  // namespace

void measure_pairs(std::FILE* out, PairSample sample) {
  const int count = sample == PairSample::few ? 4 : 60;
  const std::vector<Named> all = solids();
  test::Random dice(3);
  if (out == stdout)
    std::printf("%-10s %-10s %-9s %-7s %-9s %s\n", "a", "b", "ns", "spread", "error m", "points");
  else
    std::fprintf(out, "a,b,ns,spread,error_m,points\n");
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = i; j < all.size(); ++j) {
      const Measured m =
          measure(all[i].shape, all[j].shape, place(all[i].shape, all[j].shape, count, dice));
      std::fprintf(
          out,
          out == stdout ? "%-10s %-10s %-9.0f %-7.2f %-9.1e %.1f\n" : "%s,%s,%.0f,%.2f,%.1e,%.1f\n",
          all[i].name, all[j].name, m.nanoseconds, m.spread, m.error, m.points);
    }
}

}  // namespace pantin::study
