// Mass properties against sums over small cells and against closed forms.
#include <array>
#include <catch2/catch.hpp>

#include "engine/base/rotation.hpp"
#include "engine/geometry/shape.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

bool is_inside(const Shape& shape, Vec3 p) {
  p = to_local(shape.local, p);
  const Real r = shape.size.x;
  switch (shape.kind) {
    case ShapeKind::sphere:
      return glm::dot(p, p) <= r * r;
    case ShapeKind::capsule: {
      p.y -= glm::clamp(p.y, -shape.size.y, shape.size.y);
      return glm::dot(p, p) <= r * r;
    }
    case ShapeKind::box:
      return glm::all(glm::lessThanEqual(glm::abs(p), shape.size));
    case ShapeKind::cylinder:
      return std::hypot(p.x, p.z) <= r && std::abs(p.y) <= shape.size.y;
    case ShapeKind::cone:
      return p.y >= -shape.size.y &&
             std::hypot(p.x, p.z) <= r * (shape.size.y - p.y) / (2 * shape.size.y);
    case ShapeKind::ellipsoid:
      return glm::length(p / shape.size) <= 1;
    default:
      return false;
  }
}

/// Sums over `n`^3 cells of a cube of half edge `half` about `middle`.
MassProperties summed(const Shape& shape, Real density, Vec3 middle, Real half, int n) {
  const Real cell = 2 * half / n, mass = density * cell * cell * cell;
  Vec3 first(0);
  Mat3 second(0);
  MassProperties whole;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        const Vec3 p = middle + (Vec3(i, j, k) + 0.5) * cell - half;
        if (!is_inside(shape, p)) continue;
        whole.mass += mass, first += mass * p;
        second += mass * (glm::dot(p, p) * Mat3(1) - glm::outerProduct(p, p));
      }
  const Vec3 c = whole.centre = first / whole.mass;
  whole.inertia = second - whole.mass * (glm::dot(c, c) * Mat3(1) - glm::outerProduct(c, c));
  return whole;
}

void check_alike(const MassProperties& a, const MassProperties& b, Real part) {
  const Real trace = a.inertia[0][0] + a.inertia[1][1] + a.inertia[2][2];
  CHECK(std::abs(a.mass - b.mass) < part * a.mass);
  CHECK(glm::length(a.centre - b.centre) < part);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) CHECK(std::abs(a.inertia[i][j] - b.inertia[i][j]) < part * trace);
}

Shape at_rest(ShapeKind kind, Vec3 size) { return {kind, size, Pose{}, 0}; }

const Pose kAside{{0.2, -0.1, 0.15}, from_rotation_vector({0.3, -0.7, 1.1})};

}  // namespace

TEST_CASE("Mass properties agree with a sum over cells, for any pose") {
  for (const Shape& shape : {Shape{ShapeKind::sphere, {0.4, 0, 0}, kAside, 0},
                             Shape{ShapeKind::capsule, {0.2, 0.35, 0}, kAside, 0},
                             Shape{ShapeKind::box, {0.4, 0.2, 0.1}, kAside, 0},
                             Shape{ShapeKind::cylinder, {0.3, 0.2, 0}, kAside, 0},
                             Shape{ShapeKind::cone, {0.4, 0.3, 0}, kAside, 0},
                             Shape{ShapeKind::ellipsoid, {0.4, 0.2, 0.3}, kAside, 0}}) {
    const MassProperties exact = mass_properties(shape, 700);
    CHECK(exact.mass == Approx(700 * volume(shape)));
    check_alike(exact, summed(shape, 700, kAside.position, 0.6, 120), 2e-3);
  }
}

TEST_CASE("Mass properties of solids at rest in their frame are the closed forms") {
  const Mat3 ball = mass_properties(at_rest(ShapeKind::sphere, {0.5, 0, 0}), 3).inertia;
  const Real ball_mass = 3 * 4.0 / 3 * kPi * 0.125;
  CHECK(ball[0][0] == Approx(0.4 * ball_mass * 0.25));
  CHECK(ball[0][1] == 0);
  const Mat3 box = mass_properties(at_rest(ShapeKind::box, {0.5, 1, 1.5}), 2).inertia;
  CHECK(box[0][0] == Approx(2.0 * 6 / 12 * (4 + 9)));
  CHECK(box[1][1] == Approx(2.0 * 6 / 12 * (1 + 9)));
  CHECK(box[2][2] == Approx(2.0 * 6 / 12 * (1 + 4)));
  // A capsule without a straight part is a ball, a very slender one is a rod.
  const Shape round = at_rest(ShapeKind::capsule, {0.5, 0, 0});
  CHECK(mass_properties(round, 3).inertia[2][2] == Approx(ball[2][2]));
  const MassProperties rod = mass_properties(at_rest(ShapeKind::capsule, {1e-4, 0.5, 0}), 1);
  CHECK(rod.inertia[0][0] == Approx(rod.mass / 12).epsilon(1e-3));
}

TEST_CASE("Cylinders, cones and ellipsoids weigh what the closed forms say") {
  const auto check = [](const Shape& shape, Real volume, Vec3 centre, Vec3 unit_moments) {
    const MassProperties found = mass_properties(shape, 700);
    CHECK(found.mass == Approx(700 * volume).epsilon(1e-14));
    CHECK(glm::distance(found.centre, centre) < 1e-15);
    for (int i = 0; i < 3; ++i) {
      CHECK(found.inertia[i][i] == Approx(found.mass * unit_moments[i]).epsilon(1e-14));
      CHECK(found.inertia[i][(i + 1) % 3] == 0);
    }
  };
  const Real r = 0.3, l = 0.8;
  check(at_rest(ShapeKind::cylinder, {r, l / 2, 0}), kPi * r * r * l, Vec3(0),
        {(3 * r * r + l * l) / 12, r * r / 2, (3 * r * r + l * l) / 12});
  check(at_rest(ShapeKind::cone, {r, l / 2, 0}), kPi * r * r * l / 3, {0, -l / 4, 0},
        {0.15 * r * r + 0.0375 * l * l, 0.3 * r * r, 0.15 * r * r + 0.0375 * l * l});
  const Real a = 0.5, b = 0.2, c = 0.3;
  check(at_rest(ShapeKind::ellipsoid, {a, b, c}), 4.0 / 3 * kPi * a * b * c, Vec3(0),
        {(b * b + c * c) / 5, (a * a + c * c) / 5, (a * a + b * b) / 5});
  // With three like radii it is a ball.
  const Shape round = at_rest(ShapeKind::ellipsoid, Vec3(r)),
              ball = at_rest(ShapeKind::sphere, {r, 0, 0});
  check_alike(mass_properties(round, 3), mass_properties(ball, 3), 1e-14);
}

TEST_CASE("Two halves of a box make the box") {
  const MassProperties left =
      mass_properties({ShapeKind::box, {0.25, 0.3, 0.2}, {{-0.25, 0, 0}, kIdentity}, 0}, 900);
  const MassProperties right =
      mass_properties({ShapeKind::box, {0.25, 0.3, 0.2}, {{0.25, 0, 0}, kIdentity}, 0}, 900);
  const MassProperties whole = mass_properties(at_rest(ShapeKind::box, {0.5, 0.3, 0.2}), 900);
  check_alike(combine(left, right), whole, 1e-14);
  check_alike(combine(MassProperties{}, whole), whole, 1e-16);
  check_alike(combine(whole, MassProperties{}), whole, 1e-16);
}
