// Pushes, impulses and gravity that begin and end between two steps change the momentum by what
// they are, under every integrator.
#include <catch2/catch.hpp>

#include "engine/pantin/pantin.hpp"

using namespace pantin;

namespace {

constexpr Real kStep = 0.01, kMass = 2;

enum class Scene { slider, pair, hinge };

struct Jointed {
  Simulation sim;
  Entity body;
};

Jointed jointed(Scene scene, Integrator integrator, Real damping_ratio, int substeps) {
  World w;
  w.gravity = Vec3(0);
  w.default_settings.solver = Solver::lagrangian;
  w.default_settings.integrator = integrator;
  w.default_settings.damping_ratio = damping_ratio;
  w.default_settings.sleep_speed = 0;
  const Entity base = must(w.add(RigidBody{.motion = Motion::fixed}));
  const RigidBody made{.shape = SphereShape{0.1}, .mass = kMass, .position = {1, 0, 0}};
  const Entity body = must(w.add(made));
  if (scene == Scene::slider)
    must(w.add(PrismaticJoint{.a = base, .b = body, .anchor = {1, 0, 0}, .axis = {1, 0, 0}}));
  if (scene == Scene::hinge) must(w.add(HingeJoint{.a = base, .b = body, .axis = {0, 0, 1}}));
  if (scene == Scene::pair)
    must(w.add(FixedJoint{.a = body, .b = must(w.add(made)), .anchor = {1, 0, 0}}));
  return {Simulation(std::move(w), {.h = kStep, .substeps = substeps}), body};
}

}  // namespace

TEST_CASE("a push or an impulse on a jointed body changes its momentum by as much") {
  constexpr Real kForce = 6;
  for (const Integrator integrator : {Integrator::implicit, Integrator::radau, Integrator::rk4})
    for (const Real ratio : {0.0, 0.8, 1.0})
      for (const Scene scene : {Scene::slider, Scene::pair, Scene::hinge})
        for (const int substeps : {1, 3})
          for (const int pushes : {0, 1, 10}) {  // 0: an impulse
            CAPTURE(name_of(integrator), ratio, static_cast<int>(scene), substeps, pushes);
            Jointed j = jointed(scene, integrator, ratio, substeps);
            World& w = j.sim.world;
            const Vec3 direction = scene == Scene::hinge ? Vec3(0, 1, 0) : Vec3(1, 0, 0);
            for (int i = 0; i < 30; ++i) {
              const Vec3 at = w.bodies[j.body].pose.position;
              const Vec3 now =
                  scene == Scene::hinge ? glm::normalize(Vec3(-at.y, at.x, 0)) : direction;
              if (i == 10 && pushes == 0) must(impulse(w, j.body, kForce * now, at));
              if (i >= 10 && i < 10 + pushes) w.push(j.body, kForce * now, at);
              REQUIRE(j.sim.step().status == Status::ok);
            }
            const Real momentum = pushes == 0 ? kForce : kForce * kStep * pushes;
            const Real inertia = scene == Scene::pair    ? 2 * kMass
                                 : scene == Scene::hinge ? kMass * (1 + 0.4 * 0.1 * 0.1)
                                                         : kMass;
            const Real tolerance = scene == Scene::hinge ? 1e-3 : 1e-5;  // it turns meanwhile
            CHECK(glm::length(w.bodies[j.body].velocity) ==
                  Approx(momentum / inertia).epsilon(tolerance));
          }
}

TEST_CASE("gravity that begins and ends gives the velocity of its time") {
  for (const Integrator integrator : {Integrator::implicit, Integrator::radau, Integrator::rk4}) {
    Jointed j = jointed(Scene::slider, integrator, 0.8, 1);
    for (int i = 0; i < 30; ++i) {
      j.sim.world.gravity = {i >= 10 && i < 20 ? 9.0 : 0.0, 0, 0};
      REQUIRE(j.sim.step().status == Status::ok);
    }
    CAPTURE(name_of(integrator));
    CHECK(j.sim.world.bodies[j.body].velocity.x == Approx(0.9).epsilon(1e-5));
  }
}

TEST_CASE("a tree that was singular once goes on in the same bits when it is built anew or saved") {
  const auto run = [](int what) {
    World w;
    w.default_settings.solver = Solver::lagrangian;
    w.default_settings.integrator = Integrator::radau;
    w.default_settings.sleep_speed = 0;
    const Entity base = must(w.add(RigidBody{.motion = Motion::fixed}));
    Entity parent = base;
    std::vector<Entity> rods;
    for (int i = 0; i < 3; ++i) {
      rods.push_back(must(w.add(
          RigidBody{.shape = BoxShape{{0.25, 0.03, 0.05}}, .position = {0.25 + 0.5 * i, 0, 0}})));
      must(w.add(HingeJoint{.a = parent,
                            .b = rods.back(),
                            .anchor = {0.5 * i, 0, 0},
                            .axis = {0, 0, 1},
                            .spring = {200, 1, 0}}));
      parent = rods.back();
    }
    const Vec3 middle = w.bodies[rods[1]].pose.position;
    must(w.add(SpringJoint{.a = base,
                           .b = rods[1],
                           .anchor_a = middle + Vec3(0, 1, 0),
                           .anchor_b = middle,
                           .stiffness = 1e3}));
    Simulation sim(std::move(w), {1.0 / 240});
    for (int i = 0; i < 60; ++i) {
      if (i == 20 && what == 1) sim.world.mark_dirty();
      if (i == 20 && what == 2) sim.world = must(world_from_bytes(must(world_to_bytes(sim.world))));
      sim.step();
    }
    return sim.world.bodies[rods[2]];
  };
  const Body as_before = run(0);
  for (const int what : {1, 2}) {
    CAPTURE(what);
    const Body b = run(what);
    CHECK(b.pose.position == as_before.pose.position);
    CHECK(b.velocity == as_before.velocity);
  }
}
