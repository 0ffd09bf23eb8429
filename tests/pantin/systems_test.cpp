// Systems that have names: their order, and taking them out again.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;
using namespace pantin::detail;

namespace {

struct Journal {
  Simulation simulation;
  std::string text;
  System note(char letter) {
    return [this, letter](World&, Real) { text += letter; };
  }
  std::string step() {
    text.clear();
    simulation.step();
    return text;
  }
};

}  // namespace

TEST_CASE("systems run before and after those they name, else as they were inserted") {
  Journal j;
  Simulation& s = j.simulation;
  const Stage at = Stage::before_update;
  REQUIRE(s.insert(at, j.note('x')));
  REQUIRE(s.insert(at, {.name = "c", .after = {"b"}}, j.note('c')));
  REQUIRE(s.insert(at, {.name = "d"}, j.note('d')));
  REQUIRE(s.insert(at, {.name = "b"}, j.note('b')));
  REQUIRE(s.insert(at, {.name = "a", .before = {"b", "nobody"}}, j.note('a')));
  CHECK(j.step() == "xdabc");
  REQUIRE(s.remove("b"));
  CHECK(j.step() == "xcda");
  REQUIRE(s.insert(at, {.name = "b"}, j.note('b')));
  CHECK(j.step() == "xdabc");
}

TEST_CASE("names that are taken, circles and unknown names are refused, and nothing changes") {
  Journal j;
  Simulation& s = j.simulation;
  const Stage at = Stage::after_step;
  REQUIRE(s.insert(at, {.name = "a", .after = {"b"}}, j.note('a')));
  REQUIRE(s.insert(at, {.name = "b", .after = {"c"}}, j.note('b')));
  const auto circle = s.insert(at, {.name = "c", .after = {"a"}}, j.note('c'));
  REQUIRE_FALSE(circle);
  CHECK(circle.errors().front().message ==
        "system 'c': found a cycle in the order of systems, expected a first and a last system");
  const auto twice = s.insert(Stage::before_drive, {.name = "a"}, j.note('!'));
  REQUIRE_FALSE(twice);
  CHECK(twice.errors().front().message ==
        "system 'a': found another system of that name, expected a new one");
  CHECK_FALSE(s.insert(at, {.name = ""}, j.note('!')));
  CHECK_FALSE(s.insert(at, {.name = "e", .before = {"e"}}, j.note('!')));
  CHECK_FALSE(s.remove("c"));
  CHECK(j.step() == "ba");
}

TEST_CASE("what a system keeps for itself outlives the coming and going of others") {
  World world;
  Simulation s = Simulation::copy_of(world);
  int seen = 0;
  REQUIRE(s.insert(Stage::before_update, {.name = "counter"},
                   [&seen, count = 0](World&, Real) mutable { seen = ++count; }));
  s.step(), s.step();
  REQUIRE(s.insert(Stage::before_update, {.name = "other", .before = {"counter"}},
                   [](World&, Real) {}));
  s.step();
  REQUIRE(s.remove("other"));
  s.step();
  CHECK(seen == 4);
}

TEST_CASE("a function of a const World is a system; within a step systems stay as they are") {
  Simulation s;
  std::uint64_t tick = 99;
  REQUIRE(s.insert(Stage::before_update, [&](const World& world, Real) { tick = world.tick; }));
  bool refused = false;
  REQUIRE(s.insert(Stage::after_step, {.name = "greedy"}, [&](World&, Real) {
    refused = !s.insert(Stage::after_step, [](World&, Real) {}) && !s.remove("greedy");
  }));
  s.step();
  CHECK(tick == 0);
  CHECK(refused);
}
