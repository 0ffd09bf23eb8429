// Over-constrained mechanisms: the joint that is one too many is named.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "tests/assembly/mechanisms.hpp"

using namespace pantin;
using namespace pantin::test;
using namespace pantin::detail::assembly;

namespace {

/// A linkage that is closed, with one rod between two points, or one joint, that does not fit.
struct Spoilt {
  World world;
  Entity culprit;
  std::size_t laws = 0;
};

/// Cases 0: a rigid frame with a rod that is 1 % too long. 1: a linkage that is locked by a rod at
/// two places. 2: a link of a closed polygon with one hinge askew.
Spoilt spoilt(std::uint64_t seed) {
  Random random(seed);
  Spoilt s;
  const int kind = static_cast<int>(seed % 3);
  if (kind == 2) {
    s.world = polygon(3);
    const auto which = static_cast<std::size_t>(random.word() % 4);
    Link& l = s.world.links.values()[which];
    s.culprit = s.world.links.owners()[which];
    // The axis leans by 0.1 to 0.4 rad about the link: parallel hinges cannot all hold.
    const Real lean = 0.25 + 0.15 * random.signed_unit();
    l.joint.frames.set_b(l.joint.frames.b() * from_rotation_vector({0, lean, 0}));
    s.laws = s.world.links.size();
    return s;
  }
  const int links = 4 + static_cast<int>(random.word() % 4);
  s.world = bendy(links);
  World& w = s.world;
  // Rods hold every link in place: from points of each link to the ground, six a link are rigid
  // with its joints. Lengths are those of the closed pose.
  const Entity ground = w.find("ground");
  std::vector<Entity> rods;
  for (int i = 0; i < links; ++i) {
    const Entity link = w.find("link" + std::to_string(i));
    for (int k = 0; k < 3; ++k) {
      const Vec3 at = 0.5 * random.in_ball(),
                 far = w.bodies[link].pose.position + 2.0 * random.direction();
      const Real length = glm::distance(to_world(w.bodies[link].pose, at), far);
      rods.push_back(add_rod(w, link, at, ground, far, length,
                             "rod" + std::to_string(i) + "_" + std::to_string(k)));
    }
  }
  if (kind == 0) {
    s.culprit = rods[random.word() % rods.size()];
    w.links[s.culprit].joint.parameters.edit().length *= 1.01;
  } else {
    const Entity link =
        w.find("link" + std::to_string(random.word() % static_cast<std::uint64_t>(links)));
    const Vec3 far = w.bodies[link].pose.position + 2.0 * random.direction();
    s.culprit = add_rod(w, link, Vec3(0), ground, far,
                        glm::distance(w.bodies[link].pose.position, far) + 0.2, "too_many");
  }
  s.laws = w.links.size();
  return s;
}

}  // namespace

TEST_CASE("assembly: contradictions are named", "[.long]") {
  const char* count = std::getenv("PANTIN_STARTS");
  const int all = count ? std::atoi(count) : 200;
  int impossible = 0, right = 0, needed = 0;
  std::size_t named = 0, laws = 0;
  for (int i = 0; i < all; ++i) {
    Spoilt s = spoilt(static_cast<std::uint64_t>(i) + 1);
    World w = s.world;
    const AssemblyReport r = assemble(w, {});
    if (r.assembled) continue;
    ++impossible;
    right += std::find(r.contradictory.begin(), r.contradictory.end(), s.culprit) !=
             r.contradictory.end();
    World without = s.world;
    without.destroy(s.culprit);
    needed += assemble(without, {}).assembled;
    named += r.contradictory.size(), laws += s.laws;
  }
  std::printf(
      "contradictions: %d of %d cannot be assembled; culprit in the set: %d; without it the "
      "rest holds: %d; set of %.1f laws of %.1f\n",
      impossible, all, right, needed, double(named) / impossible, double(laws) / impossible);
  CHECK(right >= 0.95 * impossible);
}

TEST_CASE("assembly: a rod that is too long is named, and what it contradicts") {
  // A triangle of the ground and two rods, and a third rod that does not fit; elsewhere a four-bar.
  World w = polygon(3);
  const Entity link = w.find("link1"), ground = w.find("ground");
  const Vec3 at = w.bodies[link].pose.position;
  add_rod(w, link, Vec3(0), ground, at + Vec3(0, 1, 0), 1, "fits");
  const Entity other = add_solid(w, {{5, 0, 0}, kIdentity}, "other");
  join(w, {ground, other, JointKind::ball, {5, 0, 0}}, "elsewhere");
  World closed = w;
  CHECK(assemble(closed, {}).assembled);
  const Entity wrong = add_rod(w, link, Vec3(0), ground, at + Vec3(0, 1, 0), 1.01, "wrong");
  const AssemblyReport r = assemble(w, {});
  CHECK_FALSE(r.assembled);
  REQUIRE(r.contradictory.size() == 2);
  std::vector<std::string> names;
  for (const Entity e : r.contradictory) names.push_back(w.name_of(e));
  CHECK(std::find(names.begin(), names.end(), "wrong") != names.end());
  CHECK(std::find(names.begin(), names.end(), "fits") != names.end());
  CHECK(w.is_alive(wrong));
}
