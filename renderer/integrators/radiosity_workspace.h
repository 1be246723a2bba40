// SPDX-License-Identifier: Apache-2.0
// Scratch memory of the radiosity engine: one workspace per thread and nesting of fills.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "renderer/base/statistics.h"
#include "renderer/integrators/radiosity_engine.h"

namespace patina {

/// What is known of a gather ray beside the ray itself.
struct RadiosityEngine::GatherRay {
  Rgb share{1, 1, 1};   ///< that what it has passed lets through
  float spread;         ///< width gained per length
  float weight;         ///< of its radiance in what the sender receives
  float travelled = 0;  ///< through what let it pass
  float taken =
      1;  ///< what the values of the surface that it has met count: 0, or 1 over the chance that they do
  uint32_t slot;    ///< the sender
  uint32_t number;  ///< among all rays of the gather
  uint64_t seed;
  float residual;  ///< chance that what it looks up is corrected
  int bounces;     ///< that may follow, its own included; 0: surfaces do not count, only the sky behind them
};

/// A hit whose radiance the cache may know.
struct RadiosityEngine::Lookup {
  const Hit* hit;
  int bounces;          ///< that may follow at the hit
  float footprint;      ///< of the ray, at the hit
  uint32_t user;        ///< whatever the caller likes
  bool strict = false;  ///< the fine level is not to be much coarser than the ray is wide
  bool found = false;
  Rgb radiance{0, 0, 0};
  float truth = 1;  ///< what a sample of the hit's own radiance counts beside `radiance`
};

/// A look-up that waits for values to be made.
struct RadiosityEngine::Waiting {
  uint32_t lookup;
  uint32_t patch;
  bool front;
  Level level, stored;  ///< wanted; with the same vertices
  uint8_t block;        ///< of the fine level
  uint8_t bounces;      ///< kept
  bool counted;         ///< as a miss
  VertexWeights around;
  std::array<uint32_t, 4> inBlock;
  std::array<uint64_t, 4> codes;
  std::span<const uint32_t> inBlockOf() const { return {inBlock.data(), static_cast<size_t>(around.count)}; }
};

/// Codes that something waits for: all of a patch's level, or one fine vertex. The key says which, at which
/// depth; of one depth they are in the order of patches.
struct RadiosityEngine::Want {
  uint64_t key;
  uint32_t waiting;
  uint32_t corner;
  auto operator<=>(const Want&) const = default;
};

/// An entry to be made.
struct RadiosityEngine::Fill {
  uint32_t firstWant, endWant;
  uint32_t firstCode;
};

/// Of the light that a sky sends from one direction the part that diffuse rays bring, the rest being that of
/// light samples: the balance heuristic (Veach and Guibas 1995) for kSkyRays rays to a light sample, however
/// many there are of each, so that either part may be estimated, interpolated and shared without the other.
/// `cosine` by foldedCosine(); `pdf` of the light's samples. Of Lights::isShared() skies.
inline float skyPart(float cosine, float pdf) {
  constexpr float kSkyRays = 4;
  const float rays = kSkyRays * cosine * kInvPi;
  return rays > 0 ? rays / (rays + pdf) : 0;
}

/// A walk from lobe to lobe.
struct RadiosityEngine::Walk {
  ShadingPoint point;
  uint64_t seed;
  float footprint;
  uint32_t user;  ///< whatever the caller likes
  Rgb radiance{0, 0, 0}, throughput{1, 1, 1};
  int most = 1 << 20;  ///< specular bounces
  int bounces;         ///< diffuse ones that may follow from the point
  // Of the step that is being taken
  float pdf = 0, alpha = 0;
  bool delta = false;
  LightReceiver from;
};

struct RadiosityEngine::Workspace {
  // shadeNested
  std::vector<ShadingPoint> points;
  ShadedPoints shaded;
  std::vector<LightTree::Picks> lightPicks;
  std::vector<Rgb> front, back, extra;  // irradiance, of lights; ambient light
  std::vector<Irradiance> indirect;
  // addDirect
  std::vector<uint32_t> which;
  std::vector<V3f> positions;
  std::vector<V2f> random;
  std::vector<LightSample> lightSamples;
  struct LightOf {
    uint32_t light, request;
    uint32_t count;   // samples
    uint32_t stride;  // of samples in the light's sequence, from one request of a point to the next
    float share;      // of the light's in the sum: what makes up for its chance to be picked
  };
  std::vector<LightOf> lightOf;
  struct Shadowed {
    uint32_t request, sample, light, number;
    bool above;
    float weight, promise;
  };
  struct Promised {
    float all = 0, reached = 0, offset = 0;
    int count = 0;
  };
  std::vector<Promised> promised;  // by request
  std::vector<World::ShadowRay> shadowRays;
  std::vector<Shadowed> shadowed;
  std::vector<Rgb> visible;
  // addIndirect
  std::vector<Ray> rays, nextRays, beyond;
  std::vector<GatherRay> gather, nextGather;
  std::vector<Hit> hits;
  std::vector<Rgb> found;      // radiance that was met, by number in the batch
  std::vector<uint32_t> slot;  // likewise
  std::vector<uint32_t> pointOf, withPoints;
  std::vector<ShadingPoint> hitPoints, layerPoints;
  std::vector<uint32_t> met, passing;
  std::vector<float> widths;  // of rays that pass
  std::vector<Rgb> passed;    // by `passing`
  struct Missed {
    uint32_t number, slot;
    V3f from, direction;
    Rgb weight;
  };
  std::vector<Missed> missed;
  std::vector<V3f> missFrom, missDirection;
  std::vector<uint32_t> missOf;  // of walks: their rays
  std::vector<Rgb> missRadiance;
  std::vector<float> missPdf;
  struct Direct {
    uint32_t number, slot;
    Rgb weight;
    Request request;
    Rgb cached;  ///< what the cache says; negative: nothing
  };
  std::vector<Direct> direct;
  std::vector<Request> directRequests;
  std::vector<Rgb> directRadiance;
  /// Rays to be sent from a request's point, and what they find.
  struct Sender {
    uint32_t request;
    bool behind;
    float residual;            ///< chance that a look-up is corrected
    int first, count, spread;  ///< of the point's sequence; what the rays' width follows from
    float weight;              ///< of a ray
    Rgb received{0, 0, 0};
  };
  std::vector<Sender> senders;
  bool measures = false;  // distances, of the first surface met
  struct Distances {
    float inverse = 0, nearest = kInfinity;  // sum of 1/t
    float lit = 0;                           // sum of radiance/t
    float noise = 0;                         // standard error of the irradiance
    float direct = 0;                        // Gathered::direct
  };
  std::vector<Distances> distances;  // by request
  std::vector<float> inverseMet;     // while that is measured: 1/t by a ray's number, 0 = nothing
  struct Gathered {
    std::array<Rgb, 4> quarters;       // of the rays, in order; sums of radiance
    int rays = 0, next = 0, most = 0;  // sent; to be sent by the end of the round, and of all rounds
    float share = 1;                   // of the usual number of rays
    float direct = 0;  // irradiance of lights that are sampled: its largest component, roughly
    bool done = false;
  };
  std::vector<Gathered> gathered;
  std::vector<float> pixelShares;
  // irradiance
  struct Corner {
    Vertex vertex;
    Rgb irradiance{0, 0, 0};
    float inverse = 0, nearest = 0;  // mean of 1/distance; distance
    float noise = 0;                 // standard error of the irradiance
    float direct = 0;                // irradiance of lights that are sampled
    V3f P{0, 0, 0}, N{0, 0, 1};
    void set(const std::array<uint64_t, 4>& codes) {
      irradiance = PackedRgb::unpack(codes[0]);
      const auto part = [&](int k) {
        return std::bit_cast<float>(static_cast<uint32_t>(codes[1] >> (16 * k) & 0xffff) << 16);
      };
      inverse = part(3), nearest = part(2), noise = part(1), direct = part(0);
    }
  };
  std::vector<Corner> corners;
  std::unordered_map<uint64_t, uint32_t> cornerOf, nodeOf;
  struct InNode {
    uint32_t wanted;
    uint32_t i, j;  // on the lattice
    uint32_t nodeI = 0, nodeJ = 0, step;
    int count = 0;
    uint32_t corner[4]{};
  };
  std::vector<InNode> inNodes;
  std::vector<uint8_t> smooth;
  std::vector<uint32_t> sameAs;
  std::vector<Request> ends;
  std::vector<Vertex> irradianceWanted;
  std::vector<Spot> fillSpots;
  std::vector<std::pair<uint32_t, float>>
      irradianceSlot;  // two times the request, and 1 for its back; weight
  std::vector<Rgb> irradianceFound;
  // lookUp
  std::vector<Lookup> lookups;
  struct Placed {
    Waiting x;
    PatchCache::Probe probe;
    PatchCache::Probe standing;  // whether something stands in its cell
    uint32_t cell;               // of fineCells, or kNone
  };
  std::vector<Placed> placed;
  std::vector<Waiting> waiting, again;
  std::vector<Want> wants;
  std::vector<Fill> fills, others;  // to be made here, and by other threads
  std::vector<Request> fillRequests;
  std::vector<uint64_t> fillCodes;
  std::array<std::vector<Request>, 4> shadeRequests;  // by Purpose, Vertex to FineVertex
  std::array<std::vector<uint32_t>, 4> codeOf;
  std::vector<Rgb> fillRadiance;
  std::vector<std::array<uint32_t, 2>> pairOf;  // of fillRequests
  std::vector<ShadingPoint> levelCorners;       // of coarser levels
  std::vector<std::array<uint32_t, 2>> cornerPairs, codeOfCorner;
  std::vector<PointPair> pairs, hiddenPairs;
  std::vector<uint8_t> separated, hidden;
  std::vector<uint32_t> pairOfHidden;
  // vertices
  std::vector<uint32_t> vertexOf, order;
  // separations
  std::vector<Ray> chords;
  std::vector<Hit> chordHits;
  std::vector<uint32_t> chordOf, chordsMet;
  struct Cover {
    const ShadingPoint* point;
    float distance;  // to what is above it
  };
  std::vector<Cover> covers;  // by point
  float coverOf(const ShadingPoint* point) const {
    return std::lower_bound(covers.begin(), covers.end(), point,
                            [](const Cover& c, const ShadingPoint* p) { return std::less<>()(c.point, p); })
        ->distance;
  }
  std::vector<Ray> probes;
  std::vector<Hit> probeHits;
  /// A cell of the fine level, and where it is kept whether something stands in it.
  struct FineCell {
    uint32_t patch;
    bool front;
    uint8_t block, upper;  // upper: of the two triangles of a square
    uint32_t index;        // in the block
    uint32_t lookup;
    VertexWeights around;
    uint64_t code;  // whether something stands there, or kMissing
    auto place() const { return std::tuple(patch, front, upper, block, index); }
    bool operator<(const FineCell& other) const { return place() < other.place(); }
    bool sameCell(const FineCell& other) const { return place() == other.place(); }
    bool sameBlock(const FineCell& other) const {
      return std::tuple(patch, front, upper, block) ==
             std::tuple(other.patch, other.front, other.upper, other.block);
    }
  };
  std::vector<FineCell> fineCells, cellPlaces;
  std::vector<Cell> cells;
  std::vector<uint8_t> cellSeparated;
  std::vector<int> entered;  // by pair: fronts met less backs met
  // follow
  std::vector<Walk> walks;
  ShadedPoints specular;
  std::vector<BsdfSample> lobeSamples;  // where walks go on from here, by active one
  std::vector<uint32_t> lit;            // active walks that lights shine on
  struct LightOfLobe {
    uint32_t light, walk;  // active one
    float chance;          // that it is picked
  };
  std::vector<LightOfLobe> lightOfLobe;
  std::vector<Ray> walkRays;
  std::vector<Hit> walkHits;
  std::vector<ShadingPoint> walkPoints;
  std::vector<uint32_t> walkOf, picked;
  std::vector<Bsdf::Value> values;
  std::vector<Request> walkRequests;
  std::vector<Rgb> walkRadiance;
};

struct CacheStatistics {
  StatCounter lookups, hits, misses;
};
CacheStatistics& cacheStatistics(Level level, int depth);

}  // namespace patina
