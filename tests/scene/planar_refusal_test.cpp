// What a plane cannot have is refused by name.
#include <catch2/catch.hpp>

#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

using Lines = std::vector<std::string>;

const std::string kNeeds = ", expected what stays in the plane of x and y, as \"planar\" needs";

/// A scene of one box, `body` its other members, `more` those of the scene.
Lines told(const std::string& body, const std::string& more = "") {
  const Result<Scene> scene =
      parse_scene(R"({"version": 1, "solver": {"type": "planar"}, "bodies": [{"name": "a", )" +
                      body + R"("shape": {"type": "box", "size": [1, 1, 1]}}])" + more + "}",
                  "t.json");
  Lines lines;
  if (!scene)
    for (const Error& e : scene.errors()) lines.push_back(e.message);
  return lines;
}

}  // namespace

TEST_CASE("a body that leaves the plane of its solver is refused") {
  CHECK(told(R"("velocity": [1, 2, 0], "angular_velocity": [0, 0, 3], )") == Lines{});
  const Lines out = told(R"("velocity": [0, 0, 1], )");
  REQUIRE(out.size() == 1);
  CHECK(out[0].find("/bodies/0: found body \"a\", which moves along z") != std::string::npos);
  CHECK(out[0].find(kNeeds) != std::string::npos);
  CHECK(told(R"("angular_velocity": [1, 0, 0], )").size() == 1);
  CHECK(told("", R"(, "gravity": [0, -9, 1])").size() == 1);
}

TEST_CASE("a joint that a plane does not have is refused") {
  const auto joint = [](const std::string& members) {
    return told("",
                R"(, "joints": [{"a": "world", "b": "a", "anchor": [0, 0, 0], )" + members + "}]");
  };
  CHECK(joint(R"("kind": "hinge", "axis": [0, 0, 1])") == Lines{});
  CHECK(joint(R"("kind": "ball")") == Lines{});
  const Lines universal = joint(R"("kind": "universal")");
  REQUIRE(universal.size() == 1);
  CHECK(
      universal[0].find("/joints/0: found joint \"world-a\", which is of a kind that a plane does "
                        "not have") != std::string::npos);
  CHECK(joint(R"("kind": "hinge", "axis": [0, 1, 1])").size() == 1);
  CHECK(joint(R"("kind": "prismatic", "axis": [0, 0, 1])").size() == 1);
}
