#pragma once
/// Materials, camera and light.
#include <array>
#include <string>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

struct Material {
  std::string name;
  Vec3 colour{0.7, 0.7, 0.7};  // linear RGB, 0..1
  Real roughness = 0.5;        // 0..1
  Real metallic = 0;           // 0..1

  static void fields(auto& self, auto&& field) {
    field("name", self.name);
    field("colour", self.colour);
    field("roughness", self.roughness);
    field("metallic", self.metallic);
  }
};

/// A camera that looks from `eye` to `target`. With `automatic` the picture frames the whole scene
/// from the direction of `eye` to `target`.
struct Camera {
  Vec3 eye{2, 1.5, 4};
  Vec3 target{0, 1, 0};
  Real field_of_view = 0.7;  // vertical, rad
  bool automatic = true;
};

/// The sun and the sky.
struct Light {
  Vec3 direction{-0.45, -1, -0.35};  // direction in which the light travels
  Vec3 colour{1, 0.97, 0.92};        // linear
  Real strength = 3;
  Vec3 sky{0.62, 0.70, 0.80};     // ambient from above, linear
  Vec3 ground{0.25, 0.24, 0.23};  // ambient from below, linear
};

struct View {
  Camera camera;
  Light light;
  bool ground = true;      // draw the ground grid
  Real ground_height = 0;  // m
};

}  // namespace pantin
