#include "tools/pantin/view_hand.hpp"

#ifdef PANTIN_HAS_VIEW
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/island.hpp"

namespace pantin::program {

using namespace detail;

namespace {

constexpr int kFirst = 1'000'000;    // priority: above every pin of a scene
constexpr Real kFirmness = 400;      // 1/s^2: the weight of the mass stretches it by 25 mm
constexpr Real kLeastStiffness = 1;  // N/m
constexpr Real kWayBack = 0.5;       // s, from the release of a kinematic body until it is back on
                                     // its path

/// Mass of all bodies connected to a body, kg.
Real mass_with(const World& world, Entity body) {
  for (const articulated::Island& a : articulated::islands_of(world)) {
    if (std::find(a.bodies.begin(), a.bodies.end(), body) == a.bodies.end()) continue;
    Real mass = 0;
    for (Entity e : a.bodies) mass += world.bodies[e].mass;
    return mass;
  }
  return world.bodies[body].mass;
}

/// The largest residual of all pins except `pin`, m.
Real worst_hold_but(const World& world, Entity pin) {
  Real worst = 0;
  for (const articulated::Island& a : articulated::islands_of(world))
    for (const articulated::PackedPin& h : a.pins) {
      const bool is_own = h.held_pin != UINT32_MAX && world.pins.owners()[h.held_pin] == pin;
      if (h.compliance == 0 && !is_own) worst = std::max(worst, h.residual);
    }
  return worst;
}

/// Moves a body to a pose within `h` seconds.
void carry(Body& body, const Pose& to, Real h) {
  body.velocity = (to.position - body.pose.position) / h;
  body.angular_velocity = angular_velocity_between(body.pose.rotation, to.rotation, h);
  body.pose = to;
}

}  // namespace

Vec3 Hand::grip_point(const World& world) const {
  return to_world(world.bodies[body_].pose, anchor_);
}

void Hand::take(World& world, const Picked& picked, PinKind grip, const SeenPixel& mouse) {
  let_go(world);
  body_ = picked.body;
  const Body& body = world.bodies[body_];
  anchor_ = picked.anchor;
  start_ = target_ = to_world(body.pose, anchor_);  // at most one step ahead of the drawn pose
  goal_ = picked.point;
  look_again(mouse);
  now_ = {world.name_of(body_), grip == PinKind::exact ? "exact" : "spring", world.time};
  if (body.motion == Motion::kinematic) {
    now_.grip = "kinematic";
    take_kinematic(world);
    return;
  }
  if (poser_) return take_pose(world, grip);
  Pin pin;
  pin.body = body_, pin.anchor = anchor_, pin.target = target_;
  pin.priority = kFirst, pin.kind = grip;
  const Real mass = mass_with(world, body_);
  pin.stiffness = std::max(kLeastStiffness, kFirmness * mass);
  pin.damping = 2 * std::sqrt(pin.stiffness * mass);  // critical
  pin_ = world.add_pin(pin, "mouse");
}

void Hand::take_kinematic(World& world) {
  const auto known =
      std::find_if(away_.begin(), away_.end(), [this](const Away& a) { return a.body == body_; });
  if (known != away_.end()) {  // grabbed again during its return
    known->is_held = true;
    return;
  }
  Away away;
  away.body = body_;
  if (const KinematicPath* drive = world.paths.find(body_)) away.drive = *drive;
  world.paths.remove(body_);
  away_.push_back(std::move(away));
}

void Hand::take_pose(const World& world, PinKind grip) {
  const bool keeps = grip == PinKind::spring;
  now_.grip = keeps ? "pose_rotation" : "pose";
  poser_->take(world, {body_, anchor_, target_, keeps ? PoseGrip::rotation : PoseGrip::point});
}

void Hand::start_posing(const World& world) { poser_.emplace(world); }

bool Hand::stop_posing(World& world) {
  if (!poser_) return false;
  let_go(world);
  const bool moved = poser_->has_moved();
  poser_.reset();
  return moved;
}

void Hand::renew(const World& world) {
  if (poser_) poser_->renew(world);
}

void Hand::pose(World& world) {
  if (!poser_) return;
  if (holds()) {
    target_ = goal_;
    if (Body& body = world.bodies[body_]; body.motion == Motion::dynamic) {
      poser_->move(target_);
    } else {
      body.pose.position = target_ - body.pose.rotation * anchor_;
      body.teleport = true;
      poser_->note_motion();
      poser_->renew(world);
    }
  }
  poser_->follow(world);
  after_step(world);
}

void Hand::move(const SeenPixel& mouse) {
  if (!holds()) return;
  goal_ = on_plane(mouse, plane_) + offset_;
}

void Hand::look_again(const SeenPixel& mouse) {
  plane_ = goal_;
  // A body picked beside the pixel must not jump to it.
  offset_ = goal_ - on_plane(mouse, plane_);
}

void Hand::let_go(World& world) {
  if (!holds()) return;
  now_.held = world.time - now_.at;
  now_.distance_moved = glm::length(grip_point(world) - start_);
  if (const Pin* pin = world.pins.find(pin_)) now_.reachable = pin->reachable;
  drags_.push_back(now_);
  if (pin_) world.destroy(pin_);
  if (poser_) poser_->let_go();
  for (Away& a : away_) {
    if (a.body != body_) continue;
    Body& body = world.bodies[body_];
    a.is_held = false, a.left = body.pose, a.since = world.time;
    body.velocity = body.angular_velocity = Vec3(0);
  }
  std::erase_if(away_, [](const Away& a) { return !a.is_held && !a.drive; });
  body_ = pin_ = Entity{};
}

void Hand::forget() {
  if (holds()) drags_.push_back(now_);
  body_ = pin_ = Entity{};
  poser_.reset();
  away_.clear();
}

void Hand::before_part(World& world, Real h) {
  lead_back(world, h);
  if (!holds()) return;
  target_ += (goal_ - target_) / static_cast<Real>(std::max(1, parts_left_));
  parts_left_ = std::max(1, parts_left_ - 1);
  if (pin_) {
    world.pins[pin_].target = target_;
    return;
  }
  Body& body = world.bodies[body_];
  Pose to = body.pose;
  to.position = target_ - to.rotation * anchor_;
  carry(body, to, h);
}

void Hand::lead_back(World& world, Real h) {
  const Real end = world.time + h;
  for (Away& a : away_) {
    if (a.is_held) continue;
    const Real u = (end - a.since) / kWayBack;
    if (u >= 1) {
      world.paths.add(a.body, *a.drive);
      continue;
    }
    const Real left = 1 - u * u * u * (10 + u * (6 * u - 15));  // no jump in velocity
    const Pose path = pose_at(*a.drive, end), began = pose_at(*a.drive, a.since);
    carry(world.bodies[a.body],
          {path.position + left * (a.left.position - began.position),
           glm::slerp(path.rotation, a.left.rotation, left)},
          h);
  }
  std::erase_if(away_, [&](const Away& a) { return !a.is_held && world.paths.find(a.body); });
}

void Hand::after_step(const World& world) {
  if (!holds()) return;
  now_.residual = glm::length(grip_point(world) - target_);
  now_.worst_residual = std::max(now_.worst_residual, now_.residual);
  if (!poser_) now_.worst_elsewhere = std::max(now_.worst_elsewhere, worst_hold_but(world, pin_));
  now_.distance_moved = glm::length(grip_point(world) - start_);
  now_.held = world.time - now_.at;
}

}  // namespace pantin::program
#endif
