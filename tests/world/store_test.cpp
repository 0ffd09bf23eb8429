#include "engine/world/store.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

using namespace pantin;
using namespace pantin::detail;

namespace {

std::vector<std::string> listed(const Store<std::string>& store) {
  return {store.values().begin(), store.values().end()};
}

}  // namespace

TEST_CASE("values are visited in the order they were added, also after removals") {
  Entities entities;
  Store<std::string> store;
  std::vector<Entity> e;
  for (const char* word : {"a", "b", "c", "d", "e"}) {
    e.push_back(entities.create());
    store.add(e.back(), word);
  }
  store.remove(e[1]);
  CHECK(listed(store) == std::vector<std::string>{"a", "c", "d", "e"});
  const std::array<Entity, 2> ends{e[4], e[0]};
  store.remove(ends);
  CHECK(listed(store) == std::vector<std::string>{"c", "d"});
  store.add(e[0], "a again");
  CHECK(listed(store) == std::vector<std::string>{"c", "d", "a again"});
  for (std::size_t i = 0; i < store.size(); ++i)
    CHECK(store[store.owners()[i]] == store.values()[i]);
}

TEST_CASE("adding to an owner that has a value replaces it in place") {
  Entities entities;
  Store<std::string> store;
  const Entity a = entities.create(), b = entities.create();
  store.add(a, "one"), store.add(b, "two");
  const std::uint64_t before = store.version();
  CHECK(store.add(a, "three") == "three");
  CHECK(listed(store) == std::vector<std::string>{"three", "two"});
  CHECK(store.version() != before);
}

TEST_CASE("removing what is not there changes nothing") {
  Entities entities;
  Store<std::string> store;
  const Entity a = entities.create(), never = entities.create();
  store.add(a, "a");
  const std::uint64_t before = store.version();
  store.remove(never);
  store.remove(Entity{});
  store.remove(Entity{500, 0});
  CHECK(store.size() == 1);
  CHECK(store.version() == before);
}

TEST_CASE("a removal that names an owner twice takes one value away") {
  Entities entities;
  Store<std::string> store;
  const Entity a = entities.create(), b = entities.create();
  store.add(a, "a"), store.add(b, "b");
  const std::array<Entity, 2> twice{a, a};
  store.remove(twice);
  CHECK(listed(store) == std::vector<std::string>{"b"});
}

TEST_CASE("a stale handle does not find the value of its successor") {
  Entities entities;
  Store<std::string> store;
  const Entity old = entities.create();
  store.add(old, "old");
  store.remove(old);
  entities.destroy(old);
  const Entity now = entities.create();
  store.add(now, "now");
  CHECK(store.find(old) == nullptr);
  CHECK(store.slot(old) == kNoSlot);
  REQUIRE(store.find(now));
  CHECK(*store.find(now) == "now");
}

TEST_CASE("a copy of a store is independent") {
  Entities entities;
  Store<std::string> store;
  const Entity a = entities.create();
  store.add(a, "a");
  Store<std::string> copy = store;
  copy[a] = "changed";
  copy.add(entities.create(), "b");
  CHECK(listed(store) == std::vector<std::string>{"a"});
}

TEST_CASE("a store tells where values have gone since it was asked to, over several removals") {
  Entities entities;
  Store<std::string> store;
  std::vector<Entity> e;
  const auto add = [&](const char* word) {
    e.push_back(entities.create());
    store.add(e.back(), word);
  };
  for (const char* word : {"gone before", "a", "b", "c", "d"}) add(word);
  store.remove(e[0]);
  CHECK(store.slot_now(2) == 2);  // nobody asked
  CHECK_FALSE(store.is_new(2));

  store.track_slots();
  add("new");
  CHECK(store.slot_now(3) == 3);
  CHECK_FALSE(store.is_new(3));
  CHECK(store.is_new(4));
  store.remove(e[2]);
  add("newer");
  store.remove(e[1]);
  // Of a, b, c, d there are c and d, in front of what is new.
  CHECK(store.slot_now(0) == kNoSlot);
  CHECK(store.slot_now(1) == kNoSlot);
  CHECK(store.slot_now(2) == 0);
  CHECK(store.slot_now(3) == 1);
  CHECK(store.slot_now(kNoSlot) == kNoSlot);
  CHECK_FALSE(store.is_new(1));
  CHECK(store.is_new(2));
  store.add(e[4], "replaced in place");
  CHECK(store.slot_now(3) == 1);
  // What was taken away and came back is another.
  store.remove(e[4]);
  store.add(e[4], "back");
  CHECK(store.slot_now(3) == kNoSlot);
  CHECK(store.is_new(store.slot(e[4])));

  store.track_slots();
  CHECK(store.slot_now(1) == 1);
  CHECK_FALSE(store.is_new(store.slot(e[4])));
}

TEST_CASE("a value that a former handle of its index hid is found again once that is removed") {
  detail::Entities entities;
  Store<int> store;
  const Entity former = entities.create();
  entities.destroy(former);
  const Entity now = entities.create();
  REQUIRE(now.index == former.index);
  store.add(now, 1), store.add(former, 2);
  CHECK(store.find(now) == nullptr);
  store.remove(former);
  REQUIRE(store.find(now) != nullptr);
  CHECK(*store.find(now) == 1);
}

TEST_CASE(
    "a store keeps what was removed or replaced since it was asked, as long as it is little") {
  detail::Entities entities;
  Store<int> store;
  std::vector<Entity> e;
  for (int i = 0; i < 1200; ++i) e.push_back(entities.create()), store.add(e.back(), i);
  store.remove(e[0]);
  CHECK(store.gone()->empty());
  store.track_slots();
  CHECK(store.first_moved() == kNoSlot);
  const Entity other = entities.create();
  store.add(other, -1), store.add(other, -2), store.remove(other);  // was not there then
  CHECK(store.gone()->empty());
  store.add(e[5], -5), store.remove(e[7]);
  REQUIRE(store.gone()->size() == 2);
  CHECK(((*store.gone())[0].owner == e[5] && (*store.gone())[0].value == 5));
  CHECK(((*store.gone())[1].owner == e[7] && (*store.gone())[1].value == 7));
  CHECK(store.first_moved() == 6);
  store.remove(e);
  CHECK(store.gone() == nullptr);
  store.track_slots();
  CHECK(store.gone()->empty());
}
