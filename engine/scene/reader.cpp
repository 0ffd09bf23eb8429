#include "engine/scene/reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "engine/base/check.hpp"
#include "engine/base/rotation.hpp"
#include "engine/base/utf8.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kLongestName = 200;  // bytes

Real linear_of(Real srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

/// Six hexadecimal digits after "#".
std::optional<Vec3> colour_from(std::string_view text) {
  unsigned bits = 0;
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  const char* last = text.data() + text.size();
  if (std::from_chars(text.data() + 1, last, bits, 16).ptr != last) return std::nullopt;
  const auto part = [&](unsigned shift) { return linear_of(((bits >> shift) & 0xFF) / 255.0); };
  return Vec3(part(16), part(8), part(0));
}

}  // namespace

Reader::Reader(const JsonDocument& j, Diagnostics& c, NodeId n, const KeySet& set)
    : json(j), diagnostics(c), node(n), set_(set) {
  if (!is_object()) {
    diagnostics.error_value(node, "an object (" + std::string(set.what) + ")");
    return;
  }
  for (NodeId child = json[node].first_child; child != kNoNode; child = json[child].next) {
    const std::string_view key = json[child].key;
    if (accepts(key)) continue;
    const std::string_view today = today_of(kOldKeys, set.what, key);
    if (today.empty())
      refuse_unknown(child);
    else
      has_old_keys_ = true, warn_of_old(child, today);
  }
}

void Reader::refuse_unknown(NodeId child) const {
  const std::string_view key = json[child].key, near = diagnostics.hints.nearest(key, set_.keys);
  diagnostics.error_at_key(
      child,
      "found key \"" + clipped(key) + "\", expected a key of a " + std::string(set_.what) +
          (near.empty() ? ": " + listed(set_.keys) : "; nearest is \"" + std::string(near) + "\""));
}

void Reader::warn_of_old(NodeId child, std::string_view today) const {
  const std::string old(json[child].key), now(today);
  if (json.member(node, today) != kNoNode)
    diagnostics.error_at_key(child, "found \"" + old + "\" beside \"" + now +
                                        "\", expected only the latter, its name today");
  else
    diagnostics.warn(child, "old key", "the key \"" + old + "\" is called \"" + now + "\" today");
}

bool Reader::accepts(std::string_view key) const {
  return std::find(set_.keys.begin(), set_.keys.end(), key) != set_.keys.end();
}

NodeId Reader::find(std::string_view key) const {
  PANTIN_ASSERT(accepts(key));
  if (!is_object()) return kNoNode;
  const NodeId value = json.member(node, key);
  if (value != kNoNode || !has_old_keys_) return value;
  for (const OldKey& old : kOldKeys)
    if (old.what == set_.what && old.today == key)
      if (const NodeId found = json.member(node, old.old); found != kNoNode) return found;
  return kNoNode;
}

NodeId Reader::need(std::string_view key, std::string_view expected) const {
  const NodeId value = find(key);
  if (value == kNoNode && is_object())
    diagnostics.error(node,
                      "found no \"" + std::string(key) + "\", expected " + std::string(expected));
  return value;
}

Real Reader::number(std::string_view key, Real otherwise, const Range& range) const {
  const NodeId value = find(key);
  if (value == kNoNode || std::isnan(json[value].number)) return otherwise;
  if (json[value].kind == JsonKind::number && range.holds(json[value].number))
    return json[value].number;
  diagnostics.error_value(value, range.words);
  return otherwise;
}

int Reader::whole(std::string_view key, int otherwise, int least, int most) const {
  const NodeId value = find(key);
  if (value == kNoNode || std::isnan(json[value].number)) return otherwise;
  const Real x = json[value].number;
  if (json[value].kind == JsonKind::number && x == std::floor(x) && x >= least && x <= most)
    return static_cast<int>(x);
  diagnostics.error_value(
      value, "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  return otherwise;
}

bool Reader::flag(std::string_view key, bool otherwise) const {
  const NodeId value = find(key);
  if (value == kNoNode) return otherwise;
  if (json[value].kind == JsonKind::boolean) return json[value].boolean;
  diagnostics.error_value(value, "true or false");
  return otherwise;
}

std::string Reader::text(std::string_view key, std::string_view otherwise) const {
  const NodeId value = find(key);
  if (value == kNoNode) return std::string(otherwise);
  if (json[value].kind == JsonKind::string) return std::string(json[value].text);
  diagnostics.error_value(value, "text in double quotes");
  return std::string(otherwise);
}

std::size_t Reader::word(std::string_view key, std::size_t otherwise,
                         std::span<const std::string_view> words) const {
  const NodeId value = find(key);
  if (value == kNoNode) return otherwise;
  if (json[value].kind == JsonKind::string) {
    const std::string_view today = today_of(kOldWords, set_.what, json[value].text);
    const auto it = std::find(words.begin(), words.end(), today.empty() ? json[value].text : today);
    if (it != words.end() && !today.empty())
      diagnostics.warn(value, "old word",
                       "\"" + std::string(json[value].text) + "\" is called \"" +
                           std::string(today) + "\" today");
    if (it != words.end()) return static_cast<std::size_t>(it - words.begin());
  }
  diagnostics.error_value(value, listed(words) + diagnostics.hints.of(json[value].text, words));
  return otherwise;
}

bool read_numbers(const JsonDocument& json, Diagnostics& diagnostics, NodeId array,
                  std::span<Real> into, const Range& range) {
  if (json[array].kind != JsonKind::array || json[array].count != into.size()) {
    diagnostics.error_value(array, "an array of " + std::to_string(into.size()) + " numbers");
    return false;
  }
  bool good = true;
  std::size_t i = 0;
  for (NodeId c = json[array].first_child; c != kNoNode; c = json[c].next, ++i) {
    into[i] = json[c].number;
    if (std::isnan(into[i])) {
      good = false;  // refused already
    } else if (json[c].kind != JsonKind::number || !range.holds(into[i])) {
      diagnostics.error_value(c, range.words);
      good = false;
    }
  }
  return good;
}

Vec3 Reader::vec(std::string_view key, Vec3 otherwise, const Range& range) const {
  const NodeId value = find(key);
  Vec3 v(0);
  if (value == kNoNode || !read_numbers(json, diagnostics, value, {&v.x, 3}, range))
    return otherwise;
  return v;
}

std::optional<Vec3> Reader::vec_if(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  return vec(key, Vec3(0));
}

Vec3 Reader::direction(std::string_view key, Vec3 otherwise) const {
  const Vec3 v = vec(key, otherwise);
  const Real length = glm::length(v);
  if (length > 0) return v / length;
  diagnostics.error_value(find(key), "a direction: three numbers, not all 0");
  return otherwise;
}

Vec3 Reader::vec_or_number(std::string_view key, Vec3 otherwise) const {
  const NodeId value = find(key);
  if (value == kNoNode || json[value].kind == JsonKind::array) return vec(key, otherwise);
  return Vec3(number(key, otherwise.x, kAnyNumber));
}

Pose Reader::pose() const { return {vec("position", Vec3(0)), rotation(kIdentity)}; }

Quat Reader::rotation(Quat otherwise, std::string_view key) const {
  const std::string key_deg = std::string(key) + "_deg";
  const std::string_view both[] = {key, key_deg};
  one_of(both);
  if (has(key_deg)) return from_degrees(vec(key_deg, Vec3(0)));
  const NodeId value = find(key);
  Real q[4];
  if (value == kNoNode || !read_numbers(json, diagnostics, value, q, kAnyNumber)) return otherwise;
  const Quat quaternion(q[3], q[0], q[1], q[2]);
  const Real length = glm::length(quaternion), error = std::abs(length - 1);
  if (error > 1e-3) {
    diagnostics.error(value, "found a quaternion of length " + written(length) +
                                 ", expected [x, y, z, w] of length 1");
    return otherwise;
  }
  if (error > 1e-6)
    diagnostics.warn(value, "quaternion",
                     "quaternion of length " + written(length) + " was brought to length 1");
  return error < 1e-15 ? quaternion : quaternion * (1 / length);
}

Vec3 Reader::colour(std::string_view key, Vec3 otherwise, Real most) const {
  const NodeId value = find(key);
  if (value == kNoNode) return otherwise;
  const Range range{0, most, most > 1 ? "a number from 0 to 100" : kUnit.words};
  if (json[value].kind == JsonKind::array) return vec(key, otherwise, range);
  if (json[value].kind == JsonKind::string)
    if (const auto colour = colour_from(json[value].text)) return *colour;
  diagnostics.error_value(value, "a colour: \"#rrggbb\" (sRGB) or [r, g, b] (linear)");
  return otherwise;
}

std::string Reader::name() const {
  const NodeId value = need("name", "a name");
  const std::string word = text("name", "");
  if (value == kNoNode || json[value].kind != JsonKind::string) return {};
  if (word == "world") {
    diagnostics.error_value(value, "another name: this one stands for what never moves");
    return {};
  }
  const bool is_plain = std::none_of(word.begin(), word.end(), [](char c) {
    return c == '/' || static_cast<unsigned char>(c) < 0x20;
  });
  if (!word.empty() && word.size() <= kLongestName && is_plain) return word;
  diagnostics.error_value(value, "a name of 1 to 200 bytes without \"/\"");
  return {};
}

std::vector<NodeId> Reader::items(std::string_view key) const {
  std::vector<NodeId> result;
  const NodeId value = find(key);
  if (value == kNoNode) return result;
  if (json[value].kind != JsonKind::array) {
    diagnostics.error_value(value, "an array");
    return result;
  }
  result.reserve(json[value].count);
  for (NodeId c = json[value].first_child; c != kNoNode; c = json[c].next) result.push_back(c);
  return result;
}

void Reader::one_of(std::span<const std::string_view> keys) const {
  std::string_view first;
  for (std::string_view key : keys) {
    if (!has(key)) continue;
    if (first.empty())
      first = key;
    else
      diagnostics.error_at_key(find(key), "found \"" + std::string(key) + "\" beside \"" +
                                              std::string(first) + "\", expected only one of them");
  }
}

Quat from_degrees(Vec3 angles) {
  const Vec3 r = angles * (kPi / 180);
  return glm::normalize(from_rotation_vector({0, 0, r.z}) * from_rotation_vector({0, r.y, 0}) *
                        from_rotation_vector({r.x, 0, 0}));
}

}  // namespace pantin::detail
