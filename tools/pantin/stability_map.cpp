// Maps of symptoms: a coarse grid whose cells are divided where their corners differ.
#include <algorithm>
#include <cmath>

#include "tools/pantin/stability.hpp"

namespace pantin::program {

double Axis::at(double part) const {
  const double value = is_log ? from * std::pow(to / from, part) : from + (to - from) * part;
  return is_whole ? std::round(value) : value;
}

bool Map::know_corners(const Cell& cell, const Ask& ask) {
  for (const int y : {cell.y, cell.y + cell.size})
    for (const int x : {cell.x, cell.x + cell.size}) {
      const std::pair at(x, is_plane_ ? y : 0);
      if (known_.contains(at)) continue;
      const double size = size_;
      const auto symptom = ask(at.first / size, at.second / size);
      if (!symptom) return false;
      known_[at] = *symptom;
    }
  return true;
}

bool Map::is_even(const Cell& c) const {
  const int top = is_plane_ ? c.y + c.size : 0;
  const Symptom first = at(c.x, c.y);
  return at(c.x + c.size, c.y) == first && at(c.x, top) == first && at(c.x + c.size, top) == first;
}

bool Map::draw(const Ask& ask) {
  const int whole = size_ / grid_;
  std::vector<Cell> open;
  for (int y = 0; y < (is_plane_ ? grid_ : 1); ++y)
    for (int x = 0; x < grid_; ++x) open.push_back({x * whole, y * whole, whole});
  for (const Cell& cell : open)
    if (!know_corners(cell, ask)) return false;
  cells_ = open;
  for (int size = whole; size > 1; size /= 2) {
    std::vector<Cell> next;
    for (const Cell& cell : cells_) {
      if (cell.size < size || is_even(cell)) {
        next.push_back(cell);
        continue;
      }
      for (int y = 0; y < (is_plane_ ? 2 : 1); ++y)
        for (int x = 0; x < 2; ++x) {
          const int half = size / 2;
          next.push_back({cell.x + x * half, cell.y + y * half, half});
          if (!know_corners(next.back(), ask)) return false;
        }
    }
    cells_ = std::move(next);
  }
  return true;
}

}  // namespace pantin::program
