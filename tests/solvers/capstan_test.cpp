// A rope drawn over a fixed drum: the ratio of its end forces against the capstan's law.
//
// A chain of rigid links that touch the drum at their middles is a polygon about it, with a law of
// its own. Link by link, with tensions a and b at its joints, at angles u and v below its axis:
//   normal force   a sin u + b sin v = N
//   along the axis b cos v - a cos u = mu N
//   about its axis (l / 2) (a sin u - b sin v) = r mu N   (friction acts at the surface)
// and u + v is the angle from link to link. While every link is as the one before, b / a is the
// same for all. For thin short links the ratio tends to exp(mu phi).
#include <catch2/catch.hpp>

#include "engine/contact/contact.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kDrum = 0.25, kRope = 0.005;  // m, radii
constexpr Real kG = 10, kWeight = 0.1, kSpeed = 0.03;

struct Case {
  int per_turn;
  Real friction, turns, h;
};

Real link_length(const Case& c) { return 2 * (kDrum + kRope) * std::tan(kPi / c.per_turn); }

/// b / a of one link, by bisection for the angle u.
Real polygon_ratio(const Case& c) {
  const Real angle = 2 * kPi / c.per_turn, part = 2 * kRope * c.friction / link_length(c);
  Real low = 0, high = angle, ratio = 1;
  for (int i = 0; i < 60; ++i) {
    const Real u = 0.5 * (low + high), v = angle - u;
    const Real a_in = std::sin(u), b_in = a_in * (1 - part) / (1 + part);
    ratio = (std::cos(u) + c.friction * (a_in + b_in)) / std::cos(v);
    (ratio * std::sin(v) > b_in ? low : high) = u;
  }
  return ratio;
}

/// A weight on a rope over the drum, whose other end a hand draws away.
struct Capstan {
  World world;
  std::vector<Entity> rope;
  Entity weight;
  Vec3 pull{0};  // the way of the hand
};

/// The polygon around the drum, clockwise from the left side, and straight ends.
std::vector<Vec3> path_of(const Case& c) {
  const Real angle = 2 * kPi / c.per_turn, length = link_length(c);
  const Real corner = (kDrum + kRope) / std::cos(0.5 * angle);
  std::vector<Vec3> path;
  for (int i = 6; i > 0; --i) path.push_back({-(kDrum + kRope), -length / 2 - length * i, 0});
  for (int k = 0; k <= std::lround(c.per_turn * c.turns) + 1; ++k) {
    const Real at = kPi + 0.5 * angle - k * angle;
    path.push_back(corner * Vec3(std::cos(at), std::sin(at), 0));
  }
  const Vec3 way = glm::normalize(path.back() - path[path.size() - 2]);
  for (int i = 0; i < 6; ++i) path.push_back(path.back() + length * way);
  return path;
}

Capstan build(const Case& c) {
  Capstan made;
  World& w = made.world;
  w.default_settings.sleep_speed = 0, w.gravity = {0, -kG, 0};
  Collision surface;
  surface.friction = c.friction, surface.self = false;  // turns lie in one plane
  Shape drum = rod_shape(kDrum, 1);
  drum.local.rotation = from_rotation_vector({kPi / 2, 0, 0});
  add_solid(w, drum, {Vec3(0), kIdentity}, Motion::fixed, surface);
  const std::vector<Vec3> path = path_of(c);
  const Real half = 0.5 * link_length(c);
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec3 way = path[i + 1] - path[i];
    const Pose at{0.5 * (path[i] + path[i + 1]),
                  from_rotation_vector({0, 0, std::atan2(way.y, way.x) - kPi / 2})};
    const Entity e = add_solid(w, rod_shape(kRope, half), at, Motion::dynamic, surface, 5000);
    w.bodies[e].gravity_scale = 0;
    if (i > 0) add_link(w, {made.rope.back(), e, {{0, half, 0}, {0, -half, 0}}});
    made.rope.push_back(e);
  }
  Body weight;
  weight.drag = 0, weight.mass = kWeight, weight.inertia = Vec3(1e-3);
  weight.pose.position = path.front();
  made.weight = w.add_body(weight);
  add_link(w, {made.weight, made.rope.front(), {Vec3(0), {0, -half, 0}}});
  made.pull = glm::normalize(path.back() - path[path.size() - 2]);
  Body hand;
  hand.motion = Motion::kinematic, hand.pose.position = path.back();
  const Entity e = w.add_body(hand);
  add_link(w, {made.rope.back(), e, {{0, half, 0}, Vec3(0)}});
  KinematicPath drawn;  // at constant speed from the start: keyframes are at rest at both ends
  const Vec3 far = 100 * kSpeed / 1.5 * made.pull;
  drawn.curve = Keyframes{
      {{-100, {path.back() - far, kIdentity}}, {100, {path.back() + far, kIdentity}}}, false};
  w.paths.add(e, drawn);
  return made;
}

/// Means over the second half of the run: forces of weight and hand on the rope, and how much the
/// latter varies.
struct Pulled {
  Real by_weight = 0, by_hand = 0, deviation = 0;
};

Pulled draw(const Case& c, Real seconds) {
  const Capstan made = build(c);
  Simulation sim = Simulation::copy_of(made.world, {c.h});
  const long steps = std::lround(seconds / c.h);
  const auto momentum = [&] {
    Vec3 sum(0);
    for (const Entity e : made.rope) sum += sim.world.bodies[e].mass * sim.world.bodies[e].velocity;
    return sum;
  };
  Pulled mean;
  Real square = 0;
  for (long i = 0; i < steps; ++i) {
    const Vec3 rope = momentum(), weight = sim.world.bodies[made.weight].velocity;
    REQUIRE(sim.step().status == Status::ok);
    if (i < steps / 2) continue;
    const Vec3 hung = sim.world.bodies[made.weight].velocity - weight;
    const Vec3 of_weight = -kWeight * (hung / c.h + Vec3(0, kG, 0));
    Vec3 of_drum(0);
    for (const Contact& contact : contacts_of(sim.world)) of_drum += contact.force;
    const Real hand = glm::dot(made.pull, (momentum() - rope) / c.h - of_drum - of_weight);
    mean.by_weight -= of_weight.y, mean.by_hand += hand, square += hand * hand;
  }
  const Real count = static_cast<Real>(steps - steps / 2);
  mean.by_weight /= count, mean.by_hand /= count;
  mean.deviation = std::sqrt(square / count - mean.by_hand * mean.by_hand);
  return mean;
}

}  // namespace

TEST_CASE("a rope slips over a drum by the law of its polygon") {
  for (const Case& c :
       {Case{36, 0.2, 1.5, 1.0 / 240}, Case{36, 0.2, 1.5, 1.0 / 480}, Case{18, 0.2, 1.5, 1.0 / 240},
        Case{36, 0.1, 1.5, 1.0 / 240}, Case{36, 0.3, 0.5, 1.0 / 240}}) {
    const Real exact = std::pow(polygon_ratio(c), c.per_turn * c.turns);
    const Pulled forces = draw(c, 5);
    INFO(c.per_turn << " links a turn, friction " << c.friction << ", " << c.turns << " turns at "
                    << c.h << " s");
    CHECK(forces.by_weight == Approx(kWeight * kG).epsilon(1e-3));
    CHECK(forces.deviation < 0.1 * forces.by_hand);
    CHECK(forces.by_hand / forces.by_weight == Approx(exact).epsilon(0.03));
  }
}

TEST_CASE("a thin rope of short links is within 5 % of the capstan's law") {
  for (const Real h : {1.0 / 240, 1.0 / 480}) {
    const Case c{36, 0.2, 1.5, h};
    const Real law = std::exp(c.friction * 2 * kPi * c.turns);
    const Real polygon = std::pow(polygon_ratio(c), c.per_turn * c.turns);
    CHECK(polygon == Approx(law).epsilon(0.05));
    const Pulled forces = draw(c, 5);
    CHECK(forces.by_hand / forces.by_weight == Approx(law).epsilon(0.05));
  }
}
