// Bars anywhere become a four-bar linkage; a strut that does not fit gets the length that does.
#include <cstdio>
#include <pantin/assembler.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  world.default_settings.solver = Solver::lagrangian;
  const Entity frame = must(world.add(RigidBody{.motion = Motion::fixed, .name = "frame"}));
  const auto bar = [&](Real length, Vec3 anywhere, const char* name) {
    return must(
        world.add(RigidBody{.shape = CapsuleShape{.radius = 0.02, .half_length = length / 2},
                            .position = anywhere,
                            .rotation = glm::normalize(Quat(1, anywhere.x, anywhere.y, anywhere.z)),
                            .name = name}));
  };
  const Entity crank = bar(0.3, {2, 1, 0.5}, "crank"), coupler = bar(1, {-1, 2, 0.3}, "coupler"),
               rocker = bar(0.8, {0.4, -3, -0.7}, "rocker");
  // Hinges about z of either body, whose x is the axis, at points on y.
  const Quat about_z = glm::angleAxis(-kPi / 2, Vec3(0, 1, 0));
  struct End {
    Entity body;
    Vec3 at;
  };
  const auto hinge = [&](const char* name, End a, End b) {
    const LocalFrames frames{{a.at, about_z}, {b.at, about_z}};
    must(world.add(HingeJoint{.a = a.body, .b = b.body, .frames = frames, .name = name}));
  };
  hinge("A", {frame, {0, 0, 0}}, {crank, {0, -0.15, 0}});
  hinge("B", {crank, {0, 0.15, 0}}, {coupler, {0, -0.5, 0}});
  hinge("C", {coupler, {0, 0.5, 0}}, {rocker, {0, 0.4, 0}});
  hinge("D", {rocker, {0, -0.4, 0}}, {frame, {1, 0, 0}});
  std::printf("%d degree of freedom, ", assemble(world).mobility);
  // A strut of half a metre to a point more than two metres away.
  must(world.add(DistanceJoint{.a = frame,
                               .b = coupler,
                               .anchor_a = {0, 3, 0},
                               .anchor_b = world.bodies[coupler].pose.position,
                               .length = 0.5,
                               .name = "strut"}));
  for (const Entity law : assemble(world).contradictory)
    std::printf("%s ", world.name_of(law).c_str());
  const Assembly longer = assemble(world, {}, 1e-12, {{.law = world.find("strut")}});
  std::printf("cannot all hold, with a strut of %.3f m they do\n", longer.lengths[0]);
}
// prints: 1 degree of freedom, .*strut.* cannot all hold, with a strut of 2.492 m they do
