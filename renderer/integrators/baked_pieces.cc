// SPDX-License-Identifier: Apache-2.0
// Cutting surfaces into the pieces that surfels stand for, as many as memory holds.

#include <numeric>

#include "renderer/base/parallel.h"
#include "renderer/integrators/baked_points.h"

namespace patina {
namespace {

/// In patches of more micropolygons along a side, but not one across, irradiance is interpolated.
constexpr int kFewCells = 4;
/// Places on a patch from which its area is found are so many along a side, less one.
constexpr int kAreaCells = 2;
/// Of a sum of areas by which one piece stands for its neighbours: the square of its disc's radius. Slivers
/// would have discs much larger than what they stand for.
constexpr float kRoundest = 1;
/// Of neighbours: the length of their normals' mean, the square of their middles' distance from that of all,
/// and of the radius of a disc that closes the gaps to the next ones, over their area. A square's corners are
/// at 0.5.
constexpr double kCoherent = 0.5;
constexpr float kCompact = 2, kOverlap = 1;

/// Corners of the cell (i, j) of nu x nv, in a patch. A triangle's cells with i + j < nu - 1 have a second
/// half, turned around.
struct Corners {
  std::array<V2f, 4> at;
  int count;
};
template <typename Add>
void forEachCell(const Patch& patch, int nu, int nv, const Add& add) {
  const auto at = [&](int i, int j) {
    return patch.toFace(
        {static_cast<float>(i) / static_cast<float>(nu), static_cast<float>(j) / static_cast<float>(nv)});
  };
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      if (patch.shape == FaceShape::Quad) {
        add(Corners{{at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)}, 4});
      } else if (i + j < nu) {
        add(Corners{{at(i, j), at(i + 1, j), at(i, j + 1)}, 3});
        if (i + j + 1 < nu) add(Corners{{at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)}, 3});
      }
    }
}
Corners allOf(FaceShape shape) {
  return {{V2f(0, 0), {1, 0}, {0, 1}, {1, 1}}, shape == FaceShape::Quad ? 4 : 3};
}

/// Of a quadrilateral's corners in rows, or a triangle's: the area times the normal. At a pole two corners
/// are one.
V3f crossOf(std::span<const V3f> P) {
  return (P.size() == 4 ? (P[3] - P[0]).cross(P[2] - P[1]) : (P[1] - P[0]).cross(P[2] - P[0])) / 2;
}

}  // namespace

std::vector<BakedPoints::Whole> BakedPoints::wholesOf(uint32_t placement, bool wantsArea) const {
  std::vector<Whole> wholes;
  if ((world_.attributesOf(placement).visibility & kDiffuseRay) == 0) return wholes;
  const Geometry& geometry = world_.geometry();
  const PatchTable& patches = geometry.patches();
  const auto areaOf = [&](uint32_t face, const Corners& corners) {
    std::array<V3f, 4> P;
    for (size_t k = 0; k < static_cast<size_t>(corners.count); ++k)
      P[k] = geometry.facet(placement, face, corners.at[k].x, corners.at[k].y).P;
    // What a pixel is as wide as there, in view or not.
    const RasterCamera& camera = world_.camera();
    const float area = crossOf(std::span(P).first(static_cast<size_t>(corners.count))).length();
    const float pixels =
        std::min(camera.pixelsPerUnit(P[0], 0), camera.pixelsPerUnit(std::max(std::sqrt(area), 1e-30f)));
    const float seen = area * pixels * pixels;
    return std::isfinite(seen) ? seen : 0;
  };
  const auto [first, patchCount] = patches.patchesOf(placement);
  bool grouped = false;
  for (uint32_t index = first; index < first + patchCount; ++index) {
    const Patch& patch = patches[index];
    if (patch.group > 0) {
      grouped = true;
      continue;
    }
    float area = 0;
    if (wantsArea)
      forEachCell(patch, std::clamp<int>(patch.cellsU, 1, kAreaCells),
                  std::clamp<int>(patch.cellsV, 1, kAreaCells),
                  [&](const Corners& corners) { area += areaOf(patch.face, corners); });
    wholes.push_back({index, patch.face, kNone, area});
  }
  if (!grouped) return wholes;
  const Surface& surface = geometry.surface(geometry.placements()[placement]);
  for (uint32_t face = 0; face < surface.faceCount(); ++face) {
    const FaceShape shape = surface.faceShape(face);
    const float middle = shape == FaceShape::Quad ? 0.5f : 1.0f / 3;
    const uint32_t group = patches.find(placement, face, middle, middle);
    if (patches[group].group == 0) continue;
    wholes.push_back({kNone, face, group, wantsArea ? areaOf(face, allOf(shape)) : 0});
  }
  // Neighbours in sequence: groups are of such, and groups of groups.
  if (wantsArea) {
    const auto orderOf = [&](const Whole& whole) {
      std::array<uint32_t, 4> order{0, 0, 0, whole.face};
      uint32_t group = whole.group;
      for (size_t k = 3; k-- > 0 && group != kNone; group = patches.coarser(group)) order[k] = group;
      return order;
    };
    const auto firstFace =
        std::find_if(wholes.begin(), wholes.end(), [](const Whole& whole) { return whole.patch == kNone; });
    std::sort(firstFace, wholes.end(),
              [&](const Whole& a, const Whole& b) { return orderOf(a) < orderOf(b); });
  }
  return wholes;
}

/// Micropolygons along a side of a piece, of which no more than half is missing to the area `least`.
int BakedPoints::stepOf(const Whole& whole, float least) const {
  if (whole.patch == kNone || !(least > 0)) return 1;
  const Patch& patch = world_.geometry().patches()[whole.patch];
  const auto cells = static_cast<float>(std::max(1, patch.cellsU * patch.cellsV));
  int step = 1;
  while (step < std::max(patch.cellsU, patch.cellsV) &&
         2 * whole.area * static_cast<float>(step) * static_cast<float>(step) < least * cells)
    step *= 2;
  return step;
}

size_t BakedPoints::countPieces(std::span<const Whole> wholes, float least) const {
  const PatchTable& patches = world_.geometry().patches();
  size_t count = 0;
  float small = 0;
  bool isLeft = false;
  for (const Whole& whole : wholes) {
    int cells = 1;
    if (whole.patch != kNone) {
      const Patch& patch = patches[whole.patch];
      const int step = stepOf(whole, least);
      cells = std::max(1, patch.cellsU / step) * std::max(1, patch.cellsV / step);
    }
    if (cells > 1 || !(least > 0)) {
      count += static_cast<size_t>(cells);
      continue;
    }
    small += whole.area, isLeft = true;
    if (small >= least) ++count, small = 0, isLeft = false;
  }
  return count + (isLeft ? 1 : 0);
}

/// One piece for many: of neighbours that face about one way their mean, as large as it looks from there;
/// otherwise the largest, with the area of all.
BakedPoints::Piece BakedPoints::asOne(std::span<const Piece> run) {
  if (run.size() == 1) return run[0];
  V3d middle(0), cross(0);
  double area = 0;
  for (const Piece& p : run) {
    const double a = p.area;
    middle += V3d(p.P) * a, cross += V3d(p.N) * a, area += a;
  }
  const auto largest = std::max_element(run.begin(), run.end(),
                                        [](const Piece& a, const Piece& b) { return a.area < b.area; });
  Piece one = *largest;
  if (!(area > 0) || !std::isfinite(area)) return one;
  const V3f P(middle / area), N = normalizedOr(V3f(cross), one.N);
  const auto whole = static_cast<float>(area);
  bool isSheet = cross.length() > kCoherent * area;
  for (const Piece& p : run)
    isSheet = isSheet && (p.P - P).length2() < kCompact * whole && (p.area == 0 || p.N.dot(N) > 0);
  if (isSheet) {
    one = *std::min_element(run.begin(), run.end(), [&](const Piece& a, const Piece& b) {
      return (a.P - P).length2() < (b.P - P).length2();
    });
    one.isMany = true, one.surfelP = P, one.surfelN = N;
    one.area = static_cast<float>(cross.length());
    one.radius = std::sqrt(kOverlap * one.area);
    for (const Piece& p : run) one.thickness = std::max(one.thickness, std::abs((p.P - P).dot(N)));
  } else {
    const float scale = whole / one.area;
    one.area = whole;
    one.radius = std::sqrt(std::min(one.radius * one.radius * scale, kRoundest * whole));
  }
  one.halfU = one.halfV = kInfinity, one.triangle = V3f(0);
  return one;
}

/// Tiles and faces that are one piece each, and smaller than `least`, are one piece together, in their order.
void BakedPoints::addPieces(uint32_t placement, std::span<const Whole> wholes, float least,
                            std::vector<Piece>& pieces) const {
  const Geometry& geometry = world_.geometry();
  const PatchTable& patches = geometry.patches();
  const bool hasBack = !world_.attributesOf(placement).oneSided;
  const auto pieceOf = [&](const Whole& whole, const Corners& corners) {
    const auto n = static_cast<size_t>(corners.count);
    std::array<V3f, 4> P;
    V2f middle(0, 0);
    V3f center(0, 0, 0);
    for (size_t k = 0; k < n; ++k) {
      P[k] = geometry.facet(placement, whole.face, corners.at[k].x, corners.at[k].y).P;
      middle += corners.at[k] / static_cast<float>(n), center += P[k] / static_cast<float>(n);
    }
    const V3f cross = crossOf(std::span(P).first(n));
    const float area = cross.length();
    const V3f N = normalizedOr(cross, V3f(0, 0, 1));
    const V3f U = normalizedOr(P[1] - P[0], normalizedOr(P[n - 1] - P[n - 2], Frame(N).x)), V = N.cross(U);
    float radius = 0, halfU = 0, halfV = 0;
    for (size_t k = 0; k < n; ++k) {
      const V3f d = P[k] - center;
      radius = std::max(radius, d.length());
      halfU = std::max(halfU, std::abs(d.dot(U))), halfV = std::max(halfV, std::abs(d.dot(V)));
    }
    Piece p;
    p.placement = placement, p.face = whole.face, p.u = middle.x, p.v = middle.y;
    p.patch = kNone;
    if (whole.patch != kNone) {
      const Patch& patch = patches[whole.patch];
      if (std::min(patch.cellsU, patch.cellsV) > 1 && std::max(patch.cellsU, patch.cellsV) > kFewCells)
        p.patch = whole.patch;
    }
    p.P = center, p.N = N, p.U = U, p.halfU = halfU, p.halfV = halfV, p.triangle = V3f(0);
    if (n == 3 && area > 0)
      p.triangle = {(P[0] - center).dot(U), (P[1] - center).dot(U), (P[0] - center).dot(V)};
    p.size = std::sqrt(area), p.area = area, p.radius = radius;
    p.hasBack = hasBack;
    return p;
  };
  const auto onlyPieceOf = [&](const Whole& whole) {
    if (whole.patch == kNone)
      return pieceOf(whole, allOf(geometry.surface(geometry.placements()[placement]).faceShape(whole.face)));
    Corners corners = allOf(patches[whole.patch].shape);
    for (V2f& at : corners.at) at = patches[whole.patch].toFace(at);
    return pieceOf(whole, corners);
  };
  std::vector<Piece> run;
  float small = 0;
  const auto addRun = [&] {
    pieces.push_back(asOne(run));
    run.clear(), small = 0;
  };
  for (const Whole& whole : wholes) {
    int nu = 1, nv = 1;
    if (whole.patch != kNone) {
      const int step = stepOf(whole, least);
      nu = std::max(1, patches[whole.patch].cellsU / step),
      nv = std::max(1, patches[whole.patch].cellsV / step);
    }
    if (nu * nv > 1) {
      forEachCell(patches[whole.patch], nu, nv,
                  [&](const Corners& corners) { pieces.push_back(pieceOf(whole, corners)); });
    } else if (!(least > 0)) {
      pieces.push_back(onlyPieceOf(whole));
    } else {
      small += whole.area;
      run.push_back(onlyPieceOf(whole));
      if (small >= least) addRun();
    }
  }
  if (!run.empty()) addRun();
}

/// Where memory is short, the smallest pieces grow first, as seen from the camera, of all objects alike:
/// large ones, as those of a room's walls around a fine sculpture, stay as they are.
std::vector<BakedPoints::Piece> BakedPoints::collectAll(size_t room, size_t fewer,
                                                        size_t& micropolygons) const {
  const auto placements = static_cast<uint32_t>(world_.geometry().placements().size());
  std::vector<std::vector<Whole>> wholes(placements);
  const auto find = [&](bool wantsArea) {
    parallelFor(0u, placements, [&](uint32_t k) {
      if (!world_.interrupted()) wholes[k] = wholesOf(k, wantsArea);
    });
  };
  const auto count = [&](float least) {
    std::vector<size_t> counts(placements);
    parallelFor(0u, placements, [&](uint32_t k) { counts[k] = countPieces(wholes[k], least); });
    return std::accumulate(counts.begin(), counts.end(), size_t{0});
  };
  find(false);
  micropolygons = count(0);
  float least = settings_.surfelSize;
  if (least > 0) find(true);
  if (count(least) > room) {
    if (!(least > 0)) find(true);
    double area = 0;
    for (const std::vector<Whole>& of : wholes)
      for (const Whole& whole : of) area += static_cast<double>(whole.area);
    // By halves of the logarithm, from less than all pieces' mean to all in one.
    double low = std::log(area / static_cast<double>(micropolygons)) - 30, high = std::log(area) + 1;
    constexpr int kSteps = 16;
    for (int k = 0; k < kSteps && std::isfinite(low) && !world_.interrupted(); ++k) {
      const double middle = (low + high) / 2;
      (count(static_cast<float>(std::exp(middle))) > fewer ? low : high) = middle;
    }
    least = std::max(least, static_cast<float>(std::exp(high)));
  }
  std::vector<Piece> pieces;
  for (uint32_t k = 0; k < placements && !world_.interrupted(); ++k) addPieces(k, wholes[k], least, pieces);
  return pieces;
}

}  // namespace patina
