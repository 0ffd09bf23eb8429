// What an iteration costs, and how far joints and hand are apart at the rate of a haptic loop.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <pantin/assembler.hpp>
#include <pantin/must.hpp>

#include "tests/assembly/mechanisms.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// The end of a mechanism is led on a circle of 0.4 m, once a second, one iteration a cycle of
/// `rate` Hz; the best of five tenths of a second.
void drag(const char* name, const World& w, Entity body, Vec3 point, Real links, Real rate) {
  Assembler a(w);
  const Vec3 start = to_world(w.bodies[body].pose, point);
  const Target hand = must(a.add(PointTarget{.body = body, .point = point, .target = start}));
  a.settle(50);
  const int cycles = static_cast<int>(rate / 10);
  Real best = 1e300, joints = 0, target = 0;
  for (int round = 0; round < 10; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < cycles; ++i) {
      const Real phase = 2 * kPi * (round * cycles + i) / rate;
      a.move(hand, start + 0.4 * Vec3(std::cos(phase) - 1, std::sin(phase), 0));
      const AssemblerErrors e = a.iterate();
      joints = std::max(joints, e.joints);
      if (round > 0) target = std::max(target, e.targets);
    }
    const std::chrono::duration<Real, std::nano> took = std::chrono::steady_clock::now() - begin;
    best = std::min(best, took.count() / cycles);
  }
  std::printf("%-12s %6.0f Hz: %8.0f ns an iteration, %5.0f ns a link; joints %.1e, hand %.1e m\n",
              name, rate, best, best / links, joints, target);
  std::fflush(stdout);
  if (rate >= 30000) CHECK(joints < 1e-6);
}

}  // namespace

TEST_CASE("assembly: what an iteration costs: chains", "[.long]") {
  for (const Real rate : {30000.0, 1000.0})
    for (const int n : {8, 20, 100, 150}) {
      World w = bendy(n);
      w.destroy(w.find("finger"));
      drag(("bendy " + std::to_string(n)).c_str(), w, w.find("link" + std::to_string(n - 1)),
           {0.5, 0, 0}, n, rate);
    }
}

TEST_CASE("assembly: what an iteration costs: a Stewart platform", "[.long]") {
  const World platform = stewart();
  drag("Stewart", platform, platform.find("platform"), Vec3(0), 13, 30000);
}
