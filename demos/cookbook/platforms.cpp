// Who collides with whom: a platform to jump onto from below, a filter, threads of your own.
#include <cstdio>
#include <pantin/pantin.hpp>
#include <thread>
#include <vector>

using namespace pantin;

int main() {
  World world;
  // What comes from below, against `one_way`, passes; what comes from above is borne.
  const Entity platform = must(world.add(RigidBody{.motion = Motion::fixed,
                                                   .shape = BoxShape{{2, 0.1, 1}},
                                                   .collision = Collision{.one_way = {0, 1, 0}}}));
  const auto add_ball = [&](Vec3 at, Vec3 velocity) {
    return must(world.add(RigidBody{.shape = SphereShape{0.1},
                                    .position = at,
                                    .velocity = velocity,
                                    .collision = Collision{}}));
  };
  const Entity player = add_ball({-1, -0.5, 0}, {0, 5, 0}), ghost = add_ball({1, 1, 0}, {});

  StepSettings settings;
  // Asked once for each pair that comes near.
  settings.filter = [&](const ContactPair& pair) { return pair.a != ghost && pair.b != ghost; };
  // Islands are stepped by threads of the program's own, to the same bits.
  settings.run_jobs = [](std::size_t count, Job job) {
    std::vector<std::thread> threads;
    for (std::size_t i = 1; i < count; ++i) threads.emplace_back([=] { job(i); });
    if (count > 0) job(0);
    for (std::thread& thread : threads) thread.join();
  };
  Simulation simulation(std::move(world), settings);
  const auto height = [&](Entity e) { return simulation.world.bodies[e].pose.position.y; };
  while (simulation.world.time < 2) simulation.step();
  std::printf("the player stands at %.2f m, the ghost fell to %.0f m\n", height(player),
              height(ghost));

  // It drops through the platform on demand.
  must(ignore(simulation.world, player, platform, 0.2));
  while (simulation.world.time < 3) simulation.step();
  std::printf("the player is %s the platform\n", height(player) < 0 ? "below" : "on");
}
// prints: the player is below the platform
