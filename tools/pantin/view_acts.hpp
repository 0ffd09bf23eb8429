#pragma once
// Actions on the scene by mouse click, and descriptions of the object under the mouse.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/render/renderer.hpp"
#include "engine/world/findings.hpp"
#include "tools/pantin/view_pick.hpp"

namespace pantin::program {

using namespace detail;

/// The joint, cable or pin drawn nearest to a pixel, within a few pixels; otherwise the joint of
/// the body there that is nearest to the visible point. None if there is nothing to cut.
Entity find_cut(const PosedWorld& scene, const SeenPixel& mouse);

/// The joint, cable or pin drawn nearest to a pixel, within a few pixels; otherwise the body there.
Entity find_object(const PosedWorld& scene, const SeenPixel& mouse);

/// The name of a user's pins; "cut" removes them.
inline constexpr const char* kUserPin = "pinned by hand";
/// Pins a body's point at its present position, or removes such pins of the body. Returns whether
/// it is pinned now; none if the body cannot move by itself.
std::optional<bool> toggle_pin(World& world, const Picked& at);

/// The properties of shot balls.
struct BallGun {
  double radius = 0.05, mass = 1, speed = 5;  // m, kg, m/s
};
/// Balls that suit a scene viewed from this distance, m.
BallGun usual_gun(const World& world, double distance);
/// Shoots a ball along a ray. Bodies without collision begin to collide with such balls. Above a
/// maximum number, the oldest ball is removed.
Result<Entity> shoot(World& world, const Ray& ray, const BallGun& gun);
/// Removes balls that are farther from a point than `reach`, m.
void sweep_balls(World& world, Vec3 from, double reach);

/// Lines for the panel: name, mass, position, speed, contacts and joints of a body.
std::vector<std::string> describe(const World& world, Entity body);
/// A short form in one line.
std::string describe_shortly(const World& world, Entity body);

/// The forces of joints, cables and pins on their second, or only, body.
std::vector<Overlay::Arrow> forces_of(const PosedWorld& scene);

/// The positions of findings, in drawn poses, m: at mass centres, anchors of joints and cables.
std::vector<Vec3> places_of(const PosedWorld& scene, std::span<const Finding> findings);

}  // namespace pantin::program
