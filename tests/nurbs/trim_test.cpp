// Trimmed faces: what is kept, nearest points, contacts, triangles, area; against closed forms and
// dense samples.
#include "engine/nurbs/trim.hpp"

#include <catch2/catch.hpp>

#include "engine/nurbs/common_normal.hpp"
#include "engine/nurbs/curve_pair.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/plane_curves.hpp"
#include "engine/nurbs/tessellate.hpp"
#include "tests/base/random.hpp"
#include "tests/nurbs/samples.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

namespace {

constexpr Real kRadius = 0.7;

/// A circle in the parameters of a plane of 2 m by 2 m, whose domain is the unit square.
Curve circle_on_plane(Vec3 centre, Real radius) {
  return transformed(circle({}, radius),
                     {Mat3(0.5, 0, 0, 0, 0.5, 0, 0, 0, 1), 0.5 * centre + Vec3(0.5, 0.5, 0)});
}
Surface disc(std::vector<Curve> holes = {}) {
  Surface s = plane({}, 2, 2);
  s.trims = {circle_on_plane(Vec3(0), kRadius)};
  s.trims.insert(s.trims.end(), holes.begin(), holes.end());
  return s;
}
bool holds(const Face& face, Vec3 p) { return face.holds((p.x + 1) / 2, (p.y + 1) / 2); }
Vec3 on_circle(Real angle, Real radius) {
  return {radius * std::cos(angle), radius * std::sin(angle), 0};
}
Surface trimmed(Surface s, const Curve& loop) {
  s.trims.push_back(loop);
  return s;
}
/// A smooth closed curve in the middle of the unit square.
Curve blob(Random& dice) {
  std::vector<Vec3> points;
  for (int k = 0; k < 7; ++k) {
    const Real angle = 2 * kPi * k / 7, far = dice.between(0.2, 0.4);
    points.push_back(Vec3(0.5, 0.5, 0) + on_circle(angle, far));
  }
  return *interpolated(points, 3, Ends::periodic);
}
Pose at(Vec3 p) { return {p, kIdentity}; }

}  // namespace

TEST_CASE("a disc is trimmed from a plane exactly at its radius, with its rim") {
  const Face face(disc());
  REQUIRE(face.trim() != nullptr);
  for (int k = 0; k < 360; ++k) {
    const Real angle = 2 * kPi * (k + 0.137) / 360;
    CHECK(holds(face, on_circle(angle, kRadius - 1e-9)));
    CHECK(holds(face, on_circle(angle, kRadius)));
    CHECK_FALSE(holds(face, on_circle(angle, kRadius + 1e-9)));
  }
  CHECK(holds(face, Vec3(0)));
  CHECK_FALSE(holds(face, {-0.9, 0.9, 0}));
  CHECK_FALSE(Face(plane({}, 2, 2)).trim());
  CHECK(Face(plane({}, 2, 2)).holds(0.99, 0.99));
}

TEST_CASE("what an odd number of loops surrounds is kept, whatever their directions") {
  for (const bool is_reversed : {false, true}) {
    Curve hole = circle_on_plane({0.1, 0, 0}, 0.4);
    if (is_reversed) hole = reversed(hole);
    const Face face(disc({hole, circle_on_plane({0.1, 0, 0}, 0.2)}));
    CHECK(holds(face, {-0.6, 0, 0}));
    CHECK_FALSE(holds(face, {0.4, 0, 0}));
    CHECK(holds(face, {0.1, 0.1, 0}));
    CHECK_FALSE(holds(face, {0.9, 0, 0}));
    const Real area = kPi * (kRadius * kRadius - 0.4 * 0.4 + 0.2 * 0.2);
    CHECK(face.trim()->area(face) == Approx(area).epsilon(1e-13));
    CHECK(area_of(Skin({face.surface()}, 0)) == Approx(area).epsilon(1e-13));
  }
}

TEST_CASE("areas within loops on curved faces are those of the equations") {
  // The zone of a sphere between two circles of latitude, as parameters of its polar face.
  const Surface ball = sphere({}, 1.5);
  const Range u = ball.u.domain(), v = ball.v.domain();
  const Real low = v.low + 0.3 * v.width(), high = v.low + 0.8 * v.width();
  const Vec3 corners[] = {{u.low, low, 0}, {u.high, low, 0}, {u.high, high, 0}, {u.low, high, 0}};
  Curve loop{{1, {0, 0, 1, 2, 3, 4, 4}}, {}};
  for (int k = 0; k <= 4; ++k) loop.points.emplace_back(corners[k % 4], 1);
  const Face face(trimmed(ball, loop));
  const Real height =
      evaluate(ball, u.low, high, 0)[0][0].z - evaluate(ball, u.low, low, 0)[0][0].z;
  CHECK(face.trim()->area(face) == Approx(2 * kPi * 1.5 * std::abs(height)).epsilon(1e-10));
}

TEST_CASE("nearest points of a disc and of a ring are those of the equations") {
  Random dice(5);
  const Face plate(disc()), ring(disc({circle_on_plane(Vec3(0), 0.3)}));
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = dice.in_cube(1.5);
    const Real across = std::hypot(p.x, p.y);
    const Real out = std::max(across - kRadius, 0.0), in = std::max(0.3 - across, 0.0);
    const NearestPoint one = closest_point(plate, p), two = closest_point(ring, p);
    CHECK(one.distance == Approx(std::hypot(out, p.z)).margin(1e-12));
    CHECK(one.is_on_edge == (out > 0));
    CHECK(two.distance == Approx(std::hypot(std::max(out, in), p.z)).margin(1e-12));
    CHECK(two.is_on_edge == (out > 0 || in > 0));
    CHECK(one.is_certain);
  }
}

TEST_CASE("nearest points of trimmed curved faces are no farther than any dense sample") {
  Random dice(7);
  constexpr int kSamples = 120;
  for (int round = 0; round < 6; ++round) {
    const Face face(trimmed(bumpy_surface(3, 8, 0.3, dice), blob(dice)));
    std::vector<Vec3> kept;
    for (int i = 0; i <= kSamples; ++i)
      for (int j = 0; j <= kSamples; ++j) {
        const Real u = Real(i) / kSamples, v = Real(j) / kSamples;
        if (face.holds(u, v)) kept.push_back(face.at(u, v).s);
      }
    REQUIRE(kept.size() > 500);
    for (int i = 0; i < 100; ++i) {
      const Vec3 p = face.at(0.5, 0.5).s + dice.in_cube(face.size());
      Real least = 1e300;
      for (const Vec3 s : kept) least = std::min(least, glm::distance(s, p));
      const NearestPoint near = closest_point(face, p);
      CHECK(near.distance <= least + 1e-12);
      CHECK(near.distance >= least - 0.05 * face.size());
      CHECK(face.holds(near.u, near.v));
      CHECK(glm::distance(face.at(near.u, near.v).s, near.point) < 1e-12);
    }
  }
}

TEST_CASE("a pair of surfaces ends at a trim, as at a rim") {
  const Skin ball = Skin::ellipsoid(Vec3(0.3)), plate({disc()}, 0);
  PlacePair from = closest_pair({ball, plate, at({0.1, 0, 0.3})}).at;
  Real on = 0.1, off = 0.9;
  for (int round = 0; round < 60; ++round) {
    const Real middle = (on + off) / 2;
    const CommonNormal pair = track({ball, plate, at({middle, 0, 0.3})}, from);
    const bool is_on = pair.status == ContactStatus::found;
    if (!is_on) REQUIRE(pair.status == ContactStatus::left_patch);
    (is_on ? on : off) = middle;
  }
  CHECK(on == Approx(kRadius).margin(1e-9));
  CommonNormal found[4];
  CHECK(find_contacts({ball, plate, at({0.69, 0, 0.31})}, 0.1, found) == 1);
  CHECK(find_contacts({ball, plate, at({0.71, 0, 0.31})}, 0.1, found) == 0);
  // A curve over the face: a rocker that touches at its lowest point.
  const Wire rocker(transformed(circle({}, 0.3), {Mat3(1, 0, 0, 0, 0, 1, 0, -1, 0), Vec3(0)}));
  const auto over = [&](Real x) {
    return track_on_face(rocker, plate, at({x, 0, 0.3}), {0.75, {0, (x + 1) / 2, 0.5}}).status;
  };
  CHECK(over(0.69) == ContactStatus::found);
  CHECK(over(0.71) == ContactStatus::left_patch);
}

TEST_CASE("triangles of a trimmed face cover what is kept, and end on the loops") {
  const Skin ring({disc({circle_on_plane({0.2, 0.1, 0}, 0.25)})}, 0);
  constexpr Real kChord = 1e-3;
  const Tessellation tiles = tessellate(ring, kChord);
  Real area = 0;
  for (const auto& t : tiles.triangles) {
    const Vec3 n = glm::cross(tiles.points[t[1]] - tiles.points[t[0]],
                              tiles.points[t[2]] - tiles.points[t[0]]);
    CHECK(n.z > 0);
    area += n.z / 2;
  }
  const Real whole = kPi * (kRadius * kRadius - 0.25 * 0.25);
  CHECK(area == Approx(whole).epsilon(3e-3));
  int on_rim = 0;
  for (const Vec3 p : tiles.points) {
    const Real far = std::hypot(p.x, p.y), beside = std::hypot(p.x - 0.2, p.y - 0.1);
    CHECK(far <= kRadius + 1e-9);
    CHECK(beside >= 0.25 - 1e-9);
    on_rim += std::abs(far - kRadius) < 1e-3 * kChord;
  }
  CHECK(on_rim > 40);
  CHECK_FALSE(is_closed(ring));
}

TEST_CASE("loops move with their face, also to the other side") {
  Random dice(9);
  const Surface s = trimmed(bumpy_surface(3, 6, 0.3, dice), blob(dice));
  const Pose by{{1, 2, 3}, from_rotation_vector({0.3, -0.5, 0.7})};
  const Face face(s), moved(transformed(s, affine_of(by))), back(inside_out(s));
  const Real sum = s.u.low() + s.u.high();
  for (int i = 0; i < 300; ++i) {
    const Real u = dice.between(0, 1), v = dice.between(0, 1);
    CHECK(moved.holds(u, v) == face.holds(u, v));
    CHECK(back.holds(sum - u, v) == face.holds(u, v));
  }
  CHECK(moved.trim()->area(moved) == Approx(face.trim()->area(face)).epsilon(1e-9));
}

TEST_CASE("a loop that trims nothing, or not within the face, is told in one line") {
  const auto told = [](const Curve& loop) {
    const auto errors = errors_of(trimmed(plane({}, 2, 2), loop), "the face");
    REQUIRE(errors.size() == 1);
    CHECK(errors[0].message.find('\n') == std::string::npos);
    INFO(errors[0].message);
    CHECK(errors[0].message.starts_with("the face, trim 0"));
    return errors[0].message;
  };
  const auto polygon = [](std::vector<Vec3> corners) {
    Curve c{{1, {0}}, {}};
    for (std::size_t i = 0; i < corners.size(); ++i)
      c.knots.values.push_back(Real(i)), c.points.emplace_back(corners[i], 1);
    c.knots.values.push_back(Real(corners.size() - 1));
    return c;
  };
  CHECK(errors_of(disc(), "the face").empty());
  CHECK(told(line({0.2, 0.2, 0}, {0.8, 0.2, 0})).find("is open by") != std::string::npos);
  CHECK(told(circle_on_plane({0.9, 0, 0}, 0.3)).find("leaves the domain at u = 1.1") !=
        std::string::npos);
  CHECK(told(transformed(circle({}, 0.2), {Mat3(1), {0.5, 0.5, 0.1}})).find("off the plane") !=
        std::string::npos);
  CHECK(told(polygon({{0.2, 0.2, 0}, {0.8, 0.2, 0}, {0.2, 0.2, 0}})).find("encloses nothing") !=
        std::string::npos);
  CHECK(told(polygon({{0.2, 0.2, 0}, {0.8, 0.2, 0}, {0.3, 0.6, 0}, {0.8, 0.9, 0}, {0.2, 0.2, 0}}))
            .find("crosses itself at t = ") != std::string::npos);
  Curve broken = circle_on_plane(Vec3(0), 0.2);
  broken.points[0].w = -1;
  CHECK_FALSE(errors_of(trimmed(plane({}, 2, 2), broken), "the face").empty());
}
