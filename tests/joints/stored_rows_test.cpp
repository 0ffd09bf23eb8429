// Equations of joints against stored numbers.
#include <array>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/joints/drawn_joints.hpp"
#include "tests/paths.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;
using nlohmann::json;

namespace {

Vec3 vec(const json& j) { return {j.at(0), j.at(1), j.at(2)}; }
Quat quat(const json& j) { return Quat(j.at(0), j.at(1), j.at(2), j.at(3)); }

const json& stored() {
  static const json kAll = json::parse(std::ifstream(test_data("lagrangian.json")));
  return kAll;
}

BodyState body_of(const json& entry, int i) {
  return placed(vec(entry.at("x").at(i)), quat(entry.at("q").at(i)), vec(entry.at("v").at(i)),
                vec(entry.at("w").at(i)));
}

/// Row `mine` of a block against row `theirs` of an entry, which is `scale` times as large.
Real miss(const Equations& block, int mine, const json& entry, int theirs, Real scale = 1) {
  const auto i = std::size_t(mine);
  const Real c = entry.at("C").at(theirs), gamma = entry.at("gamma").at(theirs);
  Real worst = std::max(std::abs(scale * block.c[i] - c), std::abs(scale * block.gamma[i] - gamma));
  for (int k = 0; k < 12; ++k)
    worst = std::max(worst, std::abs(scale * block.j[4 * i + std::size_t(k / 3)][k % 3] -
                                     entry.at("J").at(theirs).at(k).get<Real>()));
  return worst;
}

/// The turn of joint axes of which two are known; the vectors are square to each other.
Quat frame_yz(Vec3 y, Vec3 z) { return glm::quat_cast(Mat3(glm::cross(y, z), y, z)); }
Quat frame_x(Vec3 x) {
  const Vec3 y = glm::normalize(glm::cross(x, std::abs(x.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
  return frame_yz(y, glm::cross(x, y));
}

/// The entry's joint made of its primitives, if it is one of our kinds; a universal joint's second
/// axis may have any length in the entry.
Joint joint_of(const json& entry) {
  Joint joint;
  REQUIRE(joint_kind_from_name(entry.at("kind").get<std::string>().c_str(), joint.kind));
  std::vector<Vec3> f, g;
  for (const json& p : entry.at("prims")) {
    const std::string name = p.at(0);
    if (name == "d1") {
      f.push_back(vec(p.at(1))), g.push_back(vec(p.at(2)));
      continue;
    }
    const int first = name == "d2" ? 2 : 1;
    joint.anchor_a = vec(p.at(first)), joint.anchor_b = vec(p.at(first + 1));
    if (name == "dist") joint.parameters.edit().length = p.at(3);
  }
  if (joint.kind == JointKind::universal) {
    const Vec3 z = glm::normalize(g[0]);
    const Quat on_a = frame_x(f[0]), on_b = frame_x(z);  // x to y, x to z
    joint.frames.set(on_a * about_z(-kPi / 2), on_b * about_y(kPi / 2));
  } else if (f.size() == 2) {
    joint.frames.set(frame_yz(f[0], f[1]), frame_x(g[0]));
  } else if (f.size() == 3) {
    joint.frames.set(frame_yz(f[0], f[1]), frame_yz(glm::cross(g[2], g[0]), g[2]));
  }
  return joint;
}

}  // namespace

TEST_CASE("the primitives of joints are those of the stored numbers") {
  for (const json& entry : stored().at("joints")) {
    INFO(entry.at("kind").get<std::string>());
    const BodyState a = body_of(entry, 0), b = body_of(entry, 1);
    int row = 0;
    for (const json& p : entry.at("prims")) {
      const std::string name = p.at(0);
      Joint joint;
      if (name != "d1") {
        const int first = name == "d2" ? 2 : 1;
        joint.anchor_a = vec(p.at(first)), joint.anchor_b = vec(p.at(first + 1));
      }
      const auto f = [&] { return a.rotation_matrix * vec(p.at(1)); };
      Equations block;
      const AnchorSpan span = span_of(joint, a, b, block.out());
      if (name == "pt") write_point(span, block.out());
      if (name == "d1")
        write_row(0, dot_row(f(), b.rotation_matrix * vec(p.at(2)), a, b), block.out());
      if (name == "d2") write_along(0, f(), span, block.out());
      if (name == "dist") write_distance(0, p.at(3), span, block.out());
      for (int i = 0; i < (name == "pt" ? 3 : 1); ++i) CHECK(miss(block, i, entry, row++) <= 1e-13);
    }
    CHECK(row == int(entry.at("C").size()));
  }
}

TEST_CASE("the kinds of joints are those of the stored numbers") {
  for (const json& entry : stored().at("joints")) {
    INFO(entry.at("kind").get<std::string>());
    const Joint joint = joint_of(entry);
    const Equations block = rows_of(joint, body_of(entry, 0), body_of(entry, 1));
    const int rows = row_count(joint);
    REQUIRE(rows == int(entry.at("C").size()));
    // The page has a prismatic joint's third direction before its offsets.
    const bool prismatic = joint.kind == JointKind::prismatic;
    const std::array<int, 6> theirs =
        prismatic ? std::array{0, 1, 3, 4, 2, 5} : std::array{0, 1, 2, 3, 4, 5};
    for (int i = 0; i < rows; ++i) {
      const bool scaled = joint.kind == JointKind::universal && i == 3;
      const Real scale = scaled ? glm::length(vec(entry.at("prims").at(1).at(2))) : 1;
      CHECK(miss(block, i, entry, theirs[std::size_t(i)], scale) <= 1e-12);
    }
  }
}
