// NURBS surfaces: reads JSON, STEP and IGES; checks, describes, draws and writes them.
#include "engine/geometry/surface.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/base/utf8.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/trim.hpp"
#include "engine/scene/read/surface_file.hpp"
#include "tools/pantin/command_line.hpp"
#include "tools/pantin/program.hpp"

#ifdef PANTIN_HAS_RENDER
#include "engine/render/png.hpp"
#endif

extern char** environ;

namespace pantin::program {

using namespace detail;

namespace {

namespace fs = std::filesystem;

constexpr const char* kHelper = "pantin-step";

struct SurfaceChoices {
  std::string file, out, picture, size = "1280x720";
  bool json = false;
};

bool is_cad(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".step" || ending == ".stp" || ending == ".iges" || ending == ".igs";
}

/// A temporary folder for the output of the helper, removed at the end.
struct WorkFolder {
  fs::path path;
  WorkFolder() {
    std::string name = (fs::temp_directory_path() / "pantin-XXXXXX").string();
    if (mkdtemp(name.data())) path = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    if (!path.empty()) fs::remove_all(path, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
};

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The helper program for STEP and IGES, which is beside this one.
std::optional<fs::path> find_helper() {
  std::error_code trouble;
  const fs::path own = fs::read_symlink("/proc/self/exe", trouble);
  const fs::path helper = own.parent_path() / kHelper;
  if (trouble || !fs::exists(helper, trouble)) return std::nullopt;
  return helper;
}

/// Runs the helper and collects its output in `printed`. Returns its exit code, or -1.
int run_helper(const fs::path& helper, std::vector<std::string> arguments,
               const fs::path& printed) {
  std::string name = helper.string();
  std::vector<char*> argv{name.data()};
  for (std::string& a : arguments) argv.push_back(a.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, printed.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t child = 0;
  const int failed = posix_spawn(&child, name.c_str(), &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (failed) return -1;
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Returns nothing after an error.
std::optional<fs::path> helper_for(const std::string& path) {
  auto helper = find_helper();
  if (!helper)
    complain(
        fmt::format("{}: found a file of STEP or IGES, expected JSON: this build reads no CAD "
                    "files; one with -DPANTIN_STEP=ON and OpenCASCADE "
                    "(libocct-data-exchange-dev) has {} beside it",
                    path, kHelper));
  return helper;
}

/// The surface that was read; for CAD files also what the helper reported.
struct Read {
  LoadedSurface loaded;
  Json cad;
};

std::optional<Read> read_json(const std::string& path) {
  auto loaded = load_surface(path);
  if (loaded) return Read{std::move(*loaded), {}};
  for (const Error& e : loaded.errors()) print_error(e.message);
  return std::nullopt;
}

std::optional<Read> read_cad(const std::string& path) {
  const auto helper = helper_for(path);
  if (!helper) return std::nullopt;
  const WorkFolder work;
  const fs::path made = work.path / "surface.json", told = work.path / "told.json";
  if (work.path.empty() || run_helper(*helper, {"read", path, made.string()}, told) != 0)
    return std::nullopt;  // reported already
  auto read = read_json(made.string());
  if (!read) return std::nullopt;
  read->cad = Json::parse(text_of(told), nullptr, false);
  const std::string own = made.string();
  for (std::string& line : read->loaded.warnings)  // does not name the temporary file
    if (const auto at = line.find(own); at != line.npos) line.replace(at, own.size(), path);
  return read;
}

Json vector_json(Vec3 v) { return Json{v.x, v.y, v.z}; }

std::string continuity_of(const nurbs::Surface& face) {
  std::string worst = "G1";
  for (const nurbs::Flaw& flaw : nurbs::flaws_of(face, ""))
    if (flaw.kind == nurbs::FlawKind::crease) worst = "C0";
  return worst;
}

Json face_json(const nurbs::Face& face) {
  const nurbs::Surface& s = face.surface();
  bool is_rational = false;
  for (const nurbs::Weighted& w : s.points) is_rational = is_rational || w.w != s.points[0].w;
  const nurbs::Range u = s.u.domain(), v = s.v.domain();
  Json j{{"degrees", {s.u.degree, s.v.degree}},
         {"points", {s.u.count(), s.v.count()}},
         {"knots", {s.u.values.size(), s.v.values.size()}},
         {"rational", is_rational},
         {"periodic", {s.u.is_periodic, s.v.is_periodic}},
         {"domain", {{u.low, u.high}, {v.low, v.high}}},
         {"continuity", continuity_of(s)},
         {"trims", s.trims.size()}};
  if (face.trim()) {
    nurbs::Surface whole = s;
    whole.trims.clear();
    j["trim_share"] = face.trim()->area(face) / nurbs::area_of(nurbs::Skin({whole}, 0));
  }
  return j;
}

Json summary_of(const SurfaceChoices& c, const Read& read) {
  const Surface& surface = *read.loaded.surface;
  const SkinModel& m = *surface.model;
  Json faces = Json::array();
  for (const nurbs::Face& face : surface.skin->faces()) faces.push_back(face_json(face));
  nurbs::Quadrature by;
  const Real area = nurbs::area_of(*surface.skin, &by);
  Json j{{"file", c.file},
         {"faces", std::move(faces)},
         {"closed", m.is_closed},
         {"convex", m.is_convex},
         {"low", vector_json(surface.low)},
         {"high", vector_json(surface.high)},
         {"area_m2", area}};
  if (m.is_closed) j["volume_m3"] = m.enclosed.mass, j["centre"] = vector_json(m.enclosed.centre);
  if (!read.cad.is_null()) j["cad"] = read.cad;
  j["warnings"] = read.loaded.warnings;
  if (by.doubt > 1e-6 * area)
    j["warnings"].push_back(
        fmt::format("{}: found a surface that folds too strongly to be measured, expected one "
                    "whose area is known better than to {:.2g} m^2",
                    c.file, by.doubt));
  return j;
}

/// Groups equal faces, with their number.
void print_faces(const Json& faces) {
  std::vector<std::pair<std::string, int>> kinds;
  for (const Json& f : faces) {
    const bool has_trim = f.contains("trim_share");
    const std::string trim =
        has_trim ? fmt::format(", trimmed by {} loops to {:.4g} % of its area",
                               f["trims"].get<int>(), 100 * f["trim_share"].get<double>())
                 : "";
    const std::string line = fmt::format("degrees {} x {}, {} x {} points, {}{}{}, {}{}",
                                         f["degrees"][0].get<int>(), f["degrees"][1].get<int>(),
                                         f["points"][0].get<int>(), f["points"][1].get<int>(),
                                         f["rational"].get<bool>() ? "rational" : "polynomial",
                                         f["periodic"][0].get<bool>() ? ", periodic along u" : "",
                                         f["periodic"][1].get<bool>() ? ", periodic along v" : "",
                                         f["continuity"].get<std::string>(), trim);
    const auto known = std::find_if(kinds.begin(), kinds.end(),
                                    [&](const auto& kind) { return kind.first == line; });
    if (known == kinds.end())
      kinds.emplace_back(line, 1);
    else
      ++known->second;
  }
  constexpr std::size_t kMostLines = 12;
  for (std::size_t i = 0; i < std::min(kinds.size(), kMostLines); ++i)
    fmt::print("  {:>4} of {}\n", kinds[i].second, kinds[i].first);
  if (kinds.size() > kMostLines)
    fmt::print("       and {} kinds more; --json lists all\n", kinds.size() - kMostLines);
}

void print_summary(const Json& j) {
  fmt::print("{}: {} faces, {}{}\n", printable(j["file"].get<std::string>()), j["faces"].size(),
             j["closed"].get<bool>() ? "closed" : "open",
             j["convex"].get<bool>() ? ", convex" : "");
  print_faces(j["faces"]);
  const auto at = [&](const char* key, int k) {
    return j[key][static_cast<std::size_t>(k)].get<double>();
  };
  fmt::print("  from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m, area {:.6g} m^2",
             at("low", 0), at("low", 1), at("low", 2), at("high", 0), at("high", 1), at("high", 2),
             j["area_m2"].get<double>());
  if (j.contains("volume_m3")) fmt::print(", volume {:.6g} m^3", j["volume_m3"].get<double>());
  fmt::print("\n");
  if (!j.contains("cad")) return;
  const Json& cad = j["cad"];
  fmt::print(
      "  in the file: {} faces in {}, {} trimmed, of which {} are taken whole, {} approximated\n",
      cad.value("faces", 0), printable(cad.value("unit", std::string("?"))),
      cad.value("trimmed", 0), cad.value("whole", 0), cad.value("approximated", 0));
}

#ifdef PANTIN_HAS_RENDER
int draw(const SurfaceChoices& c, const std::shared_ptr<const Surface>& surface) {
  RenderOptions options;
  if (!parse_size(c.size, options.width, options.height)) {
    complain(
        fmt::format("--size: found \"{}\", expected WIDTHxHEIGHT, each from 16 to 8192", c.size));
    return kUsage;
  }
  auto renderer = Renderer::create(options);
  if (!renderer) {
    complain("no OpenGL context could be created, so no picture can be made");
    for (const Error& e : renderer.errors()) print_error(e.message);
    return kFailed;
  }
  World world;
  Shape shape;
  shape.kind = ShapeKind::nurbs, shape.surface = surface;
  world.materials.emplace_back();
  Body body;
  body.motion = Motion::fixed;
  const Entity owner = world.create();
  world.bodies.add(owner, body);
  world.shapes.add(owner, {{shape}});
  View view;
  view.ground = false;
  view.camera = framing_camera(world, view, Real(options.width) / options.height);
  Image image;
  (*renderer)->draw({world, {}, view}, image);
  PngEncoder encoder;
  return write_or_complain(c.picture, as_text(encoder.encode(image)));
}
#else
int draw(const SurfaceChoices&, const std::shared_ptr<const Surface>&) {
  complain("this build has no pictures (PANTIN_RENDER was off or its libraries missing)");
  return kFailed;
}
#endif

int write(const SurfaceChoices& c, const nurbs::Skin& skin) {
  const std::string text = surface_text(skin);
  if (!is_cad(c.out)) return write_or_complain(c.out, text);
  const auto helper = helper_for(c.out);
  if (!helper) return kUsage;
  const WorkFolder work;
  const fs::path from = work.path / "surface.json";
  if (const int code = write_or_complain(from.string(), text)) return code;
  const int code = run_helper(*helper, {"write", from.string(), c.out}, work.path / "told.json");
  return code == 0 ? kOk : kUnwritable;
}

/// Faces join along the ends of their domains only.
void warn_of_seams(const std::string& file, LoadedSurface& loaded) {
  const std::vector<nurbs::Face>& faces = loaded.surface->skin->faces();
  const auto trimmed = std::count_if(
      faces.begin(), faces.end(), [](const nurbs::Face& face) { return face.trim() != nullptr; });
  if (trimmed == 0 || faces.size() < 2) return;
  loaded.warnings.push_back(fmt::format(
      "{}: found {} of {} faces trimmed; faces are not joined along trims: bodies that collide "
      "pass over such a seam, but a contact of a surface joint ends there, and the surface counts "
      "as open. For a surface joint give one face, or faces that join at the ends of their domains",
      file, trimmed, faces.size()));
}

int surface(const SurfaceChoices& c) {
  auto read = is_cad(c.file) ? read_cad(c.file) : read_json(c.file);
  if (!read) return kUsage;
  warn_of_seams(c.file, read->loaded);
  if (!c.json)
    for (const std::string& line : read->loaded.warnings) print_error("warning: " + line);
  const Json summary = summary_of(c, *read);
  if (!c.out.empty())
    if (const int code = write(c, *read->loaded.surface->skin)) return code;
  if (!c.picture.empty())
    if (const int code = draw(c, read->loaded.surface)) return code;
  if (c.json)
    print_json(summary);
  else
    print_summary(summary);
  return kOk;
}

constexpr const char* kExamples =
    R"(Reads a NURBS surface: JSON as in scenes, or, in a build with OpenCASCADE, STEP and IGES.
Checks it and reports faces, degrees, knots, continuity, bounds, area and volume. Lengths are in m,
whatever the unit of the file. Trims are read and written with the faces; a trimmed face whose loops
cannot be read is taken whole, within the bounds of its parameters, and reported.

Examples:
  pantin surface assets/surfaces/groove.json --picture out/groove.png
  pantin surface assets/surfaces/groove.json --out out/groove.json
  pantin surface assets/surfaces/groove.json --json

With OpenCASCADE it converts CAD files, "pantin surface part.step --out part.json", and back, by the
endings .step, .stp, .iges and .igs.

In a scene: {"type": "nurbs", "surface": "part.json"}.

--json prints file, faces (each with degrees, points, knots, rational, periodic, domain,
continuity, trims (how many loops), and trim_share of its area if there are any), closed, convex,
low, high, area_m2, volume_m3 and centre if it is closed, cad (faces, trimmed, whole, approximated,
refused, unit) of a CAD file, and warnings.

Exit codes: 0 ok, 1 no picture could be made, 2 usage or bad input, 4 could not write.)";

}  // namespace

void add_surface(CommandLine& program) {
  auto c = std::make_shared<SurfaceChoices>();
  const Subcommand command =
      program.add("surface", "Checks NURBS surfaces; reads them from STEP and IGES");
  command.option("file", c->file, "JSON, STEP or IGES").required().type(kFileType);
  command.option("--out", c->out, "write it as JSON, or as STEP or IGES, by the name's ending")
      .ends_in({".json", ".step", ".stp", ".iges", ".igs"})
      .type(kFileType);
  command.option("--picture", c->picture, "draw it into this PNG file")
      .ends_in({".png"})
      .type(kFileType);
  command.option("--size", c->size, "of the picture, in pixels")
      .type("WIDTHxHEIGHT")
      .shows_default();
  command.flag("--json", c->json, "print one JSON object instead of text");
  command.footer(kExamples);
  command.runs([c] { return surface(*c); });
}

}  // namespace pantin::program
