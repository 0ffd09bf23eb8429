// Two hundred chains stepped by several threads; the bits are those of one thread.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  for (int i = 0; i < 200; ++i) {
    const Vec3 at{0.5 * (i % 20), 3, 0.5 * (i / 20)};
    const Entity hook = must(world.add(RigidBody{.motion = Motion::fixed, .position = at}));
    must(build_chain(world, {.from = at, .to = at + Vec3(1, 0, 0), .links = 10, .start = hook}));
  }
  Simulation one = Simulation::copy_of(world), four(std::move(world), {.threads = 4});
  for (int i = 0; i < 60; ++i) one.step(), four.step();
  std::printf("%zu bodies, same bits: %s\n", four.world.bodies.size(),
              state_hash(one.world) == state_hash(four.world) ? "yes" : "no");
}
// prints: 2200 bodies, same bits: yes
