// Maps over two coefficients of friction: as characters, CSV, SVG or PNG.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/utf8.hpp"
#include "engine/modes/map.hpp"
#include "tools/pantin/canvas.hpp"
#include "tools/pantin/modes.hpp"

namespace pantin::program {
namespace {

constexpr double kSide = 480;  // pixels of a map

struct Chart {
  const Grasp& grasp;
  Slice slice;
  ModeMap map;

  const Region& region(std::size_t k) const {
    return grasp.prepared.regions[static_cast<std::size_t>(map.regions[k])];
  }
  /// Modes that are feasible somewhere in the map, as indices.
  std::vector<std::size_t> seen() const {
    std::uint32_t all = 0;
    for (const std::uint32_t cell : map.cells) all |= cell;
    std::vector<std::size_t> list;
    for (std::size_t k = 0; k < map.regions.size(); ++k)
      if (all >> k & 1) list.push_back(k);
    return list;
  }
  std::string legend(std::size_t k) const {
    return fmt::format("{}  {}: {}", character_of(grasp.prepared, map, k),
                       short_name(grasp.prepared, region(k)), in_words(grasp, signs_of(region(k))));
  }
};

std::string axis_name(const Grasp& g, std::size_t contact) {
  return fmt::format("mu{} ({})", contact + 1, g.name(contact));
}

std::string title_of(const Chart& chart) {
  std::string title = chart.grasp.plan->name;
  for (std::size_t i = 0; i < chart.grasp.contacts.size(); ++i)
    if (i != chart.slice.across && i != chart.slice.up)
      title += fmt::format(", mu{} = {:g}", i + 1, chart.grasp.slide[i]);
  return title;
}

void fill(Canvas& canvas, const Chart& chart, const Frame& frame) {
  constexpr Ink kGreys[] = {
      {255, 255, 255}, {231, 231, 231}, {200, 200, 200}, {165, 165, 165}, {130, 130, 130}};
  const std::size_t n = chart.map.size;
  const double w = frame.size.x / static_cast<double>(n), h = frame.size.y / static_cast<double>(n);
  const auto shade = [&](std::size_t i, std::size_t j) {
    return std::min(std::popcount(chart.map.cell(i, j)), 4);
  };
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n;) {
      std::size_t end = i;
      while (end < n && shade(end, j) == shade(i, j)) ++end;
      const double x = frame.corner.x + w * static_cast<double>(i);
      const double y = frame.corner.y + h * static_cast<double>(n - 1 - j);
      if (shade(i, j) > 0)
        canvas.box({x, y}, {w * static_cast<double>(end - i), h}, kGreys[shade(i, j)]);
      i = end;
    }
}

/// A region in a frame, with its colour.
struct Bounded {
  const Frame& frame;
  const Cut& cut;
  Ink ink;
};

/// Draws a region's boundary along the curve of one of its forms: in closed form, column by column,
/// and row by row where the curve is steep.
void outline_form(Canvas& canvas, const Bounded& of, const Bilinear& form) {
  const Frame& frame = of.frame;
  const Cut& cut = of.cut;
  constexpr int kFine = 600;
  const Bilinear turned{form.a, form.c, form.b, form.d};
  for (const bool is_across : {true, false}) {
    const Axis& axis = is_across ? frame.across : frame.up;
    const Axis& other = is_across ? frame.up : frame.across;
    const double step = (axis.high - axis.low) / kFine, off = 1e-6 * (other.high - other.low);
    for (int i = 0; i < kFine; ++i) {
      const double t = axis.low + step * i, u = t + step;
      const Bilinear& f = is_across ? form : turned;
      const double at_t = f.up_at(t), at_u = f.up_at(u), middle = f.up_at((t + u) / 2);
      if (!std::isfinite(at_t) || !std::isfinite(at_u) || std::abs(at_u - at_t) > 2 * step)
        continue;
      const auto branch = [&](double y) {
        return is_across ? cut.branch_at((t + u) / 2, y) : cut.branch_at(y, (t + u) / 2);
      };
      if ((branch(middle - off) != 0) == (branch(middle + off) != 0)) continue;
      const auto inside = [&](double y) { return y >= other.low && y <= other.high; };
      if (!inside(at_t) || !inside(at_u)) continue;
      if (is_across)
        canvas.line(frame.at(t, at_t), frame.at(u, at_u), 2, of.ink);
      else
        canvas.line(frame.at(at_t, t), frame.at(at_u, u), 2, of.ink);
    }
  }
}

/// The letters of the modes on a grid; several side by side where several modes are feasible.
void letter(Canvas& canvas, const Chart& chart, const Frame& frame) {
  const std::vector<std::size_t> seen = chart.seen();
  int most = 1;
  for (const std::uint32_t cell : chart.map.cells) most = std::max(most, std::popcount(cell));
  const std::size_t across = most > 2 ? 12 : 17, up = 17;
  for (std::size_t j = 0; j < up; ++j)
    for (std::size_t i = 0; i < across; ++i) {
      const double u = (static_cast<double>(i) + 0.5) / static_cast<double>(across);
      const double v = (static_cast<double>(j) + 0.5) / static_cast<double>(up);
      const auto place = [&](double part) {
        return static_cast<std::size_t>(part * static_cast<double>(chart.map.size - 1) + 0.5);
      };
      const std::uint32_t cell = chart.map.cell(place(u), place(v));
      double x = frame.corner.x + u * frame.size.x - 4.0 * (std::popcount(cell) - 1);
      for (std::size_t s = 0; s < seen.size(); ++s) {
        if (!(cell >> seen[s] & 1)) continue;
        const char c = character_of(chart.grasp.prepared, chart.map, seen[s]);
        canvas.text({x, frame.corner.y + (1 - v) * frame.size.y + 4}, std::string(1, c), ink_of(s),
                    Anchor::middle);
        x += 8;
      }
    }
}

int draw(const Chart& chart, const ModesChoices& c) {
  const std::vector<std::size_t> seen = chart.seen();
  const int lines = static_cast<int>(seen.size()) + 3;
  const auto canvas =
      make_canvas(c.out, static_cast<int>(kSide) + 140, static_cast<int>(kSide) + 120 + 20 * lines);
  if (!canvas) {
    complain("this build draws no PNG: configure with -DPANTIN_RENDER=ON, or name an .svg");
    return kFailed;
  }
  const Frame frame{{80, 60},
                    {kSide, kSide},
                    {chart.slice.low, chart.slice.high, axis_name(chart.grasp, chart.slice.across)},
                    {chart.slice.low, chart.slice.high, axis_name(chart.grasp, chart.slice.up)}};
  fill(*canvas, chart, frame);
  for (std::size_t s = 0; s < seen.size(); ++s) {
    const Cut shape = cut(chart.region(seen[s]), chart.slice);
    outline_form(*canvas, {frame, shape, ink_of(s)}, shape.divisor);
    for (int f = 0; f < shape.form_count; ++f)
      outline_form(*canvas, {frame, shape, ink_of(s)}, shape.forms[static_cast<std::size_t>(f)]);
  }
  letter(*canvas, chart, frame);
  frame.draw(*canvas, title_of(chart));
  double y = kSide + 120;
  for (std::size_t s = 0; s < seen.size(); ++s, y += 20)
    canvas->text({40, y}, chart.legend(seen[s]), ink_of(s), Anchor::start);
  canvas->label({40, y}, "A number marks where a mode holds; several: the motion is ambiguous.");
  canvas->label({40, y + 20}, "White: none holds; the lamina jams, slips or falls.");
  return write_or_complain(c.out, canvas->bytes());
}

/// Parses "mu1,mu2" or "1,2"; returns false after an error.
bool read_axes(const Grasp& g, const ModesChoices& c, Slice& slice) {
  const std::size_t n = g.contacts.size(), comma = c.axes.find(',');
  const auto contact = [&](std::string word) -> std::size_t {
    if (word.starts_with("mu")) word.erase(0, 2);
    for (std::size_t i = 0; i < n; ++i)
      if (word == std::to_string(i + 1) || word == g.name(i)) return i;
    return n;
  };
  if (comma != std::string::npos) {
    slice.across = contact(c.axes.substr(0, comma)), slice.up = contact(c.axes.substr(comma + 1));
    if (slice.across < n && slice.up < n && slice.across != slice.up) return true;
  }
  complain(
      fmt::format("--map: found \"{}\", expected two different coefficients of mu1 to mu{}, as "
                  "in mu1,mu2",
                  c.axes, n));
  return false;
}

/// Prints the modes of the map and their shares.
void print_shares(const Chart& chart, const ModesChoices& c) {
  const Grasp& g = chart.grasp;
  const std::vector<std::uint32_t>& cells = chart.map.cells;
  const auto share = [&](auto holds) {
    return static_cast<double>(std::ranges::count_if(cells, holds)) /
           static_cast<double>(cells.size());
  };
  Json j{{"lamina", g.plan->name},
         {"across", axis_name(g, chart.slice.across)},
         {"up", axis_name(g, chart.slice.up)},
         {"from", chart.slice.low},
         {"to", chart.slice.high},
         {"columns", chart.slice.size}};
  j["modes"] = Json::array();
  for (const std::size_t k : chart.seen())
    j["modes"].push_back({{"mode", short_name(g.prepared, chart.region(k))},
                          {"words", in_words(g, signs_of(chart.region(k)))},
                          {"share", share([&](std::uint32_t cell) { return cell >> k & 1; })}});
  j["several"] = share([](std::uint32_t cell) { return std::popcount(cell) > 1; });
  j["none"] = share([](std::uint32_t cell) { return cell == 0; });
  if (!c.out.empty()) j["out"] = c.out;
  print_json(j);
}

/// Writes the file of --out.
int write_map(const Chart& chart, const ModesChoices& c) {
  if (!c.out.ends_with(".csv")) return draw(chart, c);
  return write_or_complain(c.out, as_csv(chart.grasp.prepared, chart.slice, chart.map));
}

}  // namespace

int draw_map(Grasp& g, const ModesChoices& c) {
  Chart chart{g, {}, {}};
  Slice& slice = chart.slice;
  if (!read_axes(g, c, slice)) return kUsage;
  slice.low = c.range[0], slice.high = c.range[1];
  slice.size = static_cast<std::size_t>(c.size);
  slice.fixed = g.friction();
  draw_by_spans(g.prepared, slice, chart.map);
  if (!chart.map.complete) {
    complain(fmt::format("{}: more than 32 modes in the map, expected fewer contacts", c.scene));
    return kFailed;
  }
  const int written = c.out.empty() ? kOk : write_map(chart, c);
  if (c.json && written == kOk) print_shares(chart, c);
  if (c.json || !c.out.empty()) return written;
  const std::vector<std::size_t> seen = chart.seen();
  fmt::print("{}; {} upwards, {} to the right, {:g} to {:g}\n", bold(printable(title_of(chart))),
             printable(axis_name(g, slice.up)), printable(axis_name(g, slice.across)), slice.low,
             slice.high);
  std::size_t most = 1;
  for (const std::uint32_t cell : chart.map.cells)
    most = std::max(most, static_cast<std::size_t>(std::popcount(cell)));
  fmt::print("{}", as_text(g.prepared, chart.map, 72 / (most + 1), 21));
  for (const std::size_t k : seen) fmt::print("{}\n", printable(chart.legend(k)));
  fmt::print(".  none holds: the lamina jams, slips or falls\n");
  return kOk;
}

}  // namespace pantin::program
