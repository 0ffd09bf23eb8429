#include <algorithm>
#include <pantin/contacts.hpp>
#include <tuple>

#include "engine/contact/contact.hpp"
#include "engine/contact/search.hpp"

namespace pantin {

using namespace detail;

namespace {

/// A pair that was in contact stays so below this distance, m: a load that fluctuates between two
/// steps is one contact.
constexpr Real kStillTouching = 1e-4;

auto key(const ContactEvent& e) {
  return std::tuple(e.a.index, e.b.index, e.a.generation, e.b.generation, e.is_sensor);
}
bool is_before(const ContactEvent& p, const ContactEvent& q) { return key(p) < key(q); }

std::uint32_t material_of(const World& world, Entity body, std::uint32_t shape) {
  const Shapes* shapes = world.shapes.find(body);
  return shapes && shape < shapes->list.size() ? shapes->list[shape].material : 0;
}

void swap_sides(ContactEvent& e) {
  std::swap(e.a, e.b), std::swap(e.shape_a, e.shape_b), std::swap(e.material_a, e.material_b);
  e.impulse = -e.impulse, e.normal = -e.normal;
}

/// Contacts are listed pair by pair; this sums up the points of a pair.
struct Sum {
  Vec3 impulse{0}, normal{0}, point{0};
  Real depth = 0, weight = 0;
  std::uint64_t key = 0;  // of the point with the largest force, or the nearest one
  std::pair<Real, Real> most{-1, 0};
  bool bears = false, is_near = false;

  void add(const Contact& c, Vec3 at, Real seconds) {
    const bool counts = c.active || c.depth > 0;
    bears = bears || counts, is_near = is_near || c.gap < kStillTouching;
    const Real w = counts ? 1 : 1e-9;  // points without force count only if no point has one
    impulse += seconds * c.force;
    normal += w * c.normal, point += w * at, weight += w;
    depth = std::max(depth, c.depth);
    const std::pair<Real, Real> bears_now{glm::length(c.force), -c.gap};
    if (bears_now > most) most = bears_now, key = c.key;
  }
};

}  // namespace

Vec3 ContactEvents::velocity_before(Entity body, Vec3 point) const {
  if (body.index >= motions_.size() || motions_[body.index].owner != body) return Vec3(0);
  const Motion& m = motions_[body.index];
  return m.velocity + glm::cross(m.spin, point - m.position);
}

void ContactEvents::find_approaches() {
  for (ContactEvent& e : now_) {
    const Vec3 closing = velocity_before(e.b, e.point) - velocity_before(e.a, e.point);
    e.approach = std::max(Real(0), glm::dot(closing, e.normal));
  }
}

void ContactEvents::note_motions(const World& world) {
  motions_.assign(world.entities.capacity(), {});
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const Body& b = world.bodies.values()[i];
    const Entity owner = world.bodies.owners()[i];
    motions_[owner.index] = {owner, b.pose.position, b.velocity, b.angular_velocity};
  }
}

bool ContactEvents::touched(const ContactEvent& now) const {
  return std::binary_search(before_.begin(), before_.end(), now, is_before);
}

/// All contact points of a pair are in the same list.
void ContactEvents::collect(const World& world, std::span<const Contact> contacts, Real seconds) {
  for (std::size_t i = 0; i < contacts.size();) {
    const std::uint32_t slot_a = contacts[i].slot_a, slot_b = contacts[i].slot_b;
    // Contacts use the slots of the last step.
    const std::uint32_t now_a = world.bodies.slot_now(slot_a),
                        now_b = world.bodies.slot_now(slot_b);
    const bool known = std::max(now_a, now_b) < world.bodies.size();
    Sum sum;
    for (; i < contacts.size() && contacts[i].slot_a == slot_a && contacts[i].slot_b == slot_b; ++i)
      if (known)
        sum.add(contacts[i], to_world(world.bodies.values()[now_b].pose, contacts[i].point_b),
                seconds);
    if (sum.weight == 0) continue;
    ContactEvent e;
    e.a = world.bodies.owners()[now_a], e.b = world.bodies.owners()[now_b];
    e.impulse = sum.impulse, e.point = sum.point / sum.weight, e.depth = sum.depth;
    e.shape_a = contact::shape_of_a(sum.key), e.shape_b = contact::shape_of_b(sum.key);
    e.material_a = material_of(world, e.a, e.shape_a);
    e.material_b = material_of(world, e.b, e.shape_b);
    const Real length = glm::length(sum.normal);
    e.normal = length > 0 ? sum.normal / length : contacts[i - 1].normal;
    if (e.b.index < e.a.index) swap_sides(e);
    if (sum.bears || (sum.is_near && touched(e))) now_.push_back(e);
  }
}

void ContactEvents::collect_overlaps(const World& world) {
  for (const SensorOverlap& o : sensor_overlaps_of(world)) {
    if (!world.is_alive(o.sensor) || !world.is_alive(o.body)) continue;
    ContactEvent e;
    e.is_sensor = true;
    e.a = o.sensor, e.b = o.body;
    e.point = o.point, e.normal = o.normal, e.depth = o.depth;
    now_.push_back(e);
  }
}

void ContactEvents::compare() {
  events_.clear();
  for (ContactEvent& e : now_) {
    e.phase = touched(e) ? ContactPhase::persist : ContactPhase::begin;
    events_.push_back(e);
  }
  for (const ContactEvent& e : before_) {
    if (std::binary_search(now_.begin(), now_.end(), e, is_before)) continue;
    events_.push_back(e);
    events_.back().phase = ContactPhase::end;
    events_.back().impulse = Vec3(0), events_.back().depth = events_.back().approach = 0;
  }
}

std::span<const ContactEvent> ContactEvents::update(const World& world) {
  before_.swap(now_);
  now_.clear();
  const Real seconds = std::max(Real(0), world.time - time_);
  collect(world, contacts_of(world), seconds), collect(world, resting_contacts_of(world), seconds);
  collect_overlaps(world);
  std::sort(now_.begin(), now_.end(), is_before);
  find_approaches(), note_motions(world);
  compare();
  time_ = world.time;
  return events_;
}

}  // namespace pantin
