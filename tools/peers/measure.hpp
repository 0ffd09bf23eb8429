#pragma once
/// What was measured, and how it is told.
#include <array>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "tools/peers/peer.hpp"

namespace pantin::peers {

inline std::span<const Method> methods_of(const Engine& engine) {
  return {engine.methods, engine.count};
}

struct Peer {
  std::string name;
  const Engine* engine = nullptr;
  bool ours() const { return name.starts_with("ours"); }
};

/// A second of one chain by one method at one setting.
struct Point {
  std::size_t peer = 0;
  const Method* method = nullptr;
  int links = 0;
  double setting = 0;     // steps in a frame, or a tolerance
  double error = 0;       // m, of the worst centre after a second
  double energy = 0;      // gained where it was farthest from none, part of what the chain can give
  double gap = 0;         // m, the worst of any joint at the end of a frame
  double failed_at = -1;  // s; below zero: it did not
  Counts counts;
  std::vector<double> ms;  // CPU time of a simulated second, a number a round

  bool failed() const { return failed_at >= 0; }
  double step() const { return method->adaptive ? 0 : 1 / (kFrames * setting); }
};

/// Where the centres are after a second, and how far others say they are.
struct Reference {
  int links = 0;
  std::string from;
  std::vector<std::array<double, 3>> centres;
  std::vector<std::pair<std::string, double>> apart;  // m
};

struct Report {
  std::vector<Peer> peers;
  std::vector<Reference> references;  // one for each size that errors are measured at
  std::vector<Point> points;          // by size, peer, method; from coarse to fine
  int rounds = 0;
  double cpu_seconds = 0, wall_seconds = 0;  // of the rounds
  double load_before = 0, load_after = 0;
};

/// Shows how far things are, at a terminal.
void tell(const std::string& what);

double median(std::vector<double> values);
/// Widest less narrowest, part of the median.
double spread(const std::vector<double>& values);

/// Errors at which methods are compared, m.
inline constexpr double kLevels[] = {1e-2, 1e-3, 1e-4, 1e-6, 1e-8};

/// CPU ms that a method needs for an error of `level` in one round (median of all: -1); infinite
/// where it does not get there. Between neighbouring settings the logarithms are interpolated.
double cost_at(std::span<const Point> way, double level, int round);

void print_tables(const Report& report, std::FILE* out);
void print_csv(const Report& report, std::FILE* out);
void print_json(const Report& report, std::FILE* out);

}  // namespace pantin::peers
