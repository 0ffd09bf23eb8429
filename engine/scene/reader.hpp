#pragma once
/// Reads typed values from a JSON object and reports errors.
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/scene/diagnostics.hpp"
#include "engine/scene/json.hpp"
#include "engine/scene/keys.hpp"

namespace pantin::detail {

/// Allowed range of a number, and its description for errors.
struct Range {
  Real least, most;
  std::string_view words;
  bool open = false;  // `least` itself is not allowed

  bool holds(Real x) const { return (open ? x > least : x >= least) && x <= most; }
};

inline constexpr Real kMaxMagnitude = 1e9;  // m, m/s, rad/s: larger values are mistakes
inline constexpr Range kAnyNumber{-kMaxMagnitude, kMaxMagnitude, "a number between -1e9 and 1e9"};
inline constexpr Range kPositive{0, 1e12, "a number above 0, at most 1e12", true};
inline constexpr Range kNotNegative{0, 1e12, "a number from 0 to 1e12"};
inline constexpr Range kSize{1e-9, kMaxMagnitude, "a size from 1e-9 to 1e9 m"};
inline constexpr Range kWeight{1e-12, 1e12, "a number from 1e-12 to 1e12"};  // mass, density
inline constexpr Range kUnit{0, 1, "a number from 0 to 1"};

/// Reads the members of one object. A missing key yields the default; an invalid value reports an
/// error and yields the default too.
class Reader {
 public:
  /// Reports an error if `node` is not an object or has unknown keys; warns of old keys.
  Reader(const JsonDocument& json, Diagnostics& diagnostics, NodeId node, const KeySet& set);

  const JsonDocument& json;
  Diagnostics& diagnostics;
  const NodeId node;
  bool is_object() const { return json[node].kind == JsonKind::object; }

  /// Whether objects of this kind may have the key at all.
  bool accepts(std::string_view key) const;
  /// The value of a key, or kNoNode. The key must be in the set.
  NodeId find(std::string_view key) const;
  bool has(std::string_view key) const { return find(key) != kNoNode; }
  /// The same for a required key: "found no "a", expected ...".
  NodeId need(std::string_view key, std::string_view expected) const;

  Real number(std::string_view key, Real otherwise, const Range& range) const;
  int whole(std::string_view key, int otherwise, int least, int most) const;
  bool flag(std::string_view key, bool otherwise) const;
  std::string text(std::string_view key, std::string_view otherwise) const;
  /// One of `words`, as its index.
  std::size_t word(std::string_view key, std::size_t otherwise,
                   std::span<const std::string_view> words) const;
  Vec3 vec(std::string_view key, Vec3 otherwise, const Range& range = kAnyNumber) const;
  std::optional<Vec3> vec_if(std::string_view key) const;
  /// A nonzero vector, normalised.
  Vec3 direction(std::string_view key, Vec3 otherwise) const;
  /// Three numbers, or one that stands for all three.
  Vec3 vec_or_number(std::string_view key, Vec3 otherwise) const;
  /// "position" and "rotation" or "rotation_deg".
  Pose pose() const;
  Quat rotation(Quat otherwise) const { return rotation(otherwise, "rotation"); }
  /// A quaternion under `key`, or three angles under `key`_deg; not both.
  Quat rotation(Quat otherwise, std::string_view key) const;
  /// "#rrggbb" in sRGB or three linear numbers from 0 to 1 (lights: above 1 too).
  Vec3 colour(std::string_view key, Vec3 otherwise, Real most = 1) const;
  /// The name of an object: not empty, without "/", not "world".
  std::string name() const;

  /// The values of an array under a key; none if it is absent.
  std::vector<NodeId> items(std::string_view key) const;

  /// Reports an error if more than one of these keys is given.
  void one_of(std::span<const std::string_view> keys) const;

 private:
  void refuse_unknown(NodeId child) const;
  void warn_of_old(NodeId child, std::string_view today) const;

  const KeySet& set_;
  bool has_old_keys_ = false;
};

/// Reads an array of exactly `into.size()` numbers; otherwise reports an error and returns false.
bool read_numbers(const JsonDocument& json, Diagnostics& diagnostics, NodeId array,
                  std::span<Real> into, const Range& range);

/// Rotations about the fixed axes x, then y, then z.
Quat from_degrees(Vec3 angles);

}  // namespace pantin::detail
