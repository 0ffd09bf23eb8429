#include "tools/pantin/gltf.hpp"

#ifdef PANTIN_HAS_RENDER
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <span>

#include "engine/base/atomic_file.hpp"
#include "engine/render/gather.hpp"
#include "engine/render/model.hpp"
#include "engine/render/supports.hpp"

namespace pantin::program {

using namespace detail;
using Json = nlohmann::ordered_json;

namespace {

static_assert(std::endian::native == std::endian::little, "buffers are little-endian");

constexpr double kInterval = 1.0 / 60, kSlack = 1e-9;  // s
constexpr std::size_t kMostFloats = 100'000'000;
// Tubes of one cable: a slack one hangs in a curve, one with guides bends around them.
constexpr std::size_t kHanging = 6, kGuided = 24;
constexpr double kTubeRadius = 1e-3;  // fraction of the size of everything
constexpr int kFloat = 5126, kUnsigned = 5125, kVertices = 34962, kIndices = 34963;

std::size_t tubes_of(const Cable& cable) { return cable.guides.empty() ? kHanging : kGuided; }

/// Points at equal distances along a polyline, both ends included.
std::vector<Vec3> resampled(std::span<const Vec3> line, std::size_t segments) {
  std::vector<Real> lengths{0};
  for (std::size_t i = 1; i < line.size(); ++i)
    lengths.push_back(lengths.back() + glm::distance(line[i - 1], line[i]));
  std::vector<Vec3> points;
  std::size_t at = 1;
  for (std::size_t k = 0; k <= segments; ++k) {
    const Real way = lengths.back() * static_cast<Real>(k) / static_cast<Real>(segments);
    while (at + 1 < line.size() && lengths[at] < way) ++at;
    const Real part = lengths[at] - lengths[at - 1];
    const Real along = part > 0 ? std::clamp((way - lengths[at - 1]) / part, 0.0, 1.0) : 0;
    points.push_back(glm::mix(line[at - 1], line[at], along));
  }
  return points;
}

void add_vec(std::vector<float>& to, Vec3 v) {
  for (int k = 0; k < 3; ++k) to.push_back(static_cast<float>(v[k]));
}

/// With the sign nearest to the rotation before, between which viewers interpolate.
void add_rotation(std::vector<float>& to, Quat q) {
  float next[4] = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z),
                   static_cast<float>(q.w)};
  float along = 0;
  for (std::size_t k = 0; k < 4 && to.size() >= 4; ++k) along += next[k] * to[to.size() - 4 + k];
  for (float& x : next) to.push_back(along < 0 ? -x : x);
}

/// The rotation that takes y to a direction (unit), near that of the last values.
Quat turned_to(Vec3 way, const std::vector<float>& last) {
  if (last.size() < 4) return upright(way);
  const float* q = last.data() + last.size() - 4;
  const Quat before = glm::normalize(Quat(q[3], q[0], q[1], q[2]));
  const Vec3 y = before * Vec3(0, 1, 0);
  const Real along = glm::dot(y, way);
  if (along < -0.9) return upright(way);
  return glm::normalize(glm::normalize(Quat(1 + along, glm::cross(y, way))) * before);
}

/// Appends the last values once more.
void repeat(std::vector<float>& of, std::size_t count) {
  if (of.size() < count) return;
  const std::vector<float> last(of.end() - static_cast<std::ptrdiff_t>(count), of.end());
  of.insert(of.end(), last.begin(), last.end());
}

std::vector<float> first_of(std::span<const float> values, std::size_t count) {
  return {values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count)};
}

bool is_constant(std::span<const float> values, std::size_t width) {
  for (std::size_t i = width; i < values.size(); ++i)
    if (values[i] != values[i % width]) return false;
  return true;
}

/// The parts of a file: its JSON, and the bytes that it refers to. Equal data are kept once.
class File {
 public:
  explicit File(const std::string& title) {
    json_ = {{"asset", {{"version", "2.0"}, {"generator", "pantin"}}},
             {"scene", 0},
             {"scenes", Json::array({{{"name", title}, {"nodes", Json::array()}}})}};
    for (const char* list : {"nodes", "meshes", "materials", "accessors", "bufferViews"})
      json_[list] = Json::array();
  }

  /// Numbers of `type`; their bounds are given where the format asks for them.
  template <class T>
  std::size_t accessor(std::span<const T> values, const char* type, int target) {
    const std::size_t width = std::strcmp(type, "SCALAR") == 0 ? 1
                              : std::strcmp(type, "VEC3") == 0 ? 3
                                                               : 4;
    std::string bytes(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    const auto [known, is_new] = accessors_.try_emplace({type, bytes}, json_["accessors"].size());
    if (!is_new) return known->second;
    Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}};
    if (target != 0) view["target"] = target;
    json_["bufferViews"].push_back(view);
    bytes_ += bytes;  // whole words, so that all offsets are aligned
    Json entry = {{"bufferView", json_["bufferViews"].size() - 1},
                  {"componentType", std::is_same_v<T, float> ? kFloat : kUnsigned},
                  {"count", values.size() / width},
                  {"type", type}};
    if (std::is_same_v<T, float> && width < 4) {
      std::vector<T> low(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(width));
      std::vector<T> high = low;
      for (std::size_t i = 0; i < values.size(); ++i) {
        low[i % width] = std::min(low[i % width], values[i]);
        high[i % width] = std::max(high[i % width], values[i]);
      }
      entry["min"] = low, entry["max"] = high;
    }
    json_["accessors"].push_back(entry);
    return known->second;
  }

  std::size_t material(const Material& of) {
    return once("materials", {{"pbrMetallicRoughness",
                               {{"baseColorFactor", {of.colour.x, of.colour.y, of.colour.z, 1}},
                                {"metallicFactor", of.metallic},
                                {"roughnessFactor", of.roughness}}},
                              {"doubleSided", true}});
  }

  /// A mesh of parts; none without any.
  std::optional<std::size_t> mesh(std::span<const ModelPart> parts) {
    if (parts.empty()) return std::nullopt;
    Json primitives = Json::array();
    for (const ModelPart& part : parts) {
      const std::span points(part.positions[0].data(), 3 * part.positions.size());
      const std::span normals(part.normals[0].data(), 3 * part.normals.size());
      primitives.push_back({{"attributes",
                             {{"POSITION", accessor<float>(points, "VEC3", kVertices)},
                              {"NORMAL", accessor<float>(normals, "VEC3", kVertices)}}},
                            {"indices", accessor<std::uint32_t>(part.indices, "SCALAR", kIndices)},
                            {"material", material(part.material)}});
    }
    return once("meshes", {{"primitives", primitives}});
  }

  std::size_t node(Json node) {
    json_["nodes"].push_back(std::move(node));
    const std::size_t index = json_["nodes"].size() - 1;
    json_["scenes"][0]["nodes"].push_back(index);
    return index;
  }

  /// Lets a property of a node follow values at times.
  void animate(std::size_t node, const char* path, std::pair<std::size_t, std::size_t> data) {
    if (!json_.contains("animations"))
      json_["animations"] = Json::array(
          {{{"name", "run"}, {"samplers", Json::array()}, {"channels", Json::array()}}});
    Json& animation = json_["animations"][0];
    animation["channels"].push_back(
        {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
    animation["samplers"].push_back({{"input", data.first}, {"output", data.second}});
  }

  /// The whole file: a header, then both parts as chunks.
  std::string glb() {
    json_["buffers"] = Json::array({{{"byteLength", bytes_.size()}}});
    for (const char* list : {"nodes", "meshes", "materials", "accessors", "bufferViews", "buffers"})
      if (json_[list].empty() || bytes_.empty()) json_.erase(list);
    std::string text =
        json_.dump(-1, ' ', /*ensure_ascii=*/false, nlohmann::json::error_handler_t::replace);
    text.append((4 - text.size() % 4) % 4, ' ');
    std::string file = "glTF";
    const auto word = [&](std::size_t value) {
      const auto bits = static_cast<std::uint32_t>(value);
      file.append(reinterpret_cast<const char*>(&bits), 4);
    };
    constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
    word(2), word(12 + 8 + text.size() + (bytes_.empty() ? 0 : 8 + bytes_.size()));
    word(text.size()), word(kJsonChunk), file += text;
    if (!bytes_.empty()) word(bytes_.size()), word(kBinaryChunk), file += bytes_;
    return file;
  }

 private:
  /// The index of an object in a list, to which it is added unless it is there.
  std::size_t once(const char* list, const Json& object) {
    const auto [known, is_new] = objects_.try_emplace(list + object.dump(), json_[list].size());
    if (is_new) json_[list].push_back(object);
    return known->second;
  }

  Json json_;
  std::string bytes_;
  std::map<std::pair<std::string, std::string>, std::size_t> accessors_;  // by type and content
  std::map<std::string, std::size_t> objects_;
};

/// The radius of the tubes along cables, m.
Real tube_radius(const World& world) {
  Vec3 low(1e300), high(-1e300);
  for (const Body& b : world.bodies.values())
    low = glm::min(low, b.pose.position), high = glm::max(high, b.pose.position);
  return world.bodies.empty() ? kStringRadius
                              : std::max(kStringRadius, kTubeRadius * glm::distance(low, high));
}

}  // namespace

void GltfFilm::start(const World& world, std::string title) {
  start_ = world, title_ = std::move(title);
  nodes_.clear(), times_.clear();
  for (const Entity e : world.bodies.owners()) nodes_.push_back({e, world.name_of(e)});
  for (std::size_t i = 0; i < world.cables.size(); ++i)
    for (std::size_t k = 0; k < tubes_of(world.cables.values()[i]); ++k) {
      Node& node = nodes_.emplace_back();
      node.object = world.cables.owners()[i], node.name = world.name_of(node.object);
      node.segment = k, node.is_cable = true;
    }
  keep(world);
}

bool GltfFilm::add(const World& world) {
  if ((times_.size() + 1) * nodes_.size() * 10 > kMostFloats) return false;
  if (world.time >= last_ + kInterval - kSlack) keep(world);
  return true;
}

void GltfFilm::keep(const World& world) {
  times_.push_back(static_cast<float>(world.time - start_.time)), last_ = world.time;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (!nodes_[i].is_cable)
      keep_body(world, nodes_[i]);
    else if (nodes_[i].segment == 0)
      keep_cable(world, i);
}

void GltfFilm::keep_body(const World& world, Node& node) {
  if (!world.bodies.find(node.object))
    return repeat(node.translations, 3), repeat(node.rotations, 4);
  const Pose at = world.origin_pose(node.object);
  add_vec(node.translations, at.position);
  add_rotation(node.rotations, at.rotation);
}

/// All tubes of a cable: each from one point of it to the next.
void GltfFilm::keep_cable(const World& world, std::size_t first) {
  const Cable& at_start = start_.cables[nodes_[first].object];
  const std::size_t tubes = tubes_of(at_start);
  const Cable* cable = world.cables.find(nodes_[first].object);
  std::vector<Vec3> line;
  if (cable) add_cable({world}, *cable, static_cast<int>(2 * kHanging), line);
  if (line.size() < 2) {
    for (std::size_t k = 0; k < tubes; ++k) {  // it was cut, and is no longer seen
      add_vec(nodes_[first + k].translations, Vec3(0));
      add_rotation(nodes_[first + k].rotations, kIdentity);
      add_vec(nodes_[first + k].scales, Vec3(0));
    }
    return;
  }
  const std::vector<Vec3> points = resampled(line, tubes);
  for (std::size_t k = 0; k < tubes; ++k) {
    const Vec3 along = points[k + 1] - points[k];
    const Real length = glm::length(along);
    Node& node = nodes_[first + k];
    add_vec(node.translations, points[k]);
    add_rotation(node.rotations,
                 turned_to(length > 0 ? along / length : Vec3(0, 1, 0), node.rotations));
    add_vec(node.scales, {1, length, 1});
  }
}

Result<Done> GltfFilm::write(const std::string& path) const {
  File file(title_);
  const std::size_t times = file.accessor<float>(times_, "SCALAR", 0);
  const ModelPart round = tube(tube_radius(start_));
  for (const Node& node : nodes_) {
    const auto mesh =
        node.is_cable ? file.mesh({&round, 1}) : file.mesh(model_of(start_, node.object));
    Json json = {{"name", node.name}};
    if (mesh) json["mesh"] = *mesh;
    struct Channel {
      const char* path;
      const char* type;
      std::size_t width;
      std::span<const float> values;
    };
    const Channel channels[] = {{"translation", "VEC3", 3, node.translations},
                                {"rotation", "VEC4", 4, node.rotations},
                                {"scale", "VEC3", 3, node.scales}};
    for (const Channel& c : channels)
      if (!c.values.empty()) json[c.path] = first_of(c.values, c.width);
    const std::size_t index = file.node(std::move(json));
    for (const Channel& c : channels)
      if (!is_constant(c.values, c.width))
        file.animate(index, c.path, {times, file.accessor<float>(c.values, c.type, 0)});
  }
  return write_file(path, file.glb());
}

}  // namespace pantin::program

#else

namespace pantin::program {

void GltfFilm::start(const World&, std::string) {}
bool GltfFilm::add(const World&) { return true; }
Result<Done> GltfFilm::write(const std::string& path) const {
  return Error{path + ": this build has no models: it was configured without PANTIN_RENDER"};
}

}  // namespace pantin::program
#endif
