#pragma once
/// THE list of shape kinds, in the order of their numbers. A new kind is one word here and the file
/// engine/geometry/kinds/<word>.cpp, which defines shape_kinds::<word>; see kinds.hpp.
#define PANTIN_SHAPE_KINDS(kind) \
  kind(sphere)                   \
  kind(capsule)                  \
  kind(box)                      \
  kind(hull)                     \
  kind(plane)                    \
  kind(mesh)                     \
  kind(height_field)
