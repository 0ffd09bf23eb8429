// Pairs of points on a common normal: the method's vectors, closed forms, symmetries, and every way
// in which there is none.
#include "engine/nurbs/common_normal.hpp"

#include <catch2/catch.hpp>

#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/pair_descent.hpp"
#include "tests/nurbs/data.hpp"
#include "tests/nurbs/samples.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

namespace {

Pose pose_of(const json& x, const json& q) {
  return {vector_of(x), glm::normalize(Quat(q[0], q[1], q[2], q[3]))};
}

Skin single(Surface s) { return Skin({std::move(s)}, 1e-9); }

Pose at(Vec3 position) { return {position, kIdentity}; }

// Where two ellipsoids' charts face one another, roughly.
PlacePair facing(Vec3 half_a, Vec3 half_b, const Pose& a_in_b) {
  const ChartPoint a = chart_point(half_a, to_local(a_in_b, Vec3(0))),
                   b = chart_point(half_b, a_in_b.position);
  return {{a.chart, a.u, a.v}, {b.chart, b.u, b.v}};
}

const Quat kOver = from_rotation_vector({kPi, 0, 0});  // turns z down

}  // namespace

TEST_CASE("pairs and their rates are those of the method's vectors") {
  for (const json& j : nurbs_data()["closest"]) {
    const Skin a = single(surface_of(j["surface1"])), b = single(surface_of(j["surface2"]));
    const Pose p1 = pose_of(j["x1"], j["q1"]), p2 = pose_of(j["x2"], j["q2"]);
    const Pose a_in_b = compose(inverse(p2), p1);
    const json& s = j["start"];
    for (const Real off : {0.0, 0.001}) {
      const PlacePair start{{0, s[0].get<Real>() + off, s[1].get<Real>() - off},
                            {0, s[2].get<Real>() - off, s[3].get<Real>() + off}};
      const CommonNormal pair = track({a, b, a_in_b}, start);
      REQUIRE(pair.status == ContactStatus::found);
      const std::array<Real, 4> found{pair.at.a.u, pair.at.a.v, pair.at.b.u, pair.at.b.v};
      for (std::size_t i = 0; i < 4; ++i)
        CHECK(std::abs(found[i] - j["params"][i].get<Real>()) < 1e-13);
      CHECK(std::abs(pair.gap - j["gap"].get<Real>()) < 1e-14);
      CHECK(glm::distance(p2.rotation * pair.normal, vector_of(j["n2"])) < 1e-13);
      CHECK(glm::distance(to_world(p2, pair.on_a), vector_of(j["p1"])) < 1e-13);
      CHECK(glm::distance(to_world(p2, pair.on_b), vector_of(j["p2"])) < 1e-13);
      const json& t = j["twist"];
      const auto part = [&](std::size_t i) { return Vec3(t[i], t[i + 1], t[i + 2]); };
      const Vec3 v1 = part(0), w1 = part(3), v2 = part(6), w2 = part(9);
      const Quat back = glm::conjugate(p2.rotation);
      const Twist twist{back * (v1 - v2 - glm::cross(w2, p1.position - p2.position)),
                        back * (w1 - w2)};
      const auto rate = rates({a, b, a_in_b}, pair.at, twist);
      for (std::size_t i = 0; i < 4; ++i)
        CHECK(std::abs(rate[i] - j["params_rate"][i].get<Real>()) < 1e-11);
      const Vec3 slide = twist.linear + glm::cross(twist.angular, pair.on_a - a_in_b.position);
      CHECK(glm::dot(pair.normal, slide) == Approx(j["gap_rate"].get<Real>()).epsilon(1e-12));
    }
  }
}

TEST_CASE("balls are apart by the distance of their centres less both radii, or overlap by it") {
  Random dice(1);
  const Skin a = Skin::ellipsoid(Vec3(0.7)), b = Skin::ellipsoid(Vec3(1.1));
  for (const Real gap : {2.0, 0.1, 1e-4, 0.0, -1e-4, -0.1, -0.4})
    for (int i = 0; i < 20; ++i) {
      const Vec3 way = dice.direction();
      const Pose a_in_b{(1.8 + gap) * way, dice.orientation()};
      const CommonNormal pair = track({a, b, a_in_b}, facing(Vec3(0.7), Vec3(1.1), a_in_b));
      REQUIRE(pair.status == ContactStatus::found);
      CHECK(std::abs(pair.gap - gap) < 2e-15);
      CHECK(glm::distance(pair.normal, way) < 1e-14);
      CHECK(glm::distance(pair.on_b, 1.1 * way) < 2e-15);
      CHECK(glm::distance(pair.on_a, (1.1 + gap) * way) < 5e-15);
      CHECK(pair.least_curvature > 0);
      CHECK(pair.iterations <= 6);
    }
}

TEST_CASE("the pair does not depend on who is called a, nor on where both stand") {
  Random dice(2);
  const Vec3 half_a(1, 0.7, 0.5), half_b(0.8, 1.1, 0.6);
  const Skin a = Skin::ellipsoid(half_a), b = Skin::ellipsoid(half_b);
  for (int i = 0; i < 50; ++i) {
    const Pose a_in_b{2.2 * dice.direction(), dice.orientation()};
    const ClosestPair near = closest_pair({a, b, a_in_b});
    const CommonNormal one = track({a, b, a_in_b}, near.at);
    const CommonNormal two = track({b, a, inverse(a_in_b)}, {near.at.b, near.at.a});
    REQUIRE(one.status == ContactStatus::found);
    REQUIRE(two.status == ContactStatus::found);
    CHECK(std::abs(one.gap - near.distance) < 1e-14);
    CHECK(std::abs(one.gap - two.gap) < 1e-14);
    CHECK(glm::distance(to_world(a_in_b, two.on_a), one.on_b) < 1e-13);
    CHECK(glm::distance(a_in_b.rotation * two.normal, -one.normal) < 1e-13);
    // Along the normal only the gap changes, and by as much.
    const Pose off{a_in_b.position + 0.05 * one.normal, a_in_b.rotation};
    const CommonNormal moved = track({a, b, off}, one.at);
    CHECK(std::abs(moved.gap - one.gap - 0.05) < 1e-14);
    CHECK(std::abs(moved.at.a.u - one.at.a.u) < 1e-13);
    CHECK(std::abs(moved.at.b.v - one.at.b.v) < 1e-13);
  }
}

TEST_CASE("a ball that runs around an ellipsoid is followed across all charts") {
  const Vec3 half(1, 0.7, 0.5);
  const Skin ball = Skin::ellipsoid(Vec3(0.2)), egg = Skin::ellipsoid(half);
  for (const Real tilt : {0.0, 0.4, 1.1}) {
    const Quat plane = from_rotation_vector({tilt, 0, 0.3 * tilt});
    std::array<bool, 6> has_seen{};
    PlacePair places;
    int most = 0;
    for (int i = 0; i <= 720; ++i) {
      // On the outer parallel of the ellipsoid at 0.25: the ball's gap is 0.05.
      const Vec3 d = half * (plane * Vec3(std::cos(i * kPi / 180), std::sin(i * kPi / 180), 0));
      const Vec3 n = glm::normalize(d / (half * half));
      const Pose a_in_b{d + 0.25 * n, from_rotation_vector(0.01 * i * Vec3(1, 2, 0.5))};
      if (i == 0) places = closest_pair({ball, egg, a_in_b}).at;
      const CommonNormal pair = track_newton({ball, egg, a_in_b}, places);
      REQUIRE(pair.status == ContactStatus::found);
      CHECK(std::abs(pair.gap - 0.05) < 1e-14);
      CHECK(glm::distance(pair.on_b, d) < 1e-13);
      places = pair.at, most = std::max(most, pair.iterations);
      has_seen[static_cast<std::size_t>(pair.at.b.face)] = true;
    }
    CHECK(std::count(has_seen.begin(), has_seen.end(), true) >= 4);
    CHECK(most <= 7);
  }
}

TEST_CASE("the rates foretell where the pair goes, to second order") {
  const Skin ball = Skin::ellipsoid({0.3, 0.2, 0.25}), egg = Skin::ellipsoid({1, 0.7, 0.5});
  const Pose start{{0.3, 0.2, 0.9}, from_rotation_vector({0.2, 0.4, 0})};
  const CommonNormal first = track({ball, egg, start}, closest_pair({ball, egg, start}).at);
  const Twist twist{{0.3, -0.2, 0.1}, {0.5, 1, -0.7}};
  const auto rate = rates({ball, egg, start}, first.at, twist);
  Real error[2] = {};
  for (int k = 0; k < 2; ++k) {
    const Real h = k == 0 ? 1e-2 : 5e-3;
    const Pose later{start.position + h * twist.linear,
                     from_rotation_vector(h * twist.angular) * start.rotation};
    const CommonNormal then = track({ball, egg, later}, first.at);
    const PlacePair guess = predicted({ball, egg, start}, first.at, rate, h);
    error[k] =
        std::hypot(then.at.a.u - guess.a.u, then.at.a.v - guess.a.v, then.at.b.u - guess.b.u);
  }
  CHECK(error[0] < 1e-3);
  CHECK(error[1] < error[0] / 3.5);
  CHECK(error[1] > error[0] / 4.5);
}

TEST_CASE("over the rim of a face there is no phantom contact; a neighbour takes over") {
  const Skin ball = Skin::ellipsoid(Vec3(0.3));
  const Surface left = plane({{-1, 0, 0}}, 2, 2), right = plane({{1, 0, 0}}, 2, 2);
  const Skin lone = single(left), both({left, right}, 1e-9);
  CHECK(both.neighbour(0, Edge::u_high) == 1);
  CHECK(both.neighbour(1, Edge::u_low) == 0);
  CHECK_FALSE(both.neighbour(0, Edge::v_low));
  PlacePair start = closest_pair({ball, lone, at({-0.5, 0.2, 0.3})}).at;
  const CommonNormal on = track({ball, lone, at({-0.5, 0.2, 0.3})}, start);
  REQUIRE(on.status == ContactStatus::found);
  CHECK(on.gap == Approx(0).margin(1e-15));
  const CommonNormal off = track({ball, lone, at({0.1, 0.2, 0.3})}, on.at);
  CHECK(off.status == ContactStatus::left_patch);
  CHECK(word_of(off.status) == std::string("ContactLeftPatch"));
  const CommonNormal over = track({ball, both, at({0.1, 0.2, 0.3})}, on.at);
  REQUIRE(over.status == ContactStatus::found);
  CHECK(over.at.b.face == 1);
  CHECK(glm::distance(over.on_b, {0.1, 0.2, 0}) < 1e-14);
  // The pair of least distance ends at the rim, and says so.
  const ClosestPair rim = closest_pair({ball, lone, at({0.1, 0.2, 0.3})});
  CHECK(rim.is_on_edge);
  CHECK(rim.distance == Approx(std::hypot(0.1, 0.3) - 0.3));
}

TEST_CASE("faces that join backwards, and with other parameters, are crossed too") {
  const Skin ball = Skin::ellipsoid(Vec3(0.3));
  const Surface left = plane({{-1, 0, 0}}, 2, 2);
  // Its v runs the other way, and its parameter along the shared edge is bent.
  Surface right = plane({{1, 0, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}, 2, 2);
  for (std::size_t i = 0; i < right.points.size(); i += 2) right.points[i] = 3.0 * right.points[i];
  const Skin both({left, right}, 1e-9);
  REQUIRE(both.neighbour(0, Edge::u_high) == 1);
  CommonNormal pair = track({ball, both, at({-0.5, 0.7, 0.3})},
                            closest_pair({ball, both, at({-0.5, 0.7, 0.3})}).at);
  for (int i = 0; i <= 20; ++i) {
    const Vec3 centre(-0.5 + 0.06 * i, 0.7, 0.3);
    pair = track_newton({ball, both, at(centre)}, pair.at);
    REQUIRE(pair.status == ContactStatus::found);
    CHECK(glm::distance(pair.on_b, Vec3(centre.x, centre.y, 0)) < 1e-13);
  }
  CHECK(pair.at.b.face == 1);
}

TEST_CASE("poles and surfaces that fit one another are told, not divided by") {
  const Skin ball = Skin::ellipsoid(Vec3(0.3)), poled = single(sphere({}, 1));
  const CommonNormal pole = track({ball, poled, at({0, 0, 1.3})}, {{5, 0, 0}, {0, 0.2, 1}});
  CHECK(pole.status == ContactStatus::singular);
  const Skin floor = single(plane({}, 4, 4)), slab = single(plane({}, 1, 1));
  const CommonNormal flat =
      track({slab, floor, {{0.1, 0, 0.2}, kOver}}, {{0, 0.5, 0.5}, {0, 0.5, 0.5}});
  CHECK(flat.status == ContactStatus::degenerate);
  // A ball in its own socket: a sphere that looks inwards.
  Surface hollow = charts(Vec3(0.3))[5];
  for (Weighted& w : hollow.points) w = {w.x, -w.y, w.z, w.w};
  const Skin socket = single(hollow);
  const CommonNormal fit = track({ball, socket, at(Vec3(0))}, {{5, 0.01, 0}, {0, 0, 0}});
  CHECK(fit.status == ContactStatus::degenerate);
}

TEST_CASE("every hump of a sheet on a floor is a contact, and no other place") {
  Random dice(3);
  for (int trial = 0; trial < 10; ++trial) {
    const Surface humps = bumpy_surface(3, 9, 0.2, dice);
    const Skin sheet = single(humps), floor = single(plane({}, 6, 6));
    // Turned over: its humps hang down.
    const Pose a_in_b{{0, 0, 0.1}, kOver};
    std::vector<Vec3> tops;  // of samples; along a ridge there may be several of one
    constexpr int n = 400;
    std::vector<Real> z;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) z.push_back(sheet.face(0).at(i / Real(n), j / Real(n)).s.z);
    for (int i = 1; i < n; ++i)
      for (int j = 1; j < n; ++j) {
        const auto height = [&](int k, int l) {
          return z[static_cast<std::size_t>(k * (n + 1) + l)];
        };
        bool is_top = true;
        for (int k = -1; k <= 1; ++k)
          for (int l = -1; l <= 1; ++l)
            is_top &= (k == 0 && l == 0) || height(i, j) > height(i + k, j + l);
        const Vec3 top(i, j, 0);
        const auto is_near = [&](Vec3 other) { return glm::distance(other, top) < 0.02 * n; };
        if (is_top && std::none_of(tops.begin(), tops.end(), is_near)) tops.push_back(top);
      }
    std::array<CommonNormal, 64> found;
    const std::size_t count = find_contacts({sheet, floor, a_in_b}, 1, found);
    CHECK(count == tops.size());
    for (std::size_t i = 0; i < count; ++i) {
      CHECK(glm::distance(found[i].normal, {0, 0, 1}) < 1e-13);
      if (i > 0) CHECK(found[i - 1].gap <= found[i].gap);
    }
    CHECK(find_contacts({sheet, floor, a_in_b}, 1, std::span(found).first(1)) == 1);
  }
}

TEST_CASE("closest pairs are those of dense samples") {
  Random dice(4);
  for (int trial = 0; trial < 40; ++trial) {
    const Skin a =
        trial % 2 == 0 ? Skin::ellipsoid({1, 0.7, 0.5}) : single(bumpy_surface(3, 7, 0.3, dice));
    const Skin b =
        trial % 4 < 2 ? single(bumpy_surface(3, 7, 0.3, dice)) : single(torus({}, 1, 0.3));
    const Pose a_in_b{2.5 * dice.direction(), dice.orientation()};
    const ClosestPair found = closest_pair({a, b, a_in_b});
    CHECK(glm::distance(found.on_a, found.on_b) == Approx(found.distance));
    Real least = 1e300;
    constexpr int n = 7;
    const auto share = [](const Knots& k, int i) {
      return k.low() + k.domain().width() * i / (n - 1);
    };
    for (int f = 0; f < static_cast<int>(a.faces().size()); ++f)
      for (int i = 0; i < n * n; ++i)
        for (int j = 0; j < n * n; ++j) {
          const PlacePair start{{f, share(a.face(f).u(), i / n), share(a.face(f).v(), i % n)},
                                {0, share(b.face(0).u(), j / n), share(b.face(0).v(), j % n)}};
          const Vec3 p = to_world(a_in_b, a.face(f).at(start.a.u, start.a.v).s);
          const Vec3 q = b.face(0).at(start.b.u, start.b.v).s;
          if (glm::distance(p, q) > found.distance + 0.5) continue;
          least = std::min(least, descend({a, b, a_in_b}, start).distance);
        }
    CHECK(std::abs(found.distance - least) < 1e-9);
  }
}
