#pragma once
// Groups of bodies of a scene that never meet: each may have a solver of its own.
#include <optional>
#include <string>
#include <vector>

#include "tools/pantin/measure.hpp"

namespace pantin::program {

/// Dynamic bodies that no other group's bodies affect: islands, and islands whose bodies come near
/// each other. Fixed bodies, and kinematic ones, which follow their paths whatever touches them,
/// join no groups.
struct Group {
  std::vector<Entity> bodies;  // ascending slots
  std::size_t islands = 0;
  bool has_laminas = false;
  double sleeps_from = 0;  // s: at rest from then on, as in the scene's own run; its end: never
  std::string name;        // "crank, coupler and 1 more"
};

/// Groups that move alike, apart from where they are.
struct GroupKind {
  std::vector<std::size_t> groups;  // the first one stands for all
};

struct Grouping {
  std::vector<Group> groups;
  std::vector<GroupKind> kinds;
  std::size_t kinematic = 0;  // bodies that follow paths
};

/// Splits a scene, by a run of its own settings: colliding bodies of two islands whose boxes,
/// enlarged by a tenth, overlap in any step are of one group. A scene of which events change the
/// solver, of more than a thousand groups, or that its own settings cannot run within so many
/// seconds of a clock on the wall, is one group.
Grouping groups_of(const Scene& scene, const Sampling& sampling, double seconds);

/// The scene with the dynamic bodies of one group only; fixed and kinematic bodies stay.
Scene part_of(const Scene& scene, const Group& group);

/// That part as a method runs it, or why it does not. "scene" has the settings of the file.
Loaded load_part(const Scene& part, const Method& method);

/// Gives the islands of a group the settings of a method.
void apply_method(World& world, const Group& group, const Method& method, double tolerance);

/// The motion of a group within that of its scene.
Track track_of(const Track& whole, const World& world, const Group& group);

/// The diagonal of the box around the shapes of a group where it starts, m.
double extent_of(const World& world, const Group& group);

}  // namespace pantin::program
