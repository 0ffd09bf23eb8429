// Large groups of bodies in contact, which several threads solve at once: the same bits.
#include <catch2/catch.hpp>
#include <thread>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/standing.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Pairs of rods on ball joints, boxes and balls that fall into a pit.
World falling_pile(int layers) {
  World w;
  add_ground(w, rough());
  for (const Real side : {-1.0, 1.0})
    for (const bool along : {true, false}) {
      const Vec3 half = along ? Vec3(0.1, 3, 1) : Vec3(1, 3, 0.1);
      const Vec3 at = (along ? Vec3(1, 0, 0) : Vec3(0, 0, 1)) * (side * 0.9);
      add_solid(w, box_shape(half), {at, kIdentity}, Motion::fixed, rough());
    }
  for (int i = 0; i < layers; ++i)
    for (int k = 0; k < 9; ++k) {
      const Vec3 at(0.5 * (k % 3 - 1) + 0.01 * (i % 5), 0.3 + 0.35 * i, 0.5 * (k / 3 - 1));
      const Quat turn = from_rotation_vector({0.3 * i, 0.7 * k, 0.2 * (i + k)});
      if ((i + k) % 3 == 0) {
        add_solid(w, ball_shape(0.13), {at, turn}, Motion::dynamic, rough());
      } else if ((i + k) % 3 == 1) {
        add_solid(w, box_shape({0.15, 0.1, 0.12}), {at, turn}, Motion::dynamic, rough());
      } else {
        const Vec3 arm = turn * Vec3(0, 0.12, 0);
        const auto add_arm = [&](Vec3 middle) {
          return add_solid(w, rod_shape(0.06, 0.06), {middle, turn}, Motion::dynamic, rough());
        };
        const Entity a = add_arm(at - arm), b = add_arm(at + arm);
        Joint joint;
        joint.anchor_a = {0, 0.12, 0}, joint.anchor_b = {0, -0.12, 0};
        add_link(w, {a, b, joint});
      }
    }
  return w;
}

/// A user's threads: as many as there are parts, the last one first.
void run_backwards(std::size_t count, Job job) {
  std::vector<std::thread> threads;
  for (std::size_t i = count; i-- > 1;) threads.emplace_back([=] { job(i); });
  job(0);
  for (std::thread& thread : threads) thread.join();
}

}  // namespace

TEST_CASE("threads share a large group, with the bits of one thread") {
  const World start = falling_pile(12);
  const auto with = [](int threads, RunJobs run_jobs = {}) {
    StepSettings settings;
    settings.threads = threads, settings.run_jobs = std::move(run_jobs);
    return settings;
  };
  Simulation one = Simulation::copy_of(start, with(1)), two = Simulation::copy_of(start, with(2)),
             five = Simulation::copy_of(start, with(5)),
             own = Simulation::copy_of(start, with(1, run_backwards));
  int large = 0;
  for (int i = 0; i < 90; ++i) {
    REQUIRE(one.step().status == Status::ok);
    two.step(), five.step(), own.step();
    for (const auto& g : one.world.memory.of<articulated::Islands>().groups.groups)
      large += g.pairs >= 256 && g.trees > 16;
    const std::uint64_t hash = state_hash(one.world);
    REQUIRE(state_hash(two.world) == hash);
    REQUIRE(state_hash(five.world) == hash);
    REQUIRE(state_hash(own.world) == hash);
  }
  CHECK(large > 30);
}
