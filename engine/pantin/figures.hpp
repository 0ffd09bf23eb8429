#pragma once
/// Whole figures of several bodies and joints: `build_chain(world, ...)`, `build_ragdoll(world,
/// ...)`.
///
/// Either everything is added or, on errors, nothing.
#include <array>
#include <optional>
#include <pantin/joints.hpp>
#include <pantin/shapes.hpp>
#include <string>
#include <vector>

namespace pantin {

enum class ChainJoint : std::uint8_t { ball, universal };

/// Equal links, capsules end to end in a straight line.
struct ChainOptions {
  Vec3 from{0}, to{0};  // world, m
  int links = 10;
  Real radius = 0.02;           // m, less than half a link
  Real density = 1000;          // kg/m^3
  Entity start = {}, end = {};  // bodies to attach its ends to, if any
  ChainJoint joint = ChainJoint::ball;
  std::optional<Collision> collision = {};
  Real drag = Body{}.drag;  // 1/s
  std::string name = {};    // links are called name/0, name/1 ...
};
struct Chain {
  std::vector<Entity> links;   // from start to end
  std::vector<Entity> joints;  // those at the ends included
};
Result<Chain> build_chain(World& world, const ChainOptions& options);

/// A human figure of thirteen bodies that stands upright, with the ranges of human joints.
struct RagdollOptions {
  Vec3 position{0};           // world, m: between the soles
  Quat rotation{1, 0, 0, 0};  // it looks along z
  Real height = 1.75;         // m
  Real mass = 70;             // kg
  std::optional<Collision> collision = Collision{};
  Real drag = 0.05;       // 1/s
  std::string name = {};  // bodies are called name/pelvis ...
};
/// Pairs are in the order left, right.
struct Ragdoll {
  Entity pelvis, chest, head;
  std::array<Entity, 2> upper_arms, forearms, thighs, shins, feet;
  Entity waist, neck;
  std::array<Entity, 2> shoulders, elbows, hips, knees, ankles;
  std::vector<Entity> bodies() const;
  std::vector<Entity> joints() const;
};
Result<Ragdoll> build_ragdoll(World& world, const RagdollOptions& options);

}  // namespace pantin
