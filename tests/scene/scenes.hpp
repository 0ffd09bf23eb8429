#pragma once
/// Short ways to read a scene in a test.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "engine/scene/scene.hpp"

namespace pantin::test {

using namespace detail;

/// The scene of a text that must be good.
inline Scene good(const std::string& text) {
  Result<Scene> scene = parse_scene(text, "t.json");
  if (!scene)
    for (const Error& e : scene.errors()) UNSCOPED_INFO(e.message);
  REQUIRE(bool(scene));
  return std::move(*scene);
}

/// All complaints about a text that must be bad.
inline std::vector<std::string> diagnostics(const std::string& text,
                                            const SceneLimits& limits = {}) {
  const Result<Scene> scene = parse_scene(text, "t.json", limits);
  REQUIRE_FALSE(bool(scene));
  std::vector<std::string> lines;
  for (const Error& e : scene.errors()) lines.push_back(e.message);
  return lines;
}

/// A scene of one body with these members besides its name, on line 1.
inline std::string with_body(const std::string& members) {
  return R"({"version": 1, "bodies": [{"name": "rod", )" + members + "}]}";
}

/// A scene without gravity, with a ball called "a" and one called "b", 1 m to the right, and more.
inline std::string with_two(const std::string& members) {
  return R"({"version": 1, "gravity": [0, 0, 0], "bodies": [
{"name": "a", "shape": {"type": "sphere", "radius": 0.1}},
{"name": "b", "shape": {"type": "sphere", "radius": 0.1}, "position": [1, 0, 0]}],
)" + members +
         "}";
}

using Lines = std::vector<std::string>;

}  // namespace pantin::test
