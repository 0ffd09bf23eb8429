// What holds for timed events, of every kind in the list.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>

#include "engine/base/archive.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/runtime/events.hpp"
#include "engine/world/ties.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

void each_kind(auto check) {
  const auto each = [&]<class... Kinds>(const std::variant<Kinds...>*) {
    const auto one = [&]<class Event>(Event event) {
      INFO(Event::name);
      check(event);
    };
    (one(Kinds{}), ...);
  };
  each(static_cast<const EventKinds*>(nullptr));
}

/// Fills every field with some number, each larger than the one before.
struct Filler {
  Real last = 0.2;
  Real next() { return last += 0.17; }

  void operator()(const char*, Real& x) { x = next(); }
  void operator()(const char*, Vec3& v) { v = {next(), next(), next()}; }
  void operator()(const char*, Quat& q) { q = glm::normalize(Quat(next(), 0.1, 0.2, 0.3)); }
  void operator()(const char*, std::uint64_t& n) { n = static_cast<std::uint64_t>(10 * next()); }
  void operator()(const char*, std::vector<Entity>& list) { list.resize(3); }
  void operator()(const char*, JointMotor& motor) { motor.target = next(), motor.gain = next(); }
  template <class T>
  void operator()(const char*, T&) {}
};

std::string bytes_of(const TimedEvent& event) {
  FieldWriter writer;
  writer.write(event);
  return std::string(writer.bytes());
}

/// A World in which there is something of all that events act on.
struct Things {
  World world;
  Entity ball, hinge;

  Things() {
    Body wall;
    wall.motion = Motion::fixed;
    const Entity fixed = world.add_body(wall);
    ball = world.add_body(Body{});
    Joint joint;
    joint.kind = JointKind::hinge;
    hinge = add_link(world, {fixed, ball, joint});
    world.joint_drives.add(hinge, {});
  }
  /// An event on these, at `time`.
  template <class Event>
  Event at(Event event, Real time) const {
    if constexpr (requires { event.body; }) event.body = ball;
    if constexpr (requires { event.joint; }) event.joint = hinge;
    if constexpr (requires { event.tie; }) event.tie = hinge;
    if constexpr (requires { event.to; })
      event.from = time, event.to = time + 0.5;
    else
      event.at = time;
    return event;
  }
};

}  // namespace

TEST_CASE("Kinds of events have names of their own, and keys that tell what they are") {
  std::set<std::string_view> names;
  each_kind([&](const auto& event) {
    using Event = std::decay_t<decltype(event)>;
    CHECK_FALSE(Event::about.empty());
    CHECK(names.insert(Event::name).second);
    std::set<std::string_view> keys;
    Event::scene_keys(event, [&](const EventKey& key, const auto&) {
      CHECK_FALSE(key.about.empty());
      CHECK(keys.insert(key.key).second);
    });
    CHECK(keys.size() > 1);
    if constexpr (requires { Event::needs; }) CHECK_FALSE(Event::needs.complaint.empty());
  });
  CHECK(names.size() == std::variant_size_v<EventKinds>);
}

TEST_CASE("Every kind of event is written and read again, bit for bit") {
  each_kind([](auto event) {
    Filler filler;
    event.fields(event, filler);
    const TimedEvent from{event};
    const std::string bytes = bytes_of(from);
    FieldReader reader(bytes);
    TimedEvent to{};
    reader.read(to);
    REQUIRE(reader.ok());
    CHECK(reader.left() == 0);
    CHECK(bytes_of(to) == bytes);
    CHECK(name_of(to) == event.name);
  });
}

TEST_CASE("Every kind of event refuses times and vectors that are not finite") {
  each_kind([](auto event) {
    CHECK_FALSE(fault_of(TimedEvent{event}));
    auto late = event;
    if constexpr (requires { late.at; })
      late.at = -1;
    else
      late.from = -1;
    REQUIRE(fault_of(TimedEvent{late}));
    CHECK(std::string(fault_of(TimedEvent{late})->expected).find("a time from 0 on") == 0);
    event.fields(event, [&]<class T>(const char* name, T& member) {
      if constexpr (std::is_same_v<T, Vec3>) {
        const Vec3 before = member;
        member.y = std::nan("");
        REQUIRE(fault_of(TimedEvent{event}));
        CHECK(std::string(fault_of(TimedEvent{event})->member) == name);
        member = before;
      }
    });
  });
}

TEST_CASE("Every kind of event waits for its time, happens and is done") {
  each_kind([](const auto& event) {
    Things things;
    World& world = things.world;
    const Entity e = add_event(world, {things.at(event, 1)});
    const auto progress = [&] { return events_of(world)[e].progress; };
    const auto run_to = [&](Real end) {
      for (; world.time < end; world.time += 0.125) apply_events(world, 0.125);
    };
    run_to(0.875);
    CHECK_FALSE(progress().done);
    CHECK(progress().fired == 0);
    run_to(4);
    CHECK(progress().done);
  });
}

TEST_CASE("Every kind of event is harmless once what it acts on is gone") {
  each_kind([](const auto& event) {
    Things things;
    World& world = things.world;
    add_event(world, {things.at(event, 0.25)});
    world.destroy(things.ball);
    for (int i = 0; i < 32; ++i, world.time += 0.125) apply_events(world, 0.125);
    CHECK(world.bodies.size() == 1);
    CHECK(world.pins.empty());
  });
}
