#pragma once
// What a user does to the scene by a click, and what is told of what lies under the mouse.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/render/renderer.hpp"
#include "engine/world/findings.hpp"
#include "tools/pantin/view_pick.hpp"

namespace pantin::program {

using namespace detail;

/// The joint, cable or pin that is drawn nearest to a pixel, within a few pixels; else, of the body
/// there, the joint nearest to the point that is seen. None where there is nothing to cut.
Entity find_cut(const PosedWorld& scene, const SeenPixel& mouse);

/// What a user's pins are called; "cut" takes them off again.
inline constexpr const char* kUserPin = "pinned by hand";
/// Pins a body's point to the place where it is. A second call takes the pins of the body off that
/// were made so. True if it is pinned now; none if the body cannot move by itself.
std::optional<bool> toggle_pin(World& world, const Picked& at);

/// What is shot.
struct BallGun {
  double radius = 0.05, mass = 1, speed = 5;  // m, kg, m/s
};
/// A ball that suits a scene which is looked at from so far, m.
BallGun usual_gun(const World& world, double distance);
/// Shoots along a ray. Bodies that collide with nothing begin to collide with such balls. Of too
/// many balls the oldest is taken away.
Result<Entity> shoot(World& world, const Ray& ray, const BallGun& gun);
/// Takes balls away that are farther from a point than `reach`, m.
void sweep_balls(World& world, Vec3 from, double reach);

/// Lines for the panel: name, mass, place, speed, contacts and joints of a body.
std::vector<std::string> describe(const World& world, Entity body);
/// The same in one line.
std::string describe_shortly(const World& world, Entity body);

/// The forces of joints, cables and pins as they act on their second, or own, body.
std::vector<Overlay::Arrow> forces_of(const PosedWorld& scene);

/// Where findings were made, as bodies are drawn, m: at mass centres, anchors of joints and cables.
std::vector<Vec3> places_of(const PosedWorld& scene, std::span<const Finding> findings);

}  // namespace pantin::program
