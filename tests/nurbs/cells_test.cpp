// Bounds of cells hold for certain, and what is long is searched as fast as what is short.
#include "engine/nurbs/cells.hpp"

#include <catch2/catch.hpp>

#include "engine/nurbs/bounds.hpp"
#include "engine/nurbs/common_normal.hpp"
#include "engine/nurbs/curve_pair.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/pair_descent.hpp"
#include "tests/nurbs/dense.hpp"
#include "tests/nurbs/long.hpp"

namespace pantin::test {
namespace {

// Contacts from a grid of starts on both.
std::vector<CommonNormal> contacts_by_grid(const Meeting& of, Real reach, int each) {
  std::vector<CommonNormal> all;
  const auto starts = [&](const Skin& skin) {
    std::vector<Place> places;
    for (int f = 0; f < static_cast<int>(skin.faces().size()); ++f) {
      const Range u = skin.face(f).u().domain(), v = skin.face(f).v().domain();
      for (int i = 0; i < each; ++i)
        for (int j = 0; j < each; ++j)
          places.push_back(
              {f, u.low + u.width() * (i + 0.5) / each, v.low + v.width() * (j + 0.5) / each});
    }
    return places;
  };
  const std::vector<Place> on_b = starts(of.b);
  for (const Place& a : starts(of.a))
    for (const Place& b : on_b) {
      const CommonNormal found = track_newton(of, {a, b});
      if (found.status == ContactStatus::found && std::abs(found.gap) <= reach &&
          found.least_curvature > 0)
        all.push_back(found);
    }
  return all;
}

bool is_among(std::span<const CommonNormal> all, const CommonNormal& one, Real alike) {
  return std::any_of(all.begin(), all.end(), [&](const CommonNormal& o) {
    return glm::distance(o.on_a, one.on_a) < alike && glm::distance(o.on_b, one.on_b) < alike;
  });
}

}  // namespace

TEST_CASE("points and normals of every cell are within its bounds, and those of its branch",
          "[nurbs]") {
  Random dice(21);
  std::vector<Face> faces;
  for (int trial = 0; trial < 10; ++trial) faces.push_back(random_face(trial, dice));
  for (Named& n : long_surfaces()) faces.emplace_back(std::move(n.surface));
  faces.emplace_back(bumpy_surface(7, 9, 0.2, dice));
  for (const Face& face : faces) {
    const Standing as_it_is;
    std::vector<std::uint32_t> parent(face.regions().size(), 0);
    for (std::uint32_t i = 0; i < face.regions().size(); ++i) {
      const BallTree::Node& node = face.tree().nodes()[i];
      if (!node.is_leaf) parent[node.first] = parent[node.first + 1] = i;
    }
    for (std::uint32_t i = 0; i < face.regions().size(); ++i) {
      if (!face.tree().nodes()[i].is_leaf) continue;
      const nurbs::Leaf& leaf = face.leaves()[face.tree().nodes()[i].first];
      const PatchCell whole = cell_of(face, leaf, as_it_is);
      PatchCell part = half_of(whole, static_cast<int>(i % 2), as_it_is);
      part = half_of(part, static_cast<int>(i / 2 % 2), as_it_is);
      const Real room = 1e-12 * face.size();
      for (int k = 0; k < 9; ++k) {
        const PatchCell& cell = k % 2 == 0 ? whole : part;
        const Real u = dice.between(cell.u.low, cell.u.high),
                   v = dice.between(cell.v.low, cell.v.high);
        const SurfaceDerivatives d = evaluate(face.surface(), u, v, 1);
        const Vec3 n = glm::cross(d[1][0], d[0][1]), off = d[0][0] - cell.centre;
        const Real x = (u - cell.u.middle()) / (cell.u.width() / 2),
                   y = (v - cell.v.middle()) / (cell.v.width() / 2);
        REQUIRE(glm::length(off - x * cell.along_u - y * cell.along_v) <= cell.sag + room);
        REQUIRE(glm::length(off) <= (k % 2 == 0 ? leaf.radius : 1e300));
        const auto angle_to = [&](Vec3 axis) {
          return std::atan2(glm::length(glm::cross(axis, n)), glm::dot(axis, n));
        };
        if (glm::length(n) > 1e-9) REQUIRE(angle_to(cell.normal) <= cell.turn + 1e-6);
        for (std::uint32_t up = i;; up = parent[up]) {
          const Region& region = face.regions()[up];
          REQUIRE(region.distance(d[0][0]) <= room);
          if (glm::length(n) > 1e-9 && region.turn < kPi)
            REQUIRE(angle_to(region.normal) <= region.turn + 1e-6);
          if (up == 0) break;
        }
      }
    }
  }
}

TEST_CASE("no bound discards cells that hold a pair on a common normal", "[nurbs]") {
  Random dice(26);
  std::vector<Skin> skins;
  for (int trial = 0; trial < 10; ++trial)
    skins.push_back(single(random_face(trial, dice).surface()));
  for (const Named& n : long_surfaces()) skins.push_back(single(n.surface));
  skins.push_back(Skin::ellipsoid({0.2, 0.3, 0.15}));
  /// The cells that a place is in, from its leaf down to a sixteenth of that.
  const auto cells_at = [](const Skin& skin, const Place& at, const Standing& standing) {
    std::vector<PatchCell> cells;
    const Face& face = skin.face(at.face);
    const auto holds = [&](const auto& cell) { return cell.u.holds(at.u) && cell.v.holds(at.v); };
    const auto leaf = std::find_if(face.leaves().begin(), face.leaves().end(), holds);
    cells.push_back(cell_of(face, *leaf, standing));
    for (int i = 0; i < 4; ++i) {
      const PatchCell half = half_of(cells.back(), 0, standing);
      cells.push_back(holds(half) ? half : half_of(cells.back(), 1, standing));
    }
    return cells;
  };
  for (int trial = 0; trial < 4000; ++trial) {
    const Skin &a = skins[dice.below(skins.size())], &b = skins[dice.below(skins.size())];
    const Spot on_a = spot_on(a, dice), on_b = spot_on(b, dice);
    // By gaps from far below what cells measure to far above.
    const Real gap = std::pow(10, dice.between(-4, 0)) * (trial % 2 == 0 ? 1 : -1);
    const Pose a_in_b = standing(on_a, on_b, gap, dice);
    const Standing of_a{glm::mat3_cast(a_in_b.rotation), a_in_b.position};
    const Real reach = std::abs(gap) * (1 + 1e-9) + 1e-9;
    const std::vector<PatchCell> own = cells_at(a, on_a.place, of_a);
    for (const PatchCell& x : own)
      for (const PatchCell& y : cells_at(b, on_b.place, {})) {
        REQUIRE(may_face(x, y, reach));
        REQUIRE(least_distance(x, y, on_b.normal) <= reach);
      }
    REQUIRE(may_face(a.face(on_a.place.face).regions()[0], b.face(on_b.place.face).regions()[0],
                     of_a, reach));
  }
}

TEST_CASE("contacts of long surfaces are found with few looks, and none is left out", "[nurbs]") {
  Random dice(22);
  const Skin ball = Skin::ellipsoid({0.02, 0.03, 0.015});
  const Skin rod = single(cylinder({}, 0.005, 2)), bar = single(extruded(cam(40, 0.05), {0, 0, 2}));
  for (const Named& n : long_surfaces()) {
    const Skin b = single(n.surface);
    for (const Skin* a : {&ball, &rod, &bar}) {
      int pairs = 0, starts = 0;
      constexpr int kTrials = 20;
      for (int trial = 0; trial < kTrials; ++trial) {
        const Pose a_in_b = standing_on(*a, b, 1e-4, dice);
        const Meeting of{*a, b, a_in_b};
        std::array<CommonNormal, 16> found;
        SearchCost cost;
        const Real reach = std::min(n.reach, 0.01);
        const std::size_t count = find_contacts(of, reach, found, &cost);
        pairs += cost.pairs, starts += cost.starts;
        if (trial % 5 != 0) continue;
        for (const CommonNormal& one : contacts_by_grid(of, reach, a == &ball ? 3 : 7)) {
          INFO(n.name << ": gap " << one.gap << ", curvature " << one.least_curvature);
          CHECK(is_among(std::span(found).first(count), one, 1e-6 * b.size()));
        }
      }
      INFO(n.name << ": " << pairs / kTrials << " pairs, " << starts / kTrials << " starts");
      CHECK(pairs / kTrials < 4500);
      CHECK(starts / kTrials < 60);
    }
  }
}

TEST_CASE("contacts of random sheets are those of a grid of starts", "[nurbs]") {
  Random dice(23);
  const Skin ball = Skin::ellipsoid({0.2, 0.3, 0.15});
  int brute = 0;
  for (int trial = 0; trial < 24; ++trial) {
    const Skin sheet = trial % 4 == 3 ? single(random_surface(2, 2, 5, 5, dice))
                                      : single(bumpy_surface(2 + trial % 4, 8, 0.3, dice));
    const Skin other = trial % 2 == 0 ? Skin(ball) : single(bumpy_surface(3, 7, 0.3, dice));
    const Meeting of{other, sheet, standing_on(other, sheet, 1e-3, dice)};
    std::array<CommonNormal, 64> found;
    const std::size_t count = find_contacts(of, 0.1, found);
    REQUIRE(count < found.size());
    for (const CommonNormal& one : contacts_by_grid(of, 0.1, trial % 2 == 0 ? 5 : 9)) {
      ++brute;
      INFO(trial << ": gap " << one.gap << ", curvature " << one.least_curvature);
      CHECK(is_among(std::span(found).first(count), one, 1e-5));
    }
  }
  CHECK(brute > 100);
}

TEST_CASE("closest pairs and nearest points of long surfaces take few looks", "[nurbs]") {
  Random dice(24);
  const Skin ball = Skin::ellipsoid({0.02, 0.03, 0.015});
  for (const Named& n : long_surfaces()) {
    const Skin b = single(n.surface);
    int starts = 0;
    std::uint32_t looks = 0;
    Dense dense(b.face(0), 6);
    constexpr int kTrials = 10;
    for (int trial = 0; trial < kTrials; ++trial) {
      const Pose a_in_b = standing_on(ball, b, 0.01, dice);
      const Meeting of{ball, b, a_in_b};
      const ClosestPair found = closest_pair(of);
      starts += found.cost.starts;
      CHECK(std::abs(found.distance - glm::distance(found.on_a, found.on_b)) < 1e-12);
      CHECK(found.distance <= 0.01 + 1e-12);
      for (int k = 0; k < 200; ++k) {
        const Spot p = spot_on(ball, dice);
        CHECK(closest_point(b.face(0), to_world(a_in_b, p.at)).distance >=
              found.distance * (1 - 1e-9));
      }
      const Vec3 p = spot_on(b, dice).at + 0.1 * dice.in_cube(1);
      const NearestPoint near = closest_point(b.face(0), p);
      looks += near.looks;
      CHECK(near.is_certain);
      CHECK(near.distance <= dense.closest(p).distance * (1 + 1e-9));
    }
    INFO(n.name << ": " << starts / kTrials << " descents, " << looks / kTrials << " looks");
    CHECK(starts / kTrials < 800);
    CHECK(looks / kTrials < 250);
  }
}

TEST_CASE("curves over long surfaces touch them where they were laid", "[nurbs]") {
  Random dice(25);
  const Wire rod(line({-1, 0, 0}, {1, 0, 0}));
  for (const Named& n : long_surfaces()) {
    const Skin b = single(n.surface);
    int pairs = 0, starts = 0;
    constexpr int kTrials = 20;
    for (int trial = 0; trial < kTrials; ++trial) {
      // Above the hull of a convex one, across it.
      const Spot spot = spot_on(b, dice);
      const Vec3 way = glm::normalize(glm::cross(spot.normal, dice.direction()));
      const Vec3 across = glm::cross(spot.normal, way);
      const Quat turn = glm::quat_cast(Mat3(way, across, spot.normal));
      const Pose a_in_b{spot.at + 1e-4 * spot.normal - dice.between(-0.4, 0.4) * way,
                        glm::normalize(turn)};
      std::array<CurveContact, 16> found;
      SearchCost cost;
      const std::size_t count = find_on_face(rod, b, a_in_b, {n.reach, found, &cost});
      pairs += cost.pairs, starts += cost.starts;
      const bool is_there = std::any_of(found.begin(), found.begin() + count, [&](const auto& c) {
        return glm::distance(c.on_b, spot.at) < 1e-6 && std::abs(c.gap - 1e-4) < 1e-9;
      });
      const bool is_convex = n.surface.u.is_periodic && std::string_view(n.name) != "a ruled one" &&
                             std::string_view(n.name) != "a rail";
      INFO(n.name << ", " << trial << ": " << count);
      if (is_convex) CHECK(is_there);
    }
    INFO(n.name << ": " << pairs / kTrials << " pairs, " << starts / kTrials << " starts");
    CHECK(pairs / kTrials < 3000);
    CHECK(starts / kTrials < 60);
  }
}

}  // namespace pantin::test
