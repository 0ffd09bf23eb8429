// No step allocates once the structure is known. Every allocation of this runner is counted.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "tests/runtime/puppets.hpp"

namespace {

std::atomic<long> allocations{0};

void* counted(std::size_t size, std::size_t alignment = alignof(std::max_align_t)) noexcept {
  ++allocations;
  const std::size_t whole = (size + alignment - 1) / alignment * alignment;
  return std::aligned_alloc(alignment, whole ? whole : alignment);
}

void* or_throw(void* p) {
  if (!p) throw std::bad_alloc();
  return p;
}

}  // namespace

void* operator new(std::size_t size) { return or_throw(counted(size)); }
void* operator new[](std::size_t size) { return or_throw(counted(size)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new(std::size_t size, std::align_val_t a) {
  return or_throw(counted(size, static_cast<std::size_t>(a)));
}
void* operator new[](std::size_t size, std::align_val_t a) {
  return or_throw(counted(size, static_cast<std::size_t>(a)));
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete[](void* p, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

using namespace pantin;
using namespace pantin::test;

namespace {

long allocations_in(Simulation& simulation, int steps) {
  const long before = allocations;
  for (int i = 0; i < steps; ++i) simulation.step();
  return allocations - before;
}

}  // namespace

TEST_CASE("allocations are counted") {
  const long before = allocations;
  const auto kept = std::make_unique<std::vector<int>>(100);
  CHECK(allocations - before >= 2);
  CHECK(kept->size() == 100);
}

TEST_CASE("a step allocates nothing after the first few") {
  const auto solver = GENERATE(Solver::automatic, Solver::sweep, Solver::shake2, Solver::paper);
  const bool puppet = GENERATE(false, true);
  INFO(name_of(solver) << (puppet ? ", puppet" : ", chain"));
  World world = puppet ? swaying_puppet().world : hung_chain(30).world;
  world.default_settings.solver = solver;
  Simulation simulation(std::move(world));
  simulation.settings.measure = true;
  simulation.timing = true;
  simulation.insert(Place::before_update, [](World& w, Real) {
    w.push(w.bodies.owners()[2], {0, 0.5, 0}, w.bodies.values()[2].pose.position);
  });
  allocations_in(simulation, 20);
  CHECK(allocations_in(simulation, 300) == 0);
}

TEST_CASE("advancing and drawing allocate nothing after the first few") {
  Puppet p = swaying_puppet();
  Simulation simulation(p.world);
  const auto frame = [&] {
    const Advance a = simulation.advance(1.0 / 47);
    return simulation.interpolated(p.left, a.fraction);
  };
  for (int i = 0; i < 20; ++i) frame();
  const long before = allocations;
  for (int i = 0; i < 100; ++i) frame();
  CHECK(allocations == before);
}
