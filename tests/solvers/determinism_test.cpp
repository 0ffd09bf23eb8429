// The same numbers in, the same bits out: over runs, builds of the kernels, optimisation, threads.
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <string>
#ifdef __linux__
#include <unistd.h>
#endif

#include "tests/runtime/puppets.hpp"
#include "tests/solvers/stages.hpp"
#include "tests/solvers/trees.hpp"

// The kernels once more, as the compiler writes them down without optimising anything.
#if defined(__clang__)
#pragma clang optimize off
#elif defined(__GNUC__)
#pragma GCC push_options
#pragma GCC optimize("O0")
#endif
#define PANTIN_KERNELS unoptimised
#include "engine/solvers/articulated/kernels.cpp"
#include "engine/world/ties.hpp"
#undef PANTIN_KERNELS
#if defined(__clang__)
#pragma clang optimize on
#elif defined(__GNUC__)
#pragma GCC pop_options
#endif

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;
using articulated::Kernels;

namespace {

/// Chains and trees, held and free, with drag, several solvers and every kind of tie.
World everything() {
  World w = swaying_puppet().world;
  Random dice(11);
  const auto take = [&](const World& from, const SolverSettings& how, Vec3 at) {
    std::vector<Entity> made;
    const auto in_w = [&](Entity e) { return made[from.bodies.slot(e)]; };
    for (Body b : from.bodies.values()) {
      b.pose.position += at;
      made.push_back(w.add_body(b));
    }
    for (const Link& l : from.links.values()) add_link(w, {in_w(l.a), in_w(l.b), l.joint});
    for (Pin p : from.pins.values()) p.body = in_w(p.body), p.target += at, w.add_pin(p);
    w.settings.add(made.front(), how);
  };
  int n = 0;
  for (Solver solver : {Solver::articulated, Solver::sweep, Solver::shake2, Solver::procedural})
    for (bool held : {true, false})
      for (bool is_chain : {true, false}) {
        TreeSpec spec;
        spec.bodies = 5 + n % 7, spec.decades = 0.5, spec.drag = 0.1 * (n % 3);
        spec.held = held, spec.chain = is_chain;
        SolverSettings how;
        how.solver = solver;
        take(random_tree(spec, dice).world, how, {3.0 * ++n, 0, 0});
      }
  for (Body& b : w.bodies.values())
    if (b.motion == Motion::dynamic) b.angular_velocity += 3.0 * dice.in_cube(1);
  return w;
}

std::uint64_t hash_after(World start, int steps, int threads, int substeps = 1) {
  Simulation sim(std::move(start), {1.0 / 60, substeps, threads});
  for (int i = 0; i < steps; ++i) {
    if (i % 40 == 20) sim.world.push(sim.world.bodies.owners()[5], {3, 2, 1}, Vec3(0));
    sim.step();
  }
  return state_hash(sim.world);
}

/// Everything that the kernels write while one island is stepped with one table of them.
std::uint64_t hash_of_stages(const Kernels& k, const World& start, articulated::Rule rule,
                             bool first) {
  Stages s(start, k);
  articulated::Island& a = s.articulation();
  Hash hash;
  const auto note = [&](const auto& numbers) {
    for (Real number : numbers) hash.add(number);
  };
  Real gravity[3] = {0.5, -9.81, 0.25};
  hash.add(k.predict(s.packed(), {0.02, {gravity[0], gravity[1], gravity[2]}, rule, first}));
  note(a.scratch.work.numbers());
  // One stage after the other ...
  s.inward_pass();
  note(a.scratch.nodes);
  s.levers(), s.sweep();
  note(a.scratch.work.numbers()), note(a.memory.numbers());
  const articulated::VelocityInput in{0.02, rule};
  const auto note_end = [&](bool sane) {
    hash.add(sane);
    for (const Body& b : s.world.bodies.values())
      hash.add(b.pose), hash.add(b.velocity), hash.add(b.angular_velocity);
  };
  note_end(k.update_velocities(s.packed(), in));
  const Real mean[3] = {0.1, 0.2, 0.3};
  k.scale(s.packed(), 0.75, mean);
  // ... and in one pass.
  k.predict(s.packed(), {0.02, {gravity[0], gravity[1], gravity[2]}, rule, first});
  note_end(k.sweep_and_update(s.packed(), a.scratch.targets.data(), 1, in));
  note(a.memory.numbers());
  return hash.value();
}

}  // namespace

TEST_CASE("products of blocks are those of matrices, with the same bits by all builds") {
  constexpr std::size_t kColumns = 7, kTies = 3;
  Random dice(5);
  const auto numbers = [&](std::size_t count) {
    std::vector<Real> v(count);
    for (Real& x : v) x = dice.between(-1, 1);
    return v;
  };
  const std::vector<Real> a = numbers(4 * kColumns), b = numbers(4 * kColumns), to = numbers(12),
                          row = numbers(12 * kTies);
  // Ties 0 and 2 have a path through the joint.
  articulated::PathStep steps[2];
  steps[0].tie = 0, steps[0].next = 1, steps[1].tie = 2;
  articulated::PathJoint joint{steps, 0, kTies - 1, true, {}, {}};
  for (std::size_t i = 0; i < 12; ++i)
    joint.by_torque[i] = dice.between(-1, 1), joint.by_force[i] = dice.between(-1, 1);
  for (articulated::PathStep& step : steps)
    for (std::size_t i = 0; i < 9; ++i)
      step.torque[i] = dice.between(-1, 1), step.force[i] = dice.between(-1, 1);
  std::vector<Real> product = to, sums = row, left = a;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t k = 0; k < kColumns; ++k) product[4 * c + r] -= a[4 * k + r] * b[4 * k + c];
      for (const articulated::PathStep& step : steps)
        for (std::size_t k = 0; k < 3; ++k)
          sums[12 * step.tie + 4 * c + r] += joint.by_torque[4 * k + r] * step.torque[3 * c + k] +
                                             joint.by_force[4 * k + r] * step.force[3 * c + k];
    }
  for (std::size_t i = 0; i < a.size(); ++i) left[i] -= 0.7 * b[i];
  std::vector<Real> first[3];
  const auto check = [&](const Kernels& kernels) {
    INFO("kernels " << kernels.name);
    std::vector<Real> results[] = {to, row, a};
    kernels.subtract_products(results[0].data(), a.data(), b.data(), kColumns);
    kernels.add_path_responses(joint, results[1].data());
    kernels.subtract_row(results[2].data(), b.data(), 0.7, a.size() - 1);
    const std::vector<Real>* const expected[] = {&product, &sums, &left};
    for (std::size_t n = 0; n < 3; ++n) {
      // The padding of blocks is free; the last number of a row is left as it was.
      for (std::size_t i = 0; i < results[n].size(); ++i)
        if (n == 2 ? i + 1 < a.size() : i % 4 < 3)
          CHECK(results[n][i] == Approx((*expected[n])[i]).margin(1e-14));
      if (first[n].empty()) first[n] = results[n];
      CHECK(results[n] == first[n]);
    }
    CHECK(results[2].back() == a.back());
  };
  check(articulated::kernels_unoptimised);
  for (const Kernels* const* k = articulated::all_kernels(); *k; ++k) check(**k);
}

TEST_CASE("all builds of the kernels give the same bits at every stage") {
  using articulated::Rule;
  const Kernels* const* all = articulated::all_kernels();
  REQUIRE(all[0] != nullptr);
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random dice(seed);
    TreeSpec spec;
    spec.bodies = 1 + static_cast<int>(seed), spec.decades = 1, spec.drag = 0.2;
    spec.held = false, spec.chain = seed % 2 == 0;
    RandomTree t = random_tree(spec, dice);
    for (Entity e : t.bodies) {
      Body& b = t.world.bodies[e];
      b.velocity = dice.in_cube(3);
      b.angular_velocity =
          dice.in_cube(seed % 3 == 0 ? 100 : 3);  // large turns take another branch
    }
    if (seed % 4 != 0) {
      Body wall;
      wall.motion = Motion::fixed;
      const Entity hook = t.world.add_body(wall);
      add_link(t.world, {hook, t.bodies[0], {Vec3(0), {0, 0.1, 0}}});
    }
    for (Rule rule : {Rule::verlet, Rule::midpoint, Rule::euler})
      for (bool first : {false, true}) {
        INFO("tree " << seed << ", rule " << static_cast<int>(rule));
        const std::uint64_t slowest =
            hash_of_stages(articulated::kernels_unoptimised, t.world, rule, first);
        for (const Kernels* const* k = all; *k; ++k, ++compared) {
          INFO("kernels " << (*k)->name);
          CHECK(hash_of_stages(**k, t.world, rule, first) == slowest);
        }
      }
  }
  CHECK(compared >= 12 * 6);
}

TEST_CASE("a run gives the same bits again, whatever the number of threads") {
  const World start = everything();
  const std::uint64_t once = hash_after(start, 150, 1);
  CHECK(hash_after(start, 150, 1) == once);
  CHECK(hash_after(start, 150, 2) == once);
  CHECK(hash_after(start, 150, 7) == once);
  CHECK(hash_after(start, 149, 1) != once);
  CHECK(hash_after(start, 150, 1, 2) != once);
}

TEST_CASE("the hash of a long run, for the test below", "[.run_hash]") {
  std::printf("run hash %016llx\n",
              static_cast<unsigned long long>(hash_after(everything(), 150, 1)));
}

TEST_CASE("a whole run has the same bits with any kernels, and in any process") {
#ifdef __linux__
  const auto hash_in_process = [](const std::string& kernels) {
    const std::string command = "PANTIN_KERNELS=" + kernels + " \"$(readlink /proc/" +
                                std::to_string(getpid()) + "/exe)\" '[.run_hash]'";
    std::FILE* pipe = popen(command.c_str(), "r");
    REQUIRE(pipe != nullptr);
    std::string out;
    for (int c; (c = std::fgetc(pipe)) != EOF;) out += static_cast<char>(c);
    CHECK(pclose(pipe) == 0);
    const std::size_t at = out.find("run hash ");
    REQUIRE(at != std::string::npos);
    return std::strtoull(out.c_str() + at + 9, nullptr, 16);
  };
  const std::uint64_t here = hash_after(everything(), 150, 1);
  for (const Kernels* const* k = articulated::all_kernels(); *k; ++k) {
    INFO("kernels " << (*k)->name);
    CHECK(hash_in_process((*k)->name) == here);
  }
#endif
}
