// Every kind of joint in the list as scene files tell it, read from what the kind tells of itself.
#include <set>

#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/scene/keys/keys.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kValue = 0.25;  // of every parameter

/// The members of a joint of this kind, all parameters told.
std::string members_of(const JointKindInfo& kind, std::string_view word) {
  std::string members = "\"kind\": \"" + std::string(word) + "\"";
  if (!kind.is_line) members += R"(, "anchor_a": [0.1, 0, 0], "anchor_b": [-0.2, 0, 0.1])";
  for (const Parameter& p : kind.parameters)
    members += ", \"" + std::string(p.key) + "\": " + std::to_string(kValue);
  return members;
}

std::string with_joint(const std::string& members) {
  return with_two(
      "\"solver\": {\"type\": \"lagrangian\"},\n"
      "\"joints\": [{\"name\": \"j\", \"a\": \"a\", \"b\": \"b\", " +
      members + "}]");
}

Joint joint_of(const Scene& scene) { return scene.world.links[scene.world.find("j")].joint; }

void for_every_kind(auto check) {
  for (int i = 0; i < kJointKinds; ++i) {
    INFO(kJointKindInfos[i].name);
    if (kJointKindInfos[i].in_files) check(static_cast<JointKind>(i), kJointKindInfos[i]);
  }
}

bool any_has(const Lines& lines, std::string_view part) {
  return std::ranges::any_of(lines, [&](const std::string& l) { return l.find(part) != l.npos; });
}

/// Keys of limits that a file may give a joint of this kind, with a value that fits.
std::vector<std::pair<std::string, std::string>> limits_of(const JointKindInfo& kind) {
  std::vector<std::pair<std::string, std::string>> limits;
  for (const FreeCoordinate& c : kind.coordinates) {
    if (c.limit.empty()) continue;
    limits.emplace_back(c.limit, c.which == Coordinate::swing ? "1" : "[-0.5, 1]");
    if (c.which == Coordinate::swing) limits.emplace_back("swing", "[1, 0.5]");
  }
  return limits;
}

}  // namespace

TEST_CASE("every kind is read by its names, with its parameters") {
  for_every_kind([](JointKind kind, const JointKindInfo& info) {
    for (const std::string_view word : {info.name, info.alias}) {
      if (word.empty()) continue;
      const Joint joint = joint_of(good(with_joint(members_of(info, word))));
      CHECK(joint.kind == kind);
      JointParameters parameters = *joint.parameters;
      for (const Parameter& p : info.parameters) CHECK(p.value(parameters) == kValue);
    }
  });
}

TEST_CASE("every kind needs the parameters it says, and refuses those of others") {
  for_every_kind([](JointKind, const JointKindInfo& info) {
    JointKindInfo without = info;
    without.parameters = {};
    const std::string bare = with_joint(members_of(without, info.name));
    std::set<std::string_view> own;
    for (const Parameter& p : info.parameters) {
      own.insert(p.key);
      if (!p.needed.empty()) CHECK(any_has(diagnostics(bare), p.needed));
    }
    for (const Key& row : keys::joint_parameters()) {
      const std::string_view key = row.name;
      if (own.contains(key)) continue;
      const Lines lines = diagnostics(
          with_joint(members_of(info, info.name) + ", \"" + std::string(key) + "\": 1"));
      CHECK(any_has(lines, "found \"" + std::string(key) + "\" of a " + std::string(info.name)));
    }
  });
}

TEST_CASE("every kind has the limits it says, and refuses others") {
  std::set<std::string> all;
  for_every_kind([&](JointKind, const JointKindInfo& info) {
    for (const auto& [key, value] : limits_of(info)) {
      all.insert(key);
      const Joint joint = joint_of(good(with_joint(
          members_of(info, info.name) + ", \"limits\": {\"" + key + "\": " + value + "}")));
      CHECK((joint.limits.any() || joint.parameters->travel.on));
    }
  });
  for_every_kind([&](JointKind, const JointKindInfo& info) {
    std::set<std::string> foreign = all;
    for (const auto& [key, value] : limits_of(info)) foreign.erase(key);
    for (const std::string& key : foreign) {
      const Lines lines = diagnostics(
          with_joint(members_of(info, info.name) + ", \"limits\": {\"" + key + "\": [0, 1]}"));
      CHECK(any_has(lines, "found a limit \"" + key + "\""));
    }
  });
}

TEST_CASE("every kind is solved: it stays closed while it moves") {
  for_every_kind([](JointKind, const JointKindInfo& info) {
    const Scene scene = good(with_joint(members_of(info, info.name)));
    Simulation simulation = Simulation::copy_of(scene.world, {1.0 / 240, 1, 1, true});
    for (int i = 0; i < 120; ++i) {
      const StepReport report = simulation.step();
      REQUIRE(report.status == Status::ok);
      REQUIRE(report.measures.worst_gap <= 1e-10);
    }
  });
}

TEST_CASE("the table of keys has the words for every kind and integrator that a file can tell") {
  std::set<std::string_view> words, of_chains;
  for_every_kind([&](JointKind, const JointKindInfo& info) {
    for (const std::string_view word : {info.name, info.alias}) {
      if (word.empty()) continue;
      words.insert(word);
      if (info.holds_point) of_chains.insert(word);
    }
  });
  const auto told = [](const KeySet& set, std::string_view key) {
    const auto all = set.find(key)->words;
    return std::set<std::string_view>(all.begin(), all.end());
  };
  CHECK(told(keys::joint, "kind") == words);
  CHECK(told(keys::chain, "kind") == of_chains);
  const std::set<std::string_view> integrators(std::begin(kIntegratorNames),
                                               std::end(kIntegratorNames));
  CHECK(told(keys::solver, "integrator") == integrators);
}
