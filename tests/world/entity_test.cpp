#include "engine/world/entity.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "engine/base/archive.hpp"

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

TEST_CASE("handles come back from a file as they were, whether or not any was destroyed") {
  for (const int destroyed : {-1, 0, 3, 6}) {
    Entities entities;
    std::vector<Entity> all;
    for (int i = 0; i < 7; ++i) all.push_back(entities.create());
    if (destroyed >= 0) entities.destroy(all[static_cast<std::size_t>(destroyed)]);
    Entities written = entities;
    written.write_out();
    FieldWriter to;
    to.write(written);
    FieldReader from(to.bytes());
    Entities back;
    from.read(back);
    REQUIRE(from.ok());
    CHECK(back.alive() == entities.alive());
    CHECK(back.capacity() == 7);
    for (const Entity e : all) CHECK(back.is_alive(e) == entities.is_alive(e));
    CHECK(back.create() == entities.create());
    CHECK(back.create() == entities.create());
  }
}
