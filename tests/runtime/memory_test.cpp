// What solvers remember: every field that decides the next step is hashed, and no other.
#include "engine/contact/memory.hpp"

#include <catch2/catch.hpp>

#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/lagrangian/island.hpp"
#include "tests/base/arity.hpp"
#include "tests/base/leaves.hpp"
#include "tests/runtime/running.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

World after(World world, int steps) {
  Simulation sim(std::move(world));
  for (int i = 0; i < steps; ++i) sim.step();
  return std::move(sim.world);
}

std::uint64_t hash_of_next(World world) { return state_hash(after(std::move(world), 1)); }

/// Every leaf of the World and of all memory.
template <class F>
void each_leaf_of(World& world, F&& leaf) {
  each_leaf(world, Role::state, "world", leaf);
  each_leaf(articulated::islands_of(world), Role::state, "articulated", leaf);
  each_leaf(lagrangian::islands_of(world), Role::state, "lagrangian", leaf);
  each_leaf(world.memory.of<contact::Memory>(), Role::state, "contact", leaf);
}

/// Not asked: handles in use, and looks, whose changes need more than a number.
bool is_aside(const std::string& path) {
  for (const char* part : {"world.entities", "world.shapes", "world.names", "world.touched",
                           "world.materials", "version", "world.edit_count"})  // an edit wakes
    if (path.find(part) != std::string::npos) return true;
  return false;
}

}  // namespace

#ifndef __clang__  // it takes minutes to count members; g++ answers for both
TEST_CASE("no list of what is remembered forgets a member") {
  check_list<articulated::Tree>("Tree");
  check_list<articulated::JointMemory>("JointMemory");
  check_list<articulated::PackedPin>("PackedPin");
  check_list<articulated::PackedCable>("PackedCable");
  check_list<articulated::IslandStructure>("articulated::IslandStructure");
  check_list<articulated::IslandMemory>("articulated::IslandMemory");
  check_list<lagrangian::Block>("Block");
  check_list<lagrangian::BlockMemory>("BlockMemory");
  check_list<lagrangian::JointForce>("JointForce");
  check_list<lagrangian::Frame>("Frame");
  check_list<lagrangian::IslandStructure>("lagrangian::IslandStructure");
  check_list<lagrangian::IslandMemory>("lagrangian::IslandMemory");
  check_list<Contact>("Contact");
  check_list<contact::Memory>("contact::Memory");
  check_list<Partition>("Partition");
}
#endif

TEST_CASE("the state hash changes with the least change of anything remembered, results aside") {
  for (const auto& [name, start] : running_worlds()) {
    const World running = after(start, 30);
    const std::uint64_t before = state_hash(running);
    std::size_t count = 0;
    World copy = running;
    each_leaf_of(copy, [&](const std::string&, Role, auto&) { ++count; });
    for (std::size_t i = 0; i < count; ++i) {
      World changed = running;
      std::size_t at = 0;
      std::string where;
      Role what = Role::state;
      each_leaf_of(changed, [&](const std::string& path, Role role, auto& leaf) {
        if (at++ == i) where = path, what = role, change(leaf);
      });
      if (is_aside(where)) continue;
      if ((state_hash(changed) != before) == (what == Role::state)) continue;
      INFO(name << ": " << where);
      CHECK((state_hash(changed) != before) == (what == Role::state));
    }
    CHECK(count > 100);
  }
}

TEST_CASE("results do not decide the next step") {
  for (const auto& [name, start] : running_worlds()) {
    const World running = after(start, 30);
    const std::uint64_t next = hash_of_next(running);
    World changed = running;
    std::string last;
    each_leaf_of(changed, [&](const std::string& path, Role role, auto& leaf) {
      if (role == Role::passive && !is_aside(path)) change(leaf), last = path;
    });
    for (articulated::Island& a : articulated::islands_of(changed)) {
      static_cast<articulated::StepPlan&>(a) = {};
      static_cast<articulated::StepResult&>(a) = {};
    }
    INFO(name << ", the last one changed is " << last);
    CHECK(hash_of_next(changed) == next);
  }
}

TEST_CASE("a change elsewhere does not disturb an island: not one bit differs") {
  for (const auto& [name, start] : running_worlds()) {
    if (name == "beam" || name == "puppet") continue;  // all bodies are tied together
    INFO(name);
    const World calm = after(start, 30);
    World changed = calm;
    Body far;
    far.pose.position = {50, 0, 0};
    const Entity extra = changed.add_body(far);
    const World one = after(calm, 20), other = after(changed, 20);
    for (const Entity e : calm.bodies.owners()) {
      CHECK(other.bodies[e].pose.position == one.bodies[e].pose.position);
      CHECK(other.bodies[e].angular_velocity == one.bodies[e].angular_velocity);
    }
    CHECK(other.is_alive(extra));
  }
}
