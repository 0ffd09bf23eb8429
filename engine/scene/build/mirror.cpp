#include "engine/scene/build/mirror.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/plane_curves.hpp"
#include "engine/world/drive_motion.hpp"

namespace pantin::detail {
namespace {

constexpr std::pair<std::string_view, std::string_view> kSides[] = {
    {"left", "right"}, {"Left", "Right"}, {"LEFT", "RIGHT"}};

/// The opposite side if the name contains a side at `at`, and the length of the one it contains.
std::pair<std::string_view, std::size_t> side_at(std::string_view name, std::size_t at) {
  const std::string_view rest = name.substr(at);
  for (const auto& [left, right] : kSides) {
    if (rest.starts_with(left)) return {right, left.size()};
    if (rest.starts_with(right)) return {left, right.size()};
  }
  const auto is_letter = [&](std::size_t i) {
    return i < name.size() && std::isalnum(static_cast<unsigned char>(name[i])) != 0;
  };
  if ((at > 0 && is_letter(at - 1)) || is_letter(at + 1)) return {};
  constexpr std::string_view kFrom = "lrLR", kTo = "rlRL";
  const std::size_t place = kFrom.find(name[at]);
  return place == kFrom.npos ? std::pair<std::string_view, std::size_t>{}
                             : std::pair(kTo.substr(place, 1), std::size_t(1));
}

nurbs::Affine flip_of(const Reflection& by) {
  nurbs::Affine flip;
  for (int k = 0; k < 3; ++k) {
    Vec3 axis(0);
    axis[k] = 1;
    flip.linear[k] = by.direction(axis);
  }
  return flip;
}

/// Reverses a planar curve, unless it is mirrored across its own plane.
std::shared_ptr<const nurbs::Wire> curve_image(const nurbs::Wire& wire, const Reflection& by) {
  nurbs::Curve image = nurbs::transformed(wire.curve(), flip_of(by));
  if (by.plane.axis != 2) image = nurbs::reversed(image);
  return std::make_shared<const nurbs::Wire>(std::move(image));
}

/// Reverses mirrored faces, whose outer sides would otherwise be inside.
std::shared_ptr<const nurbs::Skin> skin_image(const nurbs::Skin& skin, const Reflection& by) {
  if (skin.half_axes()) return std::make_shared<nurbs::Skin>(skin);  // it is its own image
  const nurbs::Affine flip = flip_of(by);
  std::vector<nurbs::Surface> faces;
  for (const nurbs::Face& face : skin.faces())
    faces.push_back(nurbs::inside_out(nurbs::transformed(face.surface(), flip)));
  return std::make_shared<nurbs::Skin>(std::move(faces), skin.tolerance());
}

std::shared_ptr<const Surface> image_of_skin(const nurbs::Skin& skin, const Reflection& by) {
  const auto made = make_skin(skin_image(skin, by));
  return made ? *made : nullptr;
}

/// Null if the surface has no mirror image.
std::shared_ptr<const Surface> image_of(const Shape& shape, const Reflection& by) {
  const auto made_of = [](Result<std::shared_ptr<const Surface>> made) {
    return made ? *made : nullptr;
  };
  const SurfaceSource source = traits_of(shape.kind).source;
  if (source == SurfaceSource::skin) return image_of_skin(*shape.surface->skin, by);
  std::vector<Vec3> points;
  for (const Vec3 p : shape.surface->points) points.push_back(by.direction(p));
  if (source == SurfaceSource::points) return made_of(make_hull(points));
  if (source != SurfaceSource::triangles) return nullptr;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const std::vector<std::uint32_t>& corners = shape.surface->corners;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
    triangles.push_back({corners[i], corners[i + 2], corners[i + 1]});
  return made_of(make_mesh(points, triangles));
}

/// Mirrors a shape in its body's frame. A shape with symmetry about y only is rotated instead of
/// reflected.
Shape mirrored(const Shape& shape, const Reflection& by, MirrorImages& images) {
  Shape image = shape;
  image.local = {by.direction(shape.local.position), by.rotation(shape.local.rotation)};
  const ShapeTraits& kind = traits_of(shape.kind);
  if (shape.surface) {
    auto& known = images.surfaces[{shape.surface.get(), by.plane.axis}];
    if (!known) known = image_of(shape, by);
    image.surface = known;
  } else if (!kind.rounded && by.plane.axis != 0) {
    // The shape is symmetric across x: S S_x is a half turn about the third axis.
    const Quat about = by.plane.axis == 1 ? Quat(0, 0, 0, 1) : Quat(0, 0, 1, 0);
    image.local.rotation = glm::normalize(image.local.rotation * about);
  }
  return image;
}

BodyMassProperties mirrored(const BodyMassProperties& body, const Reflection& by,
                            MirrorImages& images) {
  BodyMassProperties image = body;
  image.centre = {by.direction(body.centre.position), by.rotation(body.centre.rotation)};
  for (Shape& shape : image.shapes) shape = mirrored(shape, by, images);
  return image;
}

void mirror(BuiltJoint& j, const Reflection& by) {
  const auto anchor = [&](std::uint32_t body, Vec3 at) {
    return body == kWorldBody ? by.point(at) : by.direction(at);
  };
  j.joint.anchor_a = anchor(j.a, j.joint.anchor_a),
  j.joint.anchor_b = anchor(j.b, j.joint.anchor_b);
  j.joint.frames.set(by.axes(j.joint.frames.a()), by.axes(j.joint.frames.b()));
  mirror_travel(j.joint);
  if (j.drive && j.drive->exact && j.drive->motion.travels) scale(j.drive->motion, -1);
}

void mirror(BuiltEvent& e, const Reflection& by, const BuiltScene& whole) {
  TimedEvent& t = e.event;
  each_event_key(t, [&]<class T>(const EventKey& key, T& member) {
    if constexpr (std::is_same_v<T, Vec3>) {
      if (key.form == EventForm::direction || key.form == EventForm::anchor)
        member = by.direction(member);
      if (key.form == EventForm::axial) member = by.axial(member);
      if (key.form == EventForm::point) member = by.point(member);
    }
  });
  const bool slides = e.object == EventObject::joint &&
                      !info_of(whole.joints[e.on].joint.kind).is_used(Coordinate::angle, kActuated);
  if (auto* motor = std::get_if<MotorEvent>(&t.kind); motor && slides)
    motor->motor.target = -motor->motor.target;
  if (auto* drive = std::get_if<DriveEvent>(&t.kind); drive && drive->motion)
    if (drive->motion->travels) scale(*drive->motion, -1);
}

}  // namespace

std::string mirrored_name(const std::string& name) {
  std::string image;
  for (std::size_t i = 0; i < name.size();) {
    const auto [other, length] = side_at(name, i);
    if (length > 0)
      image += other, i += length;
    else
      image += name[i++];
  }
  return image;
}

std::optional<ShapeKind> unmirrored(const BodyMassProperties& image) {
  for (const Shape& shape : image.shapes)
    if (!is_complete(shape)) return shape.kind;
  return std::nullopt;
}

BuiltBody mirrored(const BuiltBody& body, const Reflection& by, MirrorImages& images) {
  BuiltBody image = body;
  image.body.pose = by.pose(body.body.pose);
  image.body.velocity = by.direction(body.body.velocity);
  image.body.angular_velocity = by.axial(body.body.angular_velocity);
  auto& known = images.bodies[{body.mass_properties.get(), by.plane.axis}];
  if (!known)
    known = std::make_shared<BodyMassProperties>(mirrored(*body.mass_properties, by, images));
  image.mass_properties = known;
  if (body.collision &&
      (body.collision->surface_velocity != Vec3(0) || body.collision->one_way != Vec3(0))) {
    Collision collision = *body.collision;
    collision.one_way = by.direction(collision.one_way);
    collision.surface_velocity = by.direction(collision.surface_velocity);
    image.collision = std::make_shared<Collision>(collision);
  }
  return image;
}

void mirror_travel(Joint& joint) {
  // -S turns the normal of a wheel's track over: y is the image of y, and z that of z.
  if (joint.kind == JointKind::wheel) {
    const Quat half_turn(0, 1, 0, 0);
    joint.frames.set(joint.frames.a() * half_turn, joint.frames.b() * half_turn);
  }
  if (info_of(joint.kind).is_line || !joint.parameters.any()) return;
  JointParameters& own = joint.parameters.edit();
  own.pitch = -own.pitch;
  std::swap(own.travel.low, own.travel.high);
  own.travel.low = -own.travel.low, own.travel.high = -own.travel.high;
  own.translation.spring.rest = -own.translation.spring.rest;
  own.translation.motor.target = -own.translation.motor.target;
}

Gear mirrored(const Gear& gear) {
  Gear image = gear;
  if (gear.first_travels != gear.second_travels) image.ratio = -gear.ratio;
  if (gear.second_travels) image.offset = -gear.offset;
  return image;
}

ContactSurface mirrored(const ContactSurface& surface, const Reflection& by, MirrorImages& images) {
  ContactSurface image = surface;
  image.pose = {by.direction(surface.pose.position), by.rotation(surface.pose.rotation)};
  if (surface.curve) image.curve = curve_image(*surface.curve, by);
  if (!surface.skin) return image;
  auto& known = images.skins[{surface.skin.get(), by.plane.axis}];
  if (!known) known = skin_image(*surface.skin, by);
  image.skin = known;
  return image;
}

ContactSurface mirrored_in(const Pose& body, const ContactSurface& surface, const Reflection& by,
                           MirrorImages& images) {
  ContactSurface image = mirrored(surface, by, images);
  image.pose = compose(inverse(body), by.pose(compose(body, surface.pose)));
  return image;
}

BuiltScene mirrored(const BuiltScene& whole, const Reflection& by, MirrorImages& images) {
  BuiltScene image = whole;
  image.paths.clear();
  image.belts.clear();  // reported by the builder
  for (BuiltBody& b : image.bodies) b = mirrored(b, by, images);
  for (BuiltJoint& j : image.joints) mirror(j, by);
  for (BuiltGear& g : image.gears) g.ratio = mirrored(g.ratio);
  for (BuiltCable& c : image.cables) {
    c.joint.anchor_a = by.direction(c.joint.anchor_a);
    c.joint.anchor_b = by.direction(c.joint.anchor_b);
    for (BuiltGuide& g : c.guides)
      g.guide.anchor = by.direction(g.guide.anchor), g.guide.axis = by.axial(g.guide.axis);
  }
  for (BuiltPin& p : image.pins) {
    p.pin.anchor = by.direction(p.pin.anchor);
    p.pin.target = by.direction(p.pin.target);
  }
  for (BuiltSurfaceJoint& s : image.surface_joints) {
    const auto reflect = [&](std::uint32_t body, ContactSurface& side) {
      side = body == kWorldBody ? mirrored_in({}, side, by, images) : mirrored(side, by, images);
    };
    reflect(s.a, s.contact.on_a), reflect(s.b, s.contact.on_b);
    s.contact.known = false;
  }
  for (BuiltEvent& e : image.events) mirror(e, by, whole);
  const auto rename = [](auto& items) {
    for (auto& item : items) item.name = mirrored_name(item.name);
  };
  rename(image.bodies), rename(image.joints), rename(image.gears);
  rename(image.cables), rename(image.pins), rename(image.surface_joints);
  return image;
}

}  // namespace pantin::detail
