#pragma once
/// The only list of shape kinds, in the order of their numbers. A new kind is one word here and the
/// file engine/geometry/kinds/WORD.cpp, which defines shape_kinds::WORD; see kinds.hpp. Editors
/// that check scenes need the new kind in assets/schema too, as schema_of() prints it: a test
/// compares.
///
/// Internal (pantin::detail); installed because ShapeKind is made of it.
#define PANTIN_SHAPE_KINDS(kind)                                                            \
  kind(sphere) kind(capsule) kind(box) kind(hull) kind(plane) kind(mesh) kind(height_field) \
      kind(cylinder) kind(cone) kind(ellipsoid) kind(nurbs)
