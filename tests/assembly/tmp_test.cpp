#include <catch2/catch.hpp>
#include <cstdio>
#include "tests/assembly/mechanisms.hpp"
using namespace pantin;
using namespace pantin::test;
using namespace pantin::detail::assembly;
TEST_CASE("tmp trace", "[.]") {
  for (const World& m : {stewart(), polygon(3), bendy(8)}) {
    World w = m;
    scatter(w, 1003, 1, {});
    AssemblyChoices c;
    c.watch = [](const Iteration& i) { std::printf("%3d res %.3e merit %.3e mu %.1e\n", i.number, i.residual, i.merit, i.damping); };
    const auto r = assemble(w, c);
    std::printf("rows %zu rank %zu mobility %ld turned %d starts %d\n", r.rows, r.rank, long(r.mobility), r.turned_over, r.starts);
  }
}
#include <pantin/assembler.hpp>
#include <pantin/must.hpp>
TEST_CASE("tmp limit", "[.]") {
  World w;
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  const Entity arm = add_solid(w, {{0.5, 0, 0}, kIdentity}, "arm");
  const Entity hinge = join(w, {ground, arm, JointKind::hinge, Vec3(0), axes_along({0, 0, 1}, {1, 0, 0})},
                            "elbow");
  w.links[hinge].joint.limits.edit().angle = {true, -0.3, 0.8};
  Assembler pull(w);
  must(pull.add(PointTarget{.body = arm, .point = {0.5, 0, 0}, .target = {0, 1, 0}}));
  for (int i = 0; i < 12; ++i) { auto e = pull.iterate(); const Quat q = pull.world().bodies[arm].pose.rotation; std::printf("%g joints %g target %g\n", 2*std::atan2(q.z,q.w), e.joints, e.targets); }
}
TEST_CASE("tmp far", "[.]") {
  World w = bendy(5);
  w.destroy(w.find("finger"));
  const Entity last = w.find("link4");
  Assembler pull(w);
  must(pull.add(PointTarget{.body = last, .point = {0.5, 0, 0}, .target = {6,8,0}}));
  for (int i = 0; i < 3000; ++i) { auto e = pull.iterate(); if (i<10 || i%100==0) {const Vec3 p = to_world(pull.world().bodies[last].pose, {.5,0,0});  std::printf("%d %g joints %g target %.9g\n", i, glm::distance(p, Vec3(3,4,0)), e.joints, e.targets); }}
}
