#pragma once
/// How bodies moved in one engine, frame by frame: what engines write and the judge reads.
///
/// A file of lines `key value`, up to `frames BODIES`; then for each frame, as doubles in the
/// machine's order: the milliseconds of CPU time that it took, how many bodies were awake after it,
/// and of each body its position, rotation (x, y, z, w), velocity and angular velocity, of the mass
/// centre in world axes. Whatever runs short ends there. No engine is included here.
#include <cstddef>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

namespace pantin::peers {

struct Moving {
  double position[3], rotation[4], velocity[3], angular_velocity[3];
};
static_assert(sizeof(Moving) == 13 * sizeof(double));

struct Frame {
  double ms = 0, awake = 0;
  std::vector<Moving> bodies;
};

/// CPU time of this process, ms.
inline double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return double(now.tv_sec) * 1e3 + double(now.tv_nsec) * 1e-6;
}

class MotionWriter {
 public:
  explicit MotionWriter(const std::string& path) : out_(path, std::ios::binary) {}
  void tell(const std::string& key, const std::string& value) {
    out_ << key << ' ' << value << '\n';
  }
  void begin(std::size_t bodies) { out_ << "frames " << bodies << '\n'; }
  void add(const Frame& frame) {
    put(&frame.ms, 1), put(&frame.awake, 1);
    put(frame.bodies.data(), frame.bodies.size());
  }
  bool good() const { return out_.good(); }

 private:
  template <class T>
  void put(const T* from, std::size_t count) {
    out_.write(reinterpret_cast<const char*>(from),
               static_cast<std::streamsize>(count * sizeof(T)));
  }
  std::ofstream out_;
};

class MotionReader {
 public:
  /// Reads up to the first frame. False: this is no such file.
  bool open(const std::string& path) {
    in_.open(path, std::ios::binary);
    for (std::string line; std::getline(in_, line);) {
      const std::size_t gap = line.find(' ');
      if (gap == std::string::npos) return false;
      const std::string key = line.substr(0, gap), value = line.substr(gap + 1);
      if (key == "frames") {
        bodies_ = std::stoul(value);
        return true;
      }
      told.emplace_back(key, value);
    }
    return false;
  }
  bool next(Frame& frame) {
    frame.bodies.resize(bodies_);
    return get(&frame.ms, 1) && get(&frame.awake, 1) && get(frame.bodies.data(), bodies_);
  }
  std::size_t bodies() const { return bodies_; }

  std::vector<std::pair<std::string, std::string>> told;

 private:
  template <class T>
  bool get(T* to, std::size_t count) {
    in_.read(reinterpret_cast<char*>(to), static_cast<std::streamsize>(count * sizeof(T)));
    return in_.good();
  }
  std::ifstream in_;
  std::size_t bodies_ = 0;
};

}  // namespace pantin::peers
