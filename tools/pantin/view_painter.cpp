#include "tools/pantin/view_painter.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace pantin::program {

using namespace detail;

namespace {

struct Clip {
  int x0, y0, x1, y1;  // pixels [x0, x1) x [y0, y1)
};

struct Canvas {
  Image& picture;
  const InkAtlas& atlas;
  Clip clip;
};

struct Colour {
  float part[4];  // 0..255, the last is opacity
};

Colour colour_of(std::uint32_t rgba) {
  return {{static_cast<float>(rgba & 255), static_cast<float>(rgba >> 8 & 255),
           static_cast<float>(rgba >> 16 & 255), static_cast<float>(rgba >> 24)}};
}

float coverage(const InkAtlas& atlas, float u, float v) {
  const int x =
      std::clamp(static_cast<int>(u * static_cast<float>(atlas.width)), 0, atlas.width - 1);
  const int y =
      std::clamp(static_cast<int>(v * static_cast<float>(atlas.height)), 0, atlas.height - 1);
  return atlas.coverage[static_cast<std::size_t>(y) * static_cast<std::size_t>(atlas.width) +
                        static_cast<std::size_t>(x)] /
         255.0f;
}

void blend(std::uint8_t* pixel, const Colour& colour, float covered) {
  const float opaque = colour.part[3] / 255.0f * covered;
  for (int k = 0; k < 3; ++k) {
    const float below = pixel[k];
    pixel[k] = static_cast<std::uint8_t>(below + opaque * (colour.part[k] - below) + 0.5f);
  }
}

/// The result of blend() for opaque colours; the opacity of the picture is kept.
void fill(std::uint8_t* pixel, int count, std::uint32_t rgba) {
  for (int x = 0; x < count; ++x, pixel += 4) {
    std::uint32_t whole;
    std::memcpy(&whole, pixel, 4);
    whole = (whole & 0xff000000u) | (rgba & 0x00ffffffu);
    std::memcpy(pixel, &whole, 4);
  }
}

std::uint8_t* row(Image& picture, int y) {
  return picture.rgba.data() +
         4 * static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width);
}

/// The first pixel whose centre is not left of, or above, a coordinate.
int first_middle(float at) { return static_cast<int>(std::ceil(at - 0.5f)); }

/// Fast path: most of a panel is rectangles of one colour, and letters.
bool is_upright(const InkVertex* const (&c)[4]) {
  return c[0]->rgba == c[1]->rgba && c[0]->rgba == c[2]->rgba && c[0]->rgba == c[3]->rgba &&
         c[0]->x == c[3]->x && c[1]->x == c[2]->x && c[0]->y == c[1]->y && c[2]->y == c[3]->y &&
         c[0]->x < c[1]->x && c[0]->y < c[3]->y;
}

void paint_box(const Canvas& to, const InkVertex& low, const InkVertex& high) {
  const Colour colour = colour_of(low.rgba);
  const int x0 = std::max(first_middle(low.x), to.clip.x0);
  const int x1 = std::min(first_middle(high.x), to.clip.x1);
  const int y1 = std::min(first_middle(high.y), to.clip.y1);
  const float du = (high.u - low.u) / (high.x - low.x), dv = (high.v - low.v) / (high.y - low.y);
  const bool is_flat = low.u == high.u && low.v == high.v;
  const float flat = is_flat ? coverage(to.atlas, low.u, low.v) : 0;
  const bool hides = is_flat && flat == 1 && colour.part[3] == 255;  // opaque
  for (int y = std::max(first_middle(low.y), to.clip.y0); y < y1; ++y) {
    const float v = low.v + (static_cast<float>(y) + 0.5f - low.y) * dv;
    std::uint8_t* pixel = row(to.picture, y) + 4 * x0;
    if (hides) {
      fill(pixel, x1 - x0, low.rgba);
      continue;
    }
    for (int x = x0; x < x1; ++x, pixel += 4) {
      const float u = low.u + (static_cast<float>(x) + 0.5f - low.x) * du;
      const float covered = is_flat ? flat : coverage(to.atlas, u, v);
      if (covered > 0) blend(pixel, colour, covered);
    }
  }
}

// Integer coordinates, so that a pixel on a shared edge belongs to exactly one triangle.
constexpr float kParts = 256;  // subpixels per pixel

struct Corner {
  std::int64_t x, y;
};

std::int64_t edge(Corner a, Corner b, Corner p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

/// Tie-breaking: a pixel on the edge from a to b belongs to the triangle on one side only.
std::int64_t bias(Corner a, Corner b) {
  const bool owns = b.y < a.y || (b.y == a.y && b.x > a.x);
  return owns ? 0 : -1;
}

Corner corner_of(const InkVertex& v) {
  return {std::llround(v.x * kParts), std::llround(v.y * kParts)};
}

/// Pixels [from, to) of a row.
struct Run {
  int from, to;
};

/// Restricts a run to the pixels where a linear function is not negative: `first` at its start,
/// with the increment `step` per pixel.
void narrow(Run& run, std::int64_t first, std::int64_t step) {
  if (first < 0 && step <= 0) run.to = run.from;
  if (first < 0 && step > 0) {
    const std::int64_t skipped = (step - 1 - first) / step;
    run.from = static_cast<int>(std::min<std::int64_t>(run.to, run.from + skipped));
  }
  if (first >= 0 && step < 0)
    run.to = static_cast<int>(std::min<std::int64_t>(run.to, run.from + first / -step + 1));
}

bool is_of_one_colour(const Canvas& to, const InkVertex& a, const InkVertex& b,
                      const InkVertex& c) {
  return a.rgba == b.rgba && a.rgba == c.rgba && a.u == b.u && a.u == c.u && a.v == b.v &&
         a.v == c.v && a.rgba >> 24 == 255 && coverage(to.atlas, a.u, a.v) == 1;
}

void paint_triangle(const Canvas& to, const InkVertex* a, const InkVertex* b, const InkVertex* c) {
  Corner p[3]{corner_of(*a), corner_of(*b), corner_of(*c)};
  std::int64_t area = edge(p[0], p[1], p[2]);
  if (area == 0) return;
  if (area < 0) std::swap(p[1], p[2]), std::swap(b, c), area = -area;
  const bool hides = is_of_one_colour(to, *a, *b, *c);
  const Colour colours[3]{colour_of(a->rgba), colour_of(b->rgba), colour_of(c->rgba)};
  const float low_x = std::min({a->x, b->x, c->x}), high_x = std::max({a->x, b->x, c->x});
  const float low_y = std::min({a->y, b->y, c->y}), high_y = std::max({a->y, b->y, c->y});
  const int x0 = std::max(first_middle(low_x), to.clip.x0);
  const int x1 = std::min(first_middle(high_x) + 1, to.clip.x1);
  const int y1 = std::min(first_middle(high_y) + 1, to.clip.y1);
  constexpr auto kWhole = static_cast<std::int64_t>(kParts);
  for (int y = std::max(first_middle(low_y), to.clip.y0); y < y1; ++y) {
    const Corner at{x0 * kWhole + kWhole / 2, y * kWhole + kWhole / 2};
    std::int64_t w[3], step[3];
    Run run{x0, x1};
    for (int k = 0; k < 3; ++k) {
      const Corner &from = p[(k + 1) % 3], &end = p[(k + 2) % 3];
      w[k] = edge(from, end, at), step[k] = (from.y - end.y) * kWhole;
      Run rest{x0, run.to};
      narrow(rest, w[k] + bias(from, end), step[k]);
      run = {std::max(run.from, rest.from), rest.to};
    }
    if (hides && run.from < run.to) {
      fill(row(to.picture, y) + 4 * run.from, run.to - run.from, a->rgba);
      continue;
    }
    for (int x = run.from; x < run.to; ++x) {
      const float all = static_cast<float>(area);
      const float s = static_cast<float>(w[0] + (x - x0) * step[0]) / all;
      const float t = static_cast<float>(w[1] + (x - x0) * step[1]) / all;
      const float r = 1 - s - t;
      Colour colour;
      for (int k = 0; k < 4; ++k)
        colour.part[k] = s * colours[0].part[k] + t * colours[1].part[k] + r * colours[2].part[k];
      const float covered =
          coverage(to.atlas, s * a->u + t * b->u + r * c->u, s * a->v + t * b->v + r * c->v);
      if (covered > 0) blend(row(to.picture, y) + 4 * x, colour, covered);
    }
  }
}

}  // namespace

void paint(Image& picture, const InkBatch& batch, const InkAtlas& atlas) {
  const auto whole = [](float at, int most) {
    return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(most)));
  };
  const Canvas to{picture,
                  atlas,
                  {whole(batch.clip[0], picture.width), whole(batch.clip[1], picture.height),
                   whole(batch.clip[2], picture.width), whole(batch.clip[3], picture.height)}};
  const auto& i = batch.indices;
  for (std::size_t k = 0; k + 2 < i.size(); k += 3) {
    const InkVertex *a = &batch.vertices[i[k]], *b = &batch.vertices[i[k + 1]],
                    *c = &batch.vertices[i[k + 2]];
    if (k + 5 < i.size() && i[k + 3] == i[k] && i[k + 4] == i[k + 2]) {
      const InkVertex* const box[4]{a, b, c, &batch.vertices[i[k + 5]]};
      if (is_upright(box)) {
        paint_box(to, *a, *c);
        k += 3;
        continue;
      }
    }
    paint_triangle(to, a, b, c);
  }
}

}  // namespace pantin::program
