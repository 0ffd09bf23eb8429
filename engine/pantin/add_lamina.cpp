// Laminas and their fingers: checks them as the scene reader does, and adds them.
#include <algorithm>
#include <pantin/laminas.hpp>
#include <string>

#include "engine/modes/lamina_plan.hpp"
#include "engine/modes/outline.hpp"
#include "engine/pantin/detail/findings.hpp"
#include "engine/world/lamina.hpp"
#include "engine/world/lamina_shapes.hpp"
#include "engine/world/timed_event.hpp"

namespace pantin {

using namespace detail;
using modes::Vec2;

namespace {

Vec3 spatial(Vec2 v) { return {v.x, v.y, 0}; }

/// Checks a description, converts it to a plan, and adds the plan.
class LaminaBuilder {
 public:
  LaminaBuilder(World& world, const LaminaBody& described)
      : world_(world), described_(described), findings_(world, "LaminaBody", described.name) {}

  Result<Entity> add();

 private:
  Vec2 flat(const std::string& member, Vec3 v);
  void tell(const std::string& member, const LaminaFault& fault);
  void plan_outline();
  void plan_load();
  void plan_fingers();
  FingerPlan plan_finger(const LaminaBody::Finger& finger, const std::string& member);
  void check_material(const std::string& member, std::uint32_t material);
  std::vector<Vec3> about_centre(const std::vector<Vec2>& corners) const;
  Entity add_plate();
  Entity add_finger(std::size_t number);

  World& world_;
  const LaminaBody& described_;
  Findings findings_;
  LaminaPlan plan_;
  Real extent_ = 1;
};

Vec2 LaminaBuilder::flat(const std::string& member, Vec3 v) {
  findings_.finite(member.c_str(), v);
  if (v.z != 0 && is_finite(v)) findings_.add(member.c_str(), shown(v), "one with z = 0");
  return {v.x, v.y};
}

void LaminaBuilder::tell(const std::string& member, const LaminaFault& fault) {
  findings_.add(member.c_str(), fault.found, fault.expected);
}

void LaminaBuilder::check_material(const std::string& member, std::uint32_t material) {
  if (material >= world_.materials.size())
    findings_.add(member.c_str(), std::to_string(material), "an index into World::materials");
}

void LaminaBuilder::plan_outline() {
  for (const Vec3 corner : described_.outline) plan_.outline.push_back(flat("outline", corner));
  if (!findings_.ok()) return;
  if (const auto fault = check_outline(plan_.outline)) return tell("outline", *fault);
  extent_ = modes::extent(plan_.outline);
  plan_.centre = modes::centroid(plan_.outline);
  if (described_.mass_centre) plan_.centre = flat("mass_centre", *described_.mass_centre);
}

void LaminaBuilder::plan_load() {
  findings_.above_zero("mass", described_.mass);
  findings_.finite("torque", described_.torque);
  const Vec2 force = flat("force", described_.force);
  plan_.name = described_.name, plan_.mass = described_.mass, plan_.torque = described_.torque;
  plan_.force = {force.x + plan_.mass * world_.gravity.x, force.y + plan_.mass * world_.gravity.y};
  if (!findings_.ok()) return;
  if (const auto fault = check_load(plan_)) tell("force", *fault);
}

FingerPlan LaminaBuilder::plan_finger(const LaminaBody::Finger& finger, const std::string& member) {
  FingerPlan plan;
  plan.name = finger.name.empty() ? std::to_string(plan_.fingers.size() + 1) : finger.name;
  plan.point = flat(member + ".point", finger.point);
  plan.flat = finger.flat, plan.roll = finger.roll, plan.slide = finger.slide;
  plan.spread = modes::Spread::at(finger.slide);
  findings_.not_negative((member + ".roll").c_str(), finger.roll);
  findings_.not_negative((member + ".slide").c_str(), finger.slide);
  check_material(member + ".material", finger.material);
  if (finger.normal) {
    plan.normal = flat(member + ".normal", *finger.normal);
    findings_.direction((member + ".normal").c_str(), *finger.normal);
  }
  start_path(plan);
  for (const LaminaBody::Waypoint& w : finger.waypoints) {
    findings_.finite((member + ".waypoints.time").c_str(), w.time);
    const Vec2 at = flat(member + ".waypoints.at", w.at);
    if (!findings_.ok()) return plan;
    if (const auto fault = add_waypoint(plan, {w.time, at})) tell(member + ".waypoints", *fault);
  }
  move_steadily(plan, flat(member + ".velocity", finger.velocity));
  if (!findings_.ok()) return plan;
  if (const auto fault = place_finger(plan_, plan))
    tell(fault->place == LaminaFault::Place::point ? member + ".point" : member + ".normal",
         *fault);
  return plan;
}

void LaminaBuilder::plan_fingers() {
  const std::size_t count = described_.fingers.size();
  if (count == 0 || count > modes::kMostContacts)
    return findings_.add("fingers", std::to_string(count), "1 to 32");
  for (std::size_t i = 0; i < count; ++i) {
    const std::string member = "fingers[" + std::to_string(i) + "]";
    const FingerPlan plan = plan_finger(described_.fingers[i], member);
    if (!findings_.ok()) return;
    for (const LaminaFault& fault : repeated(plan_, plan)) tell(member, fault);
    plan_.fingers.push_back(plan);
  }
}

std::vector<Vec3> LaminaBuilder::about_centre(const std::vector<Vec2>& corners) const {
  std::vector<Vec3> about;
  for (const Vec2 corner : corners) about.push_back(spatial(corner - plan_.centre));
  return about;
}

Entity LaminaBuilder::add_plate() {
  Body body;
  body.mass = plan_.mass, body.drag = 0;
  body.inertia = plate_inertia(about_centre(plan_.outline), plan_.mass);
  body.pose.position = spatial(plan_.centre);
  const Entity e = world_.add_body(body, described_.name);
  if (plan_.centre.x != 0 || plan_.centre.y != 0)
    world_.origins.add(e, {-spatial(plan_.centre), kIdentity});
  std::vector<std::vector<Vec3>> pieces;
  for (const auto& piece : modes::convex_pieces(plan_.outline))
    pieces.push_back(about_centre(piece));
  std::vector<Shape> shapes = plate_shapes(pieces, {extent_, described_.material});
  if (!shapes.empty()) world_.shapes.add(e, {std::move(shapes)});
  SolverSettings how = world_.default_settings;
  how.solver = Solver::quasistatic;
  world_.settings.add(e, how);
  world_.collisions.add(e, lamina_collision());
  return e;
}

Entity LaminaBuilder::add_finger(std::size_t number) {
  const FingerPlan& f = plan_.fingers[number];
  const LaminaLook look{extent_, described_.fingers[number].material};
  const FingerTip tip{spatial(f.normal), f.flat};
  Body body;
  body.motion = Motion::kinematic, body.drag = 0;
  body.pose.position = spatial(f.point) - finger_arm(tip, look);
  const Entity e = world_.add_body(body, plan_.name.empty() ? "" : body_name(plan_, f));
  world_.shapes.add(e, {{finger_shape(tip, look)}});
  world_.collisions.add(e, finger_collision(f.slide));
  return e;
}

Result<Entity> LaminaBuilder::add() {
  check_material("material", described_.material);
  plan_outline();
  if (findings_.ok()) plan_load();
  if (findings_.ok()) plan_fingers();
  if (!findings_.ok()) return findings_.take();
  const Entity body = add_plate();
  Lamina lamina;
  lamina.outline = about_centre(plan_.outline);
  for (std::size_t i = 0; i < plan_.fingers.size(); ++i) {
    const FingerPlan& f = plan_.fingers[i];
    LaminaFinger& finger = lamina.fingers.emplace_back();
    const FingerTip tip{spatial(f.normal), f.flat};
    finger.body = add_finger(i), finger.normal = tip.normal;
    finger.point = finger_arm(tip, {extent_, 0});
    finger.flat = f.flat, finger.roll = f.roll, finger.slide = f.slide;
    for (const Waypoint& w : f.path) finger.path.push_back({w.time, spatial(w.at)});
  }
  laminas_of(world_).add(body, std::move(lamina));
  const Vec3 pull = {described_.force.x, described_.force.y, 0};
  if (pull != Vec3(0) || plan_.torque != 0)
    detail::add_event(world_,
                      {PushEvent{.body = body, .force = pull, .torque = {0, 0, plan_.torque}}});
  return body;
}

}  // namespace

Result<Entity> add_to(World& world, const LaminaBody& lamina) {
  return LaminaBuilder(world, lamina).add();
}

std::vector<Entity> fingers_of(const World& world, Entity lamina) {
  const Store<Lamina>* all = laminas_of(world);
  const Lamina* found = all ? all->find(lamina) : nullptr;
  std::vector<Entity> fingers;
  if (found)
    for (const LaminaFinger& f : found->fingers) fingers.push_back(f.body);
  return fingers;
}

}  // namespace pantin
