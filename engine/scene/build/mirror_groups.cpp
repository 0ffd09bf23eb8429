// Mirror images of bodies of a group, and of the joints, cables and pins between them.
#include <utility>

#include "engine/geometry/kinds.hpp"
#include "engine/scene/build/group_builder.hpp"
#include "engine/scene/build/place.hpp"
#include "engine/world/surface_start.hpp"

namespace pantin::detail {

void GroupBuilder::mirror_bodies(Element<MirrorRecipe> e) {
  indices_[static_cast<std::size_t>(EventObject::body)] = {};  // the index of names is outdated
  std::vector<std::uint32_t> all;
  for (const std::string& name : e.recipe.bodies) {
    if (all.size() > context_.limits.bodies) break;  // reported below
    if (const auto* found =
            look_up_all(EventObject::body, name,
                        {e.id, "bodies", "the name of a body, a chain, an instance or a grid"}))
      all.insert(all.end(), found->begin(), found->end());
  }
  BuildCount more;
  more.bodies = static_cast<Real>(all.size());
  for (const std::uint32_t body : all)
    more.parts += static_cast<Real>(made_.bodies[body].mass_properties->shapes.size());
  if (!fits(more, e.id)) return;
  context_.used.add(more, 1);
  for (const std::uint32_t body : all) add_image(e.id, body, {e.recipe.plane});
  indices_[static_cast<std::size_t>(EventObject::body)] = {};
}

void GroupBuilder::add_image(const ElementId& at, std::uint32_t body, const Reflection& by) {
  const BuiltBody& own = made_.bodies[body];
  const auto refuse = [&](const std::string& what) {
    messages_.error(at, "bodies", "found " + quoted_name(own.name) + ", " + what);
  };
  if (own.has_path)  // a path of a prefab: those of this group are added later
    return refuse("which has a path, expected a body without one: a path cannot be mirrored");
  if (own.is_lamina || own.is_finger)
    return refuse("expected no lamina and no finger of one: they cannot be mirrored");
  BuiltBody image = mirrored(own, by, context_.images);
  image.name = mirrored_name(image.name);
  if (!can_be_called(at, own.name, image.name)) return;
  if (const auto kind = unmirrored(*image.mass_properties))
    return refuse("which has a " + std::string(name_of(*kind)) +
                  ", expected a body without one: it cannot be mirrored");
  const std::uint32_t place = add(std::move(image));
  images_[body] = {place, by.plane}, images_[place] = {body, by.plane};
}

/// Reports a name without a side, or whose opposite side exists already.
bool GroupBuilder::can_be_called(const ElementId& at, const std::string& name,
                                 const std::string& image) {
  if (name == image) {
    messages_.error(at, "bodies",
                    "found " + quoted_name(name) +
                        ", expected a name with a side: \"left\" or \"right\" in it, or \"l\" or "
                        "\"r\" as in \"arm_l\"");
    return false;
  }
  if (!bodies_.contains(image) && own_names_.insert(image).second) return true;
  messages_.error(at, "bodies",
                  "found " + quoted_name(name) + ", whose mirror image would be " +
                      quoted_name(image) + ", expected that name to be free");
  return false;
}

/// Makes images of joints, cables and pins of mirrored bodies.
struct GroupBuilder::MirroredLinks {
  GroupBuilder& group;
  const BuiltScene& made = group.made_;

  /// The image to use for a connection of two bodies: one of them is mirrored, and neither is an
  /// image.
  const Image* image_of(std::uint32_t a, std::uint32_t b) const {
    const Image *of_a = find(a), *of_b = find(b);
    if (is_image(a, of_a) || is_image(b, of_b)) return nullptr;
    return of_a ? of_a : of_b;
  }
  /// The same for all bodies along a cable.
  const Image* image_along(const BuiltCable& cable) const {
    const Image* image = image_of(cable.a, cable.b);
    if (is_image(cable.a, find(cable.a)) || is_image(cable.b, find(cable.b))) return nullptr;
    for (const BuiltGuide& g : cable.guides) {
      const Image* own = find(g.body);
      if (is_image(g.body, own)) return nullptr;
      if (!image) image = own;
    }
    return image;
  }
  const Image* find(std::uint32_t body) const {
    const auto it = group.images_.find(body);
    return it == group.images_.end() ? nullptr : &it->second;
  }
  /// An image has a higher index than its original.
  static bool is_image(std::uint32_t body, const Image* image) {
    return image && image->body < body;
  }
  std::uint32_t end(std::uint32_t body) const {
    const Image* image = find(body);
    return image ? image->body : body;
  }
  Vec3 anchor(std::uint32_t body, Vec3 at, const Reflection& by) const {
    if (find(body)) return by.direction(at);
    return from_scene(made, body, by.point(to_scene(made, body, at)));
  }
  Quat axes(std::uint32_t body, Quat own, const Reflection& by) const {
    if (find(body)) return by.axes(own);
    const Quat turned = made.pose_of(body).rotation;
    return glm::normalize(glm::conjugate(turned) * by.axes(turned * own));
  }
  /// The name of the image; empty after an error.
  std::string name(const ElementId& at, const std::string& own) const {
    std::string image = mirrored_name(own);
    if (image != own && group.own_names_.insert(image).second) return image;
    group.messages_.error(
        at, "name",
        "found " + quoted_name(own) + ", which ties bodies that are mirrored, expected a name " +
            (image == own ? "with a side, as \"knee_left\""
                          : "whose mirror image " + quoted_name(image) + " is free"));
    return {};
  }

  std::vector<std::uint32_t> joints() const;  // by joint: its image, or kWorldBody
  void gears(const std::vector<std::uint32_t>& images) const;
  void cables() const;
  void pins() const;
  void surfaces() const;
};

std::vector<std::uint32_t> GroupBuilder::MirroredLinks::joints() const {
  std::vector<std::uint32_t> images(made.joints.size(), kWorldBody);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Image* image = image_of(made.joints[i].a, made.joints[i].b);
    if (!image) continue;
    const Reflection by{image->plane};
    BuiltJoint j = made.joints[i];
    j.joint.anchor_a = anchor(j.a, j.joint.anchor_a, by);
    j.joint.anchor_b = anchor(j.b, j.joint.anchor_b, by);
    j.joint.frames.set(axes(j.a, j.joint.frames.a(), by), axes(j.b, j.joint.frames.b(), by));
    mirror_travel(j.joint);
    j.name = name(j.at, j.name), j.a = end(j.a), j.b = end(j.b);
    images[i] = static_cast<std::uint32_t>(made.joints.size());
    group.made_.joints.push_back(std::move(j));
  }
  return images;
}

void GroupBuilder::MirroredLinks::gears(const std::vector<std::uint32_t>& images) const {
  for (std::size_t i = 0, count = made.gears.size(); i < count; ++i) {
    BuiltGear g = made.gears[i];
    if (g.first >= images.size() || g.second >= images.size()) continue;
    g.first = images[g.first], g.second = images[g.second];
    if (g.first == kWorldBody || g.second == kWorldBody) continue;
    g.ratio = mirrored(g.ratio), g.name = name(g.at, g.name);
    group.made_.gears.push_back(std::move(g));
  }
}

void GroupBuilder::MirroredLinks::cables() const {
  for (std::size_t i = 0, count = made.cables.size(); i < count; ++i) {
    BuiltCable c = made.cables[i];
    const Image* image = image_along(c);
    if (!image) continue;
    for (BuiltGuide& g : c.guides) {
      const Quat turned = made.pose_of(g.body).rotation;
      g.guide.anchor = anchor(g.body, g.guide.anchor, {image->plane});
      g.guide.axis = find(g.body) ? Reflection{image->plane}.axial(g.guide.axis)
                                  : glm::conjugate(turned) *
                                        Reflection{image->plane}.axial(turned * g.guide.axis);
      g.body = end(g.body);
    }
    c.joint.anchor_a = anchor(c.a, c.joint.anchor_a, {image->plane});
    c.joint.anchor_b = anchor(c.b, c.joint.anchor_b, {image->plane});
    c.name = name(c.at, c.name), c.a = end(c.a), c.b = end(c.b);
    group.made_.cables.push_back(std::move(c));
  }
}

void GroupBuilder::MirroredLinks::pins() const {
  for (std::size_t i = 0, count = made.pins.size(); i < count; ++i) {
    BuiltPin p = made.pins[i];
    const Image* image = image_of(p.body, p.to);
    if (!image) continue;
    p.pin.anchor = anchor(p.body, p.pin.anchor, {image->plane});
    p.pin.target = anchor(p.to, p.pin.target, {image->plane});
    p.name = name(p.at, p.name), p.body = end(p.body), p.to = end(p.to);
    group.made_.pins.push_back(std::move(p));
  }
}

/// The contact of the images is the image of the original contact.
void GroupBuilder::MirroredLinks::surfaces() const {
  for (std::size_t i = 0, count = made.surface_joints.size(); i < count; ++i) {
    BuiltSurfaceJoint s = made.surface_joints[i];
    const Image* image = image_of(s.a, s.b);
    if (!image) continue;
    const Reflection by{image->plane};
    const auto reflected = [&](std::uint32_t body, const ContactSurface& side) {
      return find(body) ? mirrored(side, by, group.context_.images)
                        : mirrored_in(made.pose_of(body), side, by, group.context_.images);
    };
    s.contact.on_a = reflected(s.a, s.contact.on_a),
    s.contact.on_b = reflected(s.b, s.contact.on_b);
    s.name = name(s.at, s.name), s.a = end(s.a), s.b = end(s.b);
    s.contact.known = false;
    if (const std::string why = place_surfaces(s.contact, {made.pose_of(s.a), made.pose_of(s.b)});
        !why.empty())
      group.messages_.error(s.at, "", why + " (of its mirror image)");
    group.made_.surface_joints.push_back(std::move(s));
  }
}

void GroupBuilder::mirror_links() {
  if (images_.empty()) return;
  BuildCount more;
  more.links = static_cast<Real>(made_.links());
  if (!fits(more, {ElementKind::group, number_, 0})) return;
  context_.used.add(more, 1);
  const MirroredLinks links{*this};
  links.gears(links.joints());
  links.cables(), links.pins();
  links.surfaces();
  for (const BuiltBelt& belt : made_.belts)
    for (const std::uint32_t body : belt.bodies)
      if (images_.contains(body)) {
        messages_.error(
            belt.at, "",
            "found a belt on bodies that are mirrored, expected none: it cannot be mirrored");
        break;
      }
}

}  // namespace pantin::detail
