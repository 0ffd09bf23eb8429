// Gears, Geneva drives and cams against their laws.
#include "engine/nurbs/profiles.hpp"

#include <catch2/catch.hpp>

#include "engine/base/rotation.hpp"
#include "engine/nurbs/check.hpp"
#include "engine/nurbs/curve_pair.hpp"
#include "engine/nurbs/plane_curves.hpp"
#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

namespace {

/// A curve of a part: closed, smooth, without crossings.
Wire wire_of(const Result<Curve>& made) {
  REQUIRE(made);
  REQUIRE(errors_of(*made, "curve").empty());
  CHECK(made->knots.is_periodic);
  for (const Flaw& flaw : flaws_of(*made, "curve")) {
    INFO(flaw.text);
    CHECK(flaw.kind != FlawKind::crease);
    CHECK(flaw.kind != FlawKind::singular_point);
  }
  CHECK_FALSE(crossing_of(*made));
  return Wire(*made);
}
Pose turned(Real angle, Vec3 at = Vec3(0)) { return {at, from_rotation_vector({0, 0, angle})}; }

/// Distance of the line along the normal of a contact from a point of the plane.
Real miss(const CurveContact& at, Vec3 point) {
  const Vec3 d = point - at.on_b;
  return std::abs(d.x * at.normal.y - d.y * at.normal.x);
}

}  // namespace

TEST_CASE("the flanks of two gears touch where their common normal passes the pitch point") {
  for (const auto& [first, second] : {std::pair{20, 30}, {12, 45}, {17, 17}}) {
    Teeth a, b;
    a.count = first, b.count = second;
    const Wire one = wire_of(involute_gear(a)), two = wire_of(involute_gear(b));
    const Real centres = (first + second) * a.module / 2, pitch = first * a.module / 2;
    // Touching at the pitch point: a tooth of one lies in a gap of the other.
    const Real half = second % 2 == 0 ? kPi / second : 0;
    int touches = 0;
    Real worst_gap = 0, worst_miss = 0, worst_pressure = 0;
    for (int i = 0; i < 40; ++i) {
      const Real turn = 2 * kPi / first * i / 40;
      const Pose to = turned(half - turn * first / second, {centres, 0, 0});
      const Pose a_in_b = compose(inverse(to), turned(turn));
      CurveContact found[24];
      const std::size_t count = find_planar(one, two, a_in_b, {1e-3 * a.module, found});
      for (std::size_t k = 0; k < std::min<std::size_t>(count, 24); ++k) {
        const Vec3 pitch_point = to_local(to, Vec3(pitch, 0, 0));
        const Vec3 n = to.rotation * found[k].normal;
        if (std::abs(found[k].gap) > 1e-6 * a.module) continue;
        ++touches;
        worst_gap = std::max(worst_gap, std::abs(found[k].gap));
        worst_miss = std::max(worst_miss, miss(found[k], pitch_point));
        worst_pressure =
            std::max(worst_pressure, std::abs(std::asin(std::abs(n.x)) - a.pressure_angle));
      }
    }
    INFO(first << " on " << second << ": " << touches << " contacts, gap " << worst_gap
               << " m, normal " << worst_miss << " m from the pitch point");
    // Both flanks of more than one pair at all times.
    CHECK(touches >= 2 * 40);
    CHECK(worst_gap < 1e-11);
    CHECK(worst_miss < 1e-8);
    CHECK(worst_pressure < 1e-6);
  }
}

TEST_CASE("a gear runs along a rack with constant ratio; backlash opens the other flank") {
  Teeth teeth;
  const Wire gear = wire_of(involute_gear(teeth));
  Teeth of_rack = teeth;
  of_rack.count = 9;
  const Wire rack = wire_of(involute_rack(of_rack, 0.03));
  const Real pitch = teeth.count * teeth.module / 2;
  // Above the rack, its gap over the tooth at the origin.
  int touches = 0;
  Real worst = 0;
  for (int i = 0; i < 20; ++i) {
    const Real turn = kPi / 10 * i / 20;
    const Pose a_in_b = turned(-kPi / 2 + kPi / teeth.count - turn, {pitch * turn, pitch, 0});
    CurveContact found[24];
    const std::size_t count = find_planar(gear, rack, a_in_b, {1e-3 * teeth.module, found});
    for (std::size_t k = 0; k < count; ++k)
      if (std::abs(found[k].gap) < 1e-6 * teeth.module)
        ++touches, worst = std::max(worst, std::abs(found[k].gap));
  }
  CHECK(touches >= 2 * 20);
  CHECK(worst < 1e-11);

  teeth.backlash = 2e-4;
  const Wire thin = wire_of(involute_gear(teeth));
  const Pose in_gap = turned(-kPi / 2 + kPi / teeth.count, {0, pitch, 0});
  CurveContact found[24];
  const std::size_t count = find_planar(thin, rack, in_gap, {0.1 * teeth.module, found});
  REQUIRE(count > 0);
  // Half the backlash on each side, along the normal.
  CHECK(found[0].gap == Approx(teeth.backlash / 4 * std::cos(teeth.pressure_angle)).epsilon(1e-3));
}

TEST_CASE("teeth that come to a point are refused") {
  Teeth teeth;
  teeth.count = 8, teeth.pressure_angle = 40 * kPi / 180;
  const auto made = involute_gear(teeth);
  REQUIRE_FALSE(made);
  CHECK(made.errors().front().message.find("not pointed") != std::string::npos);
  CHECK_FALSE(involute_rack(teeth, 0.03));
  CHECK_FALSE(involute_rack({}, 0.01));
}

TEST_CASE("the disc of a Geneva drive holds every wheel, and its pin fits the slots") {
  for (const int slots : {3, 4, 5, 6, 8, 12}) {
    INFO(slots << " slots");
    GenevaDrive drive;
    drive.slots = slots;
    if (slots == 12) drive.pin_radius = 0.006, drive.lip = 0.002;
    const Wire wheel = wire_of(geneva_wheel(drive)), disc = wire_of(geneva_disc(drive));
    // The pin enters along the slot: the arm is across it there.
    const Real enter = kPi / 2 - kPi / slots;
    const Vec3 pin(drive.arm() * std::cos(enter), drive.arm() * std::sin(enter), 0);
    const Vec3 to_wheel = Vec3(drive.distance, 0, 0) - pin;
    CHECK(glm::dot(glm::normalize(to_wheel), glm::normalize(pin)) == Approx(0).margin(1e-12));
    // The pin's middle is within its radius of both walls, at the mouth and at the bottom.
    for (const Real along : {drive.distance - drive.arm(), drive.distance * std::cos(kPi / slots)})
      CHECK(closest_point(wheel, Vec3(along, 0, 0)).distance ==
            Approx(drive.pin_radius).margin(1e-12));
    // At rest the wheel's hollow is about the crank's axis, with the clearance.
    const Real lock =
        closest_point(wheel, to_local(turned(kPi - kPi / slots, {drive.distance, 0, 0}), Vec3(0)))
            .distance;
    const Real out = glm::length(closest_point(disc, Vec3(-1, 0, 0)).point);
    CHECK(lock - out == Approx(drive.clearance).margin(1e-12));
  }
}

TEST_CASE("a flat follower and a roller on a cam move by the law") {
  for (const CamLaw law : {CamLaw::cycloidal, CamLaw::polynomial_345})
    for (const Real roller : {-1.0, 0.02}) {
      Cam cam;
      cam.law = law, cam.roller = roller, cam.base = 0.06;
      const Real d = kPi / 180;
      cam.lifts = {{0, 0}, {60 * d, 0}, {170 * d, 0.02}, {210 * d, 0.02}, {330 * d, 0}};
      const Wire outline = wire_of(cam_outline(cam));
      Real worst = 0;
      Random dice(1);
      for (int i = 0; i < 200; ++i) {
        const Real angle = dice.between(0, 2 * kPi);
        const Vec3 way(std::cos(angle), std::sin(angle), 0);
        const Real lift = cam.lift(angle)[0];
        if (roller > 0) {
          const Vec3 centre = (cam.base + lift + roller) * way;
          worst = std::max(worst, std::abs(closest_point(outline, centre).distance - roller));
          continue;
        }
        // The farthest point of the cam along the lift.
        Real reach = 0;
        for (const Vec3 p : points_along(outline.curve(), 1e-9).points)
          reach = std::max(reach, glm::dot(p, way));
        worst = std::max(worst, std::abs(reach - cam.base - lift));
      }
      CHECK(worst < 2e-8);
      // Closed forms: at rest, halfway, and the derivatives by differences.
      CHECK(cam.lift(30 * d)[0] == 0);
      CHECK(cam.lift(115 * d)[0] == Approx(0.01));
      CHECK(cam.lift(190 * d)[0] == Approx(0.02));
      for (const Real angle : {0.3, 1.5, 2.2, 4.0, 5.5}) {
        const Real h = 1e-5;
        const auto before = cam.lift(angle - h), after = cam.lift(angle + h), at = cam.lift(angle);
        CHECK(at[1] == Approx((after[0] - before[0]) / (2 * h)).margin(1e-9));
        CHECK(at[2] == Approx((after[1] - before[1]) / (2 * h)).margin(1e-8));
      }
    }
}

TEST_CASE("a cam that its follower would lose is refused, with the angle") {
  Cam cam;
  cam.base = 0.01, cam.lifts = {{0, 0}, {1, 0.03}};
  const auto hollow = cam_outline(cam);
  REQUIRE_FALSE(hollow);
  CHECK(hollow.errors().front().message.find("hollow where the follower is at") !=
        std::string::npos);
  cam.roller = 0.05;
  REQUIRE_FALSE(cam_outline(cam));
  CHECK(cam_outline(cam).errors().front().message.find("undercut") != std::string::npos);
}

TEST_CASE("a helix keeps its radius and rises evenly") {
  const auto made = helix({0.05, 0.02, 6.5});
  REQUIRE(made);
  const Wire wire(*made);
  for (int i = 0; i <= 500; ++i) {
    const Vec3 p = evaluate(*made, i / 500.0, 0)[0];
    CHECK(std::hypot(p.x, p.y) == Approx(0.05).margin(1e-9));
    CHECK(std::remainder(std::atan2(p.y, p.x) - 2 * kPi * p.z / 0.02, 2 * kPi) ==
          Approx(0).margin(1e-6));
  }
  CHECK(evaluate(*made, 1, 0)[0].z == Approx(0.13).margin(1e-12));
}
