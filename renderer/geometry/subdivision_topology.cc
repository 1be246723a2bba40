// SPDX-License-Identifier: Apache-2.0
// From a SubdivisionMesh request to OpenSubdiv's topology: checks, tags, face-varying channels.
#include "renderer/geometry/subdivision_topology.h"

#include <fmt/format.h>
#include <opensubdiv/far/error.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <numeric>

namespace patina {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;
using SdcOptions = Sdc::Options;
using Tag = SubdivisionMesh::Tag;

/// What OpenSubdiv says on this thread while a mesh is built; it would go to standard output otherwise.
thread_local std::string* farMessages = nullptr;

void collectMessage(const char* text) {
  if (farMessages && farMessages->size() < 400)
    *farMessages += std::string(farMessages->empty() ? "" : "; ") + text;
}

class MessageCollector {
 public:
  MessageCollector() {
    static std::once_flag once;
    std::call_once(once, [] {
      Far::SetErrorCallback([](Far::ErrorType, const char* message) { collectMessage(message); });
      Far::SetWarningCallback(collectMessage);
    });
    farMessages = &text;
  }
  ~MessageCollector() { farMessages = nullptr; }
  std::string text;
};

struct TagReader {
  const SubdivisionMesh& mesh;
  const Location& where;
  ErrorHandler& errors;
  size_t pointCount;
  const std::vector<uint32_t>& baseFace;  ///< of request faces, kNone = left out; empty = the same

  std::vector<int> creasePairs, corners, holes;
  std::vector<float> creaseWeights, cornerWeights;
  SdcOptions options{};
  int faceVarying = -1;  ///< facevaryinginterpolateboundary
  bool propagateCorners = false;

  void warn(const Tag& tag, std::string_view what) const {
    errors.report(Severity::Warning, RiError::BadArgument, where,
                  fmt::format("tag \"{}\" {}; ignored", tag.name, what));
  }

  bool isVertex(int v) const { return v >= 0 && static_cast<size_t>(v) < pointCount; }

  /// One float for all or one for each of n; not a number: refused.
  bool sharpnessFits(const Tag& tag, size_t n) const {
    const bool fits = tag.floats.size() == 1 || tag.floats.size() == n;
    return fits && std::none_of(tag.floats.begin(), tag.floats.end(), [](float f) { return std::isnan(f); });
  }
  static float sharpness(const Tag& tag, size_t i) {
    return std::clamp(tag.floats[tag.floats.size() == 1 ? 0 : i], 0.0f,
                      10.0f);  // 10 is infinite to OpenSubdiv
  }

  void crease(const Tag& tag) {
    if (tag.ints.size() < 2) return warn(tag, "needs at least two vertices");
    if (!sharpnessFits(tag, tag.ints.size() - 1))
      return warn(tag, "needs one sharpness, or one for each edge");
    if (!std::all_of(tag.ints.begin(), tag.ints.end(), [&](int v) { return isVertex(v); }))
      return warn(tag, "names a vertex that does not exist");
    for (size_t i = 0; i + 1 < tag.ints.size(); ++i) {
      creasePairs.insert(creasePairs.end(), {tag.ints[i], tag.ints[i + 1]});
      creaseWeights.push_back(sharpness(tag, i));
    }
  }

  void corner(const Tag& tag) {
    if (!sharpnessFits(tag, tag.ints.size())) return warn(tag, "needs one sharpness, or one for each vertex");
    for (size_t i = 0; i < tag.ints.size(); ++i) {
      if (!isVertex(tag.ints[i])) return warn(tag, "names a vertex that does not exist");
      corners.push_back(tag.ints[i]);
      cornerWeights.push_back(sharpness(tag, i));
    }
  }

  void hole(const Tag& tag) {
    for (int face : tag.ints) {
      if (face < 0 || static_cast<size_t>(face) >= mesh.vertsPerFace.size())
        return warn(tag, "names a face that does not exist");
      const auto f = static_cast<size_t>(face);
      if (baseFace.empty() || baseFace[f] != kNone)
        holes.push_back(baseFace.empty() ? face : static_cast<int>(baseFace[f]));
    }
  }

  void read(const Tag& tag) {
    const int value = tag.ints.empty() ? 1 : tag.ints[0];
    const std::string_view word = tag.strings.empty() ? std::string_view() : tag.strings[0];
    if (tag.name == "crease") return crease(tag);
    if (tag.name == "corner") return corner(tag);
    if (tag.name == "hole") return hole(tag);
    if (tag.name == "interpolateboundary") {
      if (value < 0 || value > 2) return warn(tag, "takes 0, 1 or 2");
      options.SetVtxBoundaryInterpolation(value == 0   ? SdcOptions::VTX_BOUNDARY_NONE
                                          : value == 1 ? SdcOptions::VTX_BOUNDARY_EDGE_AND_CORNER
                                                       : SdcOptions::VTX_BOUNDARY_EDGE_ONLY);
    } else if (tag.name == "facevaryinginterpolateboundary") {
      if (value < 0 || value > 3) return warn(tag, "takes 0, 1, 2 or 3");
      faceVarying = value;
    } else if (tag.name == "facevaryingpropagatecorners") {
      propagateCorners = value != 0;
    } else if (tag.name == "creasemethod") {
      if (word != "normal" && word != "chaikin") return warn(tag, "takes \"normal\" or \"chaikin\"");
      options.SetCreasingMethod(word == "chaikin" ? SdcOptions::CREASE_CHAIKIN : SdcOptions::CREASE_UNIFORM);
    } else if (tag.name == "smoothtriangles") {
      const bool smooth = word == "smooth" || (word.empty() && value == 2);
      options.SetTriangleSubdivision(smooth ? SdcOptions::TRI_SUB_SMOOTH : SdcOptions::TRI_SUB_CATMARK);
    } else {
      warn(tag, "is not known");
    }
  }

  void readAll() {
    for (const Tag& tag : mesh.tags) read(tag);
    const int rule = faceVarying < 0 ? 1 : faceVarying;
    options.SetFVarLinearInterpolation(rule == 0          ? SdcOptions::FVAR_LINEAR_ALL
                                       : rule == 2        ? SdcOptions::FVAR_LINEAR_NONE
                                       : rule == 3        ? SdcOptions::FVAR_LINEAR_BOUNDARIES
                                       : propagateCorners ? SdcOptions::FVAR_LINEAR_CORNERS_PLUS2
                                                          : SdcOptions::FVAR_LINEAR_CORNERS_PLUS1);
  }

  bool isSmooth(const PrimVar& variable) const {
    if (faceVarying == 0 || variable.type == ValueType::String || variable.type == ValueType::Integer)
      return false;
    return variable.storage == StorageClass::FaceVertex ||
           (variable.storage == StorageClass::FaceVarying && faceVarying > 0);
  }
};

/// Numbers the values of a variable at the corners: corners of one vertex with equal values share a number.
SubdivisionTopology::Channel makeChannel(const PrimVar& variable, const std::vector<int>& vertices,
                                         size_t pointCount, std::vector<int>& valueOf) {
  SubdivisionTopology::Channel channel{&variable, {}};
  const auto n = static_cast<size_t>(variable.components);
  const auto equal = [&](uint32_t a, uint32_t b) {
    const auto first = variable.floats.begin() + static_cast<ptrdiff_t>(a * n);
    return std::equal(first, first + static_cast<ptrdiff_t>(n),
                      variable.floats.begin() + static_cast<ptrdiff_t>(b * n));
  };
  std::vector<uint32_t> firstValue(pointCount, kNone), nextValue;
  valueOf.resize(vertices.size());
  for (uint32_t c = 0; c < vertices.size(); ++c) {
    uint32_t& first = firstValue[static_cast<size_t>(vertices[c])];
    uint32_t value = first;
    while (value != kNone && !equal(channel.cornerOf[value], c)) value = nextValue[value];
    if (value == kNone) {
      value = static_cast<uint32_t>(channel.cornerOf.size());
      channel.cornerOf.push_back(c);
      nextValue.push_back(first);
      first = value;
    }
    valueOf[c] = static_cast<int>(value);
  }
  return channel;
}

/// Says why a face cannot be subdivided; null if it can.
const char* faceProblem(std::span<const int> face, size_t pointCount, bool trianglesOnly) {
  if (face.size() < 3) return "has fewer than 3 vertices";
  if (trianglesOnly && face.size() != 3) return "is no triangle";
  for (size_t i = 0; i < face.size(); ++i)
    if (face[i] < 0 || static_cast<size_t>(face[i]) >= pointCount)
      return "uses a vertex that \"P\" does not have";
  std::array<int, kMaxValence> sorted;
  if (face.size() > kMaxValence) return nullptr;  // the whole mesh is refused then
  std::copy(face.begin(), face.end(), sorted.begin());
  const auto end = sorted.begin() + static_cast<ptrdiff_t>(face.size());
  std::sort(sorted.begin(), end);
  return std::adjacent_find(sorted.begin(), end) != end ? "uses a vertex twice" : nullptr;
}

/// A vertex at which two faces share both their edges, while some edge is sharp or has more than two faces;
/// -1 if there is none. Bfr 3.5.0 then reads sharpnesses that it has not written (mended in OpenSubdiv 3.5.1,
/// change 51eb6a0).
int findSharpPinch(const Far::TopologyLevel& level, bool creases) {
  for (int e = 0; !creases && e < level.GetNumEdges(); ++e) creases = level.IsEdgeNonManifold(e);
  for (int f = 0; creases && f < level.GetNumFaces(); ++f) {
    const auto edges = level.GetFaceEdges(f);
    for (int k = 0; k < edges.size(); ++k) {
      const auto before = level.GetEdgeFaces(edges[(k + edges.size() - 1) % edges.size()]);
      for (int other : level.GetEdgeFaces(edges[k]))
        if (other != f && before.FindIndex(other) >= 0) return level.GetFaceVertices(f)[k];
    }
  }
  return -1;
}

}  // namespace

size_t SubdivisionTopology::memory() const {
  size_t bytes = (requestFace.capacity() + firstCorner.capacity()) * sizeof(uint32_t);
  for (const Channel& c : channels) bytes += c.cornerOf.capacity() * sizeof(uint32_t);
  // The base level of the refiner: faces, edges and vertices with their incidences, as OpenSubdiv 3.5 keeps
  // them.
  if (refiner) {
    const Far::TopologyLevel level = refiner->GetLevel(0);
    const auto corners = static_cast<size_t>(level.GetNumFaceVertices());
    bytes += corners * 22 + static_cast<size_t>(level.GetNumEdges()) * 32 +
             static_cast<size_t>(level.GetNumVertices()) * 24 + static_cast<size_t>(level.GetNumFaces()) * 10;
  }
  return bytes;
}

SubdivisionTopology buildTopology(const SubdivisionMesh& mesh, const Primitive& primitive, size_t pointCount,
                                  ErrorHandler& errors) {
  SubdivisionTopology topology;
  const bool loop = mesh.scheme == "loop";
  const auto refuse = [&](std::string_view why) {
    errors.report(Severity::Warning, RiError::BadArgument, primitive.where,
                  fmt::format("SubdivisionMesh: {}; rendered as polygons", why));
    topology.asPolygons = true;
    return std::move(topology);
  };

  // Faces that make sense.
  std::vector<uint32_t> baseFace;
  std::vector<int> keptSizes, keptVertices, valence(pointCount, 0);
  size_t corner = 0, left = 0, firstBad = 0;
  const char* problem = nullptr;
  topology.firstCorner.reserve(mesh.vertsPerFace.size());
  for (size_t f = 0; f < mesh.vertsPerFace.size(); ++f) {
    const std::span<const int> face =
        std::span(mesh.vertices).subspan(corner, static_cast<size_t>(mesh.vertsPerFace[f]));
    if (face.size() > kMaxValence)
      return refuse(fmt::format("face {} has {} vertices, more than {}", f, face.size(), kMaxValence));
    if (const char* bad = faceProblem(face, pointCount, loop)) {
      if (left++ == 0) problem = bad, firstBad = f;
      if (loop && face.size() > 3)
        return refuse(fmt::format("the scheme \"loop\" needs triangles, and face {} {}", f, bad));
      if (baseFace.empty()) {
        baseFace.resize(f);
        std::iota(baseFace.begin(), baseFace.end(), 0u);
        topology.requestFace = baseFace;
        keptSizes.assign(mesh.vertsPerFace.begin(), mesh.vertsPerFace.begin() + static_cast<ptrdiff_t>(f));
        keptVertices.assign(mesh.vertices.begin(), mesh.vertices.begin() + static_cast<ptrdiff_t>(corner));
      }
      baseFace.push_back(kNone);
    } else {
      for (int v : face)
        if (++valence[static_cast<size_t>(v)] > kMaxValence)
          return refuse(fmt::format("more than {} faces meet at vertex {}", kMaxValence, v));
      topology.firstCorner.push_back(static_cast<uint32_t>(corner));
      if (left) {
        baseFace.push_back(static_cast<uint32_t>(keptSizes.size()));
        topology.requestFace.push_back(static_cast<uint32_t>(f));
        keptSizes.push_back(static_cast<int>(face.size()));
        keptVertices.insert(keptVertices.end(), face.begin(), face.end());
      }
    }
    corner += face.size();
  }
  if (left)
    errors.report(Severity::Warning, RiError::BadArgument, primitive.where,
                  fmt::format("SubdivisionMesh: {} of {} faces left out: number {} {}", left,
                              mesh.vertsPerFace.size(), firstBad, problem));
  if (topology.firstCorner.empty()) return topology;
  const std::vector<int>& sizes = left ? keptSizes : mesh.vertsPerFace;
  const std::vector<int>& vertices = left ? keptVertices : mesh.vertices;

  TagReader tags{mesh, primitive.where, errors, pointCount, baseFace, {}, {}, {}, {}, {}};
  tags.readAll();

  // Channels are made from the request's corners and cut down to those that were kept.
  std::vector<std::vector<int>> channelValues;
  for (const PrimVar& variable : primitive.variables) {
    if (!tags.isSmooth(variable) ||
        variable.floats.size() < mesh.vertices.size() * static_cast<size_t>(variable.components))
      continue;
    if (left) continue;  // face numbers no longer match: such meshes get bilinear values
    topology.channels.push_back(makeChannel(variable, vertices, pointCount, channelValues.emplace_back()));
  }
  std::vector<Far::TopologyDescriptor::FVarChannel> channels(channelValues.size());
  for (size_t i = 0; i < channels.size(); ++i) {
    channels[i].numValues = static_cast<int>(topology.channels[i].cornerOf.size());
    channels[i].valueIndices = channelValues[i].data();
  }

  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(pointCount);
  descriptor.numFaces = static_cast<int>(sizes.size());
  descriptor.numVertsPerFace = sizes.data();
  descriptor.vertIndicesPerFace = vertices.data();
  descriptor.numCreases = static_cast<int>(tags.creaseWeights.size());
  descriptor.creaseVertexIndexPairs = tags.creasePairs.data();
  descriptor.creaseWeights = tags.creaseWeights.data();
  descriptor.numCorners = static_cast<int>(tags.cornerWeights.size());
  descriptor.cornerVertexIndices = tags.corners.data();
  descriptor.cornerWeights = tags.cornerWeights.data();
  descriptor.numHoles = static_cast<int>(tags.holes.size());
  descriptor.holeIndices = tags.holes.data();
  descriptor.numFVarChannels = static_cast<int>(channels.size());
  descriptor.fvarChannels = channels.data();

  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const auto scheme = loop                        ? Sdc::SCHEME_LOOP
                      : mesh.scheme == "bilinear" ? Sdc::SCHEME_BILINEAR
                                                  : Sdc::SCHEME_CATMARK;
  MessageCollector messages;
  topology.refiner.reset(Factory::Create(descriptor, Factory::Options(scheme, tags.options)));
  if (!topology.refiner) return refuse("OpenSubdiv refuses its topology: " + messages.text);
  const bool creases =
      std::any_of(tags.creaseWeights.begin(), tags.creaseWeights.end(), [](float w) { return w > 0; });
  if (const int vertex = findSharpPinch(topology.refiner->GetLevel(0), creases); vertex >= 0) {
    topology.refiner.reset();
    return refuse(fmt::format("two faces share two edges at vertex {}, in a mesh with creases", vertex));
  }
  if (!messages.text.empty())
    errors.report(Severity::Warning, RiError::BadArgument, primitive.where,
                  "SubdivisionMesh: " + messages.text);
  return topology;
}

}  // namespace patina
