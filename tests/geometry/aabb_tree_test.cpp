// The tree of boxes against all pairs.
#include "engine/geometry/aabb_tree.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

struct Crowd {
  test::Random dice{11};
  std::vector<Aabb> boxes;

  Aabb any(Real far, Real size) {
    const Vec3 at = dice.in_cube(far);
    return {at, at + dice.in_box(0, size)};
  }
};

void check_queries(const AabbTree& tree, Crowd& crowd) {
  for (int i = 0; i < 50; ++i) {
    const Aabb box = crowd.any(12, 4);
    std::vector<std::uint32_t> found, want;
    tree.query(box, [&](std::uint32_t index) { found.push_back(index); });
    for (std::uint32_t j = 0; j < crowd.boxes.size(); ++j)
      if (crowd.boxes[j].overlaps(box)) want.push_back(j);
    std::sort(found.begin(), found.end());
    CHECK(found == want);
  }
}

}  // namespace

TEST_CASE("a tree finds what a look at every box finds, built or refitted") {
  Crowd crowd;
  for (int count : {0, 1, 2, 4, 5, 17, 300, 2000}) {
    crowd.boxes.clear();
    for (int i = 0; i < count; ++i) crowd.boxes.push_back(crowd.any(10, 2));
    AabbTree tree;
    tree.build(crowd.boxes);
    check_queries(tree, crowd);
    for (Aabb& box : crowd.boxes) box = crowd.any(10, 2);
    tree.refit(crowd.boxes);
    check_queries(tree, crowd);
  }
}

TEST_CASE("boxes all in one place make a tree like others") {
  Crowd crowd;
  crowd.boxes.assign(1000, Aabb{Vec3(0), Vec3(1)});
  AabbTree tree;
  tree.build(crowd.boxes);
  int found = 0;
  tree.query({Vec3(0.5), Vec3(0.6)}, [&](std::uint32_t) { ++found; });
  CHECK(found == 1000);
}

TEST_CASE("a tree gets looser as boxes part") {
  Crowd crowd;
  for (int i = 0; i < 100; ++i) crowd.boxes.push_back(crowd.any(1, 0.1));
  AabbTree tree;
  tree.build(crowd.boxes);
  CHECK(tree.looseness() == 1);
  for (Aabb& box : crowd.boxes) box = crowd.any(100, 0.1);
  tree.refit(crowd.boxes);
  CHECK(tree.looseness() > 10);
}

TEST_CASE("the nearest box is found") {
  Crowd crowd;
  for (int i = 0; i < 500; ++i) crowd.boxes.push_back(crowd.any(10, 1));
  AabbTree tree;
  tree.build(crowd.boxes);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p = crowd.any(12, 0).low;
    Real want = 1e300;
    for (const Aabb& box : crowd.boxes) want = std::min(want, distance_squared(box, p));
    const Real got = tree.nearest(
        p, 1e300, [&](std::uint32_t index) { return distance_squared(crowd.boxes[index], p); });
    CHECK(got == want);
  }
}
