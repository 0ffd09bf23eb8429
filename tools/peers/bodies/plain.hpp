#pragma once
/// A scene spelled out for other engines: bodies with mass and inertia, shapes, joints, and which
/// bodies may touch. So all get the same.
#include <cstdint>
#include <ostream>
#include <vector>

#include "engine/scene/scene.hpp"

namespace pantin::peers {

/// Frames are 1/60 s, whatever steps an engine takes in them.
inline constexpr int kFramesPerSecond = 60;

/// Bodies sorted by what they may touch, as collision layers of other engines are. Bodies that a
/// joint connects never touch, whatever their layers.
struct Layers {
  std::vector<int> of;  // by slot in World::bodies; below zero: touches nothing
  std::vector<std::vector<bool>> touch;
  bool may_touch(std::uint32_t a, std::uint32_t b) const {
    return of[a] >= 0 && of[b] >= 0 &&
           touch[static_cast<std::size_t>(of[a])][static_cast<std::size_t>(of[b])];
  }
};

/// Of a compiled World.
Layers layers_of(const World& world);

/// Pairs of slots that a joint connects, lower first, sorted.
std::vector<std::pair<std::uint32_t, std::uint32_t>> jointed_pairs(const World& world);

/// Writes a compiled World and what drives it for so many frames. A line `unknown ...` names each
/// thing that the text has no words for. The words:
///
///   gravity X Y Z
///   frames COUNT
///   layers COUNT                      and a line of COUNT zeros and ones for each: who touches
///   whom body NAME MOTION LAYER MASS INERTIA3 POSE7 VELOCITY3 SPIN3 DRAG GRAVITY FRICTION
///   RESTITUTION shape KIND SIZE3 POSE7 POINTS     of the body above; points of a hull, three
///   numbers each joint KIND A B ANCHOR3 ANCHOR3 AXES4 AXES4 ON LOW HIGH ON LOW HIGH ON Y Z drive
///   JOINT STIFFNESS DAMPING MOST COUNT TARGETS4     one target for all frames, or one each cable A
///   B ANCHOR3 ANCHOR3 LENGTH COMPLIANCE path BODY POSES7                  of a kinematic body, at
///   the end of each frame
///
/// Motions are dynamic, fixed, kinematic; poses are of the mass centre, rotations (x, y, z, w);
/// bodies and joints count from zero, and body -1 is the world. Kinds and limits of joints are
/// those of pantin: see engine/joints/limits.hpp.
void write_plain(const World& world, int frames, std::ostream& out);

}  // namespace pantin::peers
