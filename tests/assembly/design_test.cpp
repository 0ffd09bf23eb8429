// Design variables: numbers of laws that change with the poses, as little as possible.
#include <algorithm>
#include <catch2/catch.hpp>
#include <pantin/assembler.hpp>

#include "engine/joints/cable_path.hpp"
#include "tests/assembly/mechanisms.hpp"
#include "tests/assembly/slopes.hpp"

using namespace pantin;
using namespace pantin::test;
using namespace pantin::detail::assembly;

namespace {

Real length_of(const World& w, Entity rod) { return w.links[rod].joint.parameters->length; }

/// A point mass held by rods to points of the ground.
struct Tripod {
  World world;
  Entity ground, tip;
  std::vector<Entity> rods;

  Tripod(const std::vector<Vec3>& feet, const std::vector<Real>& lengths, Vec3 at) {
    ground = add_solid(world, {}, "ground", Motion::fixed);
    tip = add_solid(world, {at}, "tip");
    for (std::size_t i = 0; i < feet.size(); ++i)
      rods.push_back(
          add_rod(world, ground, feet[i], tip, Vec3(0), lengths[i], "rod" + std::to_string(i)));
  }
  AssemblyReport assemble_with(const std::vector<DesignVariable>& free) {
    AssemblyChoices choices;
    choices.free = free;
    return assemble(world, choices);
  }
};

DesignVariable length(Entity of) { return {of, Quantity::length}; }

const std::vector<Vec3> kFeet = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.5}};

std::vector<Real> lengths_to(Vec3 at) {
  std::vector<Real> lengths;
  for (const Vec3 foot : kFeet) lengths.push_back(glm::distance(foot, at));
  return lengths;
}

}  // namespace

TEST_CASE("design: a length that does not fit becomes the length that fits") {
  const Vec3 at(0.4, 0.3, 1);
  const std::vector<Real> fit = lengths_to(at);
  for (std::size_t i = 0; i < 4; ++i) {
    std::vector<Real> lengths = fit;
    lengths[i] *= 0.99;
    Tripod t(kFeet, lengths, at + Vec3(0.05, -0.1, 0.2));
    CHECK_FALSE(t.assemble_with({}).assembled);
    Tripod freed(kFeet, lengths, at + Vec3(0.05, -0.1, 0.2));
    const AssemblyReport r = freed.assemble_with({length(freed.rods[i])});
    REQUIRE(r.assembled);
    CHECK(std::abs(length_of(freed.world, freed.rods[i]) - fit[i]) < 1e-11);
    CHECK(glm::distance(freed.world.bodies[freed.tip].pose.position, at) < 1e-10);
    REQUIRE(r.design.size() == 1);
    CHECK(r.design[0].before.numbers.x == lengths[i]);
    CHECK(r.design[0].after.numbers.x == length_of(freed.world, freed.rods[i]));
    CHECK_FALSE(r.design[0].is_at_bound);
  }
}

TEST_CASE("design: a rod of a four-bar linkage gets the length of the law of cosines") {
  // A crank of 0.3 m that a brace from a point of the ground holds at 70 degrees; the rod from its
  // pin to the second ground, 1 m away, is 1 % too short.
  const Real crank = 0.3, angle = 70 * kPi / 180;
  const Real across = std::sqrt(1 + crank * crank - 2 * crank * std::cos(angle));
  World w;
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  const Vec3 pin(crank * std::cos(angle), crank * std::sin(angle), 0);
  const Entity bar = add_solid(w, {0.5 * pin, axes_along(pin, {0, 0, 1})}, "crank");
  join(w, {ground, bar, JointKind::hinge, Vec3(0), axes_along({0, 0, 1}, {1, 0, 0})}, "A");
  const Vec3 end(crank / 2, 0, 0);
  add_rod(w, ground, {0, 1, 0}, bar, end, glm::distance(pin, Vec3(0, 1, 0)), "brace");
  const Entity rod = add_rod(w, ground, {1, 0, 0}, bar, end, 0.99 * across, "rod");
  World stays = w;
  CHECK_FALSE(assemble(stays, AssemblyChoices{}).assembled);
  AssemblyChoices choices;
  choices.free = {length(rod)};
  const AssemblyReport r = assemble(w, choices);
  REQUIRE(r.assembled);
  CHECK(r.mobility == 0);
  CHECK(std::abs(length_of(w, rod) - across) < 1e-12);
}

TEST_CASE("design: a strut to a linkage gets the least length that reaches") {
  World w = polygon(3);
  const Entity ground = w.find("ground"), crank = w.find("link0"), coupler = w.find("link1");
  const Vec3 far(-1, 4, 0), at(0.3, 0.1, 0.2);
  const World linkage = w;
  const Entity strut = add_rod(w, ground, far, coupler, at, 0.5, "strut");
  World stays = w;
  CHECK_FALSE(assemble(stays, AssemblyChoices{}).assembled);
  AssemblyChoices choices;
  choices.free = {length(strut)};
  const AssemblyReport r = assemble(w, choices);
  REQUIRE(r.assembled);
  // With the crank held a little further on or back, the point is further away: the length is
  // stationary, and least, in the only degree of freedom.
  const auto length_at = [&](Real turn) {
    World near = linkage;
    for (std::size_t i = 0; i < w.bodies.size(); ++i)
      near.bodies.values()[i].pose = w.bodies.values()[i].pose;
    Pose& pose = near.bodies[crank].pose;
    const Vec3 pivot(1, 0, 0);  // of the first hinge
    const Quat by = from_rotation_vector({0, 0, turn});
    pose = {pivot + by * (pose.position - pivot), by * pose.rotation};
    AssemblyChoices held;
    held.held = {crank};
    REQUIRE(assemble(near, held).assembled);
    return glm::distance(to_world(near.bodies[coupler].pose, at), far);
  };
  const Real least = length_of(w, strut);
  CHECK(length_at(0) == Approx(least).epsilon(1e-9));
  CHECK(length_at(1e-3) > least);
  CHECK(length_at(-1e-3) > least);
  CHECK(std::abs(length_at(1e-3) - length_at(-1e-3)) / 2e-3 < 1e-4);
}

TEST_CASE("design: in random frames the rod that is 1 % off gets its length back") {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const int links = 2 + static_cast<int>(random.word() % 4);
    World w = bendy(links);
    const Entity ground = w.find("ground");
    std::vector<Entity> rods;
    for (int i = 0; i < links; ++i) {
      const Entity link = w.find("link" + std::to_string(i));
      for (int k = 0; k < 3; ++k) {
        const Vec3 at = 0.5 * random.in_ball();
        const Vec3 far = w.bodies[link].pose.position + 2.0 * random.direction();
        const Real fit = glm::distance(to_world(w.bodies[link].pose, at), far);
        rods.push_back(add_rod(w, link, at, ground, far, fit, "rod"));
      }
    }
    const Entity rod = rods[random.word() % rods.size()];
    Real& spoilt = w.links[rod].joint.parameters.edit().length;
    const Real fit = spoilt;
    spoilt *= seed % 2 ? 1.01 : 0.99;
    AssemblyChoices choices;
    choices.free = {length(rod)};
    World one = w;
    const AssemblyReport r = assemble(one, choices);
    CHECK(r.assembled);
    found += std::abs(length_of(one, rod) - fit) < 1e-9;
    // With all lengths free no change is larger than that of the culprit alone.
    for (const Entity other : rods)
      if (other != rod) choices.free.push_back(length(other));
    World all = w;
    const AssemblyReport shared = assemble(all, choices);
    CHECK(shared.assembled);
    Real sum = 0;
    for (const DesignChange& c : shared.design) {
      const Real part = c.after.numbers.x / c.before.numbers.x - 1;
      sum += part * part;
    }
    CHECK(std::sqrt(sum) <= 1.0000001 * std::abs(1 / (seed % 2 ? 1.01 : 0.99) - 1));
  }
  CHECK(found == 40);
}

TEST_CASE("design: lengths that fit stay as they are, however far the start") {
  const Vec3 at(0.4, 0.3, 1);
  Tripod t(kFeet, lengths_to(at), Vec3(3, -2, 2));
  std::vector<DesignVariable> free;
  for (const Entity rod : t.rods) free.push_back(length(rod));
  const AssemblyReport r = t.assemble_with(free);
  REQUIRE(r.assembled);
  for (const DesignChange& c : r.design)
    CHECK(std::abs(c.after.numbers.x - c.before.numbers.x) < 1e-9);
}

TEST_CASE("design: two lengths share a change by their size") {
  // Two rods from the left and from the right on a line of 2 m, 3 % too short together: a change d
  // of each, relative to its length L, is least where L_1 d_1 + L_2 d_2 is given and d_i = k L_i.
  for (const Real left : {1.0, 0.5}) {
    const Real right = 2 - left;
    World w;
    const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
    const Entity slider = add_solid(w, {{left + 0.1, 0, 0}}, "slider");
    join(w, {ground, slider, JointKind::prismatic, {left + 0.1, 0, 0}}, "rail");
    const Entity one = add_rod(w, ground, {0, 0, 0}, slider, Vec3(0), 0.97 * left, "one");
    const Entity two = add_rod(w, ground, {2, 0, 0}, slider, Vec3(0), 0.97 * right, "two");
    AssemblyChoices choices;
    choices.free = {length(one), length(two)};
    const AssemblyReport r = assemble(w, choices);
    REQUIRE(r.assembled);
    const Real before[] = {0.97 * left, 0.97 * right}, missing = 2 - before[0] - before[1];
    const Real squares = before[0] * before[0] + before[1] * before[1];
    CHECK(std::abs(length_of(w, one) - before[0] * (1 + before[0] * missing / squares)) < 2e-9);
    CHECK(std::abs(length_of(w, two) - before[1] * (1 + before[1] * missing / squares)) < 2e-9);
  }
}

TEST_CASE("design: the change is the least of all closures") {
  // Four rods whose lengths are all free: the tip may be anywhere, so the least change is that of
  // the tip where sum (dL/L)^2 is least, found here by Newton's method on the tip alone.
  const std::vector<Real> lengths = {1.2, 1.0, 1.15, 0.9};
  Tripod t(kFeet, lengths, {0.4, 0.3, 1});
  std::vector<DesignVariable> free;
  for (const Entity rod : t.rods) free.push_back(length(rod));
  REQUIRE(t.assemble_with(free).assembled);
  const auto cost = [&](Vec3 x) {
    Real sum = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const Real d = glm::distance(x, kFeet[i]) / lengths[i] - 1;
      sum += d * d;
    }
    return sum;
  };
  const Vec3 tip = t.world.bodies[t.tip].pose.position;
  constexpr Real h = 1e-4;
  for (int i = 0; i < 3; ++i) {
    Vec3 by(0);
    by[i] = h;
    CHECK(std::abs(cost(tip + by) - cost(tip - by)) / (2 * h) < 1e-7);
    CHECK(cost(tip + 100.0 * by) > cost(tip));
    CHECK(cost(tip - 100.0 * by) > cost(tip));
  }
  CHECK(cost(tip) > 1e-3);
}

TEST_CASE("design: bounds hold, and the other numbers make up for them") {
  const Vec3 at(0.4, 0.3, 1);
  std::vector<Real> lengths = lengths_to(at);
  lengths[0] *= 0.95;
  Tripod t(kFeet, lengths, at);
  DesignVariable bounded = length(t.rods[0]);
  bounded.most = lengths[0] * 1.01;
  AssemblyReport r = t.assemble_with({bounded});
  CHECK_FALSE(r.assembled);
  REQUIRE(r.design.size() == 1);
  CHECK(r.design[0].is_at_bound);
  CHECK(length_of(t.world, t.rods[0]) == Approx(bounded.most).epsilon(1e-15));
  Tripod both(kFeet, lengths, at);
  r = both.assemble_with({bounded, length(both.rods[1])});
  CHECK(r.assembled);
  CHECK(length_of(both.world, both.rods[0]) <= bounded.most);
  CHECK(std::abs(length_of(both.world, both.rods[1]) - lengths[1]) > 1e-3);
}

TEST_CASE("design: a four-bar linkage whose axis leans gets a parallel one") {
  World w = polygon(3);
  Link& l = w.links.values()[1];
  const Entity hinge = w.links.owners()[1];
  l.joint.frames.set_b(l.joint.frames.b() * from_rotation_vector({0, 0.2, 0.1}));
  World stays = w;
  CHECK_FALSE(assemble(stays, AssemblyChoices{}).assembled);
  AssemblyChoices choices;
  choices.free = {{hinge, Quantity::axis_b}};
  REQUIRE(assemble(w, choices).assembled);
  // Its axis is along z again, as that of all others, in a linkage of one degree of freedom.
  const Link& freed = w.links[hinge];
  const Vec3 axis = w.bodies[freed.b].pose.rotation * freed.joint.frames.b() * Vec3(1, 0, 0);
  CHECK(glm::length(glm::cross(axis, Vec3(0, 0, 1))) < 1e-9);
}

TEST_CASE("design: an anchor moves to where the linkage closes") {
  World w = polygon(3);
  const Entity hinge = w.links.owners()[2];
  // Along its axis, which no rotation makes up for. The axis of a body is not along its z.
  const Vec3 along = w.links[hinge].joint.frames.a() * Vec3(1, 0, 0);
  w.links[hinge].joint.anchor_a += 0.05 * along;
  World stays = w;
  CHECK_FALSE(assemble(stays, AssemblyChoices{}).assembled);
  const Vec3 before = w.links[hinge].joint.anchor_a;
  AssemblyChoices choices;
  choices.free = {{hinge, Quantity::anchor_a}};
  const AssemblyReport r = assemble(w, choices);
  REQUIRE(r.assembled);
  CHECK(r.mobility == 1);
  CHECK(glm::distance(w.links[hinge].joint.anchor_a, before) == Approx(0.05).margin(1e-9));
}

TEST_CASE("design: a screw between a rod and its turn gets the pitch that fits") {
  // A nut that is turned by 2 rad and held 0.5 m along the axis: the pitch is 0.25 m/rad.
  World w;
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  const Entity nut = add_solid(w, {{0.5, 0, 0}, from_rotation_vector({2, 0, 0})}, "nut");
  Joint screw;
  screw.kind = JointKind::screw, screw.parameters.edit().pitch = 0.2;
  const Entity thread = add_link(w, {ground, nut, screw}, "screw");
  Joint held;
  held.kind = JointKind::fixed, held.anchor_a = {0.5, 0, 0};
  held.frames.set_a(from_rotation_vector({2, 0, 0}));
  add_link(w, {ground, nut, held}, "held");
  World stays = w;
  CHECK_FALSE(assemble(stays, AssemblyChoices{}).assembled);
  AssemblyChoices choices;
  choices.free = {{thread, Quantity::pitch}};
  REQUIRE(assemble(w, choices).assembled);
  CHECK(std::abs(w.links[thread].joint.parameters->pitch - 0.25) < 1e-12);
}

TEST_CASE("design: derivatives are those of the rows") {
  for (const Quantity q :
       {Quantity::anchor_a, Quantity::anchor_b, Quantity::axis_a, Quantity::axis_b})
    for (const World& w : {polygon(3), bricard(), bent(4)})
      CHECK(error_of_slopes(w, {w.links.owners()[1], q}) < 1e-8);
  const Tripod t(kFeet, {1.2, 1, 1.15, 0.9}, {0.4, 0.3, 1});
  CHECK(error_of_slopes(t.world, length(t.rods[2])) < 1e-8);
  World turned;
  const Entity bed = add_solid(turned, {}, "bed", Motion::fixed);
  const Entity nut = add_solid(turned, {{0.3, 0, 0}, axes_along({1, 0.1, 0}, {0, 1, 1})}, "nut");
  Joint screw;
  screw.kind = JointKind::screw, screw.parameters.edit().pitch = 0.1;
  const Entity thread = add_link(turned, {bed, nut, screw}, "screw");
  CHECK(error_of_slopes(turned, {thread, Quantity::pitch}) < 1e-8);
  // A cable over a pulley of a body that hangs on it, taut.
  World w;
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  const Entity load = add_solid(w, {{0.5, -1, 0}, axes_along({1, 0.2, 0}, {0, 1, 0})}, "load");
  CableParameters cable;
  cable.anchor_a = {-1, 0, 0}, cable.anchor_b = {1.5, 0.3, 0}, cable.length = 1;
  const Entity rope = add_cable(w, {ground, ground, cable}, "rope");
  w.cables[rope].guides.push_back({load, {0.05, 0.1, 0}, {0, 0, 1}, 0.2});
  w.cables[rope].guides.push_back({ground, {0.9, 0.2, 0}, {0, 0, -1}, 0.1});
  for (const Quantity q : {Quantity::length, Quantity::anchor_a, Quantity::anchor_b})
    CHECK(error_of_slopes(w, {rope, q}) < 1e-8);
  for (const std::uint32_t guide : {0u, 1u})
    CHECK(error_of_slopes(w, {rope, Quantity::radius, guide}) < 1e-8);
}

TEST_CASE("design: lengths are free from outside") {
  const Vec3 at(0.4, 0.3, 1);
  std::vector<Real> lengths = lengths_to(at);
  lengths[1] *= 1.01;
  Tripod t(kFeet, lengths, at);
  const std::vector<FreeLength> free = {{t.rods[1]}, {t.ground}};
  World w = t.world;
  const Assembly fits = pantin::assemble(w, {}, 1e-12, free);
  CHECK(fits.assembled);
  REQUIRE(fits.lengths.size() == 2);
  CHECK(std::abs(fits.lengths[0] - glm::distance(kFeet[1], at)) < 1e-11);
  CHECK(fits.lengths[0] == length_of(w, t.rods[1]));
  CHECK(fits.lengths[1] == 0);  // the ground has no length
  w = t.world;
  const Assembly bounded = pantin::assemble(w, {}, 1e-12, {{t.rods[1], lengths[1] * 0.995}});
  CHECK_FALSE(bounded.assembled);
  CHECK(bounded.lengths[0] == Approx(lengths[1] * 0.995).epsilon(1e-15));
}

TEST_CASE("design: the result is the same bits each time, and by all Newton methods the same") {
  std::vector<World> found;
  for (const Method& m : methods()) {
    if (!m.changes_design) continue;
    for (int again = 0; again < 2; ++again) {
      Tripod t(kFeet, {1.2, 1, 1.15, 0.9}, {0.4, 0.3, 1});
      AssemblyChoices choices;
      choices.method = &m;
      choices.free = {length(t.rods[0]), length(t.rods[3])};
      REQUIRE(assemble(t.world, choices).assembled);
      found.push_back(t.world);
    }
  }
  REQUIRE(found.size() == 6);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Entity rod = found[i].links.owners()[0];
    if (i % 2) CHECK(length_of(found[i], rod) == length_of(found[i - 1], rod));
    CHECK(std::abs(length_of(found[i], rod) - length_of(found[0], rod)) < 1e-8);
  }
}
