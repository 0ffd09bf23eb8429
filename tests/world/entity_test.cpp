#include "engine/world/entity.hpp"

#include <catch2/catch.hpp>

using namespace pantin;
using namespace pantin::detail;

TEST_CASE("the default handle names nothing") {
  Entities entities;
  CHECK_FALSE(Entity{});
  CHECK_FALSE(entities.is_alive(Entity{}));
  entities.create();
  CHECK_FALSE(entities.is_alive(Entity{}));
}

TEST_CASE("a destroyed handle is told from the one that got its place") {
  Entities entities;
  const Entity first = entities.create();
  const Entity other = entities.create();
  entities.destroy(first);
  CHECK_FALSE(entities.is_alive(first));
  CHECK(entities.is_alive(other));

  const Entity second = entities.create();
  CHECK(second.index == first.index);
  CHECK(second.generation != first.generation);
  CHECK(second != first);
  CHECK(entities.is_alive(second));
  CHECK_FALSE(entities.is_alive(first));
}

TEST_CASE("destroying twice does not free a place twice") {
  Entities entities;
  const Entity e = entities.create();
  entities.destroy(e);
  entities.destroy(e);
  CHECK(entities.alive() == 0);
  const Entity a = entities.create();
  const Entity b = entities.create();
  CHECK(a.index != b.index);
  CHECK(entities.alive() == 2);
}

TEST_CASE("a stale handle does not destroy its successor") {
  Entities entities;
  const Entity old = entities.create();
  entities.destroy(old);
  const Entity now = entities.create();
  entities.destroy(old);
  CHECK(entities.is_alive(now));
}

TEST_CASE("handles of another World's future are not alive here") {
  Entities entities;
  entities.create();
  CHECK_FALSE(entities.is_alive(Entity{0, 1}));
  CHECK_FALSE(entities.is_alive(Entity{7, 0}));
}
