// Islands alike are stepped side by side, each in a lane: what one does must not depend on who is
// beside it, to the last bit.
#include <catch2/catch.hpp>
#include <limits>

#include "engine/pantin/change.hpp"
#include "engine/pantin/measure.hpp"
#include "engine/pantin/must.hpp"
#include "tests/runtime/puppets.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr int kMany = 7;  // a full set of lanes, and one with room

/// Copies of a World in one, each with motions of its own; `only`: that copy alone.
World copies_of(const World& one, Real speed, int only = -1) {
  World all;
  Random dice(5);
  for (int n = 0; n < kMany; ++n) {
    std::vector<Entity> made;
    const auto in_all = [&](Entity e) { return made[one.bodies.slot(e)]; };
    const bool is_there = only < 0 || only == n;
    for (std::uint32_t i = 0; i < one.bodies.size(); ++i) {
      Body b = one.bodies.values()[i];
      const Vec3 velocity = speed * dice.in_cube(0.3), spin = speed * dice.in_cube(1);
      if (b.motion == Motion::dynamic) b.velocity += velocity, b.angular_velocity += spin;
      if (!is_there) continue;
      made.push_back(all.add_body(b));
      if (const auto* path = one.paths.find(one.bodies.owners()[i])) all.paths.add(made[i], *path);
    }
    if (!is_there) continue;
    for (const Link& l : one.links.values()) add_link(all, {in_all(l.a), in_all(l.b), l.joint});
    for (const Cable& c : one.cables.values()) add_cable(all, {in_all(c.a), in_all(c.b), c.joint});
    for (Pin pin : one.pins.values()) pin.body = in_all(pin.body), all.add_pin(pin);
  }
  return all;
}

/// A trunk with two arms on strings from a bar that sways; one of the strings stretches.
World hung_puppet(Real slack) {
  Puppet p = swaying_puppet();
  World& w = p.world;
  while (!w.pins.empty()) w.destroy(w.pins.owners().front());
  w.destroy(p.free);
  for (Cable& c : w.cables.values()) c.joint.length += slack;
  return w;
}

World tree(bool held, bool chain, Real drag) {
  Random dice(3);
  TreeSpec spec;
  spec.bodies = 9, spec.decades = 0.4, spec.held = held, spec.chain = chain, spec.drag = drag;
  return random_tree(spec, dice).world;
}

/// A heavy rod on a light one that hangs by a string: its impulse turns the string.
World light_above_heavy() {
  Chain c = hung_chain(2);
  World& w = c.world;
  for (const Entity link : c.links) w.destroy(link);
  add_link(w, {c.rods[0], c.rods[1], {{kHalfLink, 0, 0}, {-kHalfLink, 0, 0}}});
  add_cable(w, {c.hook, c.rods[0], {Vec3(0), {-kHalfLink, 0, 0}, 0.001, 0}});
  w.bodies[c.rods[0]].mass = 1e-4, w.bodies[c.rods[0]].inertia *= 2e-4;
  return w;
}

/// The same with a cone and a range of twist at every joint; rad.
World with_limits(World w, Real cone, Real twist) {
  JointLimits limits;
  limits.swing = {true, cone, 0.8 * cone}, limits.angle = {true, -twist, twist};
  for (Link& l : w.links.values()) {
    l.joint.limits = limits;
    l.joint.frames.set(glm::conjugate(w.bodies[l.a].pose.rotation),
                       glm::conjugate(w.bodies[l.b].pose.rotation));
  }
  return w;
}

/// Steps all copies together, and each alone; the first difference, or nothing.
std::string difference(const World& one, Real speed, int steps, Real h = 1.0 / 60) {
  Simulation together(copies_of(one, speed), {h});
  for (int i = 0; i < steps; ++i) together.step();
  const std::size_t count = one.bodies.size();
  for (int n = 0; n < kMany; ++n) {
    Simulation alone(copies_of(one, speed, n), {h});
    for (int i = 0; i < steps; ++i) alone.step();
    for (std::size_t i = 0; i < count; ++i) {
      const Body &a = alone.world.bodies.values()[i],
                 &b = together.world.bodies.values()[static_cast<std::size_t>(n) * count + i];
      if (a.pose.position != b.pose.position || a.pose.rotation != b.pose.rotation ||
          a.velocity != b.velocity || a.angular_velocity != b.angular_velocity)
        return "copy " + std::to_string(n) + " body " + std::to_string(i) + " off by " +
               std::to_string(glm::length(a.pose.position - b.pose.position));
    }
  }
  return "";
}

}  // namespace

TEST_CASE("a crowd of trees moves as each alone") {
  for (const bool held : {true, false})
    for (const bool chain : {true, false})
      for (const Real drag : {0.0, 0.4}) {
        CAPTURE(held, chain, drag);
        CHECK(difference(tree(held, chain, drag), 1, 60) == "");
      }
  // Wild: steps are taken in parts, which differ.
  CHECK(difference(tree(true, false, 0), 60, 30) == "");
  CHECK(difference(tree(false, true, 0), 60, 30) == "");
}

TEST_CASE("a crowd of single bodies moves as each alone") {
  World one;
  Body b = rod({0, 0, 0});
  b.inertia = {0.001, 0.002, 0.0025};
  one.add_body(b);
  for (const Real spin : {1.0, 30.0, 300.0}) {
    CAPTURE(spin);
    CHECK(difference(one, spin, 60) == "");
  }
}

TEST_CASE("a crowd of puppets on strings moves as each alone") {
  CHECK(difference(hung_puppet(0), 1, 180) == "");
  CHECK(difference(hung_puppet(0), 1, 180, 1.0 / 240) == "");
  // Slack strings that come to their lengths at times of their own, with blows.
  CHECK(difference(hung_puppet(0.05), 5, 120) == "");
  CHECK(difference(light_above_heavy(), 1, 60) == "");
}

TEST_CASE("a crowd of trees with limits moves as each alone, whether they are hit or not") {
  for (const bool held : {true, false})
    for (const Real cone : {0.3, 1.0, 2.5}) {
      CAPTURE(held, cone);
      CHECK(difference(with_limits(tree(held, false, 0.1), cone, 1.5 * cone), 3, 60) == "");
      CHECK(difference(with_limits(tree(held, true, 0), cone, cone), 3, 60) == "");
    }
}

TEST_CASE("a crowd of puppets with limits on strings moves as each alone") {
  for (const Real cone : {0.4, 1.5}) {
    CAPTURE(cone);
    CHECK(difference(with_limits(hung_puppet(0), cone, cone), 1, 120) == "");
    CHECK(difference(with_limits(hung_puppet(0.05), cone, cone), 5, 120) == "");
  }
}

TEST_CASE("limits that are far away change nothing", "") {
  for (const bool held : {true, false}) {
    World free = copies_of(tree(held, true, 0.1), 0.3);
    free.gravity = Vec3(0);
    Simulation without = Simulation::copy_of(free, {1.0 / 60}),
               with = Simulation::copy_of(with_limits(free, 3, 3), {1.0 / 60});
    for (int i = 0; i < 60; ++i) {
      without.step();
      CHECK(with.step().stops_hit == 0);
    }
    for (std::size_t i = 0; i < without.world.bodies.size(); ++i) {
      const Body &a = without.world.bodies.values()[i], &b = with.world.bodies.values()[i];
      CHECK(a.pose.position == b.pose.position);
      CHECK(a.velocity == b.velocity);
    }
  }
}

TEST_CASE("one of a crowd that is lost, pushed or gone leaves the others as they are") {
  const World one = hung_puppet(0.02);
  const std::uint32_t count = static_cast<std::uint32_t>(one.bodies.size());
  constexpr std::uint32_t kBad = 3;  // copy
  const auto disturb = [&](Simulation& sim, int way, int step) {
    Body& b = sim.world.bodies.values()[kBad * count + 1];
    const Entity e = sim.world.bodies.owners()[kBad * count + 1];
    if (way == 0 && step == 20) b.velocity.x = std::numeric_limits<Real>::quiet_NaN();
    if (way == 1 && step == 20) b.angular_velocity = Vec3(1e200);
    if (way == 2 && step >= 20) sim.world.push(e, {0, 30, 4}, {0, 0.1, 0});
    if (way == 3 && step == 20) b.pose.position += Vec3(0, 1, 0), b.restart = b.teleport = true;
    if (way == 4 && step == 20) b.mass = 1e6;
    if (way == 5 && step == 20) b.drag = 3;
  };
  for (int way = 0; way < 6; ++way) {
    Simulation together(copies_of(one, 3), {1.0 / 60});
    StepReport report;
    for (int i = 0; i < 60 && report.status != Status::diverged; ++i)
      disturb(together, way, i), report = together.step();
    // What is lost ends the run, and is named.
    if (way < 2) {
      CHECK(report.status == Status::diverged);
      CHECK(report.body == together.world.bodies.owners()[kBad * count + 1]);
      continue;
    }
    for (int n = 0; n < kMany; ++n) {
      if (n == static_cast<int>(kBad)) continue;
      CAPTURE(way, n);
      Simulation alone(copies_of(one, 3, n), {1.0 / 60});
      for (int i = 0; i < 60; ++i) alone.step();
      for (std::uint32_t i = 0; i < count; ++i) {
        const Body &a = alone.world.bodies.values()[i],
                   &b = together.world.bodies.values()[static_cast<std::uint32_t>(n) * count + i];
        CHECK(a.pose.position == b.pose.position);
        CHECK(a.angular_velocity == b.angular_velocity);
      }
    }
  }
}

TEST_CASE("a crowd of which some are destroyed and added goes on as each alone") {
  const World one = tree(false, true, 0.1);
  const std::size_t count = one.bodies.size();
  Simulation together(copies_of(one, 1), {1.0 / 60});
  Simulation alone(copies_of(one, 1, kMany - 1), {1.0 / 60});
  std::vector<Entity> last;  // bodies of the last copy
  for (std::size_t i = 0; i < count; ++i)
    last.push_back(together.world.bodies.owners()[(kMany - 1) * count + i]);
  for (int i = 0; i < 60; ++i) {
    // The first copies go one by one, until the last has nobody beside it.
    if (i % 8 == 4 && together.world.bodies.size() > count)
      for (std::size_t k = 0; k < count; ++k)
        together.world.destroy(together.world.bodies.owners().front());
    together.step(), alone.step();
  }
  CHECK(together.world.bodies.size() == count);
  for (std::size_t i = 0; i < count; ++i) {
    const Body &a = alone.world.bodies.values()[i], &b = together.world.bodies[last[i]];
    CHECK(glm::length(a.pose.position - b.pose.position) < 1e-12);
  }
}

TEST_CASE("a crowd moves alike on any number of threads") {
  if (!has_threads()) return;
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 2, 4}) {
    Simulation sim(copies_of(hung_puppet(0.05), 5), {1.0 / 60, 1, threads});
    for (int i = 0; i < 60; ++i) sim.step();
    hashes.push_back(state_hash(sim.world));
  }
  CHECK(hashes[0] == hashes[1]);
  CHECK(hashes[0] == hashes[2]);
}

TEST_CASE("one of a crowd that changes goes on as it would alone") {
  const auto run = [](int only) {
    Simulation sim(copies_of(hung_puppet(0), 1, only), {1.0 / 60});
    const std::size_t first = only < 0 ? 2 * 4 : 0, cable = only < 0 ? 2 * 3 : 0;
    for (int i = 0; i < 90; ++i) {
      // Pushed; then a string that could not stretch can; then it has another length.
      if (i == 20) sim.world.bodies.values()[first + 1].velocity += Vec3(0, 1, 0);
      if (i == 40) sim.world.cables.values()[cable].joint.compliance = 1e-3;
      if (i == 60) sim.world.cables.values()[cable].joint.length += 0.05;
      sim.step();
    }
    return sim.world.bodies.values()[first + 2];
  };
  const Body together = run(-1), alone = run(2);
  CHECK(together.pose.position == alone.pose.position);
  CHECK(together.velocity == alone.velocity);
}

TEST_CASE("one of a crowd goes on as alone when a change leaves its structure as it was") {
  using Edit = void (*)(World&, Entity);
  const std::pair<const char*, Edit> edits[] = {
      {"drag", [](World& w, Entity e) { must(set_drag(w, e, 0.3)); }},
      {"gravity scale", [](World& w, Entity e) { must(set_gravity_scale(w, e, 0.5)); }},
      {"the same mass", [](World& w, Entity e) { must(set_mass(w, e, w.bodies[e].mass)); }},
      {"a Collision", [](World& w, Entity e) { must(set_collision(w, e, Collision{})); }},
      {"the same settings", [](World& w, Entity e) { w.settings.add(e, w.default_settings); }},
      {"the same body", [](World& w, Entity e) { w.bodies.add(e, Body(w.bodies[e])); }},
  };
  World ball;
  ball.add_body({});
  const std::pair<const char*, World> structures[] = {
      {"body", ball}, {"tree", tree(false, false, 0.1)}, {"puppet", hung_puppet(0.02)}};
  constexpr int kEdited = 3;
  for (const auto& [structure, one] : structures)
    for (const auto& [what, edit] : edits) {
      CAPTURE(structure, what);
      const std::size_t count = one.bodies.size();
      Simulation together(copies_of(one, 2), {1.0 / 60});
      Simulation alone(copies_of(one, 2, kEdited), {1.0 / 60});
      for (int i = 0; i < 40; ++i) {
        if (i == 20)
          edit(together.world, together.world.bodies.owners()[(kEdited + 1) * count - 1]);
        if (i == 20) edit(alone.world, alone.world.bodies.owners().back());
        CHECK(together.step().status == alone.step().status);
      }
      for (std::size_t i = 0; i < count; ++i) {
        const Body &a = alone.world.bodies.values()[i],
                   &b = together.world.bodies.values()[kEdited * count + i];
        CHECK(a.pose.position == b.pose.position);
        CHECK(a.velocity == b.velocity);
      }
    }
}
