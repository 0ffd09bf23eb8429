#pragma once
/// Internal (pantin::detail); installed because the public kinds of paths are built on it.
///
/// The interface of a kind of path. A kind is a struct in a file of its own here, named in the list
/// of kinematic_path.hpp. Steps, scene files and their schema, pictures and hashes follow from it:
///
///   static constexpr std::string_view name, about;   // "lissajous", for scene files
///   static constexpr bool turns_smoothly;            // no jump in angular velocity
///   static void fields(auto& self, auto&& field);    // its data, as of every component
///   static void scene_keys(auto& self, auto&& key);  // its keys in scene files, see PathKey
///   Pose at(Real time) const;                        // no jump in position or velocity
///   void move(const Pose& by);                       // by a rigid motion of the world
///   void shift(Real ahead);                          // the same path, `ahead` seconds earlier
///   void start_from(const Pose& start);              // replaces what is kLeftOpen
///   PathBounds bounds() const;                       // of its positions, approximate
///
/// Optional:
///
///   std::size_t parts() const;                       // for the limits on scene files
///   Pose seam() const;                               // from its first pose to its last, which
///                                                    // has to vanish for a periodic path
#include <cstdint>
#include <limits>
#include <string_view>

#include "engine/base/math.hpp"

namespace pantin::detail {

/// A box around the positions of a path; empty if low is above high.
struct PathBounds {
  Vec3 low{1e300}, high{-1e300};  // m

  void add(Vec3 p) { low = glm::min(low, p), high = glm::max(high, p); }
};

/// The type of the value under a key of the path's object.
enum class PathForm : std::uint8_t {
  vector,
  angles,            // three, at most 1e6 degrees
  vector_or_number,  // three numbers, or one for all three
  number,
  not_negative  // a number from 0 on
};

struct PathKey {
  std::string_view key, unit, about;
  PathForm form = PathForm::vector;
  Real scale = 1;             // factor from the number in the file to the member
  std::string_view old = {};  // the key's name in earlier versions
};

/// Marks a value that follows from the initial pose of the body.
inline constexpr Real kLeftOpen = std::numeric_limits<Real>::quiet_NaN();

}  // namespace pantin::detail
