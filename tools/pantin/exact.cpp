// Exact motions of scenes, from files beside them.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "engine/base/hash.hpp"
#include "engine/base/utf8.hpp"
#include "tools/pantin/subject.hpp"

namespace pantin::program {
namespace {

/// What the first line says: of which text a file is, and to what the motion is known, m.
struct Head {
  std::string text;
  double known = 0;
};

std::optional<Head> head_of(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  char text[17] = "";
  Head head;
  if (!std::getline(in, line) ||
      std::sscanf(line.c_str(), "# text %16[0-9a-f], known to %lf m", text, &head.known) != 2)
    return std::nullopt;
  head.text = text;
  return head;
}

/// The first samples of a reference only.
void cut(Reference& reference, std::size_t samples) {
  reference.track.poses.resize(samples * reference.track.names.size());
  reference.track.energies.resize(samples);
  reference.agreed = reference.compared = samples;
}

}  // namespace

Result<std::optional<Reference>> exact_motion(Subject& subject) {
  const std::filesystem::path scene(subject.path);
  const std::string file =
      (scene.parent_path() / "exact" / (scene.stem().string() + ".csv")).string();
  const std::optional<Head> head = head_of(file);
  if (!head) return std::optional<Reference>();
  Hash hash;
  hash.add(std::string_view(subject.text));
  if (hex(hash.value()) != head->text) {
    complain(
        fmt::format("{}: is the exact motion of another text of {}, compares with a refined run",
                    printable(file), printable(subject.path)));
    return std::optional<Reference>();
  }
  Sampling sampling;
  const double rows = subject.own().duration / subject.coarsest * (1 + 1e-9);
  const int most = std::clamp(static_cast<int>(rows), 1, kMostSamples);
  Result<Reference> read = read_reference(file, subject.own().world, most, sampling);
  if (!read) return read.errors();
  const double asked = subject.sampling.duration() / sampling.interval * (1 + 1e-9);
  if (asked < 1 || std::floor(asked) > sampling.count) return std::optional<Reference>();
  sampling.count = static_cast<int>(asked);
  cut(*read, sampling.samples());
  read->own.position = read->own.origin = head->known;
  subject.sampling = sampling;
  return std::optional<Reference>(std::move(*read));
}

}  // namespace pantin::program
