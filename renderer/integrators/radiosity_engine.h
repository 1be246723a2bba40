// SPDX-License-Identifier: Apache-2.0
// View-independent light: B = emission + ambient + rho E(front)/pi + tau E(back)/pi at points and at patch
// vertices, with the multiresolution cache or without it.
//
// It works in batches, breadth first: the rays of many gathers are traced together, then all that the cache
// misses of what they have met is made together, gathers of its own included.
//
// Every result is a function of its arguments and of the scene: random numbers are hashed from the place and
// depth that they are for, so that neither threads, nor what happens to be cached, change a bit of it.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "renderer/base/sampling.h"
#include "renderer/cache/cache_survey.h"
#include "renderer/cache/fill_claims.h"
#include "renderer/cache/patch_cache.h"
#include "renderer/integrators/opacity_cache.h"
#include "renderer/integrators/world.h"

namespace patina {

/// What a point is shaded for, which says how much it may cost.
enum class Purpose : uint8_t {
  Vertex,      ///< of the camera's micropolygons (depth 0), or of the cache's coarse level in a large patch
  HalfVertex,  ///< of the cache, with fewer micropolygons to a vertex: it is met less often, and shares
  QuarterVertex,  ///< the work with more neighbours
  FineVertex,     ///< of the cache's fine level
  Ray,            ///< a part of a larger estimate: one ray of each kind
  Sample,         ///< of the camera, of which a pixel has many
  Part,           ///< of a pixel, of which it has up to RayBudget::kParts
  Truth           ///< as Ray, but its mean is not to depend on what the cache holds
};
constexpr bool isRay(Purpose purpose) { return purpose == Purpose::Ray || purpose == Purpose::Truth; }

/// How many rays a shading point gets by its diffuse depth.
struct RayBudget {
  static constexpr int kParts = 16;      ///< of a pixel that are shaded apart, at most
  static constexpr int kPartsWorth = 4;  ///< so many times the rays of one point all of them have
  int diffuse0 = 128;                    ///< gather rays at depth 0
  int light0 = 16;                       ///< rays to an area or sky light at depth 0
  int samples = 1;  ///< of a pixel, among which Purpose::Sample divides them, and Purpose::Part
  int diffuse(int depth, Purpose purpose) const;
  int light(int depth, Purpose purpose) const;
};

class BakedPoints;

class RadiosityEngine {
 public:
  /// Diffuse depths up to this have entries of their own; deeper light is followed by random walks.
  static constexpr int kCachedDepths = 4;

  struct Settings {
    bool cached = true;
    bool indirect = true;
    RayBudget rays;
    size_t cacheBytes = size_t{256} << 20, opacityBytes = size_t{256} << 20;
    float gatherError = 0.01f;        ///< relative standard error at which gathers of depth 0 end
    float irradianceError = 0.1f;     ///< of Ward's estimate; 0: gathered at each vertex
    float irradianceContrast = 0.1f;  ///< that corners may have
    float fineScale = 2;              ///< as levelScale, of the fine level
    bool fullHits = false;  ///< hits that no cache is asked about are shaded as vertices of the fine level
    float residual = 0;     ///< chance that a look-up of a sample's or a truth's ray is corrected; 0: none is
    /// Gathers look at these in place of sending rays. Null: they send rays. [borrowed]
    const BakedPoints* points = nullptr;
    float levelScale = 0.35f;  ///< a level is fine enough when its spacing is at most so many ray footprints
  };
  RadiosityEngine(const World& world, const Settings& settings);

  /// Indirect irradiance of both sides of a point, the smooth sky's included.
  struct Irradiance {
    Rgb front{0, 0, 0}, back{0, 0, 0};
  };
  struct Request {
    ShadingPoint point;
    uint64_t seed;        ///< of random numbers: points of equal seed get equal ones
    int bounces;          ///< diffuse bounces that may still follow from here: see bouncesAt()
    uint32_t sample = 0;  ///< among those of equal seed: their random numbers continue each other
    const Irradiance* indirect = nullptr;  ///< what is known of it; nullptr: it is gathered [borrowed]
  };
  /// Diffuse bounces that may follow from a point of `placement` where `allowed` are left on the way to it:
  /// an object may allow fewer from there on, never more. PRMan: MIN(parent.max, parent.depth + object.max).
  int bouncesAt(uint32_t placement, int allowed = kManyBounces) const {
    return std::min(allowed, world_.attributesOf(placement).maxDiffuseDepth);
  }
  static constexpr int kManyBounces = 1 << 20;

  /// A vertex of the fine level of a patch, as seen at diffuse depth 0.
  struct Vertex {
    uint32_t patch;
    bool front;
    uint16_t index;
    uint8_t bounces;  ///< keptBounces() of those that may follow
    bool operator==(const Vertex&) const = default;
  };
  /// A place among such vertices.
  struct Spot {
    uint32_t patch;
    bool front;
    uint8_t bounces;
    VertexWeights around;
  };

  /// Radiance B that leaves each point, at diffuse depth `depth`, sampled anew. Where `spots` says between
  /// which vertices each of them lies (at depth 0, with a cache), their indirect irradiance is taken from
  /// there. [any thread]
  void shade(std::span<const Request> requests, int depth, Purpose purpose, std::span<Rgb> out,
             std::span<const Spot> spots = {}) const;

  /// Indirect irradiance of each point at diffuse depth 0, sampled anew, on the sides from which its surface
  /// scatters any. [any thread]
  void indirect(std::span<const Request> requests, Purpose purpose, std::span<Irradiance> out) const;
  /// As keys tell them apart: from 15 on they are as many as the scene allows at that depth.
  static uint8_t keptBounces(int bounces) { return static_cast<uint8_t>(std::min(bounces, kMostKept)); }
  /// B at vertices, from the cache or made and kept; without a cache, their indirect irradiance, too.
  /// [any thread]
  void vertices(std::span<const Vertex> wanted, std::span<Rgb> out,
                std::span<Irradiance> indirect = {}) const;

  /// A cell of a patch, where a point of it was met: the vertices around that, of the fine level.
  struct Cell {
    uint32_t patch;
    bool front;
    VertexWeights around;
    const ShadingPoint* met;  ///< nullptr: none in particular
  };
  /// Whether something stands between the vertices of each cell, so that interpolating them would carry light
  /// or darkness through it (a vertex inside a box that stands on the patch, or behind a wall); what holds
  /// for one point of a cell is taken to hold for all. [any thread]
  void separated(std::span<const Cell> cells, std::span<uint8_t> out, int nesting = 0) const;

  /// A place that one of a camera sample's many directions through a rough lobe has met.
  struct Blurred {
    const Hit* hit;   ///< borrowed
    float footprint;  ///< of the lobe, world units
    int bounces;      ///< as Request's
    bool found = false;
    Rgb radiance{0, 0, 0};  ///< B, if found
  };
  /// B as diffuse rays see it, of the level that is as fine as the lobe is wide, where there is one. Made by
  /// fewer rays than what the camera sees sharply, and shared with what diffuse rays meet. [any thread]
  void blurred(std::span<Blurred> places) const;

  const World& world() const { return world_; }
  const PatchCache* cache() const { return cache_.get(); }
  /// For rays of the camera's samples; nullptr: every layer is to be shaded.
  const OpacityCache* opacityCache() const { return settings_.residual > 0 ? nullptr : opacityCache_.get(); }
  void report() const;  ///< figures of the cache that are known at the end only [main]

 private:
  static constexpr int kMostKept = 15;
  /// What stands for the depth in the keys of irradiance at the camera's vertices.
  static constexpr uint8_t kIrradiance = kCachedDepths + 1, kDistances = kIrradiance + 1;
  /// ... and of what is kept of cells: 1 when something stands in them, else 0.
  static constexpr uint8_t kStanding = kDistances + 1;
  /// Where lights shine directly indirect light may be less exact, as what counts is the sum; but no less
  /// than if direct light were so many times the indirect: shadows may be near.
  static constexpr float kRelief = 3;
  /// Covers of vertices count, of the coarse and medium level and of nodes, when they are so near, as parts
  /// of the vertices' distance: above that chords see what casts its shadow on them.
  static constexpr float kCover = 0.05f;
  struct Workspace;
  struct GatherRay;
  struct Lookup;
  struct Waiting;
  struct Want;
  struct Fill;
  struct Walk;
  Workspace& workspace(int nesting) const;
  /// Coarser levels are shaded at the centroids of what their vertices stand for.
  Request vertexRequest(uint32_t patch, bool front, Level level, uint32_t vertex, int depth,
                        uint8_t keptBounces) const;
  ShadingPoint pointAt(uint32_t patch, bool front, Level level, V2f uv) const;
  /// Whether the rays of a request's gather and the light samples at its point share the light of skies: see
  /// skyPart().
  bool sharesSkies(const Request& request) const {
    return settings_.indirect && !settings_.points && request.bounces > 0;
  }
  /// At the vertex itself.
  ShadingPoint cornerAt(uint32_t patch, bool front, Level level, uint32_t vertex) const;
  /// `spots`: which places among vertices the requests are, whose irradiance may be interpolated; or empty.
  void shadeNested(std::span<const Request> requests, int depth, Purpose purpose, std::span<Rgb> out,
                   int nesting, std::span<const Spot> spots = {}) const;
  /// What surfaces at the requests' points say, to w.
  void prepare(std::span<const Request> requests, Workspace& w) const;
  void addDirect(std::span<const Request> requests, int depth, Purpose purpose, Workspace& w) const;
  void addDirect(std::span<const Request> requests, size_t first, size_t end, int depth, Purpose purpose,
                 Workspace& w) const;
  /// Shadows that are blurred by motion are sampled over time.
  bool takesOneSample(uint32_t light) const {
    return world_.lights().isDelta(light) && !world_.geometry().samplesMotion();
  }
  void addIndirect(std::span<const Request> requests, int depth, Purpose purpose, Workspace& w, int nesting,
                   std::span<const Spot> spots) const;
  /// Irradiance of the requests' front from a gather each, to w.front; with the distances of what it met.
  /// `shares`: of the usual number of rays.
  void gatherFront(std::span<const Request> requests, std::span<const float> shares, Workspace& w,
                   int nesting) const;
  void estimateDirect(std::span<const Request> requests, Workspace& w) const;
  float pixelShare(const ShadingPoint& vertex, uint32_t patch, uint32_t index) const;
  void lookAtPoints(std::span<const Request> requests, Workspace& w) const;
  /// Sends the rays of w.senders, or looks at points in their place.
  void gather(std::span<const Request> requests, int depth, bool truth, Workspace& w, int nesting) const;
  /// Indirect irradiance, the smooth sky's included, in front of vertices at depth 0: gathered or
  /// interpolated.
  void irradiance(std::span<const Vertex> wanted, std::span<Rgb> out, int nesting) const;
  void gatherCorners(size_t first, int nesting) const;
  bool findIrradiance(Waiting& x) const;
  void findSmooth(Workspace& w) const;
  void makeIrradiance(std::span<Fill> fills, std::vector<Waiting>& waiting, int nesting) const;
  static uint64_t packDistances(float inverse, float nearest, float noise, float direct);
  /// Traces the rays of `w` to where they end; what they meet goes to the irradiance of their slots, or to
  /// w.missed and w.direct.
  void trace(int depth, bool truth, Workspace& w, int nesting) const;
  void passOn(int depth, bool truth, uint32_t layer, Workspace& w) const;
  /// Radiance at hits at diffuse depth `depth`, from the cache or made and kept; those that the cache has no
  /// place for are not found.
  void lookUp(std::span<Lookup> lookups, int depth, int nesting) const;
  enum class Settled : uint8_t { Done, Waits, GoesFiner };
  CacheKey place(const Lookup& lookup, uint32_t k, uint32_t patch, Level level, int depth, Workspace& w,
                 Waiting& x) const;
  /// Names an entry, at a depth, but for the vertex of the fine level in its lowest five bits.
  static uint64_t entryKey(const Waiting& x, int depth);
  void survey(const Waiting& x, int depth) const;
  static Settled take(Lookup& lookup, Waiting& x, bool known, std::vector<Waiting>& waiting);
  void tryLevels(std::span<Lookup> lookups, uint32_t k, uint32_t patch, Level level, int depth, Workspace& w,
                 std::vector<Waiting>& waiting) const;
  void make(std::vector<Waiting>& waiting, int depth, int nesting) const;
  /// Decides by chance whether a sample of the hit's own radiance is to correct a look-up's value.
  static void correct(Lookup& lookup, float chance, uint64_t seed);
  bool takeFromCache(const Fill& fill, std::vector<Waiting>& waiting, int depth, int nesting) const;
  void makeSome(std::span<Fill> fills, std::vector<Waiting>& waiting, int depth, int nesting) const;
  static bool evaluate(const VertexWeights& around, const uint64_t* codes, Rgb& radiance);
  using PointPair = std::array<const ShadingPoint*, 2>;
  /// Whether something stands between the points of each pair: 1, else 0.
  /// Or a cover is above one of them, no farther than `reach` times their distance, and not above the other.
  void blocked(std::span<const PointPair> pairs, float reach, std::span<uint8_t> out, Workspace& w) const;
  void findCovers(std::span<const PointPair> pairs, float reach, Workspace& w) const;
  template <class FineCell>
  static CacheKey standingKey(const FineCell& cell) {
    return {cell.patch, cell.front, kStanding, cell.block, cell.upper};
  }
  void leaveSeparated(std::span<Lookup> lookups, int nesting) const;
  void hidden(std::span<const PointPair> pairs, std::span<uint8_t> out, Workspace& w) const;
  void cutAway(std::span<const Request> points, std::span<uint64_t> codes, Workspace& w) const;
  bool isDisplaced(uint32_t placement) const {
    return world_.geometry().traced()[world_.geometry().placements()[placement].traced].isDisplaced;
  }
  /// Light that lobes and view-dependent emission send back along each point's I: unbiased walks of one ray,
  /// to the first surface without lobes or the specular depth limit.
  void followLobes(std::span<Walk> walks, int depth, bool truth, int nesting) const;
  void skyOnLastLobes(std::span<Walk> walks, std::span<const uint32_t> which, uint32_t bounce, bool truth,
                      Workspace& w) const;
  void lightLobes(std::span<Walk> walks, std::span<const uint32_t> which, uint32_t bounce, bool truth,
                  Workspace& w) const;
  /// How many rays are traced together, about, and how many points that send so many each are shaded.
  size_t raysAtOnce() const;
  size_t pointsAtOnce(int raysOfEach) const;

  const World& world_;
  Settings settings_;
  std::unique_ptr<PatchCache> cache_;
  /// What samples of the truth say of the cache's values: mean(truth - cache), by depth.
  struct Residuals {
    struct Depth {
      double count = 0, cached = 0, residual = 0, squares = 0;
    };
    std::array<Depth, kCachedDepths + 1> depths;
    std::mutex mutex;
    template <class Directs>
    void add(const Directs& directs, std::span<const Rgb> truths, int depth);
    void report() const;
  };
  mutable Residuals residual_;
  mutable CacheSurvey survey_;  ///< of values in the cache, by entryKey()
  std::unique_ptr<OpacityCache> opacityCache_;
  int mostBounces_ = 0;        ///< that any object allows
  bool isAlone_ = false;       ///< one thread renders
  mutable FillClaims claims_;  ///< by Want::key
};

}  // namespace patina
