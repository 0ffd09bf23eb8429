#pragma once
/// Colours of bodies that name no material.
#include <array>

#include "engine/geometry/shape.hpp"
#include "engine/render/bounds.hpp"

namespace pantin::detail {

/// Seven colours that observers with any colour vision tell apart, in linear RGB. Neighbours in the
/// list differ most. [Okabe & Ito 2008]
extern const std::array<Vec3, 7> kPalette;

/// The material of a shape of the body in `slot` as drawn: by PosedWorld::colours, else its own. A
/// shape without one has the colour of the palette for the index of its body's entity, so that a
/// body keeps its colour while others come and go. Links of a chain, named CHAIN/NUMBER, alternate
/// between two shades of one colour. A shape of a fixed body is light grey.
Material drawn_material(const PosedWorld& scene, std::uint32_t slot, std::uint32_t material);

}  // namespace pantin::detail
