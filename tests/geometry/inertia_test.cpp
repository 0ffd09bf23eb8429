#include <catch2/catch.hpp>
#include <limits>

#include "engine/geometry/shape.hpp"
#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::detail;

TEST_CASE("Principal axes turn the moments back into the tensor") {
  test::Random dice(7);
  for (int i = 0; i < 1000; ++i) {
    // Moments of a random box, now and then very flat or with two equal.
    const Vec3 drawn = dice.in_cube(1);
    Vec3 edges(1 + drawn.x, 1 + drawn.y, std::pow(10, 3 * drawn.z));
    if (i % 5 == 0) edges.y = edges.x;
    const Vec3 s = edges * edges, moments(s.y + s.z, s.x + s.z, s.x + s.y);
    const Quat rotation = from_rotation_vector(3.0 * dice.in_cube(1));
    const Mat3 tensor = world_inertia(rotation, moments);
    const PrincipalInertia found = principal_inertia(tensor);
    const Mat3 back = world_inertia(found.rotation, found.moments);
    const Real trace = moments.x + moments.y + moments.z;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) REQUIRE(std::abs(back[r][c] - tensor[r][c]) < 1e-13 * trace);
    REQUIRE(std::abs(glm::length(found.rotation) - 1) < 1e-14);
    REQUIRE(is_possible_inertia(found.moments));
  }
}

TEST_CASE("A diagonal tensor is returned as it is, without a turn") {
  Mat3 tensor(0);
  tensor[0][0] = 3, tensor[1][1] = 2, tensor[2][2] = 4;
  const PrincipalInertia found = principal_inertia(tensor);
  CHECK(found.moments == Vec3(3, 2, 4));
  CHECK(found.rotation == Quat(1, 0, 0, 0));
}

TEST_CASE("Moments no body can have are told from those one can") {
  CHECK(is_possible_inertia({1, 1, 2}));  // a flat plate
  CHECK(is_possible_inertia({1, 2, 2.5}));
  CHECK_FALSE(is_possible_inertia({1, 1, 2.001}));
  CHECK_FALSE(is_possible_inertia({3, 1, 1}));
  CHECK_FALSE(is_possible_inertia({1, 0, 1}));
  CHECK_FALSE(is_possible_inertia({1, -1, 1}));
  CHECK_FALSE(is_possible_inertia({1, std::numeric_limits<Real>::quiet_NaN(), 1}));
  CHECK_FALSE(is_possible_inertia(Vec3(std::numeric_limits<Real>::infinity())));
}
