// Triangles that stand for skins, and what skins enclose, against closed forms.
#include "engine/nurbs/tessellate.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <tuple>

#include "engine/nurbs/closest.hpp"
#include "engine/nurbs/makers.hpp"
#include "tests/nurbs/samples.hpp"

using namespace pantin;
using namespace pantin::detail::nurbs;

namespace {

constexpr Frame kFrame;

/// A closed can: side, floor and lid, each with degenerate or joined edges.
Skin can(Real radius, Real height) {
  const auto disc = [&](Real z) { return revolved(line({0, 0, z}, {radius, 0, z}), {}, 2 * kPi); };
  return Skin({cylinder({}, radius, height), disc(0), inside_out(disc(height))}, 1e-9);
}

/// How often each edge, by its points to the bit, is there in one direction and the other.
std::size_t open_edges(const Tessellation& t) {
  using Bits = std::array<std::uint64_t, 3>;
  const auto bits = [&](std::uint32_t i) {
    Bits b;
    const Vec3 p = t.points[i] + Vec3(0);  // -0 is 0
    std::memcpy(b.data(), &p, sizeof b);
    return b;
  };
  std::map<std::pair<Bits, Bits>, int> edges;
  for (const auto& tile : t.triangles)
    for (int k = 0; k < 3; ++k) ++edges[{bits(tile[k]), bits(tile[(k + 1) % 3])}];
  std::size_t open = 0;
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    open += back == edges.end() || back->second != count;
  }
  return open;
}

Real volume_of(const Tessellation& t) {
  Real six = 0;
  for (const auto& tile : t.triangles)
    six += glm::dot(t.points[tile[0]], glm::cross(t.points[tile[1]], t.points[tile[2]]));
  return six / 6;
}

}  // namespace

TEST_CASE("skins are cut into triangles without cracks, near the surface", "[nurbs]") {
  const std::pair<const char*, Skin> skins[] = {
      {"sphere", Skin({sphere(kFrame, 0.5)}, 1e-9)},
      {"charts", Skin::ellipsoid({0.5, 0.3, 0.2})},
      {"torus", Skin({torus(kFrame, 0.5, 0.2)}, 1e-9)},
      {"can", can(0.3, 0.7)},
  };
  for (const auto& [name, skin] : skins) {
    CAPTURE(name);
    REQUIRE(is_closed(skin));
    std::size_t before = 0;
    for (const Real chord : {1e-2, 1e-3, 1e-4}) {
      const Tessellation t = tessellate(skin, chord);
      CHECK(open_edges(t) == 0);
      Real most = 0;
      for (const auto& tile : t.triangles) {
        const Vec3 middle = (t.points[tile[0]] + t.points[tile[1]] + t.points[tile[2]]) / 3.0;
        Real near = 1e300;
        for (const Face& face : skin.faces())
          near = std::min(near, closest_point(face, middle).distance);
        most = std::max(most, near);
        const Vec3 wide = glm::cross(t.points[tile[1]] - t.points[tile[0]],
                                     t.points[tile[2]] - t.points[tile[0]]);
        REQUIRE(glm::dot(wide, t.normals[tile[0]]) > 0);
      }
      CHECK(most < chord);
      const Real volume = volume_of(t), whole = enclosed_by(skin).volume;
      CHECK(std::abs(volume - whole) < 30 * chord * whole);
      CHECK(t.triangles.size() > before);
      before = t.triangles.size();
    }
  }
}

TEST_CASE("an open patch is no closed skin, and is cut to its rim", "[nurbs]") {
  const Skin sheet({plane(kFrame, 2, 1)}, 1e-9);
  CHECK_FALSE(is_closed(sheet));
  CHECK(area_of(sheet) == Approx(2).epsilon(1e-14));
  const Tessellation t = tessellate(sheet, 1e-3);
  Real area = 0;
  for (const auto& tile : t.triangles)
    area += glm::length(glm::cross(t.points[tile[1]] - t.points[tile[0]],
                                   t.points[tile[2]] - t.points[tile[0]])) /
            2;
  CHECK(area == Approx(2).epsilon(1e-12));
  CHECK(open_edges(t) == 12);  // three pieces a side
}

TEST_CASE("what skins enclose agrees with closed forms to 1e-12", "[nurbs]") {
  const auto check = [](const Skin& skin, Real volume, Vec3 centre, Vec3 squares) {
    const Enclosed in = enclosed_by(skin);
    CHECK(in.by.doubt == 0);
    CHECK(std::abs(in.volume - volume) < 1e-12 * volume);
    const Real size = std::cbrt(volume);
    CHECK(glm::distance(in.first / in.volume, centre) < 1e-12 * size);
    for (int k = 0; k < 3; ++k) {
      const Real own = in.second[k][k] - volume * centre[k] * centre[k];
      CHECK(std::abs(own / volume - squares[k]) < 1e-12 * size * size);
    }
  };
  const Real r = 0.4;
  const Vec3 away(3, -2, 1);
  Frame at;
  at.origin = away;
  check(Skin({sphere(at, r)}, 1e-9), 4 * kPi / 3 * r * r * r, away, Vec3(r * r / 5));
  const Vec3 h(0.5, 0.3, 0.2);
  const Real v = 4 * kPi / 3 * h.x * h.y * h.z;
  check(Skin::ellipsoid(h), v, Vec3(0), h * h / 5.0);
  check(Skin({ellipsoid(at, h)}, 1e-9), v, away, h * h / 5.0);
  const Real big = 0.5, small = 0.2;
  const Real across = big * big / 2 + 3 * small * small / 8;
  check(Skin({torus(at, big, small)}, 1e-9), 2 * kPi * kPi * big * small * small, away,
        Vec3(across, across, small * small / 4));
  check(can(0.3, 0.7), kPi * 0.09 * 0.7, Vec3(0, 0, 0.35), Vec3(0.09 / 4, 0.09 / 4, 0.49 / 12));
  // A cut-off cone, whose centre is in the middle of nothing.
  const Real wide = 0.3, narrow = 0.1, tall = 0.8;
  const auto disc = [](Real out, Real z) {
    return revolved(line({0, 0, z}, {out, 0, z}), {}, 2 * kPi);
  };
  const Enclosed in = enclosed_by(
      Skin({cone({}, {wide, narrow}, tall), disc(wide, 0), inside_out(disc(narrow, tall))}, 1e-9));
  const Real sum = wide * wide + wide * narrow + narrow * narrow;
  CHECK(in.volume == Approx(kPi * tall / 3 * sum).epsilon(1e-12));
  const Real high = tall / 4 * (wide * wide + 2 * wide * narrow + 3 * narrow * narrow) / sum;
  CHECK(glm::distance(in.first / in.volume, {0, 0, high}) < 1e-12);
  CHECK(area_of(Skin({torus(at, big, small)}, 1e-9)) ==
        Approx(4 * kPi * kPi * big * small).epsilon(1e-12));
  CHECK(area_of(Skin::ellipsoid(Vec3(r))) == Approx(4 * kPi * r * r).epsilon(1e-12));
}

TEST_CASE("quadrature of a wild skin comes to an end, and says how far it may be off", "[nurbs]") {
  test::Random dice(5);
  Surface wild = test::random_surface(3, 3, 16, 16, dice);
  for (Weighted& p : wild.points) p = Weighted(p.point(), std::pow(10, dice.between(-6, 0)));
  const std::size_t pieces = wild.u.spans().size() * wild.v.spans().size();
  Surface finer = wild;
  for (const Along way : {Along::u, Along::v}) {
    const std::vector<Real> breaks = knots_of(wild, way).breaks();
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
      finer = with_knot(finer, way, (breaks[i] + breaks[i + 1]) / 2, 1);
  }
  const Skin skin({wild}, 1e-9), parts({finer}, 1e-9);
  Quadrature by, by_parts;
  const Real area = area_of(skin, &by), area_by_parts = area_of(parts, &by_parts);
  const Enclosed in = enclosed_by(skin), in_parts = enclosed_by(parts);
  // Of each piece three rules and its quarters; 300 cuts, each into four that have quarters.
  const std::size_t most = pieces * (16 + 64 + 144 + 1024) + 4 * 300 * 1024;
  CHECK(static_cast<std::size_t>(by.looks) < most);
  CHECK(static_cast<std::size_t>(in.by.looks) < most);
  CHECK(by.doubt > 1e-3 * area);
  CHECK(in.by.doubt > 1e-3 * std::abs(in.volume));
  CHECK(std::abs(area - area_by_parts) < by.doubt + by_parts.doubt);
  CHECK(std::abs(in.volume - in_parts.volume) < in.by.doubt + in_parts.by.doubt);
}
