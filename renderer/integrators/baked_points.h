// SPDX-License-Identifier: Apache-2.0
// Surfels of a scene with the light that leaves them: what mode points gathers from (P. Christensen,
// "Point-Based Approximate Color Bleeding", Pixar Technical Memo 08-01, 2008).
#pragma once

#include <memory>

#include "renderer/integrators/radiosity_engine.h"
#include "renderer/points/point_raster.h"

namespace patina {

class BakedPoints {
 public:
  struct Settings {
    PointRaster::Settings raster;  ///< of the picture; while baking, of three quarters of the resolution
    /// Diffuse ones in all, no more than any object allows; 0: as many as those allow, of which what the last
    /// ones add is estimated when it is little.
    int bounces = 0;
    /// For the octree: where all pieces do not fit, the smallest grow until they take half of it. What they
    /// leave is for what rasters saw, so that only the first bounce draws them; those that find no room are
    /// drawn again. With two bounces or less, which draw none twice, pieces may take all.
    size_t bytes = size_t{256} << 20;
    /// Pixels that a piece covers at least, about, were it seen from the front: of smaller micropolygons some
    /// are one piece. 0: none are.
    float surfelSize = 1;
  };
  /// Cuts what diffuse rays see into pieces, one for each micropolygon of its patches where memory allows
  /// it, and shades them: with direct light first, then again, with what they gather from each other, for
  /// each bounce but the last, which is the picture's own. Irradiance is interpolated
  /// within patches as in the picture: `like` are the settings of that. [all threads; nobody renders]
  BakedPoints(const World& world, const RadiosityEngine::Settings& like, const Settings& settings);
  ~BakedPoints();

  /// Irradiance by surfels, and where none is, by the smooth skies that the point's surface sees; on the side
  /// of its normal or behind. `withSurfels` false: they only hide the sky. [any thread]
  PointRaster::Estimate irradiance(const ShadingPoint& point, bool behind, uint64_t seed,
                                   bool withSurfels) const;

 private:
  /// A surfel and where it is on its surface.
  struct Piece {
    uint32_t placement, face;
    uint32_t patch;  ///< kNone: of few micropolygons, one across (hair), or in a group of small faces
    float u, v;
    V3f P, N;  ///< world space: the middle and the normal of its corners
    V3f U;     ///< along a side
    float halfU, halfV;
    V3f triangle;  ///< as Surfel's, along N x U
    float size;    ///< distance of neighbours
    float area, radius;
    bool hasBack;
    /// Of neighbours that this one stands for, with them: their mean. Otherwise P, and N.
    V3f surfelP, surfelN;
    bool isMany = false;
    float thickness = 0;  ///< most distance of one of them from the plane of all
    /// In front and behind: something stands between the vertices around it, so that it is looked at by
    /// itself.
    std::array<bool, 2> isAlone{false, false};
    std::array<uint32_t, 2> cluster{kNone,
                                    kNone};  ///< in front and behind: in clusters_, where patch is kNone
  };
  /// Pieces that share irradiance: so close to each other, and turned so alike, that one side's of one stands
  /// for all; or a tangle, in which it is a function of the normal.
  struct Cluster {
    std::vector<uint32_t> lookedFrom;  ///< pieces
    bool front = true;                 ///< of what is no tangle
    bool isTangle = true;
    Rgb irradiance{0, 0, 0};                                    ///< mean
    V3f normal{0, 0, 0};                                        ///< mean, of a tangle's
    std::array<V3f, 3> slope{V3f(0), V3f(0), V3f(0)};           ///< of irradiance, by channels
    Rgb least{0, 0, 0}, most{kInfinity, kInfinity, kInfinity};  ///< that any place looked from has
    /// Irradiance of a side whose normal is N, which is unit.
    Rgb at(const V3f& N) const;
  };
  /// What pieces may be made of, of one placement: tiles, and faces in groups.
  struct Whole {
    uint32_t patch, face;  ///< patch kNone: in a group of small faces
    uint32_t group;        ///< ... which is this patch
    float area;            ///< in pixels where it is, in view or not; 0 where nobody asked
  };
  std::vector<Whole> wholesOf(uint32_t placement, bool wantsArea) const;
  int stepOf(const Whole& whole, float least) const;
  size_t countPieces(std::span<const Whole> wholes, float least) const;
  void addPieces(uint32_t placement, std::span<const Whole> wholes, float least,
                 std::vector<Piece>& pieces) const;
  static Piece asOne(std::span<const Piece> run);
  /// All pieces, if those are no more than `room`, and otherwise about `fewer`, of which the smallest are
  /// made larger. `micropolygons`: how many those would be without a limit.
  std::vector<Piece> collectAll(size_t room, size_t fewer, size_t& micropolygons) const;
  void findInnerSides(const std::vector<Piece>& pieces, size_t placements, std::vector<Surfel>& surfels);
  ShadingPoint pointOf(const Piece& piece, bool front) const;
  uint64_t seedOf(const Piece& piece, bool front) const;
  PointRaster::Estimate lookFrom(const Piece& piece, bool front) const;
  /// Makes clusters of the pieces that are in no patch to be interpolated in, with the irradiance of the
  /// first bounce.
  void findClusters(std::vector<Piece>& pieces, uint32_t placements);
  void addClusters(const std::vector<Piece>& pieces, std::span<uint32_t> members, bool front,
                   std::vector<Cluster>& clusters, std::vector<uint32_t>& counts) const;
  static float fit(Cluster& cluster, std::span<const V3f> normals, std::span<const Rgb> irradiance);
  float lookAgain(Cluster& cluster, const std::vector<Piece>& pieces) const;
  static std::vector<uint32_t> chooseFrom(const std::vector<Piece>& pieces, std::span<const uint32_t> members,
                                          float radius);
  static bool areSheets(const std::vector<Piece>& pieces, std::span<const uint32_t> members);
  void addTangles(std::vector<Piece>& pieces, std::span<uint32_t> members, size_t most, float usual,
                  std::vector<std::pair<Cluster, std::vector<uint32_t>>>& tangles) const;
  /// Makes tangles of some pieces of an object; members of tangles have them as clusters afterwards.
  void findTangles(std::vector<Piece>& pieces, std::span<uint32_t> members);
  VertexWeights around(const Piece& piece) const;
  void findAlone(const RadiosityEngine& engine, std::vector<Piece>& pieces) const;
  struct Bounce {
    int number;  ///< how many are in the radiance afterwards; objects that allow fewer keep what they have
    /// Black sides stay black: in the last bounce no side began to shine, so that what they see is as it was.
    bool onlyLit;
  };
  void gatherClusters(const std::vector<Piece>& pieces, const Bounce& bounce, const std::vector<Rgb>& front,
                      const std::vector<Rgb>& back);
  void bake(const RadiosityEngine& engine, const Bounce& bounce, const std::vector<Piece>& pieces,
            std::vector<Rgb>& front, std::vector<Rgb>& back) const;
  bool addRest(const std::vector<Piece>& pieces, int bounce, int last, const V3d& sum, const V3d& gained,
               const V3d& gainedBefore, const std::vector<Rgb>& frontBefore,
               const std::vector<Rgb>& backBefore, std::vector<Rgb>& front, std::vector<Rgb>& back) const;

  const World& world_;
  const Settings settings_;
  std::unique_ptr<PointTree> tree_;
  bool isBaked_ = false;
  std::vector<Surfel::Inner> innerOf_;  ///< by placement
  std::unique_ptr<SurfelViews> views_;  ///< while baking several bounces: what rasters saw in the first
  std::vector<Cluster> clusters_;       ///< while baking
};

}  // namespace patina
