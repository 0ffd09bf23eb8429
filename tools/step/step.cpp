// Faces of STEP and IGES files as JSON surfaces, and back.
//
//   pantin-step read IN OUT.json      prints what was read as one JSON object
//   pantin-step write IN.json OUT
//
// Exit codes: 0 ok, 2 bad input, 4 could not write.
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <BRepTools.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <Geom2dConvert.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <GeomAbs_SurfaceType.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_PrinterOStream.hxx>
#include <STEPControl_Reader.hxx>
#include <STEPControl_Writer.hxx>
#include <ShapeFix_Face.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/utf8.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/closest.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/nurbs/plane_curves.hpp"
#include "engine/scene/read/surface_file.hpp"

namespace {

using namespace pantin;
using namespace pantin::detail;

constexpr Real kMillimetre = 1e-3;  // what OpenCASCADE reads into
constexpr Real kTolerance = 1e-6;   // m, of edges that join
constexpr Real kOnBound = 1e-6;     // of the domain: pcurves that run along its sides

struct Told {
  int faces = 0, trimmed = 0, whole = 0, approximated = 0, refused = 0;
  std::string unit = "?";
};

int complain(const std::string& line, int code) {
  std::fprintf(stderr, "pantin-step: %s\n", printable(line).c_str());
  return code;
}

std::string ending_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}
bool is_step(const std::string& path) {
  return ending_of(path) == ".step" || ending_of(path) == ".stp";
}

/// Whether some edge of a face does not run along the sides of its parameters.
bool is_trimmed(const TopoDS_Face& face, const std::array<Real, 4>& b) {
  const Real wide_u = b[1] - b[0], wide_v = b[3] - b[2];
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
    Standard_Real first = 0, last = 0;
    const Handle(Geom2d_Curve) curve =
        BRep_Tool::CurveOnSurface(TopoDS::Edge(e.Current()), face, first, last);
    if (curve.IsNull()) continue;
    bool along[4] = {true, true, true, true};
    for (int i = 0; i <= 8; ++i) {
      const gp_Pnt2d p = curve->Value(first + (last - first) * i / 8);
      along[0] = along[0] && std::abs(p.X() - b[0]) <= kOnBound * wide_u;
      along[1] = along[1] && std::abs(p.X() - b[1]) <= kOnBound * wide_u;
      along[2] = along[2] && std::abs(p.Y() - b[2]) <= kOnBound * wide_v;
      along[3] = along[3] && std::abs(p.Y() - b[3]) <= kOnBound * wide_v;
    }
    if (!along[0] && !along[1] && !along[2] && !along[3]) return true;
  }
  return false;
}

/// Planes to tori and splines are converted exactly; what is offset or swept by others is not.
bool is_exact(const Handle(Geom_Surface) & surface) {
  switch (GeomAdaptor_Surface(surface).GetType()) {
    case GeomAbs_OffsetSurface:
    case GeomAbs_OtherSurface:
      return false;
    default:
      return true;
  }
}

std::vector<Real> knots_of(const TColStd_Array1OfReal& values) {
  return {values.begin(), values.end()};
}

nurbs::Surface surface_of(const Handle(Geom_BSplineSurface) & spline) {
  nurbs::Surface s;
  s.u.degree = spline->UDegree(), s.v.degree = spline->VDegree();
  s.u.values = knots_of(spline->UKnotSequence());
  s.v.values = knots_of(spline->VKnotSequence());
  for (int i = 1; i <= spline->NbUPoles(); ++i)
    for (int j = 1; j <= spline->NbVPoles(); ++j) {
      const gp_Pnt p = spline->Pole(i, j);
      s.points.emplace_back(kMillimetre * Vec3(p.X(), p.Y(), p.Z()), spline->Weight(i, j));
    }
  return s;
}

/// Clamped ends that close up, without a crease, are one place.
void close(nurbs::Surface& s) {
  for (const nurbs::Along way : {nurbs::Along::u, nurbs::Along::v}) {
    nurbs::Surface closed = s;
    (way == nurbs::Along::u ? closed.u : closed.v).is_periodic = true;
    if (!nurbs::errors_of(closed, "").empty()) continue;
    const Real seam = nurbs::knots_of(s, way).high();
    bool is_smooth = true;
    for (const nurbs::Flaw& flaw : nurbs::flaws_of(closed, ""))
      is_smooth = is_smooth &&
                  !(flaw.kind == nurbs::FlawKind::crease && flaw.way == way && flaw.knot == seam);
    if (is_smooth) s = closed;
  }
}

// ---- Trims -------------------------------------------------------------------------------------

nurbs::Curve plane_curve(const Handle(Geom2d_BSplineCurve) & spline) {
  nurbs::Curve c;
  c.knots.degree = spline->Degree();
  c.knots.values = knots_of(spline->KnotSequence());
  for (int i = 1; i <= spline->NbPoles(); ++i)
    c.points.emplace_back(Vec3(spline->Pole(i).X(), spline->Pole(i).Y(), 0), spline->Weight(i));
  return c;
}

/// From the parameters of a surface to those of its spline, which run at another speed in between
/// knots where a conic was converted.
class Mapping {
 public:
  Mapping(const Handle(Geom_Surface) & from, const nurbs::Surface& to) : from_(from), to_(to) {}

  Vec3 mapped(Vec3 at) const {
    const gp_Pnt p = from_->Value(at.x, at.y);
    const auto near =
        nurbs::closest_from(to_, kMillimetre * Vec3(p.X(), p.Y(), p.Z()), {at.x, at.y});
    return {near.u, near.v, 0};
  }
  /// Fractions of the domain between two places.
  Real apart(Vec3 a, Vec3 b) const {
    return std::max(std::abs(a.x - b.x) / to_.u().domain().width(),
                    std::abs(a.y - b.y) / to_.v().domain().width());
  }
  Vec3 on(const nurbs::Curve& c, Real share) const {
    const nurbs::Range t = c.knots.domain();
    return nurbs::evaluate(c, t.low + share * t.width(), 0)[0];
  }
  /// Unchanged where both parameters agree; a line of constant parameter is one again; others are
  /// interpolated, to kMapped.
  std::optional<nurbs::Curve> mapped(const nurbs::Curve& c) const {
    bool is_same = true, is_line = true;
    const Vec3 begin = on(c, 0), end = on(c, 1);
    const Real wide = std::abs(begin.x - end.x), high = std::abs(begin.y - end.y);
    for (int i = 0; i <= kLooks; ++i) {
      const Vec3 at = on(c, Real(i) / kLooks);
      is_same = is_same && apart(at, mapped(at)) <= kMapped;
      is_line = is_line && (apart({at.x, 0, 0}, {begin.x, 0, 0}) <= kMapped ||
                            apart({0, at.y, 0}, {0, begin.y, 0}) <= kMapped);
    }
    if (is_same) return c;
    if (is_line && (wide == 0 || high == 0 || apart({wide, 0, 0}, {}) <= kMapped ||
                    apart({0, high, 0}, {}) <= kMapped))
      return nurbs::line(mapped(begin), mapped(end));
    for (int count = 33; count <= kMostPoints; count = 2 * count - 1) {
      std::vector<Vec3> points;
      for (int i = 0; i < count; ++i) points.push_back(mapped(on(c, Real(i) / (count - 1))));
      const auto made = nurbs::interpolated(points, 3, nurbs::Ends::open);
      if (!made) return std::nullopt;
      Real error = 0;  // from the curve, whose speed differs
      const nurbs::Wire wire(*made);
      for (int i = 0; i + 1 < count; ++i) {
        const Vec3 at = mapped(on(c, (i + 0.5) / (count - 1)));
        error = std::max(error, apart(nurbs::closest_point(wire, at).point, at));
      }
      if (error <= kMapped) return *made;
    }
    return std::nullopt;
  }

 private:
  static constexpr int kLooks = 16, kMostPoints = 1025;
  static constexpr Real kMapped = 1e-8;  // of the domain

  Handle(Geom_Surface) from_;
  nurbs::Face to_;
};

/// Points on the sides of the domain to a tolerance are on them.
void snap(nurbs::Curve& c, const nurbs::Surface& s) {
  const auto onto = [](Real t, const nurbs::Range& r) {
    const Real near = kOnBound * r.width();
    return std::abs(t - r.low) <= near ? r.low : std::abs(t - r.high) <= near ? r.high : t;
  };
  for (nurbs::Weighted& w : c.points)
    w = {{onto(w.point().x, s.u.domain()), onto(w.point().y, s.v.domain()), 0}, w.w};
}

/// The boundary of a face in the parameters of its spline, loop by loop. Nothing if a curve is
/// missing, or if they do not close.
std::optional<std::vector<nurbs::Curve>> loops_of(const TopoDS_Face& given,
                                                  const Handle(Geom_Surface) & surface,
                                                  const nurbs::Surface& made) {
  const TopoDS_Face face = TopoDS::Face(given.Oriented(TopAbs_FORWARD));
  const Mapping to(surface, made);
  std::vector<nurbs::Curve> loops;
  for (TopExp_Explorer w(face, TopAbs_WIRE); w.More(); w.Next()) {
    std::vector<nurbs::Curve> sides;
    for (BRepTools_WireExplorer e(TopoDS::Wire(w.Current()), face); e.More(); e.Next()) {
      Standard_Real first = 0, last = 0;
      const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(e.Current(), face, first, last);
      if (curve.IsNull()) return std::nullopt;
      const Handle(Geom2d_Curve) part = new Geom2d_TrimmedCurve(curve, first, last);
      const Handle(Geom2d_BSplineCurve) spline = Geom2dConvert::CurveToBSplineCurve(part);
      if (spline->IsPeriodic()) spline->SetNotPeriodic();
      auto side = to.mapped(plane_curve(spline));
      if (!side) return std::nullopt;
      snap(*side, made);
      sides.push_back(e.Orientation() == TopAbs_REVERSED ? nurbs::reversed(*side) : *side);
    }
    if (sides.empty()) continue;
    const auto loop = nurbs::joined(sides);
    if (!loop) return std::nullopt;
    loops.push_back(*loop);
  }
  nurbs::Surface trimmed = made;
  trimmed.trims = loops;
  if (loops.empty() || !nurbs::errors_of(trimmed, "").empty()) return std::nullopt;
  return loops;
}

void add_face(const TopoDS_Face& face, std::vector<nurbs::Surface>& faces, Told& told) {
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  if (surface.IsNull()) {
    ++told.refused;
    return;
  }
  std::array<Real, 4> b{};
  BRepTools::UVBounds(face, b[0], b[1], b[2], b[3]);
  const bool has_trim = is_trimmed(face, b);
  told.trimmed += has_trim;
  told.approximated += !is_exact(surface);
  Standard_Real u0, u1, v0, v1;
  surface->Bounds(u0, u1, v0, v1);
  // No farther than it is there: bounds of trimming are known to a tolerance only.
  if (!surface->IsUPeriodic()) b[0] = std::max(b[0], u0), b[1] = std::min(b[1], u1);
  if (!surface->IsVPeriodic()) b[2] = std::max(b[2], v0), b[3] = std::min(b[3], v1);
  try {
    const Handle(Geom_Surface) part =
        new Geom_RectangularTrimmedSurface(surface, b[0], b[1], b[2], b[3]);
    Handle(Geom_BSplineSurface) spline = GeomConvert::SurfaceToBSplineSurface(part);
    if (spline->IsUPeriodic()) spline->SetUNotPeriodic();
    if (spline->IsVPeriodic()) spline->SetVNotPeriodic();
    nurbs::Surface made = surface_of(spline);
    if (!nurbs::errors_of(made, "").empty()) {
      ++told.refused;
      return;
    }
    close(made);
    if (has_trim) {
      if (auto loops = loops_of(face, surface, made))
        made.trims = std::move(*loops);
      else
        ++told.whole;
    }
    faces.push_back(face.Orientation() == TopAbs_REVERSED ? nurbs::inside_out(made) : made);
  } catch (const Standard_Failure&) {
    ++told.refused;
  }
}

TopoDS_Shape read_step(const std::string& path, Told& told) {
  STEPControl_Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) return {};
  TColStd_SequenceOfAsciiString lengths, angles, solids;
  reader.FileUnits(lengths, angles, solids);
  if (!lengths.IsEmpty()) told.unit = lengths.First().ToCString();
  reader.TransferRoots();
  return reader.OneShape();
}

TopoDS_Shape read_iges(const std::string& path, Told& told) {
  IGESControl_Controller::Init();
  IGESControl_Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) return {};
  const auto unit = reader.IGESModel()->GlobalSection().UnitName();
  if (!unit.IsNull()) told.unit = unit->ToCString();
  reader.TransferRoots();
  return reader.OneShape();
}

int read(const std::string& from, const std::string& to) {
  if (!std::ifstream(from))
    return complain(from + ": found no file to read, expected STEP or IGES", 2);
  Told told;
  const TopoDS_Shape shape = is_step(from) ? read_step(from, told) : read_iges(from, told);
  if (shape.IsNull())
    return complain(from + ": found nothing that can be read, expected shapes in " +
                        (is_step(from) ? "STEP" : "IGES"),
                    2);
  std::vector<nurbs::Surface> faces;
  for (TopExp_Explorer e(shape, TopAbs_FACE); e.More(); e.Next(), ++told.faces)
    add_face(TopoDS::Face(e.Current()), faces, told);
  if (faces.empty()) return complain(from + ": found no faces, expected one at least", 2);
  std::ofstream out(to);
  out << surface_text(nurbs::Skin(std::move(faces), kTolerance));
  if (!out.flush()) return complain(to + ": could not be written", 4);
  std::string unit;
  for (const char c : told.unit)
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == ' ') unit += c;
  std::printf(
      "{\"faces\": %d, \"trimmed\": %d, \"whole\": %d, \"approximated\": %d, \"refused\": %d, "
      "\"unit\": \"%s\"}\n",
      told.faces, told.trimmed, told.whole, told.approximated, told.refused, unit.c_str());
  return 0;
}

// ---- Writing -----------------------------------------------------------------------------------

/// Distinct knots and how often each occurs, as OpenCASCADE has them.
struct DistinctKnots {
  TColStd_Array1OfReal values;
  TColStd_Array1OfInteger times;
};
DistinctKnots distinct(const nurbs::Knots& k) {
  std::vector<std::pair<Real, int>> all;
  for (const Real t : k.values)
    if (all.empty() || all.back().first != t)
      all.emplace_back(t, 1);
    else
      ++all.back().second;
  const int count = static_cast<int>(all.size());
  DistinctKnots made{TColStd_Array1OfReal(1, count), TColStd_Array1OfInteger(1, count)};
  for (int i = 0; i < count; ++i) {
    made.values.SetValue(i + 1, all[static_cast<std::size_t>(i)].first);
    made.times.SetValue(i + 1, all[static_cast<std::size_t>(i)].second);
  }
  return made;
}

Handle(Geom_BSplineSurface) spline_of(const nurbs::Surface& given) {
  nurbs::Surface s = given;
  // Clamped: ends that run on are cut off.
  s = nurbs::part_of(s, nurbs::Along::u, s.u.domain());
  s = nurbs::part_of(s, nurbs::Along::v, s.v.domain());
  TColgp_Array2OfPnt poles(1, s.u.count(), 1, s.v.count());
  TColStd_Array2OfReal weights(1, s.u.count(), 1, s.v.count());
  for (int i = 0; i < s.u.count(); ++i)
    for (int j = 0; j < s.v.count(); ++j) {
      const Vec3 p = s.at(i, j).point() / kMillimetre;
      poles.SetValue(i + 1, j + 1, {p.x, p.y, p.z});
      weights.SetValue(i + 1, j + 1, s.at(i, j).w);
    }
  const DistinctKnots u = distinct(s.u), v = distinct(s.v);
  return new Geom_BSplineSurface(poles, weights, u.values, v.values, u.times, v.times, s.u.degree,
                                 s.v.degree);
}

TopoDS_Wire wire_of(const nurbs::Curve& loop, const Handle(Geom_BSplineSurface) & on) {
  const nurbs::Curve c = nurbs::part_of(loop, loop.knots.domain());
  TColgp_Array1OfPnt2d poles(1, c.knots.count());
  TColStd_Array1OfReal weights(1, c.knots.count());
  for (int i = 0; i < c.knots.count(); ++i) {
    const nurbs::Weighted& w = c.points[static_cast<std::size_t>(i)];
    poles.SetValue(i + 1, {w.point().x, w.point().y}), weights.SetValue(i + 1, w.w);
  }
  const DistinctKnots k = distinct(c.knots);
  const Handle(Geom2d_BSplineCurve) curve =
      new Geom2d_BSplineCurve(poles, weights, k.values, k.times, c.knots.degree);
  const TopoDS_Edge edge = BRepBuilderAPI_MakeEdge(curve, on);
  return BRepBuilderAPI_MakeWire(edge);
}

/// A face for each outline, with the holes right inside it.
void sew(const nurbs::Face& face, BRepBuilderAPI_Sewing& sewing) {
  const nurbs::Surface& s = face.surface();
  const Handle(Geom_BSplineSurface) spline = spline_of(s);
  if (s.trims.empty()) return sewing.Add(BRepBuilderAPI_MakeFace(spline, 1e-7).Shape());
  std::vector<int> depth(s.trims.size(), 0);
  std::vector<std::vector<bool>> is_in(s.trims.size(), std::vector<bool>(s.trims.size(), false));
  for (std::size_t k = 0; k < s.trims.size(); ++k) {
    nurbs::Surface alone = s;
    alone.trims = {s.trims[k]};
    const nurbs::Face around(alone);
    for (std::size_t i = 0; i < s.trims.size(); ++i) {
      const Vec3 at = nurbs::evaluate(s.trims[i], s.trims[i].knots.low(), 0)[0];
      is_in[i][k] = i != k && around.holds(at.x, at.y);
      depth[i] += is_in[i][k];
    }
  }
  for (std::size_t k = 0; k < s.trims.size(); ++k) {
    if (depth[k] % 2 == 1) continue;
    BRepBuilderAPI_MakeFace made(spline, wire_of(s.trims[k], spline), Standard_True);
    for (std::size_t i = 0; i < s.trims.size(); ++i)
      if (is_in[i][k] && depth[i] == depth[k] + 1) made.Add(wire_of(s.trims[i], spline));
    BRepLib::BuildCurves3d(made.Face());
    ShapeFix_Face fix(made.Face());
    fix.FixOrientation();
    sewing.Add(fix.Face());
  }
}

int write(const std::string& from, const std::string& to) {
  const auto loaded = load_surface(from);
  if (!loaded) return complain(loaded.errors().front().message, 2);
  BRepBuilderAPI_Sewing sewing(kTolerance / kMillimetre);
  for (const nurbs::Face& face : loaded->surface->skin->faces()) sew(face, sewing);
  sewing.Perform();
  bool is_written = false;
  if (is_step(to)) {
    STEPControl_Writer writer;
    writer.Transfer(sewing.SewedShape(), STEPControl_AsIs);
    is_written = writer.Write(to.c_str()) == IFSelect_RetDone;
  } else {
    IGESControl_Controller::Init();
    IGESControl_Writer writer("MM", 1);
    writer.AddShape(sewing.SewedShape());
    is_written = writer.Write(to.c_str());
  }
  return is_written ? 0 : complain(to + ": could not be written", 4);
}

}  // namespace

int main(int argc, char** argv) {
  // What it tells on stdout by itself is nobody's business.
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
  const std::string word = argc == 4 ? argv[1] : "";
  if (word != "read" && word != "write")
    return complain("found other arguments, expected: read IN OUT.json, or write IN.json OUT", 2);
  try {
    return word == "read" ? read(argv[2], argv[3]) : write(argv[2], argv[3]);
  } catch (const Standard_Failure& e) {
    return complain(std::string(argv[2]) + ": " + e.GetMessageString(), 2);
  }
}
