#pragma once
/// Builds one group of a recipe: looks up names, expands prefabs, grids and chains.
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "engine/scene/build/build_context.hpp"

namespace pantin::detail {

/// `number` as in ElementId.
BuiltScene build_group(BuildContext& context, const Group& group, std::uint32_t number);

/// An element that is being built.
template <class T>
struct Element {
  const T& recipe;
  ElementId id;
};

class GroupBuilder {
 public:
  GroupBuilder(BuildContext& context, const Group& group, std::uint32_t number)
      : context_(context), messages_(context.messages), group_(group), number_(number) {}

  BuiltScene build();

 private:
  /// Calls a member function for each element of a list.
  template <class T, class F>
  void each(const std::vector<T>& list, ElementKind kind, F f) {
    for (std::uint32_t i = 0; i < list.size(); ++i) {
      context_.poll();
      (this->*f)(Element<T>{list[i], {kind, number_, i}});
    }
  }

  // Names: group_builder.cpp.
  using Places = std::unordered_map<std::string, std::uint32_t>;
  /// A reference by name: where it is written, and how messages call its target.
  struct Wanted {
    const ElementId& from;
    std::string_view member;
    std::string_view what;
  };
  void gather_names();
  bool is_below_broken(const std::string& name) const;
  /// The index of a name; reports an error and returns nothing if there is none.
  std::optional<std::uint32_t> look_up(const Places& places, const std::string& name,
                                       const Wanted& wanted);
  std::optional<std::uint32_t> body_or_world(const std::string& name, const ElementId& from,
                                             std::string_view member);
  std::optional<std::uint32_t> body(const std::string& name, const ElementId& from,
                                    std::string_view member);
  std::string name_for(const std::string& given, const std::string& a, const std::string& b);

  // Counts, checked before building: group_builder.cpp.
  bool make_space();
  bool fits(const BuildCount& count, const ElementId& at);
  const BuiltPrefab* prefab_of(const InstanceRecipe& instance, const ElementId& id);

  // Bodies and their paths: bodies.cpp.
  std::vector<std::uint32_t> parents_of_bodies();
  void place_bodies();
  void tell_of_circle(const std::vector<std::uint32_t>& parents, std::uint32_t start);
  std::uint32_t add(BuiltBody body);
  void add_body(Element<BodyRecipe> e);
  void add_links_of(Element<ChainRecipe> e);
  void add_drive(Element<PathRecipe> e);
  void add_pose(Element<PoseRecipe> e);
  void add_sensor(Element<SensorRecipe> e);  // sensors.cpp
  void check_loop(const ElementId& at, const KinematicPath& path);

  // Copies of prefabs: copies.cpp.
  struct Copy;
  /// Start indices of a copy's objects in the lists of the group.
  struct FirstPlaces {
    std::size_t bodies, joints, gears, cables, pins;
  };
  FirstPlaces sizes() const;
  void add_instance(Element<InstanceRecipe> e);
  void add_grid(Element<GridRecipe> e);
  Pose pose_of(const InstanceRecipe& instance, const ElementId& id);
  std::uint32_t world_of(const InstanceRecipe& instance, const ElementId& id);
  const BuiltScene& part_of(const InstanceRecipe& instance, const BuiltPrefab& prefab,
                            const ElementId& id);
  void copy(const Copy& how);
  void copy_belt(const Copy& how, const BuiltBelt& belt, std::uint32_t first);
  void copy_events(const Copy& how, const FirstPlaces& first);

  // Mirror images: mirror_groups.cpp.
  /// A mirrored body: its image, and the plane of reflection.
  struct Image {
    std::uint32_t body = UINT32_MAX;
    MirrorPlane plane;
  };
  struct MirroredLinks;
  void mirror_bodies(Element<MirrorRecipe> e);
  void add_image(const ElementId& at, std::uint32_t body, const Reflection& by);
  bool can_be_called(const ElementId& at, const std::string& name, const std::string& image);
  void mirror_links();

  // Joints, gears, cables, pins: links.cpp.
  struct Ends;
  bool can_tie(const Ends& ends);
  bool can_hold(const ElementId& id, std::string_view member, std::uint32_t body, Vec3 anchor);
  bool can_turn(const ElementId& id, const BuiltJoint& j, std::uint32_t body);
  void add_joints_of(Element<ChainRecipe> e);
  void add_joint(Element<JointRecipe> e);
  void add_gear(Element<GearRecipe> e);
  // Belts: belts.cpp.
  void add_belt(Element<BeltRecipe> e);
  bool place_pulleys(Element<BeltRecipe> e, BuiltBelt& made);
  void add_links_of_belt(Element<BeltRecipe> e, const BuiltBelt& laid);
  bool can_be_driven(Element<BeltRecipe> e, const BuiltBelt& laid);
  bool slides(const std::optional<bool>& asked, std::uint32_t joint, const Wanted& place);
  void add_surface_joint(Element<SurfaceJointRecipe> e);
  bool place_side(const SurfaceSideRecipe& side, std::uint32_t body, ContactSurface& to);
  void add_cable(Element<CableRecipe> e);
  void add_cable_over(Element<CableRecipe> e, std::uint32_t a, std::uint32_t b);
  void add_pin(Element<PinRecipe> e);
  bool hold_on(Element<PinRecipe> e, BuiltPin& placed);

  // Events: events.cpp.
  /// The entities of one type, by name.
  struct Index {
    std::vector<std::string_view> names;
    std::unordered_map<std::string_view, std::vector<std::uint32_t>> found;
  };
  const Index& index_of(EventObject object);
  const std::vector<std::uint32_t>* look_up_all(EventObject object, const std::string& name,
                                                const Wanted& wanted);
  bool can_be_pushed(Element<EventRecipe> e, std::uint32_t body);
  bool place_event(Element<EventRecipe> e, std::uint32_t body, TimedEvent& event);
  bool set_motor(Element<EventRecipe> e, std::uint32_t joint, JointMotor& motor);
  bool set_motion(Element<EventRecipe> e, const BuiltJoint& j, DriveMotion& motion);
  bool set_drive(Element<EventRecipe> e, std::uint32_t joint, DriveEvent& event);
  bool count_targets(const ElementId& at, std::size_t more);
  void add_event_on(Element<EventRecipe> e, EventObject object, std::uint32_t which);
  void add_event(Element<EventRecipe> e);

  BuildContext& context_;
  BuildMessages& messages_;
  const Group& group_;
  std::uint32_t number_;
  BuiltScene made_;
  BuiltScene image_;                                         // of the prefab being copied
  Places bodies_, joints_;                                   // by name; joints are indexed on first
                                                             // use
  std::vector<Pose> own_poses_;                              // of the recipe's `bodies`
  std::vector<std::uint32_t> first_links_;                   // by chain: its first body
  std::vector<const BuiltPrefab*> of_instances_, of_grids_;  // null: broken
  std::unordered_set<std::string> own_names_, broken_;
  Index indices_[static_cast<std::size_t>(EventObject::gear) + 1];  // filled on first use
  std::size_t targets_ = 0;                                         // of events
  std::unordered_map<std::uint32_t, Image> images_;  // by body; also of the images themselves
  std::unordered_map<std::string, int> unnamed_;     // how many objects share a generated name
};

}  // namespace pantin::detail
