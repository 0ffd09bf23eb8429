// Faces of STEP and IGES files as JSON surfaces, and back.
//
//   pantin-step read IN OUT.json      prints what was read as one JSON object
//   pantin-step write IN.json OUT
//
// Exit codes: 0 ok, 2 bad input, 4 could not write.
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
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
#include <Standard_Failure.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "engine/base/utf8.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/scene/read/surface_file.hpp"

namespace {

using namespace pantin;
using namespace pantin::detail;

constexpr Real kMillimetre = 1e-3;  // what OpenCASCADE reads into
constexpr Real kTolerance = 1e-6;   // m, of edges that join
constexpr Real kOnBound = 1e-6;     // of the domain: pcurves that run along its sides

struct Told {
  int faces = 0, trimmed = 0, approximated = 0, refused = 0;
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

/// Whether all edges of a face run along the sides of its parameters.
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

void add_face(const TopoDS_Face& face, std::vector<nurbs::Surface>& faces, Told& told) {
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  if (surface.IsNull()) {
    ++told.refused;
    return;
  }
  std::array<Real, 4> b{};
  BRepTools::UVBounds(face, b[0], b[1], b[2], b[3]);
  told.trimmed += is_trimmed(face, b);
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
      "{\"faces\": %d, \"trimmed\": %d, \"approximated\": %d, \"refused\": %d, "
      "\"unit\": \"%s\"}\n",
      told.faces, told.trimmed, told.approximated, told.refused, unit.c_str());
  return 0;
}

// ---- Writing -----------------------------------------------------------------------------------

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
  const auto distinct = [](const nurbs::Knots& k) {
    std::vector<std::pair<Real, int>> all;
    for (const Real t : k.values)
      if (all.empty() || all.back().first != t)
        all.emplace_back(t, 1);
      else
        ++all.back().second;
    return all;
  };
  const auto us = distinct(s.u), vs = distinct(s.v);
  const auto arrays = [](const auto& all, TColStd_Array1OfReal& knots,
                         TColStd_Array1OfInteger& times) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      knots.SetValue(static_cast<int>(i) + 1, all[i].first);
      times.SetValue(static_cast<int>(i) + 1, all[i].second);
    }
  };
  TColStd_Array1OfReal u(1, static_cast<int>(us.size())), v(1, static_cast<int>(vs.size()));
  TColStd_Array1OfInteger u_times(1, u.Length()), v_times(1, v.Length());
  arrays(us, u, u_times), arrays(vs, v, v_times);
  return new Geom_BSplineSurface(poles, weights, u, v, u_times, v_times, s.u.degree, s.v.degree);
}

int write(const std::string& from, const std::string& to) {
  const auto loaded = load_surface(from);
  if (!loaded) return complain(loaded.errors().front().message, 2);
  BRepBuilderAPI_Sewing sewing(kTolerance / kMillimetre);
  for (const nurbs::Face& face : loaded->surface->skin->faces())
    sewing.Add(BRepBuilderAPI_MakeFace(spline_of(face.surface()), 1e-7).Shape());
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
