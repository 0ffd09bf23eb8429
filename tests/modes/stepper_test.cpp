// Laminas moved quasi-statically: switches of modes, what ends a step, and how sharp it all is.
#include "engine/modes/stepper.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <sstream>

using namespace pantin;
using namespace pantin::detail::modes;

namespace {

const std::vector<Vec2> kRod{{-1, 0}, {1, 0}, {1, 0.02}, {-1, 0.02}};

/// The rod of a reference: distances 0.4 and 0.25, both fingers at 0.01 m/s.
std::vector<Finger> rod_fingers(Real t, Real roll, Real slide) {
  return {{{-0.4 + 0.01 * t, 0}, {0.01, 0}, {}, false, roll, slide},
          {{0.25 - 0.01 * t, 0}, {-0.01, 0}, {}, false, roll, slide}};
}
Part rod() { return {kRod, {0, 0.01}, {0, -10}, 0}; }

struct Switch {
  Real time, left, right;
};

/// Steps of `h` until `end`; where the rod was at the end, and switches by where they were found.
struct RodRun {
  Stepper stepper;
  Real time = 0;
  int switches = 0;
  bool zeno = false;

  void go(Real end, Real h, Real roll = 0.5, Real slide = 0.3) {
    while (time < end - 1e-9) {
      const StepEnd e =
          stepper.step(rod(), rod_fingers(time, roll, slide), std::min(h, end - time));
      switches += e.switches, zeno |= e.zeno;
      REQUIRE(e.ending == Ending::done);
      time += e.time;
    }
  }
};

/// Poses agree to the bit.
bool same(const Placement& a, const Placement& b) {
  return a.shift.x == b.shift.x && a.shift.y == b.shift.y && a.angle == b.angle;
}

}  // namespace

TEST_CASE("A rod on two fingers switches where 30 digits say") {
  // tests of accuracy, rod_two_fingers: time, shift of the centre.
  constexpr Real kSwitches[][2] = {{12.5, -0.125},
                                   {20.5, -0.045},
                                   {25.3, -0.093},
                                   {28.18, -0.0642},
                                   {29.908, -0.08148},
                                   {30.9448, -0.071112},
                                   {31.56688, -0.0773328},
                                   {31.940128, -0.07360032},
                                   {32.1640768, -0.075839808},
                                   {32.29844608, -0.0744961152}};
  for (const Real h : {0.07, 1.0, 5.0}) {
    RodRun run;
    int count = 0;
    for (const auto& [time, shift] : kSwitches) {
      run.go(time, h);
      CAPTURE(h, time);
      CHECK(std::abs(run.stepper.placed.shift.x - shift) < 1e-9);
      CHECK(std::abs(run.stepper.placed.angle) < 1e-12);
      run.go(time + 0.01, h);
      CHECK(run.switches == ++count);
    }
  }
}

TEST_CASE("The rod's first finger to slide is the one with less load and friction") {
  RodRun run;
  run.go(1, 0.5);
  const Motion& m = run.stepper.motion;
  CHECK(m.signs == Signs{2, 1, 0});  // the right one sticks, the left one slides
  CHECK(m.index == 1);
  CHECK(m.normal_force[0] == Approx(10 * 0.25 / 0.64));  // arms at 0.5 s: 0.39, 0.25
  CHECK(m.tangent_force[0] == Approx(-0.3 * m.normal_force[0]));
}

TEST_CASE(
    "Where sticking is no stronger than sliding the rod slides on both in the mean, and says so") {
  RodRun run;
  run.go(15, 0.25, 0.3, 0.3);
  CHECK(run.zeno);
  CHECK(run.stepper.placed.shift.x == Approx(-0.075).margin(2e-4));  // both arms are equal
}

TEST_CASE("Switches that come ever faster are seen by their ratio, not followed to the end") {
  // All of them come before 32.5 s; the arms shrink by 0.6 from one to the next.
  RodRun run;
  run.go(33, 33);
  CHECK(run.zeno);
  CHECK(run.switches > 6);
  CHECK(run.switches < 14);
  CHECK(run.stepper.placed.shift.x == Approx(-0.075).margin(0.01));
  RodRun before;
  before.go(30, 30);
  CHECK(!before.zeno);
  CHECK(before.switches == 5);
}

TEST_CASE("Gaps are above 0 outside a lamina and below 0 inside, flat fingers and points alike") {
  const std::vector<Vec2> box{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const Part part{box, {0.5, 0.5}, {0, -1}, 0};
  const auto gap = [&](const Finger& f, const Placement& at) {
    const std::vector<Finger> fingers{f};
    Moment now{part, fingers};
    now.place(at);
    return least_gap(now, 0);
  };
  const Finger floor{{0.5, -0.1}, {0, 0}, {0, 1}, true}, wall{{1.3, 0}, {0, 0}, {-1, 0}, true};
  CHECK(gap(floor, {}) == Approx(0.1));
  CHECK(gap(floor, {{0, -0.3}, 0}) == Approx(-0.2));
  CHECK(gap(wall, {}) == Approx(0.3));
  CHECK(gap(wall, {{0.5, 0}, 0}) == Approx(-0.2));
  // On its corner: the other one is higher.
  CHECK(gap(floor, {{0, 0}, kPi / 4}) == Approx(0.1));
  const Finger point{{0.5, -0.1}, {0, 0}, {}, false};
  CHECK(gap(point, {}) == Approx(0.1));
  CHECK(gap(point, {{0, -0.3}, 0}) == Approx(-0.2));
  // A flat finger bears on the corner that lies on it, and only there.
  const std::vector<Finger> fingers{{{5, 0}, {0, 0}, {0, 1}, true}};
  Moment now{part, fingers};
  now.place({{0, 0}, 0.1});
  const Touches touches = touches_of(now, 1e-9);
  REQUIRE(touches.count == 1);
  CHECK(touches.list[0].feature == 0);
  CHECK(contact_of(now, touches.list[0]).normal.y == 1);
}

TEST_CASE("A copy of a stepper goes on with the same bits") {
  RodRun a;
  a.go(21, 0.25);
  RodRun b = a;
  a.go(30, 0.25), b.go(30, 0.25);
  CHECK(same(a.stepper.placed, b.stepper.placed));
  CHECK(a.switches == b.switches);
}

TEST_CASE("A rolling contact keeps its place on a lamina that turns, to order four") {
  // One finger rises under the left end; the other carries at rest and does not slip.
  const std::vector<Vec2> plate{{-1, 0}, {1, 0}, {1, 0.1}, {-1, 0.1}};
  const Part part{plate, {0, 0.05}, {0, -10}, 0};
  const auto error = [&](int steps) {
    Stepper s;
    const Real h = 2.0 / steps;
    for (int i = 0; i < steps; ++i) {
      const std::vector<Finger> fingers{{{-0.5, 0.1 * h * i}, {0, 0.1}, {}, false, 0.01, 0.01},
                                        {{0.5, 0}, {0, 0}, {}, false, 0.9, 0.9}};
      REQUIRE(s.step(part, fingers, h).ending == Ending::done);
    }
    // The edge goes through (-0.5, 0.2); the point of the lamina at (0.5, 0) has not moved.
    const Real angle = -std::atan2(0.2, 1.0);
    const Vec2 held = s.placed.shift + turned({0.5, 0}, std::cos(angle), std::sin(angle));
    CHECK(s.placed.angle == Approx(angle).margin(1e-6));
    return length(held - Vec2{0.5, 0});
  };
  const Real coarse = error(4), fine = error(8);
  CHECK(coarse < 1e-6);
  CHECK(fine < coarse / 10);
}

TEST_CASE("A finger that arrives takes over, found to the point") {
  const Part part{kRod, {0, 0.01}, {0, -10}, 0};
  Stepper s;
  Real time = 0;
  const auto fingers = [&] {
    return std::vector<Finger>{{{-0.5, 0}, {0, 0}, {}, false, 0.5, 0.5},
                               {{0.5, 0}, {0, 0}, {}, false, 0.5, 0.5},
                               {{-0.3, -0.05 + 0.07 * time}, {0, 0.07}, {}, false, 0.5, 0.5}};
  };
  for (; time < 0.99; time += 0.1) REQUIRE(s.step(part, fingers(), 0.1).ending == Ending::done);
  // It touches at 5/7 s and lifts: the first separates.
  CHECK(s.motion.touches.count == 2);
  CHECK(s.motion.touches.list[0].finger == 1);
  CHECK(s.motion.touches.list[1].finger == 2);
  CHECK(s.placed.angle == Approx(-std::atan2(0.02, 0.8)).epsilon(1e-3));
}

TEST_CASE("A flat finger bears the corners that lie on it") {
  const std::vector<Vec2> box{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const Part part{box, {0.5, 0.5}, {0, -20}, 0};
  const std::vector<Finger> fingers{{{0, 0}, {0, 0}, {0, 1}, true, 0.2, 0.2},
                                    {{0, 0.4}, {0.05, 0.01}, {}, false, 0.2, 0.2}};
  Stepper s;
  REQUIRE(s.step(part, fingers, 2).ending == Ending::done);
  CHECK(s.placed.shift.x == Approx(0.1));
  CHECK(std::abs(s.placed.shift.y) < 1e-12);
  CHECK(s.motion.touches.count == 3);
  // The finger lifts a little by its own friction, and pushes against that of the floor.
  const auto& n = s.motion.normal_force;
  CHECK(n[0] + n[1] == Approx(20 - s.motion.tangent_force[2]));
  CHECK(n[2] == Approx(0.2 * (n[0] + n[1])));
}

TEST_CASE("What quasi-statics has no answer to ends the step and is told") {
  const Part part{kRod, {0, 0.01}, {0, -10}, 0};
  const auto end_of = [&](const std::vector<Finger>& fingers, Real h) {
    Stepper s;
    return s.step(part, fingers, h);
  };
  // Both fingers on one side of the centre: it falls.
  StepEnd end = end_of({{{0.2, 0}, {0, 0}, {}, false}, {{0.6, 0}, {0, 0}, {}, false}}, 1);
  CHECK(end.ending == Ending::no_mode);
  CHECK(end.verdict == Verdict::no_balance);
  CHECK(end.time == 0);
  // A finger above and one below approach each other: squeezed.
  end = end_of({{{0, 0}, {0, 0.1}, {}, false},
                {{-0.5, 0}, {0, 0.1}, {}, false},
                {{0.5, 0}, {0, 0.1}, {}, false},
                {{0, 0.02}, {0, -0.1}, {}, false}},
               1);
  CHECK(end.verdict == Verdict::squeezed);
  // A finger slides off the end: there it has no normal.
  end =
      end_of({{{-0.4, 0}, {0, 0}, {}, false, 0.9, 0.9}, {{0.9, 0}, {0.1, 0}, {}, false, 0, 0}}, 3);
  CHECK(end.ending == Ending::at_corner);
  CHECK(end.time == Approx(1).margin(1e-6));
  // Nobody there.
  CHECK(end_of({{{0, -1}, {0, 0}, {}, false}}, 1).ending == Ending::no_mode);
}

TEST_CASE("what a stepped frame takes", "[.bench]") {
  std::ostringstream out;
  const std::array<Real, 2> frictions[] = {{0.5, 0.3}, {0.3, 0.3}};  // the second without end
  for (const auto [roll, slide] : frictions) {
    RodRun run;
    double worst = 0, sum = 0;
    int frames = 0;
    for (Real t = 0; t < 32; t += 1.0 / 60, ++frames) {
      double best = 1e9;
      const RodRun before = run;
      for (int i = 0; i < 10; ++i) {
        run = before;
        const auto start = std::chrono::steady_clock::now();
        run.go(t + 1.0 / 60, 1.0 / 60, roll, slide);
        const std::chrono::duration<double, std::micro> took =
            std::chrono::steady_clock::now() - start;
        best = std::min(best, took.count());
      }
      worst = std::max(worst, best), sum += best;
    }
    out << "rod, friction " << roll << ", " << slide << ": " << frames
        << " frames of 1/60 s, best of 10 each: mean " << sum / frames << " us, worst " << worst
        << " us; " << run.switches << " switches\n";
    CHECK(worst > 0);
  }
  WARN(out.str());
}
