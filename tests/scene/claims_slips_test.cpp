// Claims of the scenes with blades and wheels.
#include "tests/scene/claims.hpp"

using namespace pantin;
using namespace pantin::test;

CLAIM("sleigh", "the blade never slips, energy stays, and the end is straight") {
  Real slip = 0;
  std::vector<Vec3> places;
  const Played p = play("sleigh", [&](const World& w) {
    const Body& b = w.bodies[w.find("sleigh")];
    const Vec3 arm = b.pose.rotation * Vec3(-0.4, 0, 0), across = b.pose.rotation * Vec3(0, 0, 1);
    slip = std::max(slip,
                    std::abs(glm::dot(b.velocity + glm::cross(b.angular_velocity, arm), across)));
    places.push_back(b.pose.position);
  });
  CHECK(slip < 1e-10);
  CHECK(p.most_energy - p.least_energy < 1e-5 * p.start_energy);
  const Body& b = p.body("sleigh");
  CHECK(std::abs(b.angular_velocity.y) < 0.02);
  // It ends with its mass centre in front of the blade, though it started behind.
  CHECK(glm::dot(b.velocity, b.pose.rotation * Vec3(1, 0, 0)) > 1.3);
  const std::size_t n = places.size();
  const Vec3 last = places[n - 1] - places[n - 50], before = places[n - 50] - places[n - 100];
  CHECK(glm::length(glm::cross(last, before)) < 2e-3 * glm::length(last) * glm::length(before));
}

CLAIM("cart", "the wheels' speeds give its speed and its rate of turn") {
  const Played p = play("cart");
  const Body& frame = p.body("frame");
  const auto rolled = [&](const char* wheel) {
    const Body& b = p.body(wheel);
    return -0.15 * glm::dot(b.angular_velocity - frame.angular_velocity,
                            frame.pose.rotation * Vec3(0, 0, 1));
  };
  const Real left = rolled("left"), right = rolled("right");
  CHECK(left == Approx(0.6).epsilon(0.01));
  CHECK(right == Approx(1.2).epsilon(0.01));
  CHECK(glm::length(frame.velocity) == Approx((left + right) / 2).epsilon(1e-9));
  CHECK(frame.angular_velocity.y == Approx((right - left) / 0.5).epsilon(1e-9));
  // The circle's centre lies on the line of the axles, to the left.
  const Real radius = glm::length(frame.velocity) / frame.angular_velocity.y;
  CHECK(radius == Approx(0.75).epsilon(0.01));
}

CLAIM("cage", "the ball stays on the sphere, reaches its upper half, and keeps its energy") {
  const Vec3 middle(0, 0.75, 0);
  Extent height, distance;
  const Played p = play("cage", [&](const World& w) {
    const Vec3 at = w.bodies[w.find("ball")].pose.position;
    height.add(at.y - middle.y), distance.add(glm::distance(at, middle));
  });
  CHECK(distance.least > 0.5 - 1e-9);
  CHECK(distance.most < 0.5 + 1e-9);
  CHECK(height.most > 0.45);
  CHECK(p.most_energy - p.least_energy < 1e-4 * p.start_energy);
}

CLAIM("driven_turntable", "each ball's velocity turns at two sevenths of the table's rate") {
  const Real rate = 2.0 / 7 * 3;
  const Vec3 up(0, 1, 0);
  const Played p = play("driven_turntable");
  for (const char* ball : {"one", "two", "three"}) {
    CAPTURE(ball);
    const Body& start = p.scene.world.bodies[p.scene.world.find(ball)];
    const Vec3 arm = -glm::cross(up, start.velocity) / rate;  // from its circle's centre
    const Real turned = rate * p.scene.duration;
    const Vec3 now = std::cos(turned) * arm + std::sin(turned) * glm::cross(up, arm);
    CHECK(glm::distance(p.body(ball).pose.position, start.pose.position - arm + now) < 1e-6);
  }
}
