#include "engine/scene/assembly.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <unordered_map>

#include "engine/base/rotation.hpp"
#include "engine/scene/place.hpp"
#include "engine/scene/read.hpp"
#include "engine/scene/utf8.hpp"

namespace pantin {
namespace {

constexpr std::size_t kHintsEnough = 200;  // complaints after which nearest names are not sought

/// A pose moved by a rigid motion; one without a turn leaves rotations as they are to the last bit.
Pose placed(const Pose& by, const Pose& pose) {
  if (by.rotation == kNoTurn) return {by.position + pose.position, pose.rotation};
  return compose(by, pose);
}

/// What all groups of a file share while they are assembled.
struct Shop {
  const Recipe& recipe;
  const JsonDocument& json;
  Complaints& complaints;
  const SceneLimits& limits;

  enum class State { unknown, open, done, broken };
  std::vector<Assembly> assemblies{};  // of the prefabs
  std::vector<State> states{};
  std::vector<std::size_t> open{};               // prefabs being assembled, outermost first
  std::size_t bodies = 0, links = 0, parts = 0;  // placed so far, in prefabs too

  /// The assembly of a prefab, or null after a complaint.
  const Assembly* prefab(const Reference& reference);
  void complain_of_cycle(const Reference& reference, std::size_t which);
};

/// Writes one group out.
class Bench {
 public:
  Bench(Shop& shop, const Group& group) : shop_(shop), group_(group) {}

  Assembly work() {
    gather_names();
    if (!make_room()) return std::move(made_);
    for (const BodyRecipe& body : group_.bodies) add_body(body);
    for (const ChainRecipe& chain : group_.chains) add_links_of(chain);
    for (const InstanceRecipe& instance : group_.instances) add_instance(instance);
    for (const GridRecipe& grid : group_.grids) add_grid(grid);
    for (const DriveRecipe& drive : group_.drives) add_drive(drive);
    for (const ChainRecipe& chain : group_.chains) add_joints_of(chain);
    for (const JointRecipe& joint : group_.joints) add_joint(joint);
    for (const RatioRecipe& ratio : group_.ratios) add_ratio(ratio);
    for (const StringRecipe& string : group_.strings) add_string(string);
    for (const PinRecipe& pin : group_.pins) add_pin(pin);
    return std::move(made_);
  }

 private:
  void gather_names() {
    broken_ = group_.broken;
    const auto note = [&](const auto& items) {
      for (const auto& x : items)
        if (!x.name.empty()) own_names_.insert(x.name);
    };
    note(group_.bodies), note(group_.instances), note(group_.chains);
    note(group_.joints), note(group_.ratios), note(group_.strings), note(group_.pins);
    for (const GridRecipe& grid : group_.grids) own_names_.insert(grid.each.name);
  }

  // ---- Counts: known before anything is copied, since a few lines can ask for millions. ----

  struct Count {
    Real bodies = 0, links = 0, parts = 0;
    void add(const Assembly& a, Real copies) {
      bodies += copies * static_cast<Real>(a.bodies.size());
      links += copies * static_cast<Real>(a.links());
      for (const PlacedBody& b : a.bodies)
        parts += copies * static_cast<Real>(b.matter->shapes.size());
      for (const PlacedDrive& d : a.drives)
        if (const auto* path = std::get_if<Keyframes>(&d.drive.path))
          parts += copies * static_cast<Real>(path->keys.size());
      for (const PlacedJoint& j : a.joints)
        if (j.drive) parts += copies * static_cast<Real>(j.drive->keys.size());
    }
  };

  bool make_room() {
    Count count;
    count.bodies = static_cast<Real>(group_.bodies.size());
    count.links =
        static_cast<Real>(group_.joints.size() + group_.ratios.size() + group_.strings.size() +
                          group_.pins.size());
    bool good = true;
    const auto add = [&](const InstanceRecipe& instance, Real copies) {
      const Assembly* part = shop_.prefab(instance.prefab);
      prefab_of_[&instance] = part;
      if (!part) {
        broken_.push_back(instance.name);
        return;
      }
      count.add(*part, copies);
      good = good && fits(count, instance.at);
    };
    for (const BodyRecipe& b : group_.bodies)
      count.parts += static_cast<Real>(b.matter.shapes.size());
    for (const ChainRecipe& chain : group_.chains) {
      count.bodies += chain.links, count.links += chain.links + 1;
      count.parts += chain.links * static_cast<Real>(chain.link.matter.shapes.size());
      good = good && fits(count, chain.at);
    }
    for (const InstanceRecipe& instance : group_.instances) add(instance, 1);
    for (const GridRecipe& grid : group_.grids)
      add(grid.each, Real(1) * grid.count[0] * grid.count[1] * grid.count[2]);
    if (!good || !fits(count, group_.at)) return false;
    made_.bodies.reserve(static_cast<std::size_t>(count.bodies));
    made_.joints.reserve(static_cast<std::size_t>(count.links));
    place_of_.reserve(static_cast<std::size_t>(count.bodies));
    shop_.bodies += static_cast<std::size_t>(count.bodies);
    shop_.links += static_cast<std::size_t>(count.links);
    shop_.parts += static_cast<std::size_t>(count.parts);
    return true;
  }

  bool fits(const Count& count, NodeId at) {
    const auto check = [&](Real here, std::size_t before, std::size_t limit, const char* what) {
      // Prefabs are kept whole while they are copied, so each counts once more.
      if (here <= static_cast<Real>(limit) &&
          here + static_cast<Real>(before) <= 2 * static_cast<Real>(limit))
        return true;
      shop_.complaints.refuse(at, "found " + written(here) + " " + what + ", expected at most " +
                                      std::to_string(limit));
      return false;
    };
    return check(count.bodies, shop_.bodies, shop_.limits.bodies, "bodies") &&
           check(count.links, shop_.links, shop_.limits.links,
                 "joints, ratios, strings and pins") &&
           check(count.parts, shop_.parts, shop_.limits.parts, "shapes and keyframes");
  }

  // ---- Bodies ----

  std::uint32_t add(PlacedBody body) {
    const auto place = static_cast<std::uint32_t>(made_.bodies.size());
    made_.bodies.push_back(std::move(body));
    place_of_.emplace(made_.bodies.back().name, place);
    return place;
  }

  PlacedBody laid_out(const BodyRecipe& recipe, const std::string& name, const Pose& own) const {
    PlacedBody p;
    p.name = name, p.at = recipe.at, p.matter = &recipe.matter;
    p.solver = recipe.solver ? &*recipe.solver : nullptr;
    p.body.pose = recipe.matter.is_moved ? compose(own, recipe.matter.centre) : own;
    p.body.velocity = recipe.velocity, p.body.spin = recipe.spin;
    p.body.mass = recipe.matter.mass, p.body.inertia = recipe.matter.inertia;
    p.body.drag = recipe.drag, p.body.gravity_scale = recipe.gravity_scale;
    p.body.motion = recipe.motion;
    p.collision = recipe.collision ? &*recipe.collision : nullptr;
    return p;
  }

  void add_body(const BodyRecipe& recipe) { add(laid_out(recipe, recipe.name, recipe.pose)); }

  void add_links_of(const ChainRecipe& chain) {
    const ChainCourse course = course_of(chain);
    const Vec3 middle = course.middle(chain.closed);
    Real factor = 1;
    bool is_whole = true;
    for (std::size_t i = 0; i < course.links.size(); ++i) {
      PlacedBody p = laid_out(chain.link, chain.name + "/" + std::to_string(i), course.links[i]);
      const Real own = factor * (i + 1 == course.links.size() ? chain.tip_mass_factor : 1);
      p.at = chain.at;
      p.body.mass *= own, p.body.inertia *= own;
      factor *= chain.mass_ratio;
      // The chain starts as one rigid thing that turns about its middle.
      p.body.velocity += glm::cross(p.body.spin, p.body.pose.position - middle);
      if (!chain.materials.empty()) p.material = chain.materials[i % chain.materials.size()];
      if (is_whole && (!std::isfinite(p.body.mass) || !is_possible_inertia(p.body.inertia))) {
        shop_.complaints.refuse(chain.at, "found a mass of " + written(p.body.mass) +
                                              " kg at link " + std::to_string(i) +
                                              ", expected a finite mass above 0");
        is_whole = false;
      }
      add(std::move(p));
    }
  }

  // ---- Prefabs ----

  void add_instance(const InstanceRecipe& instance) {
    if (const Assembly* part = prefab_of_[&instance])
      copy(*part, instance, instance.name + "/", instance.pose, instance.time_offset);
  }

  void add_grid(const GridRecipe& grid) {
    const Assembly* part = prefab_of_[&grid.each];
    if (!part) return;
    int copies = 0;
    for (int y = 0; y < grid.count[1]; ++y)
      for (int z = 0; z < grid.count[2]; ++z)
        for (int x = 0; x < grid.count[0]; ++x) {
          const Vec3 from_middle(x - (grid.count[0] - 1) / 2.0, y - (grid.count[1] - 1) / 2.0,
                                 z - (grid.count[2] - 1) / 2.0);
          const Pose at{to_world(grid.each.pose, from_middle * grid.spacing),
                        grid.each.pose.rotation};
          copy(*part, grid.each, grid.each.name + "/" + std::to_string(copies) + "/", at,
               copies * grid.each.time_offset);
          ++copies;
        }
  }

  void copy(const Assembly& part, const InstanceRecipe& instance, const std::string& prefix,
            const Pose& at, Real ahead) {
    const auto first = static_cast<std::uint32_t>(made_.bodies.size());
    const auto first_joint = static_cast<std::uint32_t>(made_.joints.size());
    const auto moved_place = [&](std::uint32_t body) {
      return body == kWorldBody ? kWorldBody : first + body;
    };
    const auto moved_anchor = [&](std::uint32_t body, Vec3 anchor) {
      return body == kWorldBody ? to_world(at, anchor) : anchor;
    };
    const auto moved_axes = [&](std::uint32_t body, Quat axes) {
      return body == kWorldBody ? glm::normalize(at.rotation * axes) : axes;
    };
    for (const PlacedBody& b : part.bodies) {
      PlacedBody p = b;
      p.name.insert(0, prefix);
      p.body.pose = placed(at, b.body.pose);
      p.body.velocity = at.rotation * b.body.velocity;
      p.body.spin = at.rotation * b.body.spin;
      if (instance.solver) p.solver = &*instance.solver;
      add(std::move(p));
    }
    for (const PlacedJoint& j : part.joints) {
      PlacedJoint& p = made_.joints.emplace_back(j);
      p.name.insert(0, prefix);
      p.a = moved_place(j.a), p.b = moved_place(j.b);
      p.joint.anchor_a = moved_anchor(j.a, j.joint.anchor_a);
      p.joint.anchor_b = moved_anchor(j.b, j.joint.anchor_b);
      p.joint.frames.set(moved_axes(j.a, j.joint.frames.a()),
                         moved_axes(j.b, j.joint.frames.b()));
      if (j.drive) p.drive = hastened(*j.drive, ahead);
    }
    for (const PlacedRatio& r : part.ratios)
      made_.ratios.push_back(
          {prefix + r.name, r.at, first_joint + r.first, first_joint + r.second, r.ratio});
    for (const PlacedString& s : part.strings)
      made_.strings.push_back(
          {prefix + s.name,
           s.at,
           moved_place(s.a),
           moved_place(s.b),
           {moved_anchor(s.a, s.joint.anchor_a), moved_anchor(s.b, s.joint.anchor_b),
            s.joint.length, s.joint.compliance}});
    for (const PlacedPin& p : part.pins) {
      made_.pins.push_back({prefix + p.name, p.at, moved_place(p.body), p.pin, moved_place(p.to)});
      if (p.to == kWorldBody) made_.pins.back().pin.target = to_world(at, p.pin.target);
    }
    for (const PlacedDrive& d : part.drives)
      made_.drives.push_back({d.at, moved_place(d.body), hastened(moved(d.drive, at), ahead)});
  }

  // ---- Names ----

  /// The place of a named body; complains and returns nothing if there is none.
  std::optional<std::uint32_t> look_up(const Reference& reference, bool world_allowed) {
    if (reference.name == "world" && world_allowed) return kWorldBody;
    const auto it = place_of_.find(std::string(reference.name));
    if (it != place_of_.end()) return it->second;
    for (const std::string& name : broken_)
      if (reference.name.starts_with(name + "/")) return std::nullopt;
    std::vector<std::string_view> names;
    if (shop_.complaints.refused() < kHintsEnough)
      for (const PlacedBody& b : made_.bodies) names.push_back(b.name);
    shop_.complaints.refuse_value(reference.at, std::string("the name of a body") +
                                                    (world_allowed ? " or \"world\"" : "") +
                                                    hint(reference.name, names));
    return std::nullopt;
  }

  /// A name of the form "a-b" for what has none of its own.
  std::string name_for(const std::string& given, const Reference& a, const Reference& b) {
    if (!given.empty()) return given;
    const std::string base = std::string(a.name) + "-" + std::string(b.name);
    std::string name = base;
    for (int n = 2; !own_names_.insert(name).second; ++n) name = base + "#" + std::to_string(n);
    return name;
  }

  // ---- Joints, strings, pins, drives ----

  /// Complains if a joint or string cannot tie these two.
  bool can_tie(NodeId at, const Reference& a_name, const Reference& b_name, std::uint32_t a,
               std::uint32_t b) {
    const char* fault = nullptr;
    if (a == b)
      fault = "expected two different ones";
    else if (!made_.is_dynamic(a) && !made_.is_dynamic(b))
      fault = "expected a dynamic body on one side";
    if (!fault) return true;
    shop_.complaints.refuse(at, "found \"" + clipped(a_name.name) + "\" tied to \"" +
                                    clipped(b_name.name) + "\", " + fault);
    return false;
  }

  void add_joint(const JointRecipe& recipe) {
    const auto a = look_up(recipe.a, true), b = look_up(recipe.b, true);
    if (!a || !b || !can_tie(recipe.at, recipe.a, recipe.b, *a, *b)) return;
    PlacedJoint placed{name_for(recipe.name, recipe.a, recipe.b), recipe.at, *a, *b,
                       joint_of(made_, recipe, *a, *b), recipe.turn.drive};
    const Parameter* measured = info_of(placed.joint.kind).measured();
    if (measured && !recipe.turn.length && !(measured->value(placed.joint.extras.edit()) > 0))
      shop_.complaints.refuse(recipe.at, "found " + a_joint(placed.joint.kind) +
                                             " whose ends start at one point, expected a \"" +
                                             std::string(measured->key) + "\"");
    made_.joints.push_back(std::move(placed));
  }

  /// The place of a named joint; complains and returns nothing if there is none.
  std::optional<std::uint32_t> look_up_joint(const Reference& reference) {
    if (joint_of_.size() != made_.joints.size())
      for (std::uint32_t i = 0; i < made_.joints.size(); ++i)
        joint_of_.emplace(made_.joints[i].name, i);
    const auto it = joint_of_.find(std::string(reference.name));
    if (it != joint_of_.end()) return it->second;
    for (const std::string& name : broken_)
      if (reference.name.starts_with(name + "/")) return std::nullopt;
    std::vector<std::string_view> names;
    if (shop_.complaints.refused() < kHintsEnough)
      for (const PlacedJoint& j : made_.joints) names.push_back(j.name);
    shop_.complaints.refuse_value(reference.at,
                                  "the name of a joint" + hint(reference.name, names));
    return std::nullopt;
  }

  /// Whether a ratio counts the slide of a joint: as the file says, or the one freedom it has.
  /// Complains of a joint that cannot move so.
  bool slides(const std::optional<bool>& asked, std::uint32_t joint, NodeId at) {
    const JointKind kind = made_.joints[joint].joint.kind;
    const bool turns = info_of(kind).is_used(Coordinate::turn, kGeared);
    const bool can_slide = info_of(kind).is_used(Coordinate::slide, kGeared);
    const bool slides = asked.value_or(can_slide && !turns);
    if (slides ? can_slide : turns) return slides;
    shop_.complaints.refuse(
        at, "found the " + std::string(slides ? "slide" : "turn") + " of " + a_joint(kind) +
                ", expected a joint that " +
                (slides ? "slides: " : "turns about one axis: ") +
                kinds_where([&](const JointKindInfo& info) {
                  return info.is_used(slides ? Coordinate::slide : Coordinate::turn, kGeared);
                }));
    return slides;
  }

  void add_ratio(const RatioRecipe& recipe) {
    const auto first = look_up_joint(recipe.first), second = look_up_joint(recipe.second);
    if (!first || !second) return;
    if (*first == *second) {
      shop_.complaints.refuse_value(recipe.second.at, "another joint than the first");
      return;
    }
    PlacedRatio placed{name_for(recipe.name, recipe.first, recipe.second), recipe.at, *first,
                       *second, {}};
    Ratio& r = placed.ratio;
    r.slides_first = slides(recipe.slides_first, *first, recipe.first.at);
    r.slides_second = slides(recipe.slides_second, *second, recipe.second.at);
    r.ratio = recipe.ratio, r.has_offset = recipe.offset.has_value();
    r.offset = recipe.offset.value_or(0) * (recipe.in_degrees ? kPi / 180 : 1);
    if (recipe.in_degrees && r.slides_second)
      shop_.complaints.refuse(recipe.at,
                              "found \"offset_deg\" of a slide, expected \"offset\" in m");
    made_.ratios.push_back(std::move(placed));
  }

  void add_joints_of(const ChainRecipe& chain) {
    const ChainCourse course = course_of(chain);
    const auto attach = [&](const std::optional<Reference>& to, const char* name, ChainEnd end) {
      const auto body = to ? look_up(*to, true) : std::nullopt;
      if (!body) return;
      end.body = *body;
      if (*body == end.link)
        shop_.complaints.refuse_value(to->at, "another body than the link itself");
      else
        made_.joints.push_back({chain.name + "/" + name, chain.at, end.body, end.link,
                                chain_end_joint(made_, chain.turn, end), chain.turn.drive});
    };
    // Anchors are taken in the links' own frames, so that equal links are alike to the last bit.
    const std::uint32_t first = place_of_.find(chain.name + "/0")->second;
    const auto links = static_cast<std::uint32_t>(chain.links);
    const auto end_of = [&](std::uint32_t i, Real side) {
      return from_own_frame(made_, first, {0, side * course.lengths[i] / 2, 0});
    };
    attach(chain.attach, "top", {0, first, course.joints.front(), end_of(0, 1)});
    Joint joint = chain_joint(made_, chain.turn, first);
    const auto tie = [&](std::uint32_t a, std::uint32_t b, const std::optional<PoseDrive>& drive) {
      joint.anchor_a = end_of(a, -1), joint.anchor_b = end_of(b, 1);
      made_.joints.push_back({chain.name + "/" + std::to_string(a) + "-" + std::to_string(b),
                              chain.at, first + a, first + b, joint, drive});
    };
    for (std::uint32_t i = 1; i < links; ++i) tie(i - 1, i, chain.turn.drive);
    if (chain.closed) {
      // Of a joint that closes a loop only the point is held, so it claims no more.
      joint.kind = JointKind::ball, joint.limits = {}, joint.extras = {};
      tie(links - 1, 0, std::nullopt);
    }
    attach(chain.end_attach, "end",
           {0, first + links - 1, course.joints.back(), end_of(links - 1, -1)});
  }

  void add_string(const StringRecipe& recipe) {
    const auto a = look_up(recipe.a, true), b = look_up(recipe.b, true);
    if (!a || !b || !can_tie(recipe.at, recipe.a, recipe.b, *a, *b)) return;
    StringJoint joint;
    joint.anchor_a = anchor_of(made_, *a, recipe.at_a);
    joint.anchor_b = anchor_of(made_, *b, recipe.at_b);
    joint.compliance = recipe.compliance;
    const Real span = glm::length(to_scene(made_, *b, joint.anchor_b) -
                                  to_scene(made_, *a, joint.anchor_a));
    joint.length = recipe.length.value_or(recipe.slack * span);
    if (!(joint.length > 0)) {
      shop_.complaints.refuse(
          recipe.at, "found a string whose ends start at one point, expected a \"length\"");
      return;
    }
    made_.strings.push_back({name_for(recipe.name, recipe.a, recipe.b), recipe.at, *a, *b, joint});
  }

  void add_pin(const PinRecipe& recipe) {
    const auto body = look_up(recipe.body, false);
    if (!body) return;
    if (!made_.is_dynamic(*body)) {
      shop_.complaints.refuse_value(recipe.body.at,
                                    "a dynamic body: this one is not moved by pins");
      return;
    }
    PlacedPin placed{recipe.name, recipe.at, *body, recipe.pin};
    placed.pin.anchor = anchor_of(made_, *body, recipe.point);
    placed.pin.target = recipe.target.value_or(to_scene(made_, *body, placed.pin.anchor));
    if (recipe.to && !hold_on(recipe, placed)) return;
    if (placed.name.empty()) placed.name = name_for("", recipe.body, {"pin"});
    made_.pins.push_back(std::move(placed));
  }

  /// Brings a pin's target into the frame of the body it holds on to.
  bool hold_on(const PinRecipe& recipe, PlacedPin& placed) {
    const auto to = look_up(*recipe.to, false);
    if (!to) return false;
    placed.to = *to;
    placed.pin.target = recipe.anchor_to ? from_own_frame(made_, *to, *recipe.anchor_to)
                                         : from_scene(made_, *to, placed.pin.target);
    if (*to != placed.body) return true;
    shop_.complaints.refuse_value(recipe.to->at, "another body than the one that is held");
    return false;
  }

  void add_drive(const DriveRecipe& recipe) {
    const auto place = look_up(recipe.body, false);
    if (!place) return;
    PlacedBody& body = made_.bodies[*place];
    if (body.body.motion != Motion::driven) {
      shop_.complaints.refuse_value(recipe.body.at, "a body whose \"motion\" is \"driven\"");
      return;
    }
    if (body.is_driven_by_path) {
      shop_.complaints.refuse_value(recipe.body.at, "a body without another drive");
      return;
    }
    body.is_driven_by_path = true;
    PlacedDrive placed{recipe.at, *place, {}};
    if (recipe.keys.empty()) {
      placed.drive.path = sway_of(recipe, body.body.pose);
    } else {
      const Keyframes path = keyframes_of(recipe, body.body.pose);
      refuse_open_loop(recipe.at, path);
      placed.drive.path = path;
    }
    body.body.pose = pose_at(placed.drive, 0);
    made_.drives.push_back(std::move(placed));
  }

  void refuse_open_loop(NodeId at, const Keyframes& path) {
    const Pose &first = path.keys.front().pose, &last = path.keys.back().pose;
    const Real gap = glm::length(last.position - first.position);
    const Real turn = glm::length(rotation_vector(last.rotation * glm::conjugate(first.rotation)));
    if (path.loop && (gap > 1e-9 || turn > 1e-6))
      shop_.complaints.refuse(at, "found a loop whose last key is " + written(gap) + " m and " +
                                      written(turn * 180 / kPi) +
                                      " degrees from its first, expected the same pose");
  }

  Shop& shop_;
  const Group& group_;
  Assembly made_;
  std::unordered_map<std::string, std::uint32_t> place_of_;  // bodies by name
  std::unordered_map<std::string, std::uint32_t> joint_of_;  // joints by name, once asked for
  std::unordered_map<const InstanceRecipe*, const Assembly*> prefab_of_;
  std::set<std::string> own_names_;
  std::vector<std::string> broken_;
};

void Shop::complain_of_cycle(const Reference& reference, std::size_t which) {
  std::string way;
  const auto from = std::find(open.begin(), open.end(), which);
  for (auto it = from; it != open.end(); ++it) way += recipe.prefabs[*it].name + " -> ";
  complaints.refuse_value(reference.at, "a prefab that does not contain itself (" + way +
                                            recipe.prefabs[which].name + ")");
}

const Assembly* Shop::prefab(const Reference& reference) {
  if (reference.at == kNoNode) return nullptr;
  assemblies.resize(recipe.prefabs.size());
  states.resize(recipe.prefabs.size(), State::unknown);
  for (std::size_t i = 0; i < recipe.prefabs.size(); ++i) {
    if (recipe.prefabs[i].name != reference.name) continue;
    if (states[i] == State::open) complain_of_cycle(reference, i);
    if (states[i] == State::open || states[i] == State::broken) return nullptr;
    if (states[i] == State::done) return &assemblies[i];
    if (open.size() >= limits.depth) {
      complaints.refuse_value(reference.at,
                              "prefabs nested at most " + std::to_string(limits.depth) + " deep");
      return nullptr;
    }
    states[i] = State::open;
    open.push_back(i);
    const std::size_t refused_before = complaints.refused();
    assemblies[i] = Bench(*this, recipe.prefabs[i]).work();
    open.pop_back();
    states[i] = complaints.refused() == refused_before ? State::done : State::broken;
    return states[i] == State::done ? &assemblies[i] : nullptr;
  }
  std::vector<std::string_view> names;
  for (const Group& group : recipe.prefabs) names.push_back(group.name);
  complaints.refuse_value(reference.at, "the name of a prefab" + hint(reference.name, names));
  return nullptr;
}

}  // namespace

Assembly assemble(const Recipe& recipe, const JsonDocument& json, Complaints& complaints,
                  const SceneLimits& limits) {
  Shop shop{recipe, json, complaints, limits};
  // Prefabs that nothing uses are checked too.
  for (const Group& group : recipe.prefabs)
    if (!group.name.empty()) shop.prefab({group.name, json.member(group.at, "name")});
  Assembly whole = Bench(shop, recipe.top).work();
  // Joints and strings were measured with all parts at rest; now each path starts at its own time.
  for (const PlacedDrive& d : whole.drives) whole.bodies[d.body].body.pose = pose_at(d.drive, 0);
  return whole;
}

}  // namespace pantin
