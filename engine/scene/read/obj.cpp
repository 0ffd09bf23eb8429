#include "engine/scene/read/obj.hpp"

#include <charconv>
#include <cmath>
#include <optional>

#include "engine/base/utf8.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kMostErrors = 20;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Takes the next word off the front of a line; empty at its end or at a comment.
std::string_view next_word(std::string_view& line) {
  std::size_t begin = 0;
  while (begin < line.size() && is_blank(line[begin])) ++begin;
  std::size_t end = begin;
  while (end < line.size() && !is_blank(line[end])) ++end;
  std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  if (word.starts_with('#')) line = word = {};
  return word;
}

template <class T>
std::optional<T> number_of(std::string_view word) {
  T x{};
  const auto read = std::from_chars(word.data(), word.data() + word.size(), x);
  if (word.empty() || read.ec != std::errc() || read.ptr != word.data() + word.size())
    return std::nullopt;
  return x;
}

class ObjReader {
 public:
  explicit ObjReader(std::string_view name) : name_(name) {}

  Result<ObjMesh> read(std::string_view text) {
    while (!text.empty() && errors_.size() < kMostErrors) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      ++line_;
      read_line(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (errors_.empty()) return std::move(mesh_);
    return std::move(errors_);
  }

 private:
  void complain(std::string_view found, const std::string& expected) {
    errors_.push_back({printable(name_) + ":" + std::to_string(line_) + ": found " +
                       (found.empty() ? "the end of the line" : "\"" + clipped(found) + "\"") +
                       ", expected " + expected});
  }

  void read_line(std::string_view line) {
    const std::string_view what = next_word(line);
    if (what == "v") read_point(line);
    if (what == "f") read_face(line);
  }

  void read_point(std::string_view line) {
    Vec3 p(0);
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = next_word(line);
      const auto x = number_of<Real>(word);
      if (!x || !(std::abs(*x) <= 1e9)) {
        complain(word, "three numbers between -1e9 and 1e9 after v");
        break;
      }
      p[i] = *x;
    }
    mesh_.points.push_back(p);  // even if invalid, so that later faces are indexed correctly
  }

  void read_face(std::string_view line) {
    std::vector<std::uint32_t> corners;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const auto index = number_of<long>(word.substr(0, word.find('/')));
      const auto count = static_cast<long>(mesh_.points.size());
      const long place = index ? (*index < 0 ? count + *index : *index - 1) : -1;
      if (place < 0 || place >= count) {
        complain(word, "the number of one of the " + std::to_string(count) + " points above");
        return;
      }
      corners.push_back(static_cast<std::uint32_t>(place));
    }
    if (corners.size() < 3) return complain("", "three corners or more after f");
    for (std::size_t i = 1; i + 1 < corners.size(); ++i)
      mesh_.triangles.push_back({corners[0], corners[i], corners[i + 1]});
  }

  std::string_view name_;
  std::size_t line_ = 0;
  ObjMesh mesh_;
  std::vector<Error> errors_;
};

}  // namespace

Result<ObjMesh> parse_obj(std::string_view text, std::string_view name) {
  return ObjReader(name).read(text);
}

}  // namespace pantin::detail
