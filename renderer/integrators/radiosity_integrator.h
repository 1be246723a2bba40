// SPDX-License-Identifier: Apache-2.0
// Modes radiosity, distribution and direct, inside: radiosity.cc follows the camera's samples,
// radiosity_camera.cc finds the view-independent light where they meet something.
#pragma once

#include <unordered_map>

#include "renderer/integrators/baked_points.h"
#include "renderer/integrators/integrator.h"
#include "renderer/integrators/radiosity_engine.h"

namespace patina {

class RadiosityIntegrator final : public Integrator {
 public:
  RadiosityIntegrator(const World& world, const RadiosityEngine::Settings& settings)
      : world_(world), engine_(world, settings), cached_(settings.cached) {}
  /// Gathers from points, which it keeps.
  RadiosityIntegrator(const World& world, const RadiosityEngine::Settings& settings,
                      std::unique_ptr<const BakedPoints> points)
      : world_(world), points_(std::move(points)), engine_(world, settings), cached_(settings.cached) {}
  void render(FilmTile& tile, SampleRange samples, TileMemory* memory) const override;
  std::unique_ptr<TileMemory> remember() const override {
    return cached_ ? nullptr : std::make_unique<TileVertices>();
  }
  void finish() const override { engine_.report(); }

 private:
  // Random numbers of a camera sample.
  enum Dimension : uint32_t {
    kLobe = 0x1000,
    kDirection = 0x2000,
    kLightChoice = 0x3000,
    kLightPoint = 0x4000,
    kPoint = 0x5000,
    kTime = 0x6000
  };

  /// A camera sample on its way through transparent layers and specular surfaces.
  struct Walk {
    uint32_t slot = 0;
    uint32_t sample = 0;
    uint64_t frame = 0;  // World::frameSeed()
    int x = 0, y = 0;
    Ray ray;
    Rgb throughput{1, 1, 1};
    float footprint = 0, spread = 0;
    LightReceiver from;
    float pdf = 0;  // of a specular direction; 0 = camera ray or delta lobe
    uint32_t receiver = kNone;
    bool sampledLights = false;
    int specularDepth = 0, maxSpecular = 1 << 20;
    int bounces = RadiosityEngine::kManyBounces;  // diffuse ones that may still follow
    uint32_t step = 0;
    float roughness = 0;  // the largest on the way
    uint64_t seed(uint32_t dimension) const { return pixelSeed(frame, x, y, dimension + step); }
  };

  struct Result {
    Rgb radiance{0, 0, 0};
    Rgb seen{0, 0, 0};  // opacity
    Rgb air{0, 0, 0};   // of the air before it, which is no part of `seen`
    float depth = kFarDepth;
    bool matte = false;
  };

  static uint64_t keyOf(const RadiosityEngine::Vertex& v) {
    return uint64_t{v.patch} << 17 | uint64_t{v.front} << 16 | uint64_t{v.bounces} << 12 | v.index;
  }

  /// The vertices of a tile that is rendered in parts, where no cache keeps them, by keyOf().
  struct TileVertices final : TileMemory {
    struct Value {
      Rgb radiance;
      RadiosityEngine::Irradiance indirect;
    };
    std::unordered_map<uint64_t, Value> values;
  };

  struct Wave {
    std::vector<Walk> walks, next;
    std::vector<Result> results;
    std::vector<V2f> positions;
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    std::vector<uint32_t> active;  // indices of walks that hit something
    std::vector<ShadingPoint> points;
    std::vector<Rgb> radiosity, direct;
    ShadedPoints shaded;
    // Vertices
    std::unordered_map<uint64_t, uint32_t> known;
    std::unordered_map<uint64_t, uint32_t> cellOf;  // index of cells
    std::vector<RadiosityEngine::Cell> cells;
    std::vector<uint64_t> cellKeys;
    std::vector<uint8_t> separated;                      // by cell
    std::vector<std::pair<uint32_t, uint32_t>> inCells;  // points, and their cells
    std::vector<RadiosityEngine::Vertex> vertices;
    TileVertices* kept = nullptr;
    std::vector<Rgb> values;  // by vertex
    std::vector<RadiosityEngine::Irradiance> vertexIndirect;
    std::vector<VertexWeights> around;
    std::vector<uint32_t> cellAt;  // by point: of cells, or kNone
    std::vector<Rgb> made;
    std::vector<uint32_t> byHit;  // points that are shaded at the hit
    // Points that rough lobes have met
    std::vector<RadiosityEngine::Blurred> blurred;
    std::vector<uint32_t> blurredPoints, notCached;
    std::vector<uint8_t> isBlurred;  // by point
    // Points that share what is made for one of them: of groups of small faces, and of parts of pixels.
    enum class Share : uint8_t {
      Indirect,  // light; of a group of faces in a tile
      Whole,     // B; of a part of a pixel in a cell that something stands in
      Direct     // B; of a part of a pixel in a cell or group whose indirect light is known
    };
    struct Sharing {
      uint32_t point;
      uint64_t key;
      Share share;
    };
    std::unordered_map<uint64_t, std::pair<uint64_t, uint32_t>> met;  // the chance that chose one, and that
    std::vector<Sharing> sharing;
    std::array<std::vector<uint32_t>, 3> chosen;  // by Share
    std::vector<uint64_t> groupKeys;              // by point
    // What is shared in all waves of a tile
    std::unordered_map<uint64_t, Rgb> inPart;
    std::unordered_map<uint64_t, RadiosityEngine::Irradiance> inGroup;
    std::vector<RadiosityEngine::Spot> spots;
    std::vector<RadiosityEngine::Irradiance> indirect;
    std::vector<RadiosityEngine::Request> requests;
  };
  void step(Wave& wave) const;
  void throughAir(Wave& wave) const;
  void missed(Wave& wave, const Walk& walk) const;
  void viewIndependent(Wave& wave) const;
  void findBlurred(Wave& wave) const;
  void findCells(Wave& wave) const;
  void share(Wave& wave, uint32_t i, uint64_t key, Wave::Share share) const;
  void sharePart(Wave& wave, uint32_t i, uint64_t place, Wave::Share share) const;
  void shadeShared(Wave& wave) const;
  void shadeLit(Wave& wave) const;
  void makeRequests(Wave& wave, std::span<const uint32_t> which) const;
  void shadeRequests(Wave& wave, std::span<const uint32_t> which, int depth, Purpose purpose,
                     std::span<const RadiosityEngine::Spot> spots) const;
  void vertexValues(Wave& wave) const;
  bool followsLobes(const Walk& walk, uint32_t placement) const;
  void specularDirect(Wave& wave) const;
  void skyDirect(Wave& wave) const;
  /// Lights that are picked for the lobes of a point, beside delta lights where those are few.
  static int picksOf(const LightList& list);
  bool proceed(Wave& wave, size_t i, Walk& walk) const;

  const World& world_;
  const std::unique_ptr<const BakedPoints> points_;  ///< null, or what engine_ gathers from
  RadiosityEngine engine_;
  bool cached_;
};

}  // namespace patina
