// Thin bodies in fast motion by Euler's method, alone and as the rescue of others: joints stay
// closed, and without drag and outside forces there is never more energy than at the start.
#include <array>
#include <catch2/catch.hpp>
#include <sstream>

#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"
#include "tests/base/random.hpp"
#include "tests/solvers/exact.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// Rods and flat rulers in a chain or a tree, at rest relative to one another apart from spins.
struct Family {
  int bodies = 1;
  bool chain = false, held = false, flat = false;
  Real axial = 1e-2;    // moment of inertia about the long axis to that across it
  Real mass_ratio = 1;  // of a body to its parent
  Real whirl = 0;       // rad/s, of everything about an axis of any direction
  Real spin = 0;        // rad/s, of the outermost bodies about their own axes
};

struct Made {
  World world;
  Real scale = 0;  // J: kinetic energy, and what all can fall
};

Made make(const Family& of, Integrator integrator, std::uint64_t seed) {
  Random dice(seed);
  Made made{exact_world(integrator)};
  World& w = made.world;
  std::vector<Entity> bodies;
  std::vector<Real> lengths;
  std::vector<bool> outermost;
  Real depth = 0;
  for (int i = 0; i < of.bodies; ++i) {
    const int parent = i == 0 ? -1 : of.chain ? i - 1 : dice.below(i);
    const auto p = static_cast<std::size_t>(std::max(parent, 0));
    const Real mass = parent < 0 ? 1 : of.mass_ratio * w.bodies[bodies[p]].mass;
    const Real length = parent < 0 ? 0.5 : lengths[p] * dice.between(0.6, 1.1);
    const Real across = mass * length * length / 12;
    Body b = solid(mass, {across, of.axial * across, (of.flat ? 1 + of.axial : 1) * across});
    b.pose.rotation = dice.rotation();
    const Vec3 own(0, 0.5 * length, 0);
    Vec3 joint(0), out(0);
    if (parent >= 0) {
      out = {0, -0.5 * lengths[p] * (of.chain ? 1 : dice.between(-0.5, 1)), 0};
      joint = to_world(w.bodies[bodies[p]].pose, out);
      outermost[p] = false;
    }
    b.pose.position = joint - b.pose.rotation * own;
    bodies.push_back(w.add_body(b)), lengths.push_back(length), outermost.push_back(true);
    if (parent >= 0) add_link(w, {bodies[p], bodies.back(), {out, own}});
    if (parent < 0 && of.held) {
      Pin pin;
      pin.body = bodies.back(), pin.anchor = own;
      w.add_pin(pin);
    }
    depth += length;
  }
  const Vec3 whirl = of.whirl * dice.direction();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    Body& b = w.bodies[bodies[i]];
    b.velocity = glm::cross(whirl, b.pose.position), b.angular_velocity = whirl;
    if (outermost[i]) b.angular_velocity += of.spin * (b.pose.rotation * Vec3(0, 1, 0));
  }
  made.scale = measure(w).kinetic;
  for (const Body& b : w.bodies.values())
    if (of.held) made.scale += 9.81 * b.mass * (b.pose.position.y + depth);
  if (!of.held) w.gravity = Vec3(0);
  return made;
}

struct Kept {
  Real most = -1e300, end = 0;  // change of energy, parts of the scale
  Real gap = 0;                 // m
  int rescued = 0, failed = 0;  // steps
  Measures first, last;
};

Kept run(const Made& made, Real rate, Real duration) {
  Simulation sim = Simulation::copy_of(made.world, {1 / rate, 1, 1, true});
  Kept kept;
  kept.first = measure(sim.world);
  for (int i = 0; i < static_cast<int>(std::lround(duration * rate)); ++i) {
    const StepReport report = sim.step();
    if (report.status != Status::ok && ++kept.failed > 0) return kept;
    kept.last = report.measures;
    kept.end = (kept.last.energy() - kept.first.energy()) / made.scale;
    kept.most = std::max(kept.most, kept.end);
    kept.gap = std::max(kept.gap, report.worst_constraint);
    kept.rescued += report.rescued;
  }
  return kept;
}

Family any_family(Random& dice) {
  Family of;
  of.bodies = std::array{1, 2, 3, 6, 12}[static_cast<std::size_t>(dice.below(5))];
  of.chain = dice.below(2) == 0, of.held = dice.below(2) == 0, of.flat = dice.below(2) == 0;
  of.axial = std::pow(10.0, dice.between(-6, -1));
  of.mass_ratio = std::pow(10.0, dice.between(-0.7, of.bodies > 3 ? 0.3 : 1));
  of.whirl = dice.between(0, 60), of.spin = dice.between(-60, 60);
  return of;
}

std::string told(const Family& of, const Kept& kept) {
  std::ostringstream text;
  text << of.bodies << (of.flat ? " rulers" : " rods") << (of.chain ? " in a chain" : " in a tree")
       << (of.held ? ", held" : ", free") << ", axial ratio " << of.axial << ", masses x"
       << of.mass_ratio << ", " << of.whirl << " rad/s, spin " << of.spin << ": most " << kept.most
       << ", end " << kept.end << ", gap " << kept.gap << ", rescued " << kept.rescued;
  return text.str();
}

}  // namespace

TEST_CASE("thin rods and rulers never gain energy by Euler's method, whatever the step") {
  Random dice(11);
  for (int n = 0; n < 160; ++n) {
    const Family of = any_family(dice);
    const Real rate = std::array{60, 120, 240, 480}[static_cast<std::size_t>(n % 4)];
    const Kept kept = run(make(of, Integrator::euler, static_cast<std::uint64_t>(n + 1)), rate, 2);
    INFO(n << ", " << rate << " Hz: " << told(of, kept));
    CHECK(kept.failed == 0);
    CHECK(kept.most < 1e-6);
    if (kept.rescued == 0) CHECK(kept.gap < 1e-7);
  }
}

TEST_CASE("a free thin stick keeps energy and angular momentum by Euler's method") {
  for (const Real axial : {1e-1, 1e-3, 1e-6})
    for (const bool flat : {false, true})
      for (const Real whirl : {4.0, 20.0}) {
        Family of;
        of.axial = axial, of.flat = flat, of.whirl = whirl, of.spin = 5;
        const Kept kept = run(make(of, Integrator::euler, 3), 240, 10);
        INFO(told(of, kept));
        CHECK(std::abs(kept.end) < 1e-9);
        CHECK(glm::length(kept.last.angular_momentum - kept.first.angular_momentum) <
              1e-5 * glm::length(kept.first.angular_momentum));
      }
}

namespace {

/// Rods of 1 m together, hung from the first one's end, each turned by up to `kink` rad; the last
/// is `heavy` times the others' mass.
Made taut_chain(Integrator integrator, int links, Real heavy, Real kink) {
  Random dice(5);
  Made made{exact_world(integrator)};
  const Real length = 1.0 / links;
  Entity before;
  Vec3 tip(0);
  for (int i = 0; i < links; ++i) {
    const Real mass = (i == links - 1 ? heavy : 1) / links, across = mass * length * length / 12;
    Body b = solid(mass, {across, 1e-3 * across, across});
    b.pose.rotation = from_rotation_vector({0, 0, dice.between(-kink, kink)});
    const Vec3 own(0, 0.5 * length, 0);
    b.pose.position = tip - b.pose.rotation * own;
    const Entity e = made.world.add_body(b);
    if (i == 0) {
      Pin pin;
      pin.body = e, pin.anchor = own;
      made.world.add_pin(pin);
    } else {
      add_link(made.world, {before, e, {-own, own}});
    }
    tip = b.pose.position - b.pose.rotation * own, before = e;
    made.scale += 9.81 * mass * (b.pose.position.y + (i + 0.5) * length);
  }
  return made;
}

}  // namespace

TEST_CASE("chains pulled taut by a weight swing out by Euler's method, however stiff they are") {
  for (const int links : {5, 20})
    for (const Real heavy : {1.0, 1e2, 1e4})
      for (const Real rate : {60.0, 240.0}) {
        const Kept kept = run(taut_chain(Integrator::euler, links, heavy, 0.01), rate, 3);
        INFO(links << " links, weight x" << heavy << ", " << rate << " Hz: most " << kept.most
                   << ", end " << kept.end);
        CHECK(kept.failed + kept.rescued == 0);
        CHECK(kept.most < 1e-6);
        // Most of the energy of the kinks is gone, and no more than there was.
        CHECK(kept.end < -0.5);
        CHECK(kept.end >= -1);
        CHECK(kept.gap < 1e-7);
      }
}

TEST_CASE("steps that Euler takes for another integrator add no energy") {
  // Feathers that hold a weight whip too fast for explicit steps of this length.
  int rescued = 0;
  for (const Real kink : {0.01, 0.3})
    for (const int links : {3, 5}) {
      const Made made = taut_chain(Integrator::rk4, links, 1e4, kink);
      Simulation sim = Simulation::copy_of(made.world, {1.0 / 15, 1, 1, true});
      Real before = measure(sim.world).energy();
      for (int i = 0; i < 45; ++i) {
        const StepReport report = sim.step();
        REQUIRE(report.status == Status::ok);
        INFO(links << " links, kinks of " << kink << " rad, step " << i << ": rescued "
                   << report.rescued << ", gained "
                   << (report.measures.energy() - before) / made.scale);
        rescued += report.rescued;
        if (report.rescued > 0) CHECK(report.measures.energy() - before <= 1e-6 * made.scale);
        before = report.measures.energy();
      }
    }
  CHECK(rescued > 20);
}

TEST_CASE("hinged, universal and fixed thin bodies and loops gain no energy by Euler's method") {
  Random dice(1);
  for (int n = 0; n < 100; ++n) {
    Family of = any_family(dice);
    of.spin = 0;  // about axes that joints may not leave free
    Made made = make(of, Integrator::euler, static_cast<std::uint64_t>(n + 1));
    World& w = made.world;
    for (Link& l : w.links.values()) {
      constexpr JointKind kKinds[] = {JointKind::ball, JointKind::hinge, JointKind::universal,
                                      JointKind::fixed};
      const JointKind kind = kKinds[dice.below(4)];
      const Vec3 point = to_world(w.bodies[l.a].pose, l.joint.anchor_a);
      l.joint = joint_at(w, l.a, l.b, kind, point, dice.rotation());
    }
    if (n % 3 == 0 && of.held) {  // the last body is held too: a loop through the world, at rest
      Pin pin;
      pin.body = w.bodies.owners().back(), pin.anchor = {0, -0.2, 0};
      pin.target = to_world(w.bodies[pin.body].pose, pin.anchor);
      w.add_pin(pin);
      for (Body& b : w.bodies.values()) b.velocity = b.angular_velocity = Vec3(0);
    }
    const Kept kept = run(made, std::array{60, 120, 240, 480}[static_cast<std::size_t>(n % 4)], 3);
    INFO(n << ": " << told(of, kept));
    CHECK(kept.failed == 0);
    CHECK(kept.most < 1e-6);
  }
}

TEST_CASE("threadlike rulers on hinges stay closed and gain no energy by Euler's method") {
  Random dice(3);
  for (int n = 0; n < 60; ++n) {
    Family of{2 + n % 2, true, n % 4 < 2, true, 1e-6};
    of.whirl = 35;
    Made made = make(of, Integrator::euler, static_cast<std::uint64_t>(n + 1));
    World& w = made.world;
    for (Link& l : w.links.values()) {
      const Vec3 point = to_world(w.bodies[l.a].pose, l.joint.anchor_a);
      l.joint = joint_at(w, l.a, l.b, JointKind::hinge, point, dice.rotation());
    }
    const Kept kept = run(made, 240, 2);
    INFO(n << ": " << told(of, kept));
    CHECK(kept.failed == 0);
    CHECK(kept.gap < 1e-6);
    CHECK(kept.most < 1e-6);
  }
}
