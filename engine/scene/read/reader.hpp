#pragma once
/// Reads typed values from a JSON object and reports errors.
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/math.hpp"
#include "engine/scene/json/diagnostics.hpp"
#include "engine/scene/json/json.hpp"
#include "engine/scene/keys/key.hpp"

namespace pantin::detail {

/// An object from which others inherit keys: a class, or the defaults of a scene.
struct KeySource {
  NodeId node = kNoNode;
  std::string_view only = {};  // keys separated by spaces; empty: all
};

/// An object, and the sources from which it inherits missing keys, nearest first.
struct ObjectSource {
  ObjectSource(NodeId object) : node(object) {}
  NodeId node;
  std::vector<KeySource> sources{};
  std::vector<std::string_view> left_out{};  // keys that are not inherited from these
  bool is_class_unknown = false;             // so that missing keys are not reported
};

/// Reads the members of one object by the table of its keys. A missing key yields the default,
/// normally that of the table. An invalid value is reported and yields the default too.
class Reader {
 public:
  /// Reports an error if `node` is not an object, has unknown keys, or has keys that exclude or
  /// require each other; warns of old keys. An inherited value is dropped if a nearer source
  /// excludes it.
  Reader(const JsonDocument& json, Diagnostics& diagnostics, ObjectSource from, const KeySet& set);

  const JsonDocument& json;
  Diagnostics& diagnostics;
  const NodeId node;
  bool is_object() const { return json[node].kind == JsonKind::object; }

  std::span<const Key> keys() const { return set_.keys; }
  /// Whether objects of this kind may have the key at all.
  bool accepts(std::string_view key) const;
  /// The value of a key, or kNoNode. The key must be in the set.
  NodeId find(std::string_view key) const;
  bool has(std::string_view key) const { return find(key) != kNoNode; }
  /// Whether any of several keys, separated by spaces, is present.
  bool has_any(std::string_view keys) const;
  /// Whether the object itself has it, not only its class.
  bool says(std::string_view key) const { return find_in(node, key) != kNoNode; }
  /// The same for a key that is required in this context: "found no "a", expected ...". A missing
  /// key with is_needed in the table has been reported already.
  NodeId need(std::string_view key) const;

  Real number(std::string_view key, Real otherwise) const;
  Real number(std::string_view key) const { return number(key, row(key).defaults[0]); }
  /// The same with a narrower range.
  Real number(std::string_view key, Real otherwise, const Range& range) const;
  int whole(std::string_view key, int otherwise) const;
  int whole(std::string_view key) const;
  /// The same with a narrower range.
  int whole(std::string_view key, int otherwise, int most) const;
  bool flag(std::string_view key, bool otherwise) const;
  bool flag(std::string_view key) const { return flag(key, row(key).defaults[0] != 0); }
  std::string text(std::string_view key, std::string_view otherwise) const;
  /// One of the key's words, as its index.
  std::size_t word(std::string_view key, std::size_t otherwise) const;
  std::size_t word(std::string_view key) const;
  /// The same with the choice restricted to `words`.
  std::size_t word(std::string_view key, std::size_t otherwise,
                   std::span<const std::string_view> words) const;
  Vec3 vec(std::string_view key, Vec3 otherwise) const;
  Vec3 vec(std::string_view key) const { return vec(key, default_of(key)); }
  std::optional<Vec3> vec_if(std::string_view key) const;
  /// A nonzero vector, normalised.
  Vec3 direction(std::string_view key, Vec3 otherwise) const;
  /// Three numbers, or one number for all three.
  Vec3 vec_or_number(std::string_view key, Vec3 otherwise) const;
  Vec3 vec_or_number(std::string_view key) const { return vec_or_number(key, default_of(key)); }
  /// An array of exactly `into.size()` numbers; returns false if it is missing or invalid.
  bool numbers(std::string_view key, std::span<Real> into) const;
  /// The same for the array at a node, with another range.
  bool numbers_at(NodeId array, std::span<Real> into, const Range& range) const;
  /// The name of another object; reports anything but text that is not empty.
  std::optional<std::string> reference(std::string_view key) const;
  /// "position" and "rotation" or "rotation_deg".
  Pose pose() const;
  Quat rotation(Quat otherwise) const { return rotation(otherwise, "rotation"); }
  /// A quaternion under `key`, or three angles under `key`_deg; not both.
  Quat rotation(Quat otherwise, std::string_view key) const;
  /// "#rrggbb" in sRGB or three linear numbers.
  Vec3 colour(std::string_view key, Vec3 otherwise) const;
  /// The name of an object: not empty, without "/", not "world".
  std::string name() const;

  /// The values of an array under a key; none if it is missing.
  std::vector<NodeId> items(std::string_view key) const;

  /// The vectors in the array "points", invalid ones too, so that the indices of others are kept.
  std::vector<Vec3> points() const;

  /// As in Diagnostics: at the object, at the value under a key, at the key itself.
  void error(std::string message) const { diagnostics.error(node, std::move(message)); }
  void error(std::string_view key, std::string message) const {
    diagnostics.error(find(key), std::move(message));
  }
  void error_value(std::string_view key, std::string_view expected) const {
    diagnostics.error_value(find(key), expected);
  }
  void error_at_key(std::string_view key, std::string message) const {
    diagnostics.error_at_key(find(key), std::move(message));
  }

  /// The result of building from the object; nothing after reporting its error at the object.
  template <class T>
  std::optional<T> kept(Result<T> made) const {
    if (made) return std::move(*made);
    for (const Error& e : made.errors()) error(e.message);
    return std::nullopt;
  }

  /// The key's row of the table; the key must be in it.
  const Key& row(std::string_view key) const;

 private:
  void refuse_unknown(NodeId child) const;
  void warn_of_old(NodeId child, std::string_view today) const;
  void check_pairs() const;
  void check_exclusive(std::string_view one, std::string_view other,
                       std::vector<NodeId>& told) const;
  void check_needs() const;
  Vec3 default_of(std::string_view key) const;
  NodeId find_in(NodeId object, std::string_view key) const;
  NodeId find_inherited(std::string_view key) const;
  bool is_excluded_by(NodeId object, std::string_view key) const;

  const KeySet& set_;
  const ObjectSource from_;
  bool has_old_keys_ = false;
};

/// Rotations about the fixed axes x, then y, then z.
Quat from_degrees(Vec3 angles);

}  // namespace pantin::detail
