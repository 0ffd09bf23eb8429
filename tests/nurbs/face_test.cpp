// The fast evaluation and the bounds of a face against the plain evaluation.
#include "engine/nurbs/face.hpp"

#include <catch2/catch.hpp>

#include "engine/nurbs/makers.hpp"
#include "tests/nurbs/data.hpp"
#include "tests/nurbs/samples.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

namespace {

// The worst difference of the derivatives, relative to the largest of their order or 1.
Real jet_error(const Jet& j, const SurfaceDerivatives& d) {
  const auto off = [](Vec3 a, Vec3 b) {
    return glm::distance(a, b) / std::max(1.0, glm::length(b));
  };
  return std::max({off(j.s, d[0][0]), off(j.u, d[1][0]), off(j.v, d[0][1]), off(j.uu, d[2][0]),
                   off(j.uv, d[1][1]), off(j.vv, d[0][2])});
}

std::vector<Surface> all_surfaces(Random& dice) {
  std::vector<Surface> all{sphere({}, 1.5), torus({}, 2, 0.6), cylinder({}, 1, 2), plane({}, 1, 2)};
  for (int p = 1; p <= 5; ++p)
    for (int q = 1; q <= 5; ++q) all.push_back(random_surface(p, q, p + 4, q + 3, dice));
  for (const Surface& s : charts({1, 0.7, 0.5})) all.push_back(s);
  return all;
}

}  // namespace

TEST_CASE("a face evaluates what its surface does, at knots and ends too") {
  Random dice(1);
  for (const Surface& s : all_surfaces(dice)) {
    const Face face(s);
    Real most = 0;
    for (int i = 0; i < 200; ++i) {
      const Real u = s.u.low() + s.u.domain().width() * dice.between(0, 1);
      const Real v = s.v.low() + s.v.domain().width() * dice.between(0, 1);
      most = std::max(most, jet_error(face.at(u, v), evaluate(s, u, v, 2)));
    }
    for (Real u : s.u.breaks())
      for (Real v : s.v.breaks())
        most = std::max(most, jet_error(face.at(u, v), evaluate(s, u, v, 2)));
    CHECK(most < 1e-13);
  }
}

TEST_CASE("a face evaluates the method's vectors") {
  for (const json& j : nurbs_data()["nurbs_eval"]) {
    const Jet jet = Face(surface_of(j["surface"])).at(j["u"], j["v"]);
    const auto off = [&](Vec3 found, const char* key) {
      const Vec3 e = vector_of(j["derivs"][key]);
      return glm::distance(found, e) / std::max(1.0, glm::length(e));
    };
    CHECK(off(jet.s, "00") < 1e-13);
    CHECK(off(jet.u, "10") < 1e-13);
    CHECK(off(jet.v, "01") < 1e-13);
    CHECK(off(jet.uu, "20") < 1e-13);
    CHECK(off(jet.uv, "11") < 1e-13);
    CHECK(off(jet.vv, "02") < 1e-13);
  }
}

TEST_CASE("a face of a sphere is round to the last digits, its seam smooth") {
  const Face face(sphere({}, 1.5));
  Real most = 0;
  for (int i = 0; i <= 100; ++i)
    for (int j = 0; j <= 100; ++j)
      most = std::max(most, std::abs(glm::length(face.at(i / 100.0, j / 100.0).s) / 1.5 - 1));
  CHECK(most <= 1e-15);
  for (int j = 1; j < 20; ++j) {
    const Jet before = face.at(1, j / 20.0), after = face.at(0, j / 20.0);
    CHECK(glm::distance(before.s, after.s) < 1e-15);
    CHECK(glm::distance(before.u, after.u) < 1e-13);
    CHECK(glm::distance(before.v, after.v) < 1e-13);
  }
}

TEST_CASE("normals are square to differences along the surface") {
  Random dice(2);
  const Face face(bumpy_surface(3, 8, 0.3, dice));
  for (int i = 0; i < 200; ++i) {
    const Real u = dice.between(0.01, 0.99), v = dice.between(0.01, 0.99), h = 1e-6;
    const Jet j = face.at(u, v);
    const Vec3 n = glm::normalize(glm::cross(j.u, j.v));
    const Real angle = dice.between(0, 2 * kPi), x = h * std::cos(angle), y = h * std::sin(angle);
    const Vec3 way = face.at(u + x, v + y).s - face.at(u - x, v - y).s;
    CHECK(std::abs(glm::dot(n, way)) < 1e-8 * glm::length(way));
  }
}

TEST_CASE("the bounds of all cells hold") {
  Random dice(3);
  for (const Surface& s : all_surfaces(dice)) {
    const Face face(s);
    Real area = 0;
    for (const nurbs::Leaf& leaf : face.leaves()) {
      area += leaf.u.width() * leaf.v.width();
      const Real hu = leaf.u.width() / 2, hv = leaf.v.width() / 2;
      for (int i = 0; i < 12; ++i) {
        const Real u = leaf.u.middle() + hu * dice.between(-1, 1),
                   v = leaf.v.middle() + hv * dice.between(-1, 1);
        const SurfaceDerivatives d = evaluate(s, u, v, 3);
        const Vec3 off = d[0][0] - leaf.centre;
        CHECK(glm::length(off) <= leaf.radius);
        CHECK(std::abs(glm::dot(off, leaf.normal)) <= leaf.half_thickness);
        const Vec3 n = glm::cross(d[1][0], d[0][1]);
        if (leaf.turn < kPi)
          CHECK(glm::dot(n, leaf.normal) >= std::cos(leaf.turn) * glm::length(n) * (1 - 1e-12));
        for (std::size_t order = 1; order <= 3; ++order)
          for (std::size_t l = 0; l <= order; ++l) {
            const Real* const bounds[] = {leaf.first, leaf.second, leaf.third};
            const Real size = glm::length(d[order - l][l]) * std::pow(hu, Real(order - l)) *
                              std::pow(hv, Real(l));
            CHECK(size <= bounds[order - 1][l] * (1 + 1e-12) + 1e-13 * face.size());
          }
      }
    }
    CHECK(area == Approx(s.u.domain().width() * s.v.domain().width()));
  }
}
