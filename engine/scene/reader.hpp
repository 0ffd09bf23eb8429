#pragma once
/// Takes typed values out of a JSON object and complains of whatever does not fit.
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/scene/complaints.hpp"
#include "engine/scene/json.hpp"
#include "engine/scene/keys.hpp"

namespace pantin {

/// What a number may be, and how complaints say it.
struct Range {
  Real least, most;
  std::string_view words;
  bool open = false;  // `least` itself is not allowed

  bool holds(Real x) const { return (open ? x > least : x >= least) && x <= most; }
};

inline constexpr Real kFar = 1e9;  // m, m/s, rad/s: beyond it a scene is a slip of the pen
inline constexpr Range kAnyNumber{-kFar, kFar, "a number between -1e9 and 1e9"};
inline constexpr Range kPositive{0, 1e12, "a number above 0, at most 1e12", true};
inline constexpr Range kNotNegative{0, 1e12, "a number from 0 to 1e12"};
inline constexpr Range kSize{1e-9, kFar, "a size from 1e-9 to 1e9 m"};
inline constexpr Range kWeight{1e-12, 1e12, "a number from 1e-12 to 1e12"};  // mass, density
inline constexpr Range kUnit{0, 1, "a number from 0 to 1"};

/// Reads the members of one object. Every call with a key that is absent yields the alternative;
/// every call with a value that does not fit complains and yields the alternative too.
class Reader {
 public:
  /// Complains if `node` is no object or has keys that `set` lacks; warns of old keys.
  Reader(const JsonDocument& json, Complaints& complaints, NodeId node, const KeySet& set);

  const JsonDocument& json;
  Complaints& complaints;
  const NodeId node;
  bool is_object() const { return json[node].kind == JsonKind::object; }

  /// Whether objects of this kind may have the key at all.
  bool accepts(std::string_view key) const;
  /// The value of a key, or kNoNode. The key must be in the set.
  NodeId find(std::string_view key) const;
  bool has(std::string_view key) const { return find(key) != kNoNode; }
  /// The same; complains if it is absent: "found no "a", expected ...".
  NodeId need(std::string_view key, std::string_view expected) const;

  Real number(std::string_view key, Real otherwise, const Range& range) const;
  int whole(std::string_view key, int otherwise, int least, int most) const;
  bool flag(std::string_view key, bool otherwise) const;
  std::string text(std::string_view key, std::string_view otherwise) const;
  /// One of `words`, as its place in them.
  std::size_t word(std::string_view key, std::size_t otherwise,
                   std::span<const std::string_view> words) const;
  Vec3 vec(std::string_view key, Vec3 otherwise, const Range& range = kAnyNumber) const;
  std::optional<Vec3> vec_if(std::string_view key) const;
  /// A vector that is not zero, made one long.
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
  /// A name of one's own: not empty, without "/", not "world".
  std::string name() const;

  /// The values of an array under a key; none if it is absent.
  std::vector<NodeId> items(std::string_view key) const;

  /// Complains if more than one of these keys is given.
  void one_of(std::span<const std::string_view> keys) const;

 private:
  void refuse_unknown(NodeId child) const;
  void warn_of_old(NodeId child, std::string_view today) const;

  const KeySet& set_;
  bool has_old_keys_ = false;
};

/// Reads an array of exactly `into.size()` numbers; complains and returns false otherwise.
bool read_numbers(const JsonDocument& json, Complaints& complaints, NodeId array,
                  std::span<Real> into, const Range& range);

/// Turned about the fixed x axis first, then y, then z.
Quat from_degrees(Vec3 angles);

}  // namespace pantin
