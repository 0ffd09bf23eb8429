#include "engine/world/kinematic_path.hpp"

#include <catch2/catch.hpp>
#include <cstring>

#include "engine/base/rotation.hpp"
#include "engine/world/settings.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

Real distance(Vec3 a, Vec3 b) { return glm::length(a - b); }
Real angle(Quat a, Quat b) { return glm::length(rotation_vector(a * glm::conjugate(b))); }

KinematicPath four_keys(bool loop) {
  Keyframes path;
  path.loop = loop;
  path.keys = {{1, {{0, 0, 0}, kIdentity}},
               {2, {{1, 1, 0}, from_rotation_vector({0, 0, 1})}},
               {4, {{2, 0, 1}, from_rotation_vector({0, 2, 0})}},
               {5, {{0, 0, 0}, kIdentity}}};
  return {path};
}

/// Velocity by a central difference.
Vec3 rate(const KinematicPath& d, Real time) {
  constexpr Real kStep = 1e-5;
  return (pose_at(d, time + kStep).position - pose_at(d, time - kStep).position) / (2 * kStep);
}

}  // namespace

TEST_CASE("A path passes through all its keys and rests outside them") {
  const KinematicPath d = four_keys(false);
  for (const Keyframe& k : std::get<Keyframes>(d.curve).keys) {
    CHECK(distance(pose_at(d, k.time).position, k.pose.position) < 1e-15);
    CHECK(angle(pose_at(d, k.time).rotation, k.pose.rotation) < 1e-7);
  }
  CHECK(pose_at(d, -3).position == Vec3(0));
  CHECK(distance(pose_at(d, 99).position, Vec3(0)) < 1e-15);
}

TEST_CASE("A path is smooth in position and starts and ends at rest") {
  const KinematicPath d = four_keys(false);
  for (Real time : {2.0, 4.0})
    CHECK(distance((pose_at(d, time).position - pose_at(d, time - 1e-6).position) / 1e-6,
                   (pose_at(d, time + 1e-6).position - pose_at(d, time).position) / 1e-6) < 1e-4);
  for (Real time : {1.0, 5.0}) CHECK(glm::length(rate(d, time)) < 1e-4);
  // At a key: the mean velocity between its neighbours.
  CHECK(distance(rate(d, 2), Vec3(2, 0, 1) / 3.0) < 1e-4);
}

TEST_CASE("A straight path with even keys is run at an even speed between its ends") {
  Keyframes path;
  for (int i = 0; i < 5; ++i) path.keys.push_back({Real(i), {{2.0 * i, 0, 0}, kIdentity}});
  const KinematicPath d{path};
  for (Real time : {1.0, 1.3, 2.5, 2.9}) CHECK(rate(d, time).x == Approx(2));
}

TEST_CASE("Rotations go the short way at an even rate") {
  Keyframes path;
  path.keys = {{0, {}},
               {1, {Vec3(0), -from_rotation_vector({0, 0, 1})}}};  // the same rotation, sign turned
  const KinematicPath d{path};
  for (Real u : {0.25, 0.5, 0.75})
    CHECK(angle(pose_at(d, u).rotation, from_rotation_vector({0, 0, u})) < 1e-12);
}

TEST_CASE("A loop repeats in both directions of time and is smooth at its seam") {
  const KinematicPath d = four_keys(true);
  for (Real time : {1.2, 2.7, 4.9}) {
    CHECK(distance(pose_at(d, time).position, pose_at(d, time + 8).position) < 1e-12);
    CHECK(distance(pose_at(d, time).position, pose_at(d, time - 4).position) < 1e-12);
  }
  CHECK(distance(rate(d, 5 - 1e-4), rate(d, 1 + 1e-4)) < 1e-2);
  CHECK(glm::length(rate(d, 5)) > 0.1);
}

TEST_CASE("A path of one key or of none stands still") {
  Keyframes one;
  one.keys = {{3, {{1, 2, 3}, kIdentity}}};
  CHECK(pose_at({one}, 0).position == Vec3(1, 2, 3));
  CHECK(pose_at({one}, 9).position == Vec3(1, 2, 3));
  CHECK(pose_at({Keyframes{}}, 1).position == Vec3(0));
}

TEST_CASE("A sway is a sine, axis by axis, in place and in turn") {
  Lissajous sway;
  sway.centre = {{1, 2, 3}, from_rotation_vector({0.5, 0, 0})};
  sway.amplitude = {1, 2, 0}, sway.frequency = {1, 0.5, 9}, sway.phase = {0, kPi / 2, 1};
  sway.turn_amplitude = {0, 0.3, 0}, sway.turn_frequency = {0, 0.25, 0};
  const Pose p = pose_at({sway}, 0.25);
  CHECK(distance(p.position, {1 + std::sin(kPi / 2), 2 + 2 * std::cos(kPi / 4), 3}) < 1e-15);
  CHECK(angle(p.rotation, from_rotation_vector({0, 0.3 * std::sin(kPi / 8), 0}) *
                              sway.centre.rotation) < 1e-12);
}

TEST_CASE("A sway that rises starts at rest at its centre and is whole afterwards") {
  Lissajous sway;
  sway.amplitude = {1, 0, 0}, sway.frequency = {1, 0, 0}, sway.phase = {1, 0, 0};
  Lissajous rising = sway;
  rising.rise = 2;
  CHECK(pose_at({rising}, 0).position == Vec3(0));
  CHECK(pose_at({rising}, -1).position == Vec3(0));
  CHECK(glm::length(rate({rising}, 0)) < 1e-4);
  CHECK(distance(rate({rising}, 2 - 1e-4), rate({rising}, 2 + 1e-4)) < 1e-2);
  for (Real time : {2.0, 3.3})
    CHECK(pose_at({rising}, time).position == pose_at({sway}, time).position);
}

TEST_CASE("A path moved rigidly is the path, moved rigidly") {
  const Pose by{{1, -2, 0.5}, from_rotation_vector({0.4, 1.2, -0.3})};
  Lissajous sway;
  sway.centre = {{0.1, 0.2, 0.3}, from_rotation_vector({0, 0.4, 0})};
  sway.amplitude = {0.5, 0.2, 0.7}, sway.frequency = {1, 2, 3};
  sway.turn_amplitude = {0.3, 0.2, 0.1}, sway.turn_frequency = {1, 1, 2};
  for (const KinematicPath& d : {KinematicPath{sway}, four_keys(false)})
    for (Real time : {0.0, 1.7, 3.1}) {
      const Pose expected = compose(by, pose_at(d, time)), found = pose_at(moved(d, by), time);
      CHECK(distance(expected.position, found.position) < 1e-14);
      CHECK(angle(expected.rotation, found.rotation) < 1e-7);
    }
}

TEST_CASE("A path run ahead is where it would be later, but rises at its own time") {
  Lissajous sway;
  sway.amplitude = {0.5, 0.2, 0}, sway.frequency = {1, 0.3, 0};
  sway.turn_amplitude = {0, 0.4, 0}, sway.turn_frequency = {0, 0.7, 0};
  for (const KinematicPath& d : {KinematicPath{sway}, four_keys(true)}) {
    const KinematicPath early = shifted(d, 0.75);
    CHECK(distance(pose_at(early, 2).position, pose_at(d, 2.75).position) < 1e-12);
    CHECK(angle(pose_at(early, 2).rotation, pose_at(d, 2.75).rotation) < 1e-7);
  }
  sway.rise = 1;
  CHECK(pose_at(shifted({sway}, 0.75), 0).position == Vec3(0));
}

TEST_CASE("Solvers are known by their names") {
  for (const char* name : {"auto", "sweep", "shake2", "procedural"}) {
    Solver s{};
    REQUIRE(solver_from_name(name, s));
    CHECK(std::strcmp(name_of(s), name) == 0);
  }
  Solver s = Solver::procedural;
  CHECK_FALSE(solver_from_name("Auto", s));
  CHECK_FALSE(solver_from_name("", s));
  CHECK_FALSE(solver_from_name(nullptr, s));
  CHECK(s == Solver::procedural);
}
