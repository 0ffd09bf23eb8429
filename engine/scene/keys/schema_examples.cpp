// Examples for editors, by kind of object. Each fits the schema: tests/scene/schema_test.py.
#include "engine/scene/keys/schema.hpp"

namespace pantin::detail {
namespace {

struct Example {
  std::string_view what, text;
};

constexpr Example kExamples[] = {
    {"scene", R"({"version": 1, "title": "A pendulum",
      "bodies": [{"name": "rod", "shape": {"type": "capsule", "radius": 0.02,
                                           "from": [0, 2, 0], "to": [0.8, 1.4, 0]}}],
      "joints": [{"a": "world", "b": "rod", "anchor": [0, 2, 0]}]})"},
    {"body", R"({"name": "shin", "parent": "thigh", "position": [0, -0.4, 0], "class": "limb",
      "shape": {"type": "capsule", "radius": 0.05, "from": [0, 0, 0], "to": [0, -0.4, 0]}})"},
    {"class", R"({"name": "limb", "body": {"density": 900, "drag": 0.05},
      "joint": {"kind": "hinge", "limits": {"angle_deg": [0, 140]}}})"},
    {"defaults", R"({"body": {"drag": 0.1}, "joint": {"friction": {"viscous": 0.02}}})"},
    {"capsule", R"({"type": "capsule", "radius": 0.05, "from": [0, 0, 0], "to": [0.3, 0.1, 0]})"},
    {"box", R"({"type": "box", "size": [0.4, 0.2, 0.1]})"},
    {"sphere", R"({"type": "sphere", "radius": 0.1})"},
    {"joint", R"({"name": "knee", "kind": "hinge", "a": "thigh", "b": "shin", "anchor": [0, 0.5, 0],
      "axis": [1, 0, 0], "limits": {"angle_deg": [0, 140]}})"},
    {"limits", R"({"angle_deg": [0, 140], "soft": {"zone_deg": 10, "stiffness": 5}})"},
    {"joint_drive", R"({"target_deg": [0, 0, 20], "stiffness": 40, "damping": 2})"},
    {"drive_motion", R"({"table_deg": [[0, 0], [0.4, 90], [0.6, 90], [1, 0]], "law": "cycloidal",
      "loop": true})"},
    {"sensor", R"({"name": "reach", "type": "distance", "body": "hand", "to": "cup",
      "to_anchor": [0, 0.1, 0]})"},
    {"motor", R"({"velocity_deg": 90, "cap": 2})"},
    {"spring", R"({"stiffness": 50, "damping": 0.5})"},
    {"gear", R"({"first": "crank", "second": "wheel", "ratio": -2})"},
    {"belt", R"({"pulleys": [{"body": "motor", "radius": 0.1}, {"body": "fan", "radius": 0.3}]})"},
    {"surface_joint", R"({"a": {"body": "ball"}, "b": {"body": "table"}, "motion": "rolling"})"},
    {"cable", R"({"a": "world", "b": "lamp", "point_a": [0, 3, 0], "length": 1.5})"},
    {"pin", R"({"body": "hand", "anchor": [0, -0.1, 0], "target": [0.4, 1.2, 0]})"},
    {"material", R"({"name": "wood", "colour": "#c89b5c", "roughness": 0.6})"},
    {"collision", R"({"friction": 0.6, "groups": ["puppet"], "with": ["ground"]})"},
    {"prefab", R"({"name": "leg", "file": "leg.json"})"},
    {"instance", R"({"name": "left_leg", "prefab": "leg", "position": [0.1, 0.9, 0]})"},
    {"chain", R"({"name": "rope", "links": 20, "length": 0.1, "start": [0, 2, 0],
      "attach": "world", "shape": {"type": "capsule", "radius": 0.02, "length": 0.08}})"},
    {"grid", R"({"name": "crowd", "prefab": "puppet", "count": [10, 1, 10]})"},
    {"ring", R"({"name": "seats", "prefab": "seat", "count": 8, "arm": [2, 0, 0]})"},
    {"gear_curve", R"({"type": "gear", "teeth": 20, "module": 0.01})"},
    {"cam_curve", R"({"type": "cam", "base": 0.05, "roller": 0.02, "law": "3-4-5",
      "lifts": [[0, 0], [60, 0], [150, 0.02], [210, 0.02], [300, 0]]})"},
    {"geneva_wheel_curve",
     R"({"type": "geneva_wheel", "slots": 6, "distance": 0.2, "pin": 0.008})"},
    {"stairs", R"({"name": "flight", "count": 8, "width": 1, "rise": 0.17, "run": 0.28})"},
    {"mirror", R"({"bodies": ["upper_arm_left", "forearm_left"], "axis": "x"})"},
    {"lamina", R"({"name": "rod", "outline": [[-1, 0], [1, 0], [1, 0.02], [-1, 0.02]], "mass": 1,
      "fingers": [{"point": [-0.8, 0], "velocity": [0.01, 0], "friction": [0.45, 0.3]},
                  {"point": [0.6, 0], "velocity": [-0.01, 0], "friction": 0.4}]})"},
    {"finger", R"({"name": "left", "point": [-0.8, 0], "normal": [0, 1], "velocity": [0.01, 0],
      "friction": 0.3, "friction_between": [0.2, 0.4]})"},
    {"push_event", R"({"type": "push", "body": "chest", "force": [120, 0, 0], "to": 0.3})"},
    {"cut_event", R"({"type": "cut", "joint": "rope/4-5", "at": 1})"},
    {"wind_event", R"({"type": "wind", "velocity": [3, 0, 0], "gusts": 2, "seed": 7})"},
};

}  // namespace

std::string_view example_of(std::string_view what) {
  for (const Example& example : kExamples)
    if (example.what == what) return example.text;
  return {};
}

}  // namespace pantin::detail
