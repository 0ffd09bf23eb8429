// What a solver does not know is told, not passed over.
#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/puppets.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Solver kAll[] = {Solver::articulated, Solver::sweep, Solver::shake2, Solver::procedural,
                           Solver::lagrangian};

struct Case {
  Feature feature;
  std::function<Entity(Chain&)> add;  // returns who is to be named
};

Joint& hinge(Chain& c) {
  Joint& j = c.world.links[c.links[1]].joint;
  j.kind = JointKind::hinge;
  return j;
}

std::vector<Case> cases() {
  return {
      {Feature::spring,
       [](Chain& c) {
         return hinge(c).parameters.edit().rotation.spring.stiffness = 2, c.links[1];
       }},
      {Feature::spring,
       [](Chain& c) { return hinge(c).parameters.edit().rotation.spring.damping = 2, c.links[1]; }},
      {Feature::friction,
       [](Chain& c) { return hinge(c).parameters.edit().rotation.friction.dry = 2, c.links[1]; }},
      {Feature::motor,
       [](Chain& c) {
         hinge(c).parameters.edit().rotation.motor = {MotorKind::velocity, 1, 1, 0, 5};
         return c.links[1];
       }},
      {Feature::restitution,
       [](Chain& c) {
         hinge(c).limits.edit().angle = {true, -1, 1};
         hinge(c).parameters.edit().restitution = 0.5;
         return c.links[1];
       }},
      {Feature::kind,
       [](Chain& c) {
         hinge(c).kind = JointKind::prismatic;
         return c.links[1];
       }},
      {Feature::ratio,
       [](Chain& c) {
         hinge(c).kind = JointKind::hinge;
         c.world.links[c.links[2]].joint.kind = JointKind::hinge;
         Gear r;
         r.first = c.links[1], r.second = c.links[2], r.ratio = 2;
         return add_gear(c.world, r);
       }},
      {Feature::soft_stop,
       [](Chain& c) {
         JointLimits& l = c.world.links[c.links[1]].joint.limits.edit();
         l.swing = {true, 1, 1}, l.soft_zone = 0.1, l.soft_stiffness = 5;
         return c.links[1];
       }},
      {Feature::pose_drive,
       [](Chain& c) {
         JointDrive d;
         d.stiffness = 2;
         c.world.joint_drives.add(c.links[1], d);
         return c.links[1];
       }},
      {Feature::exact_drive,
       [](Chain& c) {
         hinge(c);
         c.world.joint_drives.add(c.links[1], {}).exact = true;
         return c.links[1];
       }},
      {Feature::cable,
       [](Chain& c) {
         return add_cable(c.world, {c.hook, c.rods[2], {Vec3(0), Vec3(0), 2, 0}});
       }},
      {Feature::spring_pin,
       [](Chain& c) {
         Pin p;
         p.body = c.rods[2], p.kind = PinKind::spring;
         return c.world.add_pin(p);
       }},
      {Feature::contact,
       [](Chain& c) {
         Shape ball;
         c.world.shapes.add(c.rods[1], {{ball}});
         c.world.collisions.add(c.rods[1], {});
         return c.rods[1];
       }},
  };
}

}  // namespace

TEST_CASE("what a solver does not know is told by name, with the solvers that do") {
  for (Solver solver : kAll)
    for (const Case& c : cases()) {
      INFO(name_of(solver) << ", " << name_of(c.feature));
      Chain chain = hung_chain(4);
      chain.world.default_settings.solver = solver;
      const Entity who = c.add(chain);
      const std::vector<StructureFault> faults = check(chain.world);
      StepReport report;
      Simulation sim = Simulation::copy_of(chain.world);
      for (int i = 0; i < 3; ++i) report = sim.step();
      if (knows(solver_for(solver, c.feature), c.feature)) {  // "auto" leaves it to another
        CHECK(faults.empty());
        CHECK(report.faults == 0);
        CHECK_FALSE(report.fault);
        continue;
      }
      REQUIRE(faults.size() == 1);
      CHECK(faults.front().link == who);
      CHECK(report.faults == 1);
      CHECK(report.fault == who);
      const bool left_out = c.feature == Feature::kind;
      CHECK(faults.front().kind == (left_out ? StructureFault::left_out : StructureFault::unknown));
      if (left_out) continue;
      CHECK(faults.front().reason.find(name_of(c.feature)) != std::string::npos);
      CHECK(faults.front().reason.find(name_of(solver)) != std::string::npos);
      CHECK(faults.front().reason.find(solvers_that_know(c.feature)) != std::string::npos);
    }
}

TEST_CASE("surfaces that move or resist rolling are told to a solver that does not know them") {
  for (const bool on_belt : {false, true}) {
    World w;
    Body ball;
    ball.pose.position = {0, 1, 0};
    Entity special = w.add_body(ball);
    w.shapes.add(special, {{Shape{}}});
    w.collisions.add(special, {});
    if (on_belt) {
      Body belt;
      belt.motion = Motion::fixed, belt.pose.position = {0, -9, 0};
      special = w.add_body(belt);
      w.shapes.add(special, {{Shape{}}});
      w.collisions.add(special, {}).surface_velocity = {1, 0, 0};
    } else {
      w.collisions[special].rolling = 0.01;
    }
    for (const Solver solver : {Solver::articulated, Solver::lagrangian, Solver::planar}) {
      w.default_settings.solver = solver;
      w.mark_dirty();
      const std::vector<StructureFault> faults = check(w);
      if (solver != Solver::planar) {
        CHECK(faults.empty());
        continue;
      }
      REQUIRE(faults.size() == 1);
      CHECK(faults.front().link == special);
      CHECK(faults.front().kind == StructureFault::unknown);
      CHECK(faults.front().reason.find(name_of(Feature::surface)) != std::string::npos);
    }
  }
}

TEST_CASE("every feature is known to a solver") {
  for (int f = 0; f < kFeatures; ++f) {
    bool known = knows(Solver::planar, static_cast<Feature>(f));
    for (Solver s : kAll) known = known || knows(s, static_cast<Feature>(f));
    CHECK(known);
  }
}

TEST_CASE("a check changes nothing, finds nothing in a sound World, and needs no step") {
  Puppet p = swaying_puppet();
  const std::uint64_t before = state_hash(p.world);
  CHECK(check(p.world).empty());
  CHECK(state_hash(p.world) == before);
  // Changed by hand, without a touch: found all the same.
  Simulation sim = Simulation::copy_of(p.world);
  for (int i = 0; i < 3; ++i) sim.step();
  sim.world.bodies[p.trunk].mass = 0;
  const auto faults = check(sim.world);
  REQUIRE(faults.size() == 1);
  CHECK(faults.front().link == p.trunk);
  CHECK(faults.front().kind == StructureFault::impossible);
}

TEST_CASE("settings with which no step can be computed stop their island, and are told") {
  const Real none = std::numeric_limits<Real>::quiet_NaN();
  SolverSettings bad[6];
  bad[0].sweeps = 10'001, bad[1].sweeps = -3, bad[2].rotation_stiffness = -1;
  bad[3].tolerance = none, bad[4].damping_ratio = 2, bad[5].step_tolerance = -1;
  for (const SolverSettings& settings : bad) {
    Chain chain = hung_chain(3);
    chain.world.default_settings = settings;
    const auto faults = check(chain.world);
    REQUIRE(faults.size() == 1);
    CHECK(faults.front().kind == StructureFault::impossible);
    CHECK(faults.front().reason.find("solver settings") != std::string::npos);
    Simulation sim = Simulation::copy_of(chain.world);
    const Pose before = sim.world.bodies[faults.front().link].pose;
    const StepReport report = sim.step();
    CHECK(report.status != Status::ok);
    CHECK(report.body == faults.front().link);
    CHECK(sim.world.bodies[faults.front().link].pose.position == before.position);
    CHECK(sim.world.bodies[faults.front().link].pose.rotation == before.rotation);
  }
}

TEST_CASE("islands are told apart: each by the solver it has") {
  Chain chain = hung_chain(3);
  Entity last;
  for (int i = 0; i < 2; ++i) {
    Body fixed;
    fixed.motion = Motion::fixed, fixed.pose.position = {0, 0, 3.0 + i};
    const Entity hook = chain.world.add_body(fixed);
    const Entity e = chain.world.add_body(rod({kHalfLink, 0, 3.0 + i}));
    Joint j{Vec3(0), {-kHalfLink, 0, 0}};
    j.kind = JointKind::hinge;
    j.parameters.edit().rotation.motor = {MotorKind::velocity, 1, 1, 0, 5};
    const Entity link = add_link(chain.world, {hook, e, j});
    SolverSettings how;
    how.solver = i == 0 ? Solver::lagrangian : Solver::sweep;
    chain.world.settings.add(e, how);
    if (i == 1) last = link;
  }
  const auto faults = check(chain.world);
  REQUIRE(faults.size() == 1);
  CHECK(faults.front().link == last);
}
