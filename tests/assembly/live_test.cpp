// Bodies follow targets, one iteration a call.
#include "engine/assembly/live.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <pantin/assembler.hpp>
#include <pantin/must.hpp>
#include <pantin/pantin.hpp>
#include <thread>

#include "tests/assembly/mechanisms.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// A chain of `n` links of 1 m on ball joints, straight along x, with one end on the ground.
World chain(int n) {
  World w;
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  Entity before = ground;
  for (int i = 0; i < n; ++i) {
    // Folded a little, so that the end may move along x.
    const Vec3 along(std::cos(0.4), i % 2 ? std::sin(0.4) : -std::sin(0.4), 0);
    const Vec3 from(i * std::cos(0.4), i % 2 ? -std::sin(0.4) : 0, 0);
    const Entity link = add_solid(w, {from + 0.5 * along, axes_along(along, {0, 0, 1})},
                                  "link" + std::to_string(i));
    join(w, {before, link, JointKind::ball, from}, "joint" + std::to_string(i));
    before = link;
  }
  return w;
}

Vec3 end_of(const World& w, Entity link) { return to_world(w.bodies[link].pose, {0.5, 0, 0}); }

}  // namespace

TEST_CASE("assembler: a chain follows a hand at the rate of a haptic loop") {
  for (const int n : {8, 20, 100}) {
    const World w = chain(n);
    const Entity last = w.find("link" + std::to_string(n - 1));
    const Vec3 start = end_of(w, last);
    Assembler drag(w);
    const Target hand =
        must(drag.add(PointTarget{.body = last, .point = {0.5, 0, 0}, .target = start}));
    drag.settle(50);
    constexpr Real kRate = 30000;
    Real joints = 0, target = 0;
    for (int i = 0; i < 15000; ++i) {
      const Real phase = 2 * kPi * i / kRate;
      REQUIRE(drag.move(hand, start + 0.4 * Vec3(std::cos(phase) - 1, std::sin(phase), 0)));
      const AssemblerErrors e = drag.iterate();
      joints = std::max(joints, e.joints);
      if (i > 100) target = std::max(target, e.targets);
    }
    INFO(n << " links: joints " << joints << ", target " << target);
    CHECK(joints < 1e-6);
    CHECK(target < 1e-6);
  }
}

TEST_CASE("assembler: steps with an older factor are as good as with a new one") {
  const World w = chain(8);
  const Entity last = w.find("link7");
  const Vec3 start = end_of(w, last);
  enum class Path { circle, shaken, stops };
  for (const Path path : {Path::circle, Path::shaken, Path::stops}) {
    Assembler drag(w);
    const Target hand =
        must(drag.add(PointTarget{.body = last, .point = {0.5, 0, 0}, .target = start}));
    drag.settle(50);
    Real joints = 0, target = 0;
    for (int i = 0; i < 6000; ++i) {
      const Real phase = 2 * kPi * (path == Path::stops ? i - i % 100 : i) / 30000;
      Vec3 to = start + 0.4 * Vec3(std::cos(phase) - 1, std::sin(phase), 0);
      if (path == Path::shaken) to.z += 1e-4 * ((7 * i) % 5 - 2);
      drag.move(hand, to);
      const AssemblerErrors e = drag.iterate();
      joints = std::max(joints, e.joints);
      if (i > 100 && (path != Path::stops || i % 100 > 3)) target = std::max(target, e.targets);
    }
    INFO("joints " << joints << ", target " << target);
    CHECK(joints < (path == Path::circle ? 2e-8 : 1e-6));
    CHECK(target < (path == Path::circle ? 2e-8 : 1e-6));
  }
}

TEST_CASE("assembler: out of reach the joints hold and the end is nearest") {
  const World w = chain(5);
  const Entity last = w.find("link4");
  Assembler pull(w);
  const Vec3 far(6, 8, 0);
  must(pull.add(PointTarget{.body = last, .point = {0.5, 0, 0}, .target = far}));
  Real joints = 0;
  for (int i = 0; i < 3000; ++i) {
    const AssemblerErrors e = pull.iterate();
    if (i > 200) joints = std::max(joints, e.joints);
  }
  CHECK(joints < 1e-5);
  // Straight towards the target, 10 m away, 5 m long.
  CHECK(glm::distance(end_of(pull.world(), last), Vec3(3, 4, 0)) < 1e-4);
}

TEST_CASE("assembler: contradicting targets meet at the mean of their weights") {
  World w;
  const Entity body = add_solid(w, {}, "body");
  Assembler both(w);
  must(both.add(PointTarget{.body = body, .target = {0, 0, 0}, .weight = 1}));
  const Target second = must(both.add(PointTarget{.body = body, .target = {1, 0, 0}, .weight = 3}));
  both.settle(2000);
  CHECK(both.world().bodies[body].pose.position.x == Approx(0.75).margin(1e-6));
  REQUIRE(both.set_weight(second, 1));
  both.settle(2000);
  CHECK(both.world().bodies[body].pose.position.x == Approx(0.5).margin(1e-6));
}

TEST_CASE("assembler: a pose and an aim are met") {
  World w;
  const Entity body = add_solid(w, {}, "body"), eye = add_solid(w, {{2, 0, 0}, kIdentity}, "eye");
  Assembler both(w);
  const Pose there{{0.3, 0.4, -0.2}, glm::normalize(Quat(0.9, 0.2, 0.1, -0.3))};
  must(both.add(PoseTarget{.body = body, .target = there}));
  both.hold(body), both.let_go(body);
  const Target aim =
      must(both.add(AimTarget{.body = eye, .direction = {0, 0, 1}, .target = {1, 2, 3}}));
  both.settle(500);
  const Pose found = both.world().bodies[body].pose;
  CHECK(glm::distance(found.position, there.position) < 1e-9);
  CHECK(std::abs(glm::dot(found.rotation, there.rotation)) == Approx(1).margin(1e-12));
  const auto off_line = [&](Vec3 target) {
    const Pose at = both.world().bodies[eye].pose;
    const Vec3 d = target - at.position, along = at.rotation * Vec3(0, 0, 1);
    return glm::length(d - glm::dot(d, along) * along);
  };
  CHECK(off_line({1, 2, 3}) < 1e-9);
  REQUIRE(both.move(aim, Vec3(-1, 2, 0.5)));
  CHECK(off_line({-1, 2, 0.5}) > 0.1);
  both.settle(500);
  CHECK(off_line({-1, 2, 0.5}) < 1e-9);
}

TEST_CASE("assembler: limits are respected while a hand pulls beyond them") {
  World w;
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  const Entity arm = add_solid(w, {{0.5, 0, 0}, kIdentity}, "arm");
  const Entity hinge =
      join(w, {ground, arm, JointKind::hinge, Vec3(0), axes_along({0, 0, 1}, {1, 0, 0})}, "elbow");
  w.links[hinge].joint.limits.edit().angle = {true, -0.3, 0.8};
  Assembler pull(w);
  const Target hand =
      must(pull.add(PointTarget{.body = arm, .point = {0.5, 0, 0}, .target = {0, 1, 0}}));
  const auto angle = [&] {
    const Quat q = pull.world().bodies[arm].pose.rotation;
    return std::remainder(2 * std::atan2(q.z, q.w), 2 * kPi);
  };
  Real most = -10, least = 10;
  for (int i = 0; i < 300; ++i) pull.iterate(), most = std::max(most, angle());
  CHECK(most < 0.8 + 1e-6);
  CHECK(angle() == Approx(0.8).margin(1e-6));
  REQUIRE(pull.move(hand, Vec3(0, -1, 0)));
  for (int i = 0; i < 300; ++i) pull.iterate(), least = std::min(least, angle());
  CHECK(least > -0.3 - 1e-6);
  CHECK(angle() == Approx(-0.3).margin(1e-6));
  REQUIRE(pull.move(hand, Vec3(1, 0.2, 0)));
  for (int i = 0; i < 300; ++i) pull.iterate();
  CHECK(angle() == Approx(std::atan2(0.2, 1)).margin(1e-6));
}

namespace {

/// A figure on its feet looks and reaches for a ball that circles in front of it, in steps of 2 mm.
struct Reach {
  Real far = 0, joints = 0;  // m, the largest errors after the first hundred steps
  Vec3 elbow{0};             // where it is in the end
};
Reach reach(bool limited) {
  World w;
  w.default_settings.solver = Solver::lagrangian;
  const Ragdoll doll = must(build_ragdoll(w, {}));
  for (Link& l : w.links.values())
    if (!limited) l.joint.limits = {};
  Assembler figure(w);
  for (const Entity foot : doll.feet) figure.hold(foot);
  const Entity arm = doll.forearms[1];
  const Vec3 tip{0, -0.13, 0}, rest = to_world(w.bodies[arm].pose, tip);
  const Target hand = must(figure.add(PointTarget{.body = arm, .point = tip, .target = rest}));
  const Target gaze = must(figure.add(
      AimTarget{.body = doll.head, .direction = {0, 0, 1}, .target = {0, 1.6, 1}, .weight = 0.1}));
  Reach r;
  for (int i = 0; i < 600; ++i) {
    const Real angle = 2 * kPi * i / 600;
    const Vec3 ball = rest + Vec3(0.15 * (std::cos(angle) - 1), 0.3 + 0.2 * std::sin(angle), 0.3);
    figure.move(hand, ball), figure.move(gaze, ball);
    const AssemblerErrors e = figure.iterate();
    r.joints = std::max(r.joints, e.joints);
    if (i > 100) r.far = std::max(r.far, e.targets);
  }
  r.elbow = figure.world().bodies[arm].pose.position;
  return r;
}

}  // namespace

TEST_CASE("assembler: a hand in reach is followed as closely while limits press") {
  const Reach free = reach(false), limited = reach(true);
  CAPTURE(1e6 * free.far, 1e6 * limited.far);
  CHECK(glm::distance(free.elbow, limited.elbow) > 0.01);
  CHECK(free.far < 5e-5);
  CHECK(limited.far < 5e-5);
  CHECK(limited.joints < 1e-6);
}

TEST_CASE("assembler: held bodies stay, wrong targets are refused") {
  const World w = chain(3);
  Assembler a(w);
  const Entity first = w.find("link0");
  const Pose before = w.bodies[first].pose;
  a.hold(first);
  must(a.add(PointTarget{.body = w.find("link2"), .point = {0.5, 0, 0}, .target = {1, 1, 1}}));
  const Target idle = must(a.add(PointTarget{.body = first, .target = {9, 9, 9}}));
  const AssemblerErrors errors = a.settle();
  CHECK(errors.targets < 1);  // a held body follows no target
  CHECK(a.move(idle, Vec3(8)));
  CHECK(a.iterate().targets < 1);
  a.remove(idle);
  CHECK_FALSE(a.move(idle, Vec3(7)));
  CHECK(a.world().bodies[first].pose.position == before.position);
  CHECK_FALSE(a.add(PointTarget{.body = w.find("ground"), .target = {1, 1, 1}}));
  CHECK_FALSE(a.add(PointTarget{.body = {}, .target = {1, 1, 1}}));
  CHECK_FALSE(a.add(PointTarget{.body = first, .target = {NAN, 1, 1}}));
  CHECK_FALSE(a.add(AimTarget{.body = first, .direction = {0, 0, 0}}));
  CHECK_FALSE(a.move(Target{17}, Vec3(0)));
}

namespace {

using assembly::Goal;
using assembly::Live;

/// Targets of a mechanism that is led with 30 kHz, on circles.
struct Led {
  World world;
  std::vector<Entity> held;
  std::vector<assembly::LiveTarget> targets;

  Live start() const {
    Live live(world, held);
    for (const assembly::LiveTarget& t : targets) live.add(t);
    return live;
  }
};

Led led_chain() {
  Led led{chain(8), {}, {}};
  const Entity last = led.world.find("link7");
  led.targets = {{Goal::point, last, {{0.5, 0, 0}, kIdentity}, {end_of(led.world, last), {}}}};
  return led;
}
Led led_platform() {
  Led led{stewart(), {}, {}};
  led.targets = {{Goal::pose, led.world.find("platform"), {}, {{0, 1, 0}, kIdentity}, 1, 0.5}};
  return led;
}
/// A figure on its feet whose limits press.
Led led_figure() {
  Led led;
  led.world.default_settings.solver = Solver::lagrangian;
  const Ragdoll doll = must(build_ragdoll(led.world, {}));
  led.held.assign(doll.feet.begin(), doll.feet.end());
  const Pose tip{{0, -0.13, 0}, kIdentity}, along{Vec3(0), axes_along({0, 0, 1}, {0, 1, 0})};
  const Vec3 hand = to_world(led.world.bodies[doll.forearms[1]].pose, tip.position);
  led.targets = {{Goal::point, doll.forearms[1], tip, {hand + Vec3(0, 0.3, 0.3), kIdentity}},
                 {Goal::aim, doll.head, along, {{0, 1.6, 1}, kIdentity}, 0.1}};
  return led;
}

/// One iteration; the bits of its poses and errors.
std::uint64_t bits_of_iteration(Live& live, const Led& led, int i) {
  const Real phase = 2 * kPi * i / 30000;
  for (std::size_t t = 0; t < led.targets.size(); ++t) {
    Pose to = led.targets[t].target;
    to.position += 0.2 * Vec3(std::cos(phase) - 1, std::sin(phase), 0);
    live.move(t, to);
  }
  const assembly::LiveReport report = live.iterate();
  Hash hash;
  hash.add(report.joint_error), hash.add(report.target_error);
  for (const Body& b : live.world().bodies.values()) hash.add(b.pose);
  return hash.value();
}

using Bits = std::vector<std::uint64_t>;  // by iteration
Bits bits_of_run(Live& live, const Led& led, int from, int to) {
  Bits bits;
  for (int i = from; i < to; ++i) bits.push_back(bits_of_iteration(live, led, i));
  return bits;
}

constexpr int kRun = 400;  // iterations, several times those that a factor serves

/// The bits of a run from the start, which must be those of a chord method.
Bits reference(const Led& led) {
  Live live = led.start();
  Bits bits = bits_of_run(live, led, 0, kRun);
  Live renewed = led.start();
  int same = 0;
  for (int i = 0; i < kRun; ++i) {
    for (std::size_t t = 0; t < led.targets.size(); ++t)  // its factor serves one step only
      renewed.set_weight(t, led.targets[t].weight, led.targets[t].turn_weight);
    same += bits_of_iteration(renewed, led, i) == bits[i];
  }
  REQUIRE(same < kRun / 4);
  return bits;
}

/// Leaves freed memory full of numbers that no one should read.
void litter() {
  std::vector<std::vector<Real>> blocks;
  for (std::size_t size = 1; size < 20000; size += 1 + size / 8) blocks.emplace_back(size, 1e7);
}

}  // namespace

TEST_CASE("assembler: a run gives the same bits whatever ran before or beside it") {
  const Led all[] = {led_chain(), led_platform(), led_figure()};
  for (const Led& led : all) {
    const Bits bits = reference(led);
    litter();
    Live others[] = {all[0].start(), all[1].start(), all[2].start()}, again = led.start();
    Bits beside;
    for (int i = 0; i < kRun; ++i) {
      beside.push_back(bits_of_iteration(again, led, i));
      for (int k = 0; k < 3; ++k) bits_of_iteration(others[k], all[k], 5 * i);
    }
    CHECK(beside == bits);
    Live at_once[] = {led.start(), led.start()};
    Bits in_thread;
    std::thread thread([&] { in_thread = bits_of_run(at_once[0], led, 0, kRun); });
    CHECK(bits_of_run(at_once[1], led, 0, kRun) == bits);
    thread.join();
    CHECK(in_thread == bits);
  }
}

TEST_CASE("assembler: copies go on with the same bits, at every age of the factor") {
  for (const Led& led : {led_chain(), led_platform(), led_figure()}) {
    const Bits bits = reference(led);
    Live live = led.start(), over = led_chain().start();
    over.iterate();
    constexpr int kFirst = 100, kAges = 34;  // two more than the steps that a factor serves
    bits_of_run(live, led, 0, kFirst);
    for (int i = kFirst; i < kFirst + kAges; ++i) {
      INFO("copied before iteration " << i);
      Live copy = live;
      over = copy;
      const Bits rest(bits.begin() + i, bits.end());
      CHECK(bits_of_run(copy, led, i, kRun) == rest);
      Live moved = std::move(over);
      CHECK(bits_of_run(moved, led, i, kRun) == rest);
      over = moved;
      REQUIRE(bits_of_iteration(live, led, i) == bits[i]);
    }
  }
}

TEST_CASE("assembler: a copy of an Assembler follows its own targets") {
  const World w = chain(8);
  const PointTarget hand{.body = w.find("link7"), .point = {0.5, 0, 0}, .target = {5, 1, 0}};
  Assembler one(w);
  const Target target = must(one.add(hand));
  one.settle(20);
  Assembler other = one;
  CHECK(one.iterate().targets == other.iterate().targets);
  REQUIRE(other.move(target, Vec3(5, 2, 0)));
  one.settle(), other.settle();
  CHECK(end_of(one.world(), hand.body).y == Approx(1).margin(1e-9));
  CHECK(end_of(other.world(), hand.body).y == Approx(2).margin(1e-9));
  one = other;
  CHECK(end_of(one.world(), hand.body) == end_of(other.world(), hand.body));
}

TEST_CASE("assembler: a World taken amid a run starts the same run in each of its copies") {
  for (const Led& led : {led_chain(), led_platform(), led_figure()}) {
    Live live = led.start();
    bits_of_run(live, led, 0, kRun / 2);
    Led written = led, taken = led;
    live.write_to(written.world);
    taken.world = live.world();
    const World copy = taken.world;
    Live first = taken.start();
    const Bits bits = bits_of_run(first, led, kRun / 2, kRun);
    litter();
    taken.world = copy;
    for (const Led& again : {taken, written}) {
      Live second = again.start();
      CHECK(bits_of_run(second, led, kRun / 2, kRun) == bits);
    }
  }
}
