#pragma once
/// Reads what write_plain() of plain.hpp writes; the words are told there. tools/peers/motion has
/// more:
///
///   rate COUNT        frames of a second; 60 if it is not said
///   parts COUNT       steps of a frame; a path has a pose at the end of each
///   sway BODY CENTRE3 AMPLITUDE3 FREQUENCY3 PHASE3    the same path as a formula
///   spring A B ANCHOR3 ANCHOR3 LENGTH STIFFNESS       pulls and pushes along its line
///   torque BODY TORQUE3                               a constant one, in the world's axes
///
/// Nothing of pantin's or of an engine's is included.
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace pantin::peers {

using Three = std::array<double, 3>;
using Four = std::array<double, 4>;  // a rotation: x, y, z, w

struct SpeltPose {
  Three position{};
  Four rotation{0, 0, 0, 1};
};

struct SpeltShape {
  std::string kind;
  Three size{};
  SpeltPose at;
  std::vector<Three> points;
};

struct SpeltBody {
  std::string name, motion;
  int layer = -1;
  double mass = 0;
  Three inertia{};
  SpeltPose at;
  Three velocity{}, spin{};
  double drag = 0, gravity = 1, friction = 0, restitution = 0;
  std::vector<SpeltShape> shapes;
  std::vector<SpeltPose> path;  // by frame
};

struct SpeltRange {
  bool on = false;
  float low = 0, high = 0;
};

struct SpeltDrive {
  float stiffness = 0, damping = 0, most = 0;
  std::vector<Four> targets;  // one, or one a frame; none: there is no drive
};

struct SpeltJoint {
  std::string kind;
  int a = -1, b = -1;
  Three anchor_a{}, anchor_b{};
  Four axes_a{0, 0, 0, 1}, axes_b{0, 0, 0, 1};
  SpeltRange first, second, swing;  // of the swing: half angles about y and z
  SpeltDrive drive;
};

struct SpeltCable {
  int a = -1, b = -1;
  Three anchor_a{}, anchor_b{};
  double length = 0, compliance = 0;
};

struct SpeltSpring {
  int a = -1, b = -1;
  Three anchor_a{}, anchor_b{};
  double length = 0, stiffness = 0;  // m, N/m
};

struct SpeltTorque {
  int body = -1;
  Three torque{};  // N m
};

/// A place on a curve: centre + amplitude sin(2 pi frequency t + phase), by axis.
struct SpeltSway {
  int body = -1;
  Three centre{}, amplitude{}, frequency{}, phase{};  // m, Hz, rad
};

struct Spelt {
  Three gravity{};
  int frames = 0, rate = 60;             // frames of a second
  int parts = 1;                         // steps of a frame; paths have a pose for each
  std::vector<std::vector<bool>> touch;  // by layer
  std::vector<SpeltBody> bodies;
  std::vector<SpeltJoint> joints;
  std::vector<SpeltCable> cables;
  std::vector<SpeltSway> sways;
  std::vector<SpeltSpring> springs;
  std::vector<SpeltTorque> torques;
  std::vector<std::string> unknown;
};

template <std::size_t N>
std::istream& operator>>(std::istream& in, std::array<double, N>& v) {
  for (double& x : v) in >> x;
  return in;
}
inline std::istream& operator>>(std::istream& in, SpeltPose& p) {
  return in >> p.position >> p.rotation;
}
inline std::istream& operator>>(std::istream& in, SpeltRange& r) {
  return in >> r.on >> r.low >> r.high;
}

inline void read_layers(std::istream& line, std::istream& in, Spelt& to) {
  std::size_t count = 0;
  line >> count;
  to.touch.assign(count, std::vector<bool>(count));
  for (std::vector<bool>& row : to.touch)
    for (std::size_t k = 0; k < count; ++k) {
      int touches = 0;
      in >> touches;
      row[k] = touches != 0;
    }
}

inline void read_drive(std::istream& line, Spelt& to) {
  std::size_t joint = 0, count = 0;
  SpeltDrive drive;
  line >> joint >> drive.stiffness >> drive.damping >> drive.most >> count;
  drive.targets.resize(count);
  for (Four& q : drive.targets) line >> q;
  to.joints.at(joint).drive = drive;
}

/// False: there is no such file, or a line of it has unknown words or lacks some.
inline bool read_spelt(const std::string& path, Spelt& to) {
  std::ifstream in(path);
  if (!in) return false;
  for (std::string text; std::getline(in, text);) {
    std::istringstream line(text);
    std::string word;
    if (!(line >> word)) continue;
    if (word == "gravity") {
      line >> to.gravity;
    } else if (word == "frames") {
      line >> to.frames;
    } else if (word == "rate") {
      line >> to.rate;
    } else if (word == "parts") {
      line >> to.parts;
    } else if (word == "sway") {
      SpeltSway s;
      line >> s.body >> s.centre >> s.amplitude >> s.frequency >> s.phase;
      to.sways.push_back(s);
    } else if (word == "spring") {
      SpeltSpring s;
      line >> s.a >> s.b >> s.anchor_a >> s.anchor_b >> s.length >> s.stiffness;
      to.springs.push_back(s);
    } else if (word == "torque") {
      SpeltTorque t;
      line >> t.body >> t.torque;
      to.torques.push_back(t);
    } else if (word == "layers") {
      read_layers(line, in, to);
    } else if (word == "body") {
      SpeltBody b;
      line >> b.name >> b.motion >> b.layer >> b.mass >> b.inertia >> b.at >> b.velocity >> b.spin;
      line >> b.drag >> b.gravity >> b.friction >> b.restitution;
      to.bodies.push_back(b);
    } else if (word == "shape") {
      SpeltShape s;
      line >> s.kind >> s.size >> s.at;
      if (line.fail()) return false;
      for (Three p; line >> p;) s.points.push_back(p);
      line.clear();
      to.bodies.at(to.bodies.size() - 1).shapes.push_back(s);
    } else if (word == "joint") {
      SpeltJoint j;
      line >> j.kind >> j.a >> j.b >> j.anchor_a >> j.anchor_b >> j.axes_a >> j.axes_b;
      line >> j.first >> j.second >> j.swing;
      to.joints.push_back(j);
    } else if (word == "drive") {
      read_drive(line, to);
    } else if (word == "cable") {
      SpeltCable c;
      line >> c.a >> c.b >> c.anchor_a >> c.anchor_b >> c.length >> c.compliance;
      to.cables.push_back(c);
    } else if (word == "path") {
      std::size_t body = 0;
      line >> body;
      for (SpeltPose p; line >> p;) to.bodies.at(body).path.push_back(p);
      line.clear();
    } else if (word == "unknown") {
      to.unknown.push_back(text.substr(8));
    } else {
      return false;
    }
    if (line.fail()) return false;
  }
  return true;
}

/// What springs and torques come to now, for engines that have no such parts. point(body, local)
/// returns the place of a point, push(body, place, force) and turn(body, torque) load a body; the
/// body may be the world.
template <class Point, class Push, class Turn>
void load(const Spelt& scene, const Point& point, const Push& push, const Turn& turn) {
  for (const SpeltSpring& s : scene.springs) {
    const Three a = point(s.a, s.anchor_a), b = point(s.b, s.anchor_b);
    const double length = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    Three pull{}, back{};
    for (std::size_t k = 0; k < 3; ++k) {
      pull[k] = s.stiffness * (length - s.length) / length * (b[k] - a[k]);
      back[k] = -pull[k];
    }
    push(s.a, a, pull), push(s.b, b, back);
  }
  for (const SpeltTorque& t : scene.torques) turn(t.body, t.torque);
}

}  // namespace pantin::peers
