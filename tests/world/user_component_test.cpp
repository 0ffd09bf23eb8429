// A component type of the user's own, attached without a line of the engine changed.
#include <catch2/catch.hpp>
#include <string>

#include "engine/world/world.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

struct Glow {
  Real strength = 0;
  Vec3 colour{1};
  static void fields(auto& self, auto&& field) {
    field("strength", self.strength);
    field("colour", self.colour);
  }
};

struct Remark {  // no `fields`: not part of the state
  std::string text;
};

static_assert(HasFields<Glow>);
static_assert(!HasFields<Remark>);

}  // namespace

TEST_CASE("a user's component is kept with its entity") {
  World world;
  const Entity a = world.add_body({}), b = world.add_body({});
  world.store<Glow>().add(b, {2});
  world.store<Remark>().add(b, {"lamp"});
  CHECK(world.store<Glow>().find(a) == nullptr);
  CHECK(world.store<Glow>()[b].strength == 2);
  CHECK(world.store<Remark>()[b].text == "lamp");
}

TEST_CASE("a user's component is copied with the World") {
  World world;
  const Entity a = world.add_body({});
  world.store<Glow>().add(a, {2});
  World copy = world;
  copy.store<Glow>()[a].strength = 5;
  CHECK(world.store<Glow>()[a].strength == 2);
  world = copy;
  CHECK(world.store<Glow>()[a].strength == 5);
}

TEST_CASE("a user's component goes with its entity") {
  World world;
  const Entity a = world.add_body({}), b = world.add_body({});
  world.store<Glow>().add(a, {1});
  world.store<Glow>().add(b, {2});
  world.destroy(a);
  CHECK(world.store<Glow>().size() == 1);
  CHECK(world.store<Glow>().find(a) == nullptr);
  CHECK(world.store<Glow>()[b].strength == 2);
  CHECK(world.store<Glow>().find(world.add_body({})) == nullptr);  // the place is used again
}

TEST_CASE("a user's component is hashed if it says what its numbers are") {
  World world;
  const Entity a = world.add_body({});
  const std::uint64_t bare = state_hash(world);
  world.store<Remark>().add(a, {"one"});
  world.store<Glow>();
  CHECK(state_hash(world) == bare);

  world.store<Glow>().add(a, {1});
  const std::uint64_t lit = state_hash(world);
  CHECK(lit != bare);
  world.store<Glow>()[a].colour.z = 0.5;
  CHECK(state_hash(world) != lit);
  world.store<Glow>()[a].colour.z = 1;
  world.store<Remark>()[a].text = "two";
  CHECK(state_hash(world) == lit);
}
