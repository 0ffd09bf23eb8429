// Findings: what makes a result doubtful is told with its place, its time and its amount; what is
// right is not.
#include <catch2/catch.hpp>
#include <string>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/runtime/energy_account.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/puppets.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

const Finding* find(const Simulation& sim, FindingKind kind) {
  for (const Finding& f : sim.findings())
    if (f.kind == kind) return &f;
  return nullptr;
}

/// Watched for `seconds`.
Simulation watched(World world, Real h, Real seconds) {
  Simulation sim(std::move(world), {h, 1, 1, false, true});
  while (sim.world.time < seconds - h / 2) sim.step();
  return sim;
}

/// A stick on a hook that is led to and fro, with twice its weight at most.
World led_stick() {
  World w;
  Body hook;
  hook.motion = Motion::kinematic;
  const Entity h = w.add_body(hook, "hook");
  Lissajous path;
  path.amplitude = {0.5, 0, 0}, path.frequency = {1, 0, 0};
  w.paths.add(h, {path});
  Body stick = rod({kHalfLink, 0, 0});
  stick.drag = 0;
  const Entity s = w.add_body(stick, "stick");
  add_link(w, {h, s, {{}, {-kHalfLink, 0, 0}}});
  return w;
}

}  // namespace

TEST_CASE("every kind of finding has a name, a unit, a meaning and what to change") {
  for (int i = 0; i <= static_cast<int>(last_of(FindingKind{})); ++i) {
    const FindingInfo& info = info_of(static_cast<FindingKind>(i));
    CHECK(info.name.find(' ') == std::string_view::npos);
    CHECK_FALSE(info.name.empty());
    CHECK(info.meaning.ends_with('.'));
    CHECK(info.change.ends_with('.'));
  }
}

TEST_CASE("work of a led body, of pushes and of springs is no gain of energy") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian}) {
    INFO(name_of(solver));
    World w = led_stick();
    w.default_settings.solver = solver;
    const Simulation led = watched(w, 1.0 / 240, 5);
    CHECK(led.findings().empty());
    CHECK(led.is_energy_checked(led.world.find("stick")));
    CHECK(measure(led.world).kinetic > 0.01);

    Chain chain = hung_chain(6);
    chain.world.default_settings.solver = solver;
    Simulation pushed = Simulation::copy_of(chain.world, {1.0 / 240, 1, 1, false, true});
    pushed.insert(Stage::before_update, [&](World& world, Real) {
      world.push(chain.rods.back(), {20, 0, 5}, world.bodies[chain.rods.back()].pose.position);
    });
    for (int i = 0; i < 480; ++i) pushed.step();
    CHECK(pushed.findings().empty());
  }
}

TEST_CASE("work of a body that the caller leads is no gain of energy, by joint or spring") {
  const Real h = 1.0 / 240;
  for (const Solver solver : {Solver::articulated, Solver::lagrangian, Solver::sweep})
    for (const bool has_spring : {false, true}) {
      if (has_spring && solver == Solver::sweep) continue;  // springs rest there
      INFO(name_of(solver) << has_spring);
      World w = led_stick();
      w.default_settings.solver = solver;
      const Entity hook = w.find("hook");
      w.paths.remove(hook);
      if (has_spring) {
        Joint& joint = w.links.values()[0].joint;
        const Quat along_z = from_rotation_vector({0, -kPi / 2, 0});
        joint.kind = JointKind::hinge, joint.frames.set(along_z, along_z);
        joint.parameters.edit().rotation.spring = {2, 0.1, 0};
      }
      const auto height = [&](int i) { return 0.1 * (1 - std::cos(3 * h * i)); };
      const auto turn = [&](int i) { return 0.5 * std::sin(2 * h * i); };
      Simulation sim(std::move(w), {h, 1, 1, false, true});
      for (int i = 0; i < 1200; ++i) {
        Body& b = sim.world.bodies[hook];
        b.velocity.y = (height(i + 1) - height(i)) / h;
        b.angular_velocity.z = (turn(i + 1) - turn(i)) / h;
        b.pose = {{0, height(i + 1), 0}, from_rotation_vector({0, 0, turn(i + 1)})};
        sim.step();
      }
      for (const Finding& f : sim.findings())
        UNSCOPED_INFO(info_of(f.kind).name << " " << f.amount << " " << f.time);
      CHECK(sim.findings().empty());
      CHECK(measure(sim.world).kinetic > 1e-3);
    }
}

TEST_CASE("energy that nobody brought is told as soon as it is there") {
  EnergyAccount account;
  World w;
  const Entity e = w.add_body(rod(Vec3(0)), "rod");
  w.gravity = Vec3(0);
  Simulation still = Simulation::copy_of(w, {1e-3});
  still.step();
  World& world = still.world;
  int gains = 0;
  for (int i = 0; i < 3; ++i) {
    account.begin_substep(world), account.note_start(world, 1e-3);
    if (i == 1) world.bodies[e].velocity = {0, 3, 0};
    account.end_substep(world, 1e-3);
    account.each_change(world, [&](const EnergyAccount::Change& gain) {
      ++gains;
      CHECK(gain.kind == EnergyAccount::Change::Kind::gain);
      CHECK(gain.body == e);
      CHECK(gain.amount == Approx(0.5 * 0.5 * 9));
    });
  }
  CHECK(gains == 2);
}

TEST_CASE("a free body that is pushed for a step, at any time, lost nothing") {
  for (const int wait : {0, 2, 5, 40}) {
    World w;
    w.gravity = Vec3(0);
    Body b;
    b.drag = 0;
    const Entity body = w.add_body(b);
    Simulation sim(std::move(w), {1.0 / 60, 1, 1, false, true});
    for (int i = 0; i < wait; ++i) sim.step();
    sim.world.forces.add(body, {{120, 0, 0}, {0, 3, 0}});
    sim.step();
    sim.world.forces.remove(body);
    for (int i = 0; i < 60; ++i) sim.step();
    CHECK(measure(sim.world).kinetic > 1);
    CHECK(sim.findings().empty());
  }
}

TEST_CASE("pushes on many bodies hide no more energy than their own work") {
  // Forty rods in a row move along; half of them are pushed, the others braked as much. Half of
  // their energy once more is nobody's work.
  constexpr Real kStep = 1e-3;
  EnergyAccount account;
  Chain chain = hung_chain(40);
  chain.world.gravity = Vec3(0);
  chain.world.destroy(chain.links.front());
  Simulation sim(std::move(chain.world), {kStep});
  sim.step();
  World& world = sim.world;
  for (std::size_t i = 0; i < chain.rods.size(); ++i) {
    Body& b = world.bodies[chain.rods[i]];
    b.velocity = {3, 0, 0}, b.angular_velocity = Vec3(0), b.drag = 0;
    world.push(chain.rods[i], {i < 20 ? 600 : -600, 0, 0}, b.pose.position);
  }
  int gains = 0;
  for (int i = 0; i < 3; ++i) {
    account.begin_substep(world), account.note_start(world, kStep);
    for (const Entity rod : chain.rods) {
      Body& b = world.bodies[rod];
      b.pose.position += kStep * b.velocity;
      if (i == 1) b.velocity *= std::sqrt(1.5);
    }
    account.end_substep(world, kStep);
    account.each_change(world, [&](const EnergyAccount::Change& change) {
      gains += change.kind == EnergyAccount::Change::Kind::gain;
    });
  }
  CHECK(gains == 2);
}

TEST_CASE("energy that nothing takes is missed as soon as it is gone, but for what drag takes") {
  for (const Real slower : {0.04, 0.06})
    for (const Real drag : {0.0, 1e-3, 40.0}) {
      EnergyAccount account;
      World w;
      Body body = rod(Vec3(0));
      body.velocity = {3, 0, 0}, body.drag = drag;
      const Entity e = w.add_body(body, "rod");
      w.gravity = Vec3(0);
      Simulation sim = Simulation::copy_of(w, {1e-3});
      sim.step();
      World& world = sim.world;
      const Real had = 0.25 * glm::dot(world.bodies[e].velocity, world.bodies[e].velocity);
      int losses = 0;
      for (int i = 0; i < 6; ++i) {
        account.begin_substep(world), account.note_start(world, 1e-3);
        if (i == 4) world.bodies[e].velocity.x *= std::sqrt(1 - slower);
        account.end_substep(world, 1e-3);
        account.each_change(world, [&](const EnergyAccount::Change& loss) {
          ++losses;
          CHECK(loss.kind == EnergyAccount::Change::Kind::loss);
          CHECK(loss.body == e);
          CHECK(loss.amount == Approx(slower * had).epsilon(1e-3));
        });
      }
      INFO(slower << " " << drag);
      CHECK(losses == (slower > 0.05 && drag < 1 ? 2 : 0));
    }
}

TEST_CASE("angular momentum that turns by itself is told, of what is held it is not asked") {
  for (const Real by : {0.04, 0.06})
    for (const bool is_held : {false, true}) {
      EnergyAccount account;
      World w;
      Body body = rod({kHalfLink, 0, 0});
      body.inertia = Vec3(0.002), body.drag = 0;
      const Entity e = w.add_body(body, "rod");
      if (is_held) {
        Body hook;
        hook.motion = Motion::fixed;
        add_link(w, {w.add_body(hook), e, {{}, {-kHalfLink, 0, 0}}});
      }
      w.gravity = Vec3(0);
      Simulation sim = Simulation::copy_of(w, {1e-3});
      sim.step();
      World& world = sim.world;
      Body& b = world.bodies[e];
      b.velocity = Vec3(0), b.angular_velocity = {0, 50, 0};
      int turns = 0;
      for (int i = 0; i < 6; ++i) {
        account.begin_substep(world), account.note_start(world, 1e-3);
        if (i == 4) b.angular_velocity = from_rotation_vector({by, 0, 0}) * b.angular_velocity;
        account.end_substep(world, 1e-3);
        account.each_change(world, [&](const EnergyAccount::Change& turn) {
          ++turns;
          CHECK(turn.kind == EnergyAccount::Change::Kind::spin);
          CHECK(turn.amount == Approx(by * 0.002 * 50).epsilon(1e-2));
        });
      }
      INFO(by << " " << is_held);
      CHECK(turns == (by > 0.0505 && !is_held ? 2 : 0));
    }
}

TEST_CASE("a solver that throws a chain is told, one that keeps its energy is not") {
  for (const Solver solver : {Solver::sweep, Solver::shake2, Solver::articulated}) {
    World w = hung_chain(12).world;
    w.default_settings.solver = solver;
    const Simulation sim = watched(w, 1.0 / 60, 1.5);
    const Finding* gain = find(sim, FindingKind::energy_gained);
    INFO(name_of(solver));
    REQUIRE((gain != nullptr) == (solver == Solver::sweep));
    if (gain) CHECK(gain->amount > 1);
    if (gain) CHECK(sim.world.bodies.find(gain->where));
  }
}

TEST_CASE("a joint that its solver cannot keep closed is told with its gap") {
  for (const Real z : {0.0, 0.5}) {
    Chain chain = hung_chain(4);
    World& w = chain.world;
    w.default_settings.solver = Solver::planar;
    w.links[chain.links[2]].joint.anchor_b.z = z;
    const Simulation sim = watched(w, 1.0 / 60, 0.5);
    INFO(z);
    if (z == 0) {
      CHECK(sim.findings().empty());
      continue;
    }
    const Finding* open = find(sim, FindingKind::joint_open);
    REQUIRE(open);
    CHECK(open->where == chain.links[2]);
    CHECK(open->amount >= 0.49);
    CHECK(open->time == Approx(1.0 / 60));
    CHECK(open->steps == 30);
  }
}

TEST_CASE("a cable between bodies that cannot come nearer is told with what it is too long by") {
  for (const Real apart : {1.0, 1.1}) {
    Chain chain = hung_chain(3);
    World& w = chain.world;
    Body far;
    far.motion = Motion::fixed, far.pose.position = {-apart, 0, 0};
    // From the first rod's hook, which cannot move.
    const Entity c = add_cable(w, {w.add_body(far), chain.rods[0], {{}, {-kHalfLink, 0, 0}, 1, 0}});
    const Simulation sim = watched(w, 1.0 / 60, 0.2);
    const Finding* taut = find(sim, FindingKind::cable_overlong);
    INFO(apart);
    CHECK((taut != nullptr) == (apart > 1));
    if (taut) CHECK(taut->where == c);
    if (taut) CHECK(taut->amount == Approx(0.1).epsilon(0.2));
  }
}

TEST_CASE("a box that friction jams between walls that close is told and not flung when it slips") {
  World w;
  w.gravity = Vec3(0);
  const auto add = [&](Vec3 half, Body b) {
    const Entity e = w.add_body(b);
    w.shapes.add(e, {{{ShapeKind::box, half, {}, 0, nullptr}}});
    Collision how;
    how.friction = 0.4;
    w.collisions.add(e, how);
    return e;
  };
  const Real speed = 0.1;
  for (const Real side : {-1.0, 1.0}) {
    Body wall;
    wall.motion = Motion::kinematic, wall.pose.position.x = 0.25 * side;
    Lissajous path;  // of a quarter swing of ten seconds
    path.centre.position = wall.pose.position, path.frequency = {1.0 / 40, 0, 0};
    path.amplitude = {-side * speed * 40 / (2 * kPi), 0, 0};
    w.paths.add(add({0.1, 1, 0.5}, wall), {path});
  }
  Body box;
  box.drag = 0, box.inertia = Vec3(0.0067), box.pose.rotation = from_rotation_vector({0, 0, 0.52});
  const Entity b = add(Vec3(0.1), box);
  Simulation sim(std::move(w), {1.0 / 960, 1, 1, false, true});
  while (sim.world.time < 1) {
    sim.step();
    REQUIRE(glm::length(sim.world.bodies[b].velocity) < 4 * speed);
  }
  const Finding* told = find(sim, FindingKind::contacts_unsolved);
  REQUIRE(told);
  CHECK(told->where == b);
}

TEST_CASE("watching does not change the motion") {
  World w = swaying_puppet().world;
  Simulation plain = Simulation::copy_of(w, {1.0 / 60}),
             seen = Simulation::copy_of(w, {1.0 / 60, 1, 1, false, true});
  for (int i = 0; i < 120; ++i) plain.step(), seen.step();
  CHECK(state_hash(plain.world) == state_hash(seen.world));
}
