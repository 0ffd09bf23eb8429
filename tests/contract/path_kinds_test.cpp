// What holds for the path of a kinematic body, of every kind in the list.
#include <catch2/catch.hpp>

#include "engine/base/archive.hpp"
#include "engine/base/rotation.hpp"
#include "engine/world/kinematic_path.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

/// Fills every field with some number, each larger than the one before: lists with four items.
struct Filler {
  Real last = 0;
  Real next() { return last += 0.17; }

  void operator()(std::string_view, Real& x) { x = next(); }
  void operator()(std::string_view, bool&) {}
  void operator()(std::string_view, Vec3& v) {
    v.x = next(), v.y = 0.5 - next(), v.z = 0.3 * next();
  }
  void operator()(std::string_view, Quat& q) {
    q = from_rotation_vector({0.2 * next(), 0.1, std::sin(next())});
  }
  void operator()(std::string_view name, Pose& pose) {
    (*this)(name, pose.position), (*this)(name, pose.rotation);
  }
  template <class T>
  void operator()(std::string_view, std::vector<T>& list) {
    list.resize(4);
    for (T& item : list) T::fields(item, *this);
  }
};

template <class Path>
Path filled() {
  Path path;
  Filler filler;
  Path::fields(path, filler);
  return path;
}

/// A path as a scene file without a number in it tells it.
struct AsItIs {
  void operator()(const PathKey&, auto&) const {}
};

void each_kind(auto check) {
  const auto each = [&]<class... Kinds>(const std::variant<Kinds...>*) {
    const auto one = [&]<class Path>(Path path) {
      INFO(Path::name);
      check(path);
    };
    (one(filled<Kinds>()), ...);
  };
  each(static_cast<const PathKinds*>(nullptr));
}

/// From one pose to another: m, and rad as a rotation vector.
struct Step {
  Vec3 aside{0}, turn{0};
};
Step between(const Pose& a, const Pose& b) {
  return {b.position - a.position, rotation_vector(b.rotation * glm::conjugate(a.rotation))};
}

/// The fastest step of this length in a while, m/s and rad/s, and how fast that changes from one
/// step to the next.
struct Fastest {
  Real speed = 0, turn = 0, speed_change = 0, turn_change = 0;
};
Fastest fastest(const auto& path, Real h) {
  Fastest most;
  Step before = between(path.at(-1 - h), path.at(-1));
  for (Real t = -1; t < 5; t += h) {
    const Step now = between(path.at(t), path.at(t + h));
    most.speed = std::max(most.speed, glm::length(now.aside) / h);
    most.turn = std::max(most.turn, glm::length(now.turn) / h);
    most.speed_change =
        std::max(most.speed_change, glm::length(now.aside - before.aside) / (h * h));
    most.turn_change = std::max(most.turn_change, glm::length(now.turn - before.turn) / (h * h));
    before = now;
  }
  return most;
}

Real apart(const Pose& a, const Pose& b) {
  const Step step = between(a, b);
  return glm::length(step.aside) + glm::length(step.turn);
}

const Pose kBy{{0.7, -2, 0.4}, from_rotation_vector({0.4, -1.1, 0.8})};
constexpr Real kTimes[] = {-1e6, -1, 0, 1e-300, 0.3, 0.68, 1.36, 2, 5, 17.3, 1e6};

}  // namespace

TEST_CASE("Every kind of path is somewhere at all times, on a unit rotation") {
  each_kind([](const auto& path) {
    for (const Real t : kTimes) {
      const Pose pose = path.at(t);
      CHECK(is_finite(pose));
      CHECK(std::abs(glm::length(pose.rotation) - 1) < 1e-14);
    }
  });
}

TEST_CASE(
    "Every kind of path moves, without jumps, and without jumps of what velocity it promises") {
  // A jump makes the quotient of differences grow with 1/h.
  each_kind([](const auto& path) {
    const Fastest coarse = fastest(path, 4e-3), fine = fastest(path, 2.5e-4);
    CHECK(coarse.speed > 0);
    CHECK(fine.speed < 1.5 * coarse.speed);
    CHECK(fine.turn < 1.5 * coarse.turn + 1e-9);
    CHECK(fine.speed_change < 2 * coarse.speed_change);
    if (std::decay_t<decltype(path)>::turns_smoothly)
      CHECK(fine.turn_change < 2 * coarse.turn_change + 1e-6);  // rounding over h^2
  });
}

TEST_CASE("Every kind of path is written and read again, bit for bit") {
  each_kind([](const auto& path) {
    const KinematicPath from{path};
    FieldWriter writer;
    writer.write(from);
    FieldReader reader(writer.bytes());
    KinematicPath to;
    reader.read(to);
    REQUIRE(reader.ok());
    CHECK(reader.left() == 0);
    for (const Real t : kTimes) {
      CHECK(pose_at(to, t).position == pose_at(from, t).position);
      CHECK(pose_at(to, t).rotation == pose_at(from, t).rotation);
    }
    FieldWriter again;
    again.write(to);
    CHECK(again.bytes() == writer.bytes());
  });
}

TEST_CASE("Every kind of path moves with the world") {
  each_kind([](const auto& curve) {
    const KinematicPath path{curve};
    for (const Real t : kTimes) {
      const Pose there = compose(kBy, pose_at(path, t));
      const Real size = std::max(Real(1), glm::length(there.position));
      CHECK(apart(pose_at(moved(path, kBy), t), there) < 1e-13 * size);
    }
    const KinematicPath back = moved(moved(path, kBy), inverse(kBy));
    CHECK(apart(pose_at(back, 0.5), pose_at(path, 0.5)) < 1e-13);
  });
}

TEST_CASE("Every kind of path can be ahead of itself") {
  each_kind([](const auto& curve) {
    const KinematicPath path{curve};
    for (const Real t : {5.0, 7.3, 20.0})  // a rise is over by then
      CHECK(apart(pose_at(shifted(path, 0.75), t), pose_at(path, t + 0.75)) < 1e-12);
  });
}

TEST_CASE("Every kind of path starts where its body is, unless it says where") {
  each_kind([](auto curve) {
    using Path = decltype(curve);
    const KinematicPath told = started({curve}, kBy);
    CHECK(glm::length(pose_at(told, 3).position - curve.at(3).position) < 1e-14);
    CHECK(is_finite(pose_at(told, 3)));
    if constexpr (requires { Path::scene_keys(curve, AsItIs{}); }) {
      Path untold;
      Path::scene_keys(untold, AsItIs{});
      CHECK_FALSE(is_finite(untold.at(0)));
      CHECK(apart(pose_at(started({untold}, kBy), 0), kBy) < 1e-14);
    }
  });
}

TEST_CASE("Every kind of path lies in its box, or not far outside") {
  each_kind([](const auto& path) {
    const PathBounds box = path.bounds();
    const Real slack = 0.2 * glm::length(box.high - box.low);
    CHECK(slack > 0);
    for (Real t = -1; t < 9; t += 0.01) {
      const Vec3 p = path.at(t).position;
      for (int i = 0; i < 3; ++i) CHECK((p[i] > box.low[i] - slack && p[i] < box.high[i] + slack));
    }
  });
}

TEST_CASE("Kinds of paths have names of their own") {
  std::vector<std::string_view> names;
  each_kind([&](const auto& path) {
    const std::string_view name = std::decay_t<decltype(path)>::name;
    CHECK_FALSE(std::decay_t<decltype(path)>::about.empty());
    CHECK(std::count(names.begin(), names.end(), name) == 0);
    names.push_back(name);
  });
  CHECK(names.size() == std::variant_size_v<PathKinds>);
}
