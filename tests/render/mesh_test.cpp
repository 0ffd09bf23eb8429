#include <catch2/catch.hpp>
#include <map>

#include "engine/base/math.hpp"
#include "engine/render/meshes.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

Vec3 place(const MeshVertex& v, Vec3 core, Real skin) {
  Vec3 p;
  for (int k = 0; k < 3; ++k) p[k] = v.corner[k] * core[k] + v.normal[k] * skin;
  return p;
}

/// Volume inside the triangles; positive when they are counter-clockwise seen from outside.
Real enclosed(const Meshes& meshes, Mesh mesh, Vec3 core, Real skin) {
  Real sum = 0;
  const MeshRange range = meshes.ranges[mesh];
  for (std::uint32_t i = range.first; i < range.first + range.count; i += 3) {
    const auto at = [&](std::uint32_t k) {
      return place(meshes.vertices[meshes.indices[i + k]], core, skin);
    };
    sum += glm::dot(at(0), glm::cross(at(1), at(2))) / 6;
  }
  return sum;
}

}  // namespace

TEST_CASE("meshes are closed and face outwards everywhere") {
  const Meshes meshes = make_meshes();
  for (std::size_t m = 0; m < kMeshCount; ++m) {
    const MeshRange range = meshes.ranges[m];
    std::map<std::pair<std::uint16_t, std::uint16_t>, int> edges;
    const Vec3 core = m == kBox ? Vec3{1, 0.5, 0.7} : Vec3{0, 1, 0};
    for (std::uint32_t i = range.first; i < range.first + range.count; i += 3) {
      const auto* t = &meshes.indices[i];
      for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
      const Vec3 a = place(meshes.vertices[t[0]], core, 0.2);
      const Vec3 b = place(meshes.vertices[t[1]], core, 0.2);
      const Vec3 c = place(meshes.vertices[t[2]], core, 0.2);
      CHECK(glm::dot(glm::cross(b - a, c - a), a + b + c) > 0);  // all are convex
    }
    for (const auto& [edge, count] : edges) {
      CHECK(count == 1);
      CHECK(edges.count({edge.second, edge.first}) == 1);
    }
  }
}

TEST_CASE("capsule meshes hold 48 and 192 triangles and approach the volume of a capsule") {
  const Meshes meshes = make_meshes();
  CHECK(meshes.ranges[kRound6].count == 3 * 48);
  CHECK(meshes.ranges[kRound16].count == 3 * 192);
  const Real exact = kPi * 0.09 * 2 + 4.0 / 3 * kPi * 0.027;
  Real last = 0;
  for (Mesh m : {kRound6, kRound16, kRound32, kRound64}) {
    const Real volume = enclosed(meshes, m, {0, 1, 0}, 0.3);
    CHECK(volume > last);
    CHECK(volume < exact);
    last = volume;
  }
  CHECK(last == Approx(exact).epsilon(0.005));
}

TEST_CASE("a bevelled box is a little smaller than the box") {
  const Meshes meshes = make_meshes();
  const Real box = 8 * 0.4 * 0.3 * 0.2, skin = 0.02;
  const Real volume = enclosed(meshes, kBox, Vec3{0.4, 0.3, 0.2} - skin, skin);
  CHECK(volume < box);
  CHECK(volume > 0.98 * box);
}
