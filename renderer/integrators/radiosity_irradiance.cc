// SPDX-License-Identifier: Apache-2.0
// Indirect irradiance at the camera's micropolygon vertices, gathered at some of them and interpolated
// between where it is smooth: irradiance caching (Ward et al. 1988, "A Ray Tracing Solution for Diffuse
// Interreflection") on the lattice of a patch, where no search is needed, and where the result does not
// depend on what was looked at first.
//
// A node is a square of step x step micropolygons (in triangles half of one along the third edge), the
// largest that fit the patch. Where the gathers at its corners allow it, all vertices in it are interpolated;
// where they do not it is cut into four; the vertices of single micropolygons are gathered.
#include <algorithm>

#include "renderer/base/statistics.h"
#include "renderer/integrators/radiosity_workspace.h"

namespace patina {
namespace {

STAT_TIME("Time of threads/everything else", otherTime);
STAT_COUNTER("Irradiance cache/vertices asked for", askedVertices);
STAT_COUNTER("Irradiance cache/vertices interpolated", interpolatedVertices);
STAT_COUNTER("Irradiance cache/vertices gathered", gatheredVertices);

/// Irradiance on a convex surface falls with the angle from the middle, which costs its square.
constexpr float kNormalWeight = 3;

/// Corners that differ by noise only, so many standard errors, do not make a node be cut: who met something
/// bright by chance would else keep it to itself, and the others would spread what they missed.
constexpr float kNoise = 3;

}  // namespace

/// 16 bits each: 8 of the exponent and 7 of the mantissa of what is not negative, rounded down.
uint64_t RadiosityEngine::packDistances(float inverse, float nearest, float noise, float direct) {
  const auto part = [](float f) { return uint64_t{floatBits(f) >> 16}; };
  return part(inverse) << 48 | part(nearest) << 32 | part(noise) << 16 | part(direct);
}

/// Width of the largest nodes that a vertex may be a corner of.
static uint32_t widestStep(const Patch& patch, uint32_t vertex) {
  const auto [i, j] = patch.latticePosition(vertex);
  uint32_t step = std::max<uint32_t>(std::min(patch.cellsU, patch.cellsV), 1);
  while (step > 1 && (i % step != 0 || j % step != 0)) step /= 2;
  return step;
}

/// How much of a pixel's irradiance a vertex of the camera's micropolygons stands for, at most all of it:
/// others may be interpolated from it. Where all of a node's are they are step^2; often they are not.
float RadiosityEngine::pixelShare(const ShadingPoint& vertex, uint32_t patch, uint32_t index) const {
  constexpr float kLeastCosine = 1.0f / 32;
  const RasterCamera& camera = world_.camera();
  const V3f from = vertex.P - camera.eye();
  const float distance = from.length();
  const V3f view = camera.perspective() ? from * (1 / std::max(distance, 1e-30f)) : camera.viewDirection();
  const float width = vertex.footprint * camera.pixelsPerUnit(distance);
  const auto step = static_cast<float>(widestStep(world_.geometry().patches()[patch], index));
  const float share = width * width * step * std::max(std::abs(vertex.Ng.dot(view)), kLeastCosine);
  return share < 1 ? share : 1;
}

void RadiosityEngine::irradiance(std::span<const Vertex> wanted, std::span<Rgb> out, int nesting) const {
  Workspace& w = workspace(nesting);
  const PatchTable& patches = world_.geometry().patches();
  askedVertices += static_cast<int64_t>(wanted.size());
  std::vector<Workspace::Corner>& corners = w.corners;
  corners.clear(), w.cornerOf.clear();
  const auto cornerAt = [&](const Vertex& v) {
    const uint64_t key =
        uint64_t{v.patch} << 17 | uint64_t{v.front} << 16 | uint64_t{v.bounces} << 12 | v.index;
    const auto [found, isNew] = w.cornerOf.try_emplace(key, static_cast<uint32_t>(corners.size()));
    if (isNew) corners.push_back({v});
    return found->second;
  };
  // The node that a wanted vertex is in; one on the border of two is in the first.
  w.inNodes.clear();
  for (uint32_t k = 0; k < wanted.size(); ++k) {
    const Patch& patch = patches[wanted[k].patch];
    const auto [i, j] = patch.latticePosition(wanted[k].index);
    const auto step = std::min<uint32_t>(patch.cellsU, patch.cellsV);
    Workspace::InNode at{.wanted = k, .i = i, .j = j, .step = step == 0 ? 1 : step};
    if (step > 1) at.nodeI = std::min(i / step, patch.cellsU / step - 1) * step;
    if (step > 1) at.nodeJ = std::min(j / step, patch.cellsV / step - 1) * step;
    w.inNodes.push_back(at);
  }
  while (!w.inNodes.empty()) {
    // Corners of nodes that lie close enough to be worth a try; single vertices for themselves.
    const size_t before = corners.size();
    for (Workspace::InNode& at : w.inNodes) {
      const Vertex& v = wanted[at.wanted];
      const Patch& patch = patches[v.patch];
      at.count = 0;
      const auto add = [&](uint32_t i, uint32_t j) {
        Vertex corner = v;
        corner.index = static_cast<uint16_t>(patch.latticeVertex(i, j));
        at.corner[at.count++] = cornerAt(corner);
      };
      if (at.step == 1 || (at.i == at.nodeI && at.j == at.nodeJ)) {
        add(at.i, at.j);
        continue;
      }
      add(at.nodeI, at.nodeJ), add(at.nodeI + at.step, at.nodeJ), add(at.nodeI, at.nodeJ + at.step);
      if (patch.shape == FaceShape::Quad || at.nodeI + at.nodeJ + 2 * at.step <= patch.cellsU)
        add(at.nodeI + at.step, at.nodeJ + at.step);
    }
    gatherCorners(before, nesting);
    size_t kept = 0;
    findSmooth(w);
    for (size_t k = 0; k < w.inNodes.size(); ++k) {
      Workspace::InNode at = w.inNodes[k];
      if (at.count == 1) {
        out[at.wanted] = corners[at.corner[0]].irradiance;
        continue;
      }
      if (w.smooth[k]) {
        const float scale = 1 / static_cast<float>(at.step);
        const float a = static_cast<float>(at.i - at.nodeI) * scale,
                    b = static_cast<float>(at.j - at.nodeJ) * scale;
        const auto e = [&](int c) { return corners[at.corner[c]].irradiance; };
        out[at.wanted] = at.count == 4
                             ? (e(0) * (1 - a) + e(1) * a) * (1 - b) + (e(2) * (1 - a) + e(3) * a) * b
                             : e(0) * (1 - a - b) + e(1) * a + e(2) * b;
        ++interpolatedVertices;
        continue;
      }
      at.step /= 2;
      const auto half = [&](uint32_t x, uint32_t node) { return node + (x >= node + at.step ? at.step : 0); };
      // The far border belongs to the last part.
      at.nodeI = std::min(half(at.i, at.nodeI), at.nodeI + at.step);
      at.nodeJ = std::min(half(at.j, at.nodeJ), at.nodeJ + at.step);
      w.inNodes[kept++] = at;
    }
    w.inNodes.resize(kept);
  }
}

/// Finds or makes the irradiance at corners from `first` on.
void RadiosityEngine::gatherCorners(size_t first, int nesting) const {
  Workspace& w = workspace(nesting);
  w.waiting.clear(), w.vertexOf.clear();
  for (size_t k = first; k < w.corners.size(); ++k) {
    Workspace::Corner& corner = w.corners[k];
    const Vertex& v = corner.vertex;
    const BlockVertex at = world_.geometry().patches()[v.patch].blockOf(v.index);
    Waiting x;
    x.patch = v.patch, x.front = v.front, x.level = x.stored = Level::Fine, x.block = at.block;
    x.bounces = v.bounces, x.counted = false;
    x.around.count = 1, x.around.index[0] = v.index, x.inBlock[0] = at.index;
    x.codes.fill(PackedRgb::kMissing);
    if (!findIrradiance(x)) {
      w.waiting.push_back(x);
      w.vertexOf.push_back(static_cast<uint32_t>(k));
    } else {
      corner.set(x.codes);
    }
  }
  gatheredVertices += static_cast<int64_t>(w.waiting.size());
  make(w.waiting, kIrradiance, nesting);
  for (size_t i = 0; i < w.waiting.size(); ++i) w.corners[w.vertexOf[i]].set(w.waiting[i].codes);
  for (size_t k = first; k < w.corners.size(); ++k) {
    Workspace::Corner& corner = w.corners[k];
    const Vertex& v = corner.vertex;
    const ShadingPoint point = vertexRequest(v.patch, v.front, Level::Fine, v.index, 0, v.bounces).point;
    corner.P = point.P, corner.N = point.N;
  }
}

bool RadiosityEngine::findIrradiance(Waiting& x) const {
  const uint32_t index = x.inBlock[0];
  const CacheKey light{x.patch, x.front, kIrradiance, x.block, x.bounces};
  const CacheKey distances{x.patch, x.front, kDistances, x.block, x.bounces};
  if (cache_->find(light, Level::Fine, {&index, 1}, &x.codes[0]) && x.codes[0] != PackedRgb::kMissing &&
      cache_->find(distances, Level::Fine, {&index, 1}, &x.codes[1]) && x.codes[1] != PackedRgb::kMissing)
    return true;
  x.codes.fill(PackedRgb::kMissing);  // one without the other is of no use
  return false;
}

void RadiosityEngine::makeIrradiance(std::span<Fill> fills, std::vector<Waiting>& waiting,
                                     int nesting) const {
  const TimeShare share(otherTime);
  Workspace &w = workspace(nesting), &inner = workspace(nesting + 1);
  w.fillRequests.clear(), w.pixelShares.clear();
  for (const Fill& fill : fills) {
    const Waiting& x = waiting[w.wants[fill.firstWant].waiting];
    w.fillRequests.push_back(vertexRequest(x.patch, x.front, Level::Fine, x.around.index[0], 0, x.bounces));
    w.pixelShares.push_back(pixelShare(w.fillRequests.back().point, x.patch, x.around.index[0]));
  }
  gatherFront(w.fillRequests, w.pixelShares, inner, nesting + 1);
  std::array<uint64_t, kMaxBlockVertices> light, distances;
  for (size_t k = 0; k < fills.size(); ++k) {
    const uint64_t codes[2] = {PackedRgb::pack(inner.front[k]),
                               packDistances(inner.distances[k].inverse, inner.distances[k].nearest,
                                             inner.distances[k].noise, inner.distances[k].direct)};
    for (uint32_t i = fills[k].firstWant; i < fills[k].endWant; ++i)
      std::copy_n(codes, 2, waiting[w.wants[i].waiting].codes.begin());
    // Vertices of one block follow each other.
    constexpr uint64_t kInBlock = 31;
    const uint64_t key = w.wants[fills[k].firstWant].key;
    const auto startsBlock = [&](size_t i) {
      return i == 0 || i == fills.size() ||
             ((w.wants[fills[i].firstWant].key ^ w.wants[fills[i - 1].firstWant].key) & ~kInBlock) != 0;
    };
    if (startsBlock(k)) light.fill(PackedRgb::kMissing), distances.fill(PackedRgb::kMissing);
    light[key & kInBlock] = codes[0], distances[key & kInBlock] = codes[1];
    if (!startsBlock(k + 1)) continue;
    const Waiting& x = waiting[w.wants[fills[k].firstWant].waiting];
    cache_->store({x.patch, x.front, kIrradiance, x.block, x.bounces}, Level::Fine, light);
    cache_->store({x.patch, x.front, kDistances, x.block, x.bounces}, Level::Fine, distances);
  }
}

/// Which nodes' corners may be interpolated between: by Ward's estimate of the error at the centre, the
/// nearest surface, how much the corners differ, and what stands between them.
void RadiosityEngine::findSmooth(Workspace& w) const {
  w.smooth.assign(w.inNodes.size(), 0);
  w.fillRequests.clear(), w.pairOf.clear(), w.order.clear();
  std::unordered_map<uint64_t, uint32_t>& known = w.nodeOf;  // to the first of w.inNodes in it
  known.clear();
  w.pairs.clear(), w.pairOf.clear();
  w.ends.clear();
  w.sameAs.assign(w.inNodes.size(), kNone);
  for (uint32_t k = 0; k < w.inNodes.size(); ++k) {
    const Workspace::InNode& at = w.inNodes[k];
    if (at.count < 3) continue;
    const uint64_t key = uint64_t{at.corner[0]} << 32 | at.corner[1];
    const auto [found, isNew] = known.try_emplace(key, k);
    if (!isNew) {
      w.sameAs[k] = found->second;
      continue;
    }
    V3f centre(0, 0, 0), normal(0, 0, 0);
    Rgb mean(0, 0, 0);
    for (int c = 0; c < at.count; ++c) {
      const Workspace::Corner& corner = w.corners[at.corner[c]];
      centre += corner.P, normal += corner.N, mean += corner.irradiance;
    }
    const float part = 1 / static_cast<float>(at.count);
    centre *= part, mean *= part, normal = normalizedOr(normal, w.corners[at.corner[0]].N);
    // Where lights shine directly an error in what they do not give counts less.
    float direct = kInfinity;
    for (int c = 0; c < at.count; ++c) direct = std::min(direct, w.corners[at.corner[c]].direct);
    const float light = maxComponent(mean),
                relief = light > 0 ? 1 + std::min(direct / light, kRelief) : 1 + kRelief;
    bool smooth = true;
    for (int c = 0; c < at.count && smooth; ++c) {
      const Workspace::Corner& corner = w.corners[at.corner[c]];
      const float r = (corner.P - centre).length();
      const float error =
          r * corner.inverse + kNormalWeight * std::sqrt(std::max(0.0f, 1 - corner.N.dot(normal)));
      const Rgb off = corner.irradiance - mean;
      const float contrast = std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)});
      smooth = error <= settings_.irradianceError * relief && r <= corner.nearest &&
               contrast <= settings_.irradianceContrast * relief * light + kNoise * corner.noise;
    }
    w.smooth[k] = smooth;
    if (!smooth) continue;
    const auto add = [&](int a, int b) {
      w.pairOf.push_back({k, static_cast<uint32_t>(w.ends.size())});
      for (const int c : {a, b}) {
        const Vertex& v = w.corners[at.corner[c]].vertex;
        w.ends.push_back(vertexRequest(v.patch, v.front, Level::Fine, v.index, 0, v.bounces));
      }
    };
    if (at.count == 4)
      add(0, 3), add(1, 2);
    else
      add(0, 1), add(0, 2), add(1, 2);
  }
  w.fillCodes.assign(w.ends.size(), 0);
  cutAway(w.ends, w.fillCodes, w);
  for (const auto& [k, end] : w.pairOf) w.pairs.push_back({&w.ends[end].point, &w.ends[end + 1].point});
  w.separated.resize(w.pairs.size());
  blocked(w.pairs, kCover, w.separated, w);
  for (size_t p = 0; p < w.pairs.size(); ++p) {
    const auto [k, end] = w.pairOf[p];
    if (w.separated[p] || w.fillCodes[end] == PackedRgb::kMissing ||
        w.fillCodes[end + 1] == PackedRgb::kMissing)
      w.smooth[k] = 0;
  }
  for (size_t k = 0; k < w.inNodes.size(); ++k)
    if (w.sameAs[k] != kNone) w.smooth[k] = w.smooth[w.sameAs[k]];
}

}  // namespace patina
