// Nearest points of surfaces beside SISL's, in one run: the same surfaces, the same points, the
// distances compared. SISL is AGPL: it is in this program alone, and in nothing that is shipped.
#include <sisl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "engine/nurbs/closest.hpp"
#include "engine/nurbs/makers.hpp"
#include "tests/base/random.hpp"
#include "tests/nurbs/samples.hpp"

namespace {

using namespace pantin;
using namespace pantin::detail;

constexpr int kRounds = 3, kQueries = 200;
constexpr double kNone = 1e300;
constexpr double kSame = 1e-8;                         // m
constexpr double kComputation = 0, kGeometry = 1e-10;  // m, what SISL is asked for

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

SISLSurf* to_sisl(nurbs::Surface s) {
  s = nurbs::part_of(s, nurbs::Along::u, s.u.domain());
  s = nurbs::part_of(s, nurbs::Along::v, s.v.domain());
  std::vector<double> points;  // u runs fastest there
  bool is_plain = true;
  for (const nurbs::Weighted& w : s.points) is_plain = is_plain && w.w == 1;
  for (int j = 0; j < s.v.count(); ++j)
    for (int i = 0; i < s.u.count(); ++i) {
      const nurbs::Weighted& w = s.at(i, j);
      points.insert(points.end(), {w.x, w.y, w.z});
      if (!is_plain) points.push_back(w.w);
    }
  return newSurf(s.u.count(), s.v.count(), s.u.degree + 1, s.v.degree + 1, s.u.values.data(),
                 s.v.values.data(), points.data(), is_plain ? 1 : 2, 3, 1);
}

struct Case {
  const char* name;
  nurbs::Surface surface;
};

using Query = double (*)(SISLSurf*, const nurbs::Face&, Vec3);

double distance_at(const nurbs::Face& face, const double* at, Vec3 p) {
  const nurbs::Jet j = face.at(face.u().domain().clamped(at[0]), face.v().domain().clamped(at[1]));
  return glm::distance(j.s, p);
}

/// The quick one: a descent from one place, which may be the wrong one.
double quick(SISLSurf* surface, const nurbs::Face& face, Vec3 p) {
  double at[2], distance = 0;
  int status = 0;
  s1958(surface, &p.x, 3, kComputation, kGeometry, at, &distance, &status);
  return status < 0 ? kNone : distance_at(face, at, p);
}

/// The thorough one: all nearest points, by subdivision.
double thorough(SISLSurf* surface, const nurbs::Face& face, Vec3 p) {
  double* at = nullptr;
  SISLIntcurve** curves = nullptr;
  int points = 0, curve_count = 0, status = 0;
  s1954(surface, &p.x, 3, kComputation, kGeometry, &points, &at, &curve_count, &curves, &status);
  double best = kNone;
  for (int i = 0; i < points; ++i) best = std::min(best, distance_at(face, at + 2 * i, p));
  for (int i = 0; i < curve_count; ++i)
    best = std::min(best, distance_at(face, curves[i]->epar1, p));
  if (curves) freeIntcrvlist(curves, curve_count);
  std::free(at);
  return status < 0 ? kNone : best;
}

/// Of one way to ask SISL: how long it takes, and how its distances differ from ours.
struct Asked {
  SISLSurf* surface;
  const nurbs::Face& face;
  const std::vector<Vec3>& points;
};
void tell(const char* name, Query query, const Asked& of) {
  const auto& [surface, face, points] = of;
  std::vector<Real> ours(points.size()), other(points.size());
  double least_ours = kNone, least_other = kNone;
  for (int round = 0; round < kRounds; ++round) {
    double start = now();
    for (std::size_t i = 0; i < points.size(); ++i)
      ours[i] = nurbs::closest_point(face, points[i]).distance;
    least_ours = std::min(least_ours, now() - start);
    start = now();
    for (std::size_t i = 0; i < points.size(); ++i) other[i] = query(surface, face, points[i]);
    least_other = std::min(least_other, now() - start);
  }
  int farther = 0, nearer = 0, failed = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    failed += other[i] == kNone;
    farther += other[i] != kNone && other[i] > ours[i] + kSame;
    nearer += other[i] < ours[i] - kSame;
  }
  const double queries = static_cast<double>(points.size());
  std::printf("  %-8s %9.2f %10.2f %8.1f %8d %8d %8d\n", name, 1e6 * least_ours / queries,
              1e6 * least_other / queries, least_other / least_ours, farther, nearer, failed);
}

void measure(const Case& c, test::Random& dice) {
  const nurbs::Face face(c.surface);
  SISLSurf* theirs = to_sisl(c.surface);
  std::vector<Vec3> points;
  for (int i = 0; i < kQueries; ++i) points.push_back(dice.in_cube(1.5 * face.size()));
  std::printf("%s\n", c.name);
  tell("s1958", quick, {theirs, face, points});
  tell("s1954", thorough, {theirs, face, points});
  freeSurf(theirs);
}

}  // namespace

int main() {
  test::Random dice(11);
  const Case cases[] = {
      {"bicubic, 8 x 8", test::bumpy_surface(3, 8, 0.2, dice)},
      {"bicubic, 20 x 20", test::bumpy_surface(3, 20, 0.2, dice)},
      {"biquadratic, 8 x 8", test::bumpy_surface(2, 8, 0.2, dice)},
      {"rational bicubic, 6 x 6", test::random_surface(3, 3, 6, 6, dice)},
      {"torus", nurbs::torus({}, 0.5, 0.2)},
      {"sphere with poles", nurbs::sphere({}, 0.5)},
  };
  std::printf(
      "%d points, %d rounds, the least of each; SISL is asked for %g m. farther, nearer: how often "
      "its point is\n",
      kQueries, kRounds, kGeometry);
  std::printf("  %-8s %9s %10s %8s %8s %8s %8s\n", "SISL's", "ours/us", "SISL/us", "ratio",
              "farther", "nearer", "failed");
  for (const Case& c : cases) measure(c, dice);
}
