#pragma once
/// Where two surfaces touch at first, and why they cannot.
#include <string>

#include "engine/world/surface_contact.hpp"

namespace pantin::detail {

/// Finds the pair of places whose gap is the smallest, with the bodies at these poses, and sets
/// SurfaceContact::at; leaves what is `known`. Returns "found ..., expected ..." where surfaces
/// that are held do not face one another within their size, where they fit one another, and where
/// one has a crease; else nothing.
struct StartPoses {
  Pose a, b;  // of the bodies' mass-centre frames
};
std::string place_surfaces(SurfaceContact& contact, const StartPoses& bodies);

}  // namespace pantin::detail
